// SPDX-License-Identifier: MIT
#include <maxlogdet/jacobian.hpp>

#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/block_planes.hpp"
#include "kernel/blocks/camera_checks.hpp"

namespace maxlogdet {
namespace {

simd::BlockInput block_input(const RigidTransform& T_bw, const Matches& matches, const BlockOptions& options) noexcept {
  simd::BlockInput input{};
  input.weighting = options.weighting;
  input.third = options.depth_cue;
  input.T_bw = T_bw.data();
  input.map_sigma = options.map_sigma;
  input.depth_sigma = options.depth_sigma;
  input.min_depth = options.min_depth;
  input.size = matches.size;
  input.points = static_cast<const unsigned char*>(matches.points.data());
  input.point_stride = matches.points.stride();
  input.are_points_float = matches.points.are_float();
  input.sigmas = matches.sigmas;
  input.has_third = matches.has_depth_cue;
  input.usable = matches.usable;
  input.map_covariances = matches.map_covariances;
  input.camera_ids = matches.camera_ids;
  return input;
}

BlockReport report_of(const simd::BlockInput& input, const simd::BlockOutput& output) noexcept {
  BlockReport report;
  report.appended = input.size;
  report.invalid = input.size - output.stored;
  report.unusable = output.invalid[simd::unusable];
  report.behind_camera = output.invalid[simd::behind_camera];
  report.too_near = output.invalid[simd::too_near];
  report.singular_rays = output.invalid[simd::singular_ray];
  report.invalid_covariances = output.invalid[simd::invalid_covariance];
  return report;
}

}  // namespace

BlockReport append_blocks(const Camera* cameras, std::size_t count, const RigidTransform& T_bw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks) {
  BlockReport report;
  report.error = check(matches.points, matches.size);
  if (report.error == Error::none) report.error = check(cameras, count, options, T_bw);
  if (report.error != Error::none) return report;
  simd::CameraInput inputs[max_cameras];
  for (std::size_t i = 0; i < count; ++i) inputs[i] = camera_input(cameras[i]);
  simd::BlockInput input = block_input(T_bw, matches, options);
  input.camera = inputs[0];
  input.cameras = inputs;
  input.camera_count = count;
  return report_of(input, planes_to_fill(blocks).append(input));
}

BlockReport append_blocks(const Camera& camera, const RigidTransform& T_cw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks) {
  return append_blocks(&camera, 1, T_cw, matches, options, blocks);
}

const char* to_string(Weighting weighting) noexcept {
  switch (weighting) {
    case Weighting::map_bias: return "map_bias";
    case Weighting::map_bias_world: return "map_bias_world";
    case Weighting::measurement: return "measurement";
    case Weighting::measurement_and_map: return "measurement_and_map";
  }
  return "unknown";
}

}  // namespace maxlogdet
