// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/require.hpp"

#include <maxlogdet/maxlogdet.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <memory>

// Structs as callers of the C API give them, whatever their sizes are.

namespace maxlogdet::fuzz {

inline void require_error(maxlogdet_error error, int expected, const char* property) {
  require(error == expected, property, maxlogdet_error_name(error), error, "instead of", expected);
}

/// Whether the header takes a struct of that size.
template <class Struct>
bool is_size_of(std::size_t size) {
  return size % 8 == 0 && size >= 16 && size <= sizeof(Struct);
}

/// A struct as a caller has it whose declaration ends earlier, in memory that ends there as well; or of an
/// invalid size, in memory for the whole one.
template <class Struct>
class Given {
 public:
  Given(Bytes& bytes, const Struct& whole, const Struct& defaults) : seen_(defaults) {
    std::size_t size = sizeof(Struct);
    if (bytes.chance(48)) size = bytes.chance(64) ? bytes.raw<std::size_t>() : 8 * bytes.below(sizeof(Struct) / 8 + 2);
    is_good_ = is_size_of<Struct>(size);
    const std::size_t room = is_good_ ? size : sizeof(Struct);
    memory_.reset(new unsigned char[room]);  // aligned for any struct, and guarded by AddressSanitizer
    std::memcpy(memory_.get(), &whole, room);
    std::memcpy(memory_.get(), &size, sizeof size);
    if (is_good_) std::memcpy(&seen_, &whole, size);
    is_null_ = bytes.chance(8);
    is_good_ = is_good_ && !is_null_;
  }

  const Struct* get() const {
    return is_null_ ? nullptr : reinterpret_cast<const Struct*>(memory_.get());  // NOLINT(*-reinterpret-cast)
  }
  /// Whether the struct is valid, reserved fields aside.
  bool is_good() const { return is_good_; }
  /// What the library has to read from it, defaults included.
  const Struct& seen() const { return seen_; }

 private:
  std::unique_ptr<unsigned char[]> memory_;
  Struct seen_;
  bool is_good_ = false;
  bool is_null_ = false;
};

template <class Struct>
Struct defaults_of(maxlogdet_error (*init)(Struct*, std::size_t)) {
  Struct made;
  require_error(init(&made, sizeof made), MAXLOGDET_ERROR_NONE, "init takes the size of its struct");
  return made;
}

/// Checks that init() writes the defaults up to the size and no more, or marks the struct.
template <class Struct>
void check_init(Bytes& bytes, maxlogdet_error (*init)(Struct*, std::size_t)) {
  const std::size_t size = bytes.chance(64) ? bytes.raw<std::size_t>() : bytes.below(sizeof(Struct) + 20);
  require_error(init(nullptr, size), MAXLOGDET_ERROR_INVALID_ARGUMENT, "init refuses a null pointer");
  constexpr int untouched = 0xA5;
  Struct made;
  std::memset(&made, untouched, sizeof made);
  const maxlogdet_error error = init(&made, size);
  const bool is_good = is_size_of<Struct>(size);
  require_error(error, is_good ? MAXLOGDET_ERROR_NONE : MAXLOGDET_ERROR_INVALID_ARGUMENT, "init knows its sizes");
  const Struct defaults = defaults_of(init);
  std::array<unsigned char, sizeof(Struct)> expected;
  expected.fill(untouched);
  if (is_good) std::memcpy(expected.data(), &defaults, size);
  const std::size_t marked = is_good ? size : 0;
  if (is_good || size >= sizeof marked) std::memcpy(expected.data(), &marked, sizeof marked);
  require(std::memcmp(&made, expected.data(), sizeof made) == 0, "init writes the defaults up to the size", size);
}

}  // namespace maxlogdet::fuzz
