// SPDX-License-Identifier: MIT
// Random draws for sampling without replacement. Integers only: the same on every instruction set.

namespace {

void draw(std::uint64_t key, std::uint64_t first, std::uint32_t range, std::size_t count, std::uint32_t* draws) {
  for (std::size_t j = 0; j < count; ++j) {
    draws[j] = maxlogdet::CounterRandom::below_at(key, first + j, range - static_cast<std::uint32_t>(j));
  }
}

}  // namespace
