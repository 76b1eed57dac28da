// SPDX-License-Identifier: MIT
// Any text as calib.txt, times.txt and poses.txt of a KITTI folder, after a letter for the layout, form feeds between
// them; without the last two where there is no text for them.
#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/dataset_check.hpp"

namespace maxlogdet::fuzz {
namespace {

// Three pairs of images in each of the three layouts.
class KittiFolders {
 public:
  KittiFolders() {
    constexpr const char* sides[][2] = {{"image_l", "image_r"}, {"image_0", "image_1"}, {"image_2", "image_3"}};
    for (std::size_t layout = 0; layout < layouts; ++layout) {
      for (const char* side : sides[layout]) {
        const std::string images = name(layout) + "/" + side;
        folder_.make_folder(images);
        for (const char* file : {"/000000.png", "/000001.png", "/000002.png"}) write_image(folder_, images + file);
      }
    }
  }

  void check(Bytes bytes) const {
    const std::string here = name(bytes.below(layouts));
    folder_.write(here + "/calib.txt", bytes.text_until('\f'));
    for (const char* file : {"/times.txt", "/poses.txt"}) {
      if (bytes.is_empty()) {
        folder_.remove(here + file);
      } else {
        folder_.write(here + file, bytes.text_until('\f'));
      }
    }
    check_folder(folder_, here);
  }

 private:
  static constexpr std::size_t layouts = 3;
  static std::string name(std::size_t layout) { return "kitti_" + std::to_string(layout); }

  InputFolder folder_;
};

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const maxlogdet::fuzz::KittiFolders folders;
  folders.check(maxlogdet::fuzz::Bytes(data, size));
  return 0;
}
