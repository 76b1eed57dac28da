// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <maxlogdet/version.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>

// GoogleTest's main, except that a run on an instruction set that this machine lacks (MAXLOGDET_ISA) is skipped: 77.
int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  const char* const forced = std::getenv("MAXLOGDET_ISA");
  if (forced != nullptr && !maxlogdet::isa_is_supported(forced)) {
    for (int i = 0; maxlogdet::built_in_isa(i) != nullptr; ++i) {
      if (std::strcmp(maxlogdet::built_in_isa(i), forced) != 0) continue;
      std::printf("skipped: this machine has no %s\n", forced);
      return 77;
    }
  }
  return RUN_ALL_TESTS();
}
