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

bool is_pose(const double* T_cw) noexcept {
  if (T_cw == nullptr) return false;
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

BlockStatus check(const PinholeCamera& camera, const Matches& matches, const BlockOptions& options) noexcept {
  if (matches.size > 0 && matches.points == nullptr) return BlockStatus::missing_points;
  if (!is_positive(camera.fx) || !is_positive(camera.fy)) return BlockStatus::invalid_camera;
  if (options.third == ThirdMeasurement::stereo && !is_positive(camera.bf)) return BlockStatus::invalid_camera;
  if (options.threads < 0 || !is_positive(options.depth_sigma) || !(options.map_sigma >= 0) ||
      !std::isfinite(options.map_sigma)) {
    return BlockStatus::invalid_options;
  }
  if (options.weighting < Weighting::map_bias || options.weighting > Weighting::measurement_and_map ||
      options.third < ThirdMeasurement::none || options.third > ThirdMeasurement::depth) {
    return BlockStatus::invalid_options;
  }
  return BlockStatus::ok;
}

}  // namespace

BlockReport append_blocks(const PinholeCamera& camera, const double* T_cw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks, Executor* executor) {
  BlockReport report;
  report.status = check(camera, matches, options);
  if (report.status == BlockStatus::ok && !is_pose(T_cw)) report.status = BlockStatus::invalid_pose;
  if (report.status != BlockStatus::ok) return report;

  simd::BlockInput input{};
  input.weighting = static_cast<simd::BlockWeighting>(options.weighting);
  input.third = static_cast<simd::ThirdRow>(options.third);
  input.fx = camera.fx;
  input.fy = camera.fy;
  input.bf = camera.bf;
  input.T_cw = T_cw;
  input.map_sigma = options.map_sigma;
  input.depth_sigma = options.depth_sigma;
  input.size = matches.size;
  input.points = matches.points;
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
  report.behind_camera = output.behind_camera;
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
  }
  return "unknown";
}

}  // namespace maxlogdet
