// SPDX-License-Identifier: MIT
// Any calls of the C API in any order, misuse that its header covers included, compared with the same calls in C++.
#include "tests/fuzz/c_api_calls.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::Bytes bytes(data, size);
  maxlogdet::fuzz::check_c_api(bytes);
  return 0;
}
