// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace maxlogdet::sim {

/// FNV-1a, which is the same on every machine, unlike std::hash.
class Hash {
 public:
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3U; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

/// Returns the hash of a text, byte by byte.
inline std::uint64_t hash_of(const std::string& text) {
  Hash hash;
  for (const char c : text) hash.add(static_cast<unsigned char>(c));
  return hash.value();
}

}  // namespace maxlogdet::sim
