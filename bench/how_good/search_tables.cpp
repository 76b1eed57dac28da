// SPDX-License-Identifier: MIT
// Measures what bounds, deadlines, targets and denormal numbers cost and give away; writes two lines about the build,
// then tables (about a minute). Usage: maxlogdet_search_tables [NAME]; bench/how_good/write_search_tables.py calls it.
// A name asks for one table alone.
#include "bench/how_good/search_tables.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>

int main(int argc, char** argv) {
  using namespace maxlogdet;
  struct Part {
    const char* name;
    void (*write)();
  };
  static constexpr Part parts[] = {{"denormals", bench::write_denormal_table},
                                   {"targets", bench::write_target_table},
                                   {"deadline", bench::write_deadline_table},
                                   {"certificates", bench::write_certificate_tables}};
  const char* const only = argc == 2 ? argv[1] : nullptr;
  const auto is_asked_for = [only](const Part& part) { return only == nullptr || std::strcmp(only, part.name) == 0; };
  if (argc > 2 || std::none_of(std::begin(parts), std::end(parts), is_asked_for)) {
    std::fputs("usage: maxlogdet_search_tables [", stderr);
    for (const Part& part : parts) std::fprintf(stderr, "%s%s", &part == parts ? "" : "|", part.name);
    std::fputs("]\n", stderr);
    return 2;
  }
  std::printf("isa %s\ncompiler %s\n", active_isa(), MAXLOGDET_COMPILER);
  for (const Part& part : parts) {
    if (is_asked_for(part)) part.write();
  }
  return 0;
}
