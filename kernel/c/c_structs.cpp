// SPDX-License-Identifier: MIT
#include "kernel/c/c_structs.hpp"

#include <cstring>
#include <type_traits>

namespace maxlogdet {
namespace c_api {
namespace {

static_assert(
    std::is_same<std::int32_t, int>::value && sizeof(std::size_t) == 8,
    "every field, or pair of fields, takes 8 bytes, so that a struct cut at a multiple of 8 ends after a field");
constexpr std::size_t min_size = 16;
constexpr std::size_t size_step = 8;

template <class Struct>
bool is_size_of(std::size_t size) noexcept {
  return size >= min_size && size <= sizeof(Struct) && size % size_step == 0;
}

// The defaults of a caller that fills in nothing: those of C++, which are thus defined once.

maxlogdet_camera default_camera() noexcept {
  const Camera from;
  maxlogdet_camera to{};
  to.struct_size = sizeof to;
  to.fx = from.pinhole.fx;
  to.fy = from.pinhole.fy;
  to.cx = from.pinhole.cx;
  to.cy = from.pinhole.cy;
  to.bf = from.pinhole.bf;
  to.model = static_cast<maxlogdet_camera_model>(from.model);
  std::memcpy(to.parameters, from.parameters, sizeof to.parameters);
  return to;
}

maxlogdet_matches default_matches() noexcept {
  const Matches from;
  maxlogdet_matches to{};
  to.struct_size = sizeof to;
  to.size = from.size;
  to.points = from.points.data();
  to.point_type = MAXLOGDET_POINT_TYPE_FLOAT64;
  to.sigmas = from.sigmas;
  to.has_depth_cue = from.has_depth_cue;
  to.usable = from.usable;
  to.weights = from.weights;
  to.map_covariances = from.map_covariances;
  to.jacobians = from.jacobians;
  to.camera_ids = from.camera_ids;
  return to;
}

maxlogdet_block_options default_block_options() noexcept {
  const BlockOptions from;
  maxlogdet_block_options to{};
  to.struct_size = sizeof to;
  to.weighting = static_cast<maxlogdet_weighting>(from.weighting);
  to.depth_cue = static_cast<maxlogdet_depth_cue>(from.depth_cue);
  to.map_sigma = from.map_sigma;
  to.depth_sigma = from.depth_sigma;
  to.min_depth = from.min_depth;
  to.threads = from.threads;
  return to;
}

maxlogdet_options default_options() noexcept {
  const Options from;
  maxlogdet_options to{};
  to.struct_size = sizeof to;
  to.budget = from.budget;
  to.strategy = static_cast<maxlogdet_strategy>(from.strategy);
  to.threads = from.threads;
  to.epsilon = from.stochastic.epsilon;
  to.seed = from.stochastic.seed;
  to.prior = from.prior;
  to.time_limit = from.time_limit;
  to.certificate = from.certificate.compute ? 1 : 0;
  to.certificate_passes = from.certificate.passes;
  to.exchange_sweeps = from.exchange.sweeps;
  to.required = from.required;
  to.excluded = from.excluded;
  to.groups = from.groups.ids;
  to.group_count = from.groups.count;
  to.max_per_group = from.groups.maximum;
  to.group_maxima = from.groups.maxima;
  to.target_efficiency = from.target.efficiency;
  to.target_translation_sigma = from.target.translation_sigma;
  to.target_rotation_sigma = from.target.rotation_sigma;
  return to;
}

maxlogdet_executor default_executor() noexcept { return {sizeof(maxlogdet_executor), nullptr, nullptr, nullptr}; }

template <class Struct>
maxlogdet_error init(Struct* given, std::size_t size, const Struct& defaults) noexcept {
  if (given == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  if (!is_size_of<Struct>(size)) {
    if (size >= sizeof given->struct_size) given->struct_size = 0;  // refused wherever it is read
    return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  }
  std::memcpy(given, &defaults, size);
  given->struct_size = size;
  return MAXLOGDET_ERROR_NONE;
}

// Overwrites the defaults in `full` with the fields that `given` has.
template <class Struct>
bool complete(const Struct* given, Struct& full) noexcept {
  if (given == nullptr) return false;
  const std::size_t size = given->struct_size;
  if (!is_size_of<Struct>(size)) return false;
  std::memcpy(&full, given, size);
  return true;
}

template <class Scalar>
Points points_of(const maxlogdet_matches& from) noexcept {
  return {static_cast<const Scalar*>(from.points), from.point_stride == 0 ? 3 * sizeof(Scalar) : from.point_stride};
}

bool read_points(const maxlogdet_matches& from, Points& points) noexcept {
  const bool are_float = from.point_type == MAXLOGDET_POINT_TYPE_FLOAT32;
  if (!are_float && from.point_type != MAXLOGDET_POINT_TYPE_FLOAT64) return false;
  points = are_float ? points_of<float>(from) : points_of<double>(from);
  return true;
}

}  // namespace

bool read(const maxlogdet_camera* given, Camera& camera) noexcept {
  maxlogdet_camera from = default_camera();
  if (!complete(given, from) || from.reserved != 0) return false;
  camera = Camera(from.fx, from.fy, from.cx, from.cy, from.bf);
  camera.model = static_cast<CameraModel>(from.model);
  std::memcpy(camera.parameters, from.parameters, sizeof camera.parameters);
  return true;
}

bool read(const maxlogdet_matches* given, Matches& matches) noexcept {
  maxlogdet_matches from = default_matches();
  if (!complete(given, from) || from.reserved != 0 || !read_points(from, matches.points)) return false;
  matches.size = from.size;
  matches.sigmas = from.sigmas;
  matches.has_depth_cue = from.has_depth_cue;
  matches.usable = from.usable;
  matches.weights = from.weights;
  matches.map_covariances = from.map_covariances;
  matches.jacobians = from.jacobians;
  matches.camera_ids = from.camera_ids;
  return true;
}

bool read(const maxlogdet_block_options* given, BlockOptions& options) noexcept {
  maxlogdet_block_options from = default_block_options();
  if (!complete(given, from) || from.reserved != 0) return false;
  options.weighting = static_cast<Weighting>(from.weighting);
  options.depth_cue = static_cast<DepthCue>(from.depth_cue);
  options.map_sigma = from.map_sigma;
  options.depth_sigma = from.depth_sigma;
  options.min_depth = from.min_depth;
  options.threads = from.threads;
  return true;
}

bool read(const maxlogdet_options* given, Options& options) noexcept {
  maxlogdet_options from = default_options();
  if (!complete(given, from) || from.reserved != 0) return false;
  options.budget = from.budget;
  options.strategy = static_cast<Strategy>(from.strategy);
  options.threads = from.threads;
  options.stochastic.epsilon = from.epsilon;
  options.stochastic.seed = from.seed;
  options.prior = from.prior;
  options.time_limit = from.time_limit;
  options.certificate.compute = from.certificate != 0;
  options.certificate.passes = from.certificate_passes;
  options.exchange.sweeps = from.exchange_sweeps;
  options.required = from.required;
  options.excluded = from.excluded;
  options.groups.ids = from.groups;
  options.groups.count = from.group_count;
  options.groups.maximum = from.max_per_group;
  options.groups.maxima = from.group_maxima;
  options.target.efficiency = from.target_efficiency;
  options.target.translation_sigma = from.target_translation_sigma;
  options.target.rotation_sigma = from.target_rotation_sigma;
  return true;
}

bool read(const maxlogdet_executor* given, maxlogdet_executor& executor) noexcept {
  maxlogdet_executor from = default_executor();
  if (!complete(given, from) || from.concurrency == nullptr || from.run == nullptr) return false;
  executor = from;
  return true;
}

maxlogdet_block_report to_c(const BlockReport& report) noexcept {
  maxlogdet_block_report to{};
  to.error = static_cast<maxlogdet_error>(report.error);
  to.appended = report.appended;
  to.invalid = report.invalid;
  to.unusable = report.unusable;
  to.behind_camera = report.behind_camera;
  to.too_near = report.too_near;
  to.singular_rays = report.singular_rays;
  to.invalid_covariances = report.invalid_covariances;
  to.invalid_jacobians = report.invalid_jacobians;
  return to;
}

maxlogdet_selection to_c(const Selection& selection) noexcept {
  maxlogdet_selection to{};
  to.status = static_cast<maxlogdet_status>(selection.status);
  to.error = static_cast<maxlogdet_error>(selection.error);
  to.strategy = static_cast<maxlogdet_strategy>(selection.strategy);
  to.size = selection.size;
  to.indices = selection.indices;
  to.gains = selection.gains;
  to.log_det = selection.log_det;
  to.upper_bound = selection.upper_bound;
  to.evaluations = selection.evaluations;
  to.float64_decisions = selection.float64_decisions;
  to.invalid_candidates = selection.invalid_candidates;
  to.threads = selection.threads;
  to.efficiency = selection.efficiency;
  to.translation_sigma = selection.translation_sigma;
  to.rotation_sigma = selection.rotation_sigma;
  return to;
}

}  // namespace c_api
}  // namespace maxlogdet

using maxlogdet::c_api::init;

maxlogdet_error maxlogdet_camera_init(maxlogdet_camera* camera, size_t struct_size) {
  return init(camera, struct_size, maxlogdet::c_api::default_camera());
}

maxlogdet_error maxlogdet_matches_init(maxlogdet_matches* matches, size_t struct_size) {
  return init(matches, struct_size, maxlogdet::c_api::default_matches());
}

maxlogdet_error maxlogdet_block_options_init(maxlogdet_block_options* options, size_t struct_size) {
  return init(options, struct_size, maxlogdet::c_api::default_block_options());
}

maxlogdet_error maxlogdet_options_init(maxlogdet_options* options, size_t struct_size) {
  return init(options, struct_size, maxlogdet::c_api::default_options());
}

maxlogdet_error maxlogdet_executor_init(maxlogdet_executor* executor, size_t struct_size) {
  return init(executor, struct_size, maxlogdet::c_api::default_executor());
}
