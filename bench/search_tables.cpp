// SPDX-License-Identifier: MIT
// Measures when the searches other than lazy greedy pay; writes two lines about the build, then tables (about a
// minute). Usage: maxlogdet_search_tables [denormals|targets]; bench/write_search_tables.py calls it. A name asks for
// that table alone.
#include "bench/search_tables.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdio>
#include <cstring>

int main(int argc, char** argv) {
  using namespace maxlogdet;
  const bool only_denormals = argc == 2 && std::strcmp(argv[1], "denormals") == 0;
  const bool only_targets = argc == 2 && std::strcmp(argv[1], "targets") == 0;
  if (argc > 1 && !only_denormals && !only_targets) {
    std::fputs("usage: maxlogdet_search_tables [denormals|targets]\n", stderr);
    return 2;
  }
  std::printf("isa %s\ncompiler %s\n", active_isa(), MAXLOGDET_COMPILER);
  if (only_targets) {
    bench::write_target_table();
    return 0;
  }
  bench::write_denormal_table();
  if (only_denormals) return 0;
  bench::write_exchange_table();
  bench::write_backward_table();
  bench::write_target_table();
  bench::write_certificate_tables();
  bench::write_relaxed_tables();
  return 0;
}
