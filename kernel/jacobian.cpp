// SPDX-License-Identifier: MIT
#include <maxlogdet/jacobian.hpp>

#include "kernel/block_writer.hpp"
#include "threading/team.hpp"

#include <cmath>

namespace maxlogdet {
namespace {

// Fewer matches than this are not worth a second thread (docs/threading.md).
constexpr std::size_t crossover = 10000;
constexpr double rotation_tolerance = 1e-3;  // of R R^T - I: poses kept in float32 pass

bool is_positive(double value) noexcept { return value > 0 && std::isfinite(value); }

bool is_rigid(const RigidTransform& transform) noexcept {
  const double* const T_cw = transform.data();
  for (int i = 0; i < 12; ++i) {
    if (!std::isfinite(T_cw[i])) return false;
  }
  double r[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[i][j] = T_cw[4 * i + j];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double dot = r[i][0] * r[j][0] + r[i][1] * r[j][1] + r[i][2] * r[j][2];
      if (std::abs(dot - (i == j ? 1 : 0)) > rotation_tolerance) return false;
    }
  }
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  return determinant > 0;
}

template <class To, class From>
constexpr bool is_same(To to, From from) noexcept {
  return static_cast<int>(to) == static_cast<int>(from);
}
static_assert(is_same(simd::BlockWeighting::map_bias, Weighting::map_bias) &&
                  is_same(simd::BlockWeighting::map_bias_world, Weighting::map_bias_world) &&
                  is_same(simd::BlockWeighting::measurement, Weighting::measurement) &&
                  is_same(simd::BlockWeighting::measurement_and_map, Weighting::measurement_and_map),
              "simd/blocks.hpp lists the weightings in this order");
static_assert(is_same(simd::ThirdRow::none, ThirdMeasurement::none) &&
                  is_same(simd::ThirdRow::stereo, ThirdMeasurement::stereo) &&
                  is_same(simd::ThirdRow::depth, ThirdMeasurement::depth),
              "simd/blocks.hpp lists the third measurements in this order");

// Where points are, as far as it can be told without reading them.
BlockStatus check(const Points& points, std::size_t size) noexcept {
  if (size == 0) return BlockStatus::ok;
  if (points.data() == nullptr) return BlockStatus::missing_points;
  const std::size_t entry = points.are_float() ? sizeof(float) : sizeof(double);
  const bool is_stride = points.stride() >= 3 * entry && points.stride() % entry == 0;
  return is_stride ? BlockStatus::ok : BlockStatus::invalid_stride;
}

BlockStatus check(const PinholeCamera& camera, const Matches& matches, const BlockOptions& options) noexcept {
  const BlockStatus of_points = check(matches.points, matches.size);
  if (of_points != BlockStatus::ok) return of_points;
  if (!is_positive(camera.fx) || !is_positive(camera.fy)) return BlockStatus::invalid_camera;
  if (options.third == ThirdMeasurement::stereo && !is_positive(camera.bf)) return BlockStatus::invalid_camera;
  if (options.threads < 0 || !is_positive(options.depth_sigma) || !(options.map_sigma >= 0) ||
      !std::isfinite(options.map_sigma) || !(options.min_depth >= 0) || !std::isfinite(options.min_depth)) {
    return BlockStatus::invalid_options;
  }
  if (options.weighting < Weighting::map_bias || options.weighting > Weighting::measurement_and_map ||
      options.third < ThirdMeasurement::none || options.third > ThirdMeasurement::depth) {
    return BlockStatus::invalid_options;
  }
  return BlockStatus::ok;
}

}  // namespace

BlockReport append_blocks(const Camera& given, const RigidTransform& T_cw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks, Executor* executor) {
  const PinholeCamera& camera = given.pinhole;
  BlockReport report;
  report.status = check(camera, matches, options);
  if (report.status == BlockStatus::ok && !is_rigid(T_cw)) report.status = BlockStatus::invalid_pose;
  if (report.status != BlockStatus::ok) return report;

  simd::BlockInput input{};
  input.weighting = static_cast<simd::BlockWeighting>(options.weighting);
  input.third = static_cast<simd::ThirdRow>(options.third);
  input.fx = camera.fx;
  input.fy = camera.fy;
  input.bf = camera.bf;
  input.T_cw = T_cw.data();
  input.map_sigma = options.map_sigma;
  input.depth_sigma = options.depth_sigma;
  input.min_depth = options.min_depth;
  input.size = matches.size;
  input.points = static_cast<const unsigned char*>(matches.points.data());
  input.point_stride = matches.points.stride();
  input.are_points_float = matches.points.are_float();
  input.sigmas = matches.sigmas;
  input.weights = matches.weights;
  input.has_third = matches.has_third;
  input.usable = matches.usable;
  input.map_covariances = matches.map_covariances;
  BlockWriter writer(blocks, matches.size);
  simd::BlockOutput output{};
  threading::Team team;
  team.run(executor, threading::workers_for(executor, options.threads, matches.size, crossover),
           [&] { output = writer.append(input, team); });

  report.appended = matches.size;
  report.invalid = matches.size - output.stored;
  report.unusable = output.unusable;
  report.behind_camera = output.behind_camera;
  report.too_near = output.too_near;
  report.singular_rays = output.singular_rays;
  if (report.singular_rays > 0) report.status = BlockStatus::singular_rays;
  return report;
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

const char* to_string(BlockStatus status) noexcept {
  switch (status) {
    case BlockStatus::ok: return "ok";
    case BlockStatus::singular_rays: return "singular_rays";
    case BlockStatus::invalid_camera: return "invalid_camera";
    case BlockStatus::invalid_pose: return "invalid_pose";
    case BlockStatus::invalid_options: return "invalid_options";
    case BlockStatus::missing_points: return "missing_points";
    case BlockStatus::invalid_stride: return "invalid_stride";
    case BlockStatus::unknown_camera_model: return "unknown_camera_model";
    case BlockStatus::invalid_camera_id: return "invalid_camera_id";
    case BlockStatus::invalid_jacobians: return "invalid_jacobians";
  }
  return "unknown";
}

}  // namespace maxlogdet
