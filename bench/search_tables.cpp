// SPDX-License-Identifier: MIT
// Writes where the searches beyond lazy greedy pay: two lines of facts, then tables (about a minute).
// Usage: maxlogdet_search_tables [denormals]; bench/write_search_tables.py calls it. denormals: that table alone.
#include "bench/search_tables.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdio>
#include <cstring>

int main(int argc, char** argv) {
  using namespace maxlogdet;
  const bool only_denormals = argc == 2 && std::strcmp(argv[1], "denormals") == 0;
  if (argc > 1 && !only_denormals) {
    std::fputs("usage: maxlogdet_search_tables [denormals]\n", stderr);
    return 2;
  }
  std::printf("isa %s\ncompiler %s\n", active_isa(), MAXLOGDET_COMPILER);
  bench::write_denormal_table();
  if (only_denormals) return 0;
  bench::write_exchange_table();
  bench::write_backward_table();
  bench::write_certificate_tables();
  bench::write_relaxed_tables();
  return 0;
}
