// SPDX-License-Identifier: MIT
// Where there is no libFuzzer: runs a fuzz target on every file of a folder, or on all regressions and the share of the
// others that MAXLOGDET_TEST_SHARE names. Usage: PROGRAM FOLDER
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv) {
  std::vector<std::string> files;
  std::error_code error;
  if (argc == 2) {
    for (const auto& entry : std::filesystem::directory_iterator(argv[1], error))
      files.push_back(entry.path().string());
  }
  if (files.empty()) {
    std::fprintf(stderr, "expected the folder of a corpus as the only argument, and inputs in it\n");
    return 2;
  }
  std::sort(files.begin(), files.end());
  const std::size_t step = files.size() / maxlogdet::test::trials(files.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const bool is_regression = std::filesystem::path(files[i]).filename().string().rfind("regression_", 0) == 0;
    if (i % step != 0 && !is_regression) continue;
    ++count;
    std::printf("%s\n", files[i].c_str());  // the last one printed is that of a failure
    std::fflush(stdout);
    const std::string bytes = maxlogdet::test::text_of(files[i]);
    (void)LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  std::printf("%zu of %zu inputs replayed\n", count, files.size());
  return 0;
}
