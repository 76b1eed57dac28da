// SPDX-License-Identifier: MIT
#include <maxlogdet/jacobian.hpp>

#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/block_writer.hpp"
#include "kernel/blocks/camera_checks.hpp"
#include "threading/team.hpp"

#include <cmath>

namespace maxlogdet {
namespace {

// Fewer matches than this are not worth a second thread (docs/threading.md).
constexpr std::size_t crossover = 10000;

Error first_error(Error first, Error second) noexcept { return first == Error::none ? second : first; }

// Ids of matches that are not usable are not read.
Error check_ids(const Cameras& cameras, const Matches& matches) noexcept {
  const unsigned char* const ids = matches.camera_ids;
  if (cameras.data() == nullptr || cameras.size() == 0 || cameras.size() > max_cameras) {
    return Error::invalid_camera_id;
  }
  if (ids == nullptr) return Error::none;
  if (!cameras.is_rig) return Error::invalid_camera_id;
  for (std::size_t i = 0; i < matches.size; ++i) {
    if (ids[i] >= cameras.size() && (matches.usable == nullptr || matches.usable[i] != 0)) {
      return Error::invalid_camera_id;
    }
  }
  return Error::none;
}

Error check(const Cameras& cameras, const RigidTransform& T, const Matches& matches,
            const BlockOptions& options) noexcept {
  Error error = first_error(check(matches.points, matches.size), check_ids(cameras, matches));
  if (error != Error::none) return error;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    error = first_error(error, check(cameras.data()[i].camera, matches.jacobians != nullptr, options.depth_cue));
  }
  error = first_error(error, check(options));
  bool are_rigid = is_rigid(T);
  for (std::size_t i = 0; cameras.is_rig && i < cameras.size(); ++i) are_rigid &= is_rigid(cameras.data()[i].T_cb);
  return first_error(error, are_rigid ? Error::none : Error::invalid_pose);
}

simd::BlockInput block_input(const RigidTransform& T, const Matches& matches, const BlockOptions& options) noexcept {
  simd::BlockInput input{};
  input.weighting = options.weighting;
  input.third = options.depth_cue;
  input.T_cw = T.data();
  input.map_sigma = options.map_sigma;
  input.depth_sigma = options.depth_sigma;
  input.min_depth = options.min_depth;
  input.size = matches.size;
  input.points = static_cast<const unsigned char*>(matches.points.data());
  input.point_stride = matches.points.stride();
  input.are_points_float = matches.points.are_float();
  input.sigmas = matches.sigmas;
  input.weights = matches.weights;
  input.has_third = matches.has_depth_cue;
  input.usable = matches.usable;
  input.map_covariances = matches.map_covariances;
  input.jacobians = matches.jacobians;
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
  report.invalid_jacobians = output.invalid[simd::invalid_jacobian];
  return report;
}

}  // namespace

BlockReport append_blocks(const Cameras& cameras, const RigidTransform& T_cw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks, Executor* executor) {
  BlockReport report;
  report.error = check(cameras, T_cw, matches, options);
  if (report.error != Error::none) return report;
  simd::BlockInput input = block_input(T_cw, matches, options);
  simd::CameraInput inputs[max_cameras];
  for (std::size_t i = 0; i < cameras.size(); ++i) inputs[i] = camera_input(cameras.data()[i]);
  input.camera = inputs[0];
  input.rig = cameras.is_rig ? inputs : nullptr;
  input.rig_size = cameras.size();
  BlockWriter writer(blocks, input.size);
  simd::BlockOutput output{};
  threading::Team team;
  team.run(executor, threading::workers_for(executor, options.threads, input.size, crossover),
           [&] { output = writer.append(input, team); });
  return report_of(input, output);
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
