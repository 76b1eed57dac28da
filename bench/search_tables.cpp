// SPDX-License-Identifier: MIT
// Writes where the searches beyond lazy greedy pay: two lines of facts, then tables (about a minute).
// Usage: maxlogdet_search_tables; bench/write_search_tables.py calls it.
#include "bench/search_tables.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdio>

int main() {
  using namespace maxlogdet;
  std::printf("isa %s\ncompiler %s\n", active_isa(), MAXLOGDET_COMPILER);
  bench::write_exchange_table();
  bench::write_backward_table();
  bench::write_certificate_tables();
  bench::write_relaxed_tables();
  return 0;
}
