// SPDX-License-Identifier: MIT
// Any bytes as a frame file (docs/frame_format.md): a frame that blocks can be made of, or one InputError.
#include "sim/frame_reader.hpp"
#include "sim/names.hpp"
#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/input_folder.hpp"
#include "tests/fuzz/require.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <initializer_list>

namespace maxlogdet::fuzz {
namespace {

bool all_finite(std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

void check(const sim::Frame& frame) {
  const PinholeCamera& camera = frame.camera;
  require(all_finite({camera.fx, camera.fy, camera.cx, camera.cy, camera.bf}), "the camera is finite");
  require(camera.fx > 0 && camera.fy > 0 && camera.bf >= 0, "the camera is one", camera.fx, camera.fy, camera.bf);
  require(frame.width > 0 && frame.height > 0, "the image has a size", frame.width, frame.height);
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T_cw(frame.T_cw_prior.data());
  const Eigen::Matrix3d R = T_cw.leftCols<3>();
  require(T_cw.allFinite() && (R * R.transpose()).isIdentity(1.001e-3) && R.determinant() > 0, "the pose is one");
  require(frame.map_covariances.empty(), "a file has no covariances");
  for (const sim::Match& match : frame.matches) {
    require(all_finite({match.point[0], match.point[1], match.point[2], match.u, match.v, match.u_right,
                        match.inv_sigma2, match.desc_dist}),
            "matches are finite");
    require(match.octave >= 0 && match.octave < 64, "an octave is one", match.octave);
    require(match.inv_sigma2 > 0, "a variance is positive", match.inv_sigma2);
  }
}

void check_blocks(const sim::Frame& frame) {
  for (const Weighting weighting : sim::weightings) {
    BlockOptions options;
    options.weighting = weighting;
    if (frame.camera.bf > 0) options.third = ThirdMeasurement::stereo;
    BlockStore blocks;
    const BlockReport report = sim::build_blocks(frame, options, blocks);
    require(report.status == BlockStatus::ok || report.status == BlockStatus::singular_rays,
            "blocks can be made of a frame", to_string(weighting), to_string(report.status));
    require(blocks.size() == frame.matches.size() && report.appended == blocks.size(), "every match has its candidate");
    require(report.invalid == blocks.invalid_count(), "invalid candidates are counted");
    for (std::size_t i = 0; i < blocks.stored(); ++i) {
      for (int e = 0; e < blocks.rows() * state_dimension; ++e) {
        const float entry = blocks.plane(e / state_dimension, e % state_dimension)[i];
        require(std::isfinite(entry), "valid blocks are finite", i);
      }
    }
  }
}

void check_file(Bytes bytes) {
  static const InputFolder folder;
  folder.write("frame_1.csv", bytes.rest());
  sim::Frame frame;
  if (!reads([&] { frame = sim::read_frame(folder.path("frame_1.csv")); }, folder.path("frame_1.csv:"))) return;
  check(frame);
  check_blocks(frame);
}

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::check_file(maxlogdet::fuzz::Bytes(data, size));
  return 0;
}
