// SPDX-License-Identifier: MIT
// Any text as the text files of an EuRoC folder, form feeds between them; a file without text is left out.
#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/dataset_check.hpp"

namespace maxlogdet::fuzz {
namespace {

class EurocFolder {
 public:
  EurocFolder() {
    for (const char* camera : {"/cam0", "/cam1"}) {
      folder_.make_folder(mav0 + camera + "/data");
      for (const char* file : {"/data/1.png", "/data/2.png", "/data/3.png"}) {
        write_image(folder_, mav0 + camera + file);
      }
    }
    folder_.make_folder(mav0 + "/state_groundtruth_estimate0");
  }

  void check(Bytes bytes) const {
    for (const char* file :
         {"/mav0/cam0/sensor.yaml", "/mav0/cam1/sensor.yaml", "/mav0/cam0/data.csv", "/mav0/cam1/data.csv",
          "/mav0/state_groundtruth_estimate0/data.csv", "/ground_truth.txt"}) {
      const std::string_view text = bytes.text_until('\f');
      if (text.empty()) {
        folder_.remove(name + file);
      } else {
        folder_.write(name + file, text);
      }
    }
    check_folder(folder_, name);
  }

 private:
  const std::string name = "euroc";
  const std::string mav0 = name + "/mav0";
  InputFolder folder_;
};

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const maxlogdet::fuzz::EurocFolder folder;
  folder.check(maxlogdet::fuzz::Bytes(data, size));
  return 0;
}
