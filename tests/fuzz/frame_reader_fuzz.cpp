// SPDX-License-Identifier: MIT
// Any bytes as a frame file (docs/frame_format.md): a frame that blocks can be made of, or one InputError.
#include "bench/world/frame_reader.hpp"
#include "bench/world/names.hpp"
#include "bench/world/text_file.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace maxlogdet::fuzz {
namespace {

template <class... Numbers>
bool all_finite(Numbers... numbers) {
  return (std::isfinite(numbers) && ...);
}

void check_pose(const std::array<double, 12>& rows) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T(rows.data());
  const Eigen::Matrix3d R = T.leftCols<3>();
  require(T.allFinite() && (R * R.transpose()).isIdentity(1.001e-3) && R.determinant() > 0, "the pose is one");
}

void check_match(const sim::Match& match, const sim::FrameCamera& camera) {
  require(all_finite(match.point[0], match.point[1], match.point[2], match.u, match.v, match.u_right, match.depth,
                     match.inv_sigma2, match.desc_dist),
          "matches are finite");
  require(match.octave >= 0 && match.octave < 64, "an octave is one", match.octave);
  require(match.inv_sigma2 > 0, "a variance is positive", match.inv_sigma2);
  require(match.camera_id < std::max<std::size_t>(camera.rig.size(), 1), "there is the camera", match.camera_id);
  require(!match.is_stereo() || camera.is_pinhole(), "right columns are of a pinhole");
  require(!(match.depth > 0) || camera.depth_sigma > 0, "depths have a deviation", match.depth);
}

void check_covariances(const sim::Frame& frame) {
  if (frame.map_covariances.empty()) return;
  require(frame.map_covariances.size() == frame.matches.size(), "every match has its covariance");
  for (const auto& covariance : frame.map_covariances) {
    if (std::isnan(covariance[0])) continue;  // unknown
    const Eigen::Map<const Eigen::Matrix3d> C(covariance.data());
    require(C.allFinite() && C == C.transpose() && C.diagonal().minCoeff() >= 0, "a covariance is symmetric");
  }
}

void check(const sim::Frame& frame) {
  check_pose(frame.T_cw_prior);
  if (frame.T_cw_true) check_pose(*frame.T_cw_true);
  check_covariances(frame);
  require(frame.width >= 0 && frame.height >= 0, "the image has a size", frame.width, frame.height);
  require(all_finite(frame.camera.depth_sigma) && frame.camera.depth_sigma >= 0, "a deviation is one");
  constexpr sim::ImageGrid grid{8, 6};
  for (const sim::Match& match : frame.matches) {
    check_match(match, frame.camera);
    require(grid.cell_of(frame, match) < grid.cells(), "every match is in a cell");
  }
}

void check_blocks(const sim::Frame& frame) {
  BlockOptions options;
  if (frame.camera.depth_sigma > 0) options.depth_sigma = frame.camera.depth_sigma;
  BlockStore blocks;
  const BlockReport report =
      sim::build_blocks(frame, sim::feature_matches(frame, frame.camera.depth_cue()), options, blocks);
  require(report.error == Error::none, "blocks can be made of a frame", to_string(report.error));
  require(blocks.size() == frame.matches.size() && report.appended == blocks.size(), "every match has its candidate");
  require(report.invalid == blocks.size() - blocks.stored(), "invalid candidates are counted");
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double block[max_block_rows * state_dimension] = {};
    blocks.block(i, block);
    for (const double entry : block) require(std::isfinite(entry), "valid blocks are finite", i);
  }
}

// Of this process alone; where TMPDIR says, which ci/fuzz sets to memory.
struct Folder {
  Folder() { require(mkdtemp(path.data()) != nullptr, "a folder can be made as", path); }
  ~Folder() {
    std::error_code error;
    std::filesystem::remove_all(path, error);
  }
  std::string path = (std::filesystem::temp_directory_path() / "maxlogdet_fuzz_XXXXXX").string();
};

void check_file(const char* bytes, std::size_t size) {
  static const Folder folder;
  const std::string path = folder.path + "/frame_1.csv";
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(bytes, static_cast<std::streamsize>(size));
  stream.close();
  require(!stream.fail(), "a file can be written:", path);
  sim::Frame frame;
  try {
    frame = sim::read_frame(path);
  } catch (const sim::InputError& error) {
    const std::string message = error.what();
    require(message.rfind(path + ":", 0) == 0, "an error begins with the file's name:", message);
    require(message.find('\n') == std::string::npos, "an error is one line:", message);
    require(message.find("expected") != std::string::npos, "an error tells what was expected:", message);
    return;
  } catch (const std::exception& error) {
    require(false, "a reader throws nothing but InputError:", error.what());
  }
  check(frame);
  check_blocks(frame);
}

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::check_file(reinterpret_cast<const char*>(data), size);
  return 0;
}
