// SPDX-License-Identifier: MIT
#include "kernel/c/c_structs.hpp"

#include "kernel/blocks/camera_checks.hpp"
#include "kernel/c/c_handles.hpp"

#include <cstring>
#include <type_traits>

namespace maxlogdet {
namespace c_api {
namespace {

static_assert(std::is_same<std::int32_t, int>::value && sizeof(std::size_t) == 8,
              "every field, entry of an array, or run of small fields takes 8 bytes: a struct cut at a multiple of 8 "
              "has all of it");
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
  to.prior = from.prior;
  to.time_limit = from.time_limit;
  to.strategy = static_cast<maxlogdet_strategy>(from.strategy);
  to.threads = from.threads;
  to.required = from.required;
  to.excluded = from.excluded;
  to.target_efficiency = from.target.efficiency;
  to.target_translation_sigma = from.target.translation_sigma;
  to.target_rotation_sigma = from.target.rotation_sigma;
  to.group_ids = from.groups.ids;
  to.group_count = from.groups.count;
  to.group_maximum = from.groups.maximum;
  to.group_maxima = from.groups.maxima;
  to.certificate_compute = from.certificate.compute ? 1 : 0;
  to.certificate_passes = from.certificate.passes;
  to.stochastic_epsilon = from.stochastic.epsilon;
  to.stochastic_seed = from.stochastic.seed;
  to.exchange_sweeps = from.exchange.sweeps;
  return to;
}

maxlogdet_match default_match() noexcept { return to_c(FeatureMatch()); }

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
  options.prior = from.prior;
  options.time_limit = from.time_limit;
  options.strategy = static_cast<Strategy>(from.strategy);
  options.threads = from.threads;
  options.required = from.required;
  options.excluded = from.excluded;
  options.target.efficiency = from.target_efficiency;
  options.target.translation_sigma = from.target_translation_sigma;
  options.target.rotation_sigma = from.target_rotation_sigma;
  options.groups.ids = from.group_ids;
  options.groups.count = from.group_count;
  options.groups.maximum = from.group_maximum;
  options.groups.maxima = from.group_maxima;
  options.certificate.compute = from.certificate_compute != 0;
  options.certificate.passes = from.certificate_passes;
  options.stochastic.epsilon = from.stochastic_epsilon;
  options.stochastic.seed = from.stochastic_seed;
  options.exchange.sweeps = from.exchange_sweeps;
  return true;
}

bool read(const maxlogdet_match* given, FeatureMatch& match) noexcept {
  maxlogdet_match from = default_match();
  if (!complete(given, from) || from.reserved != 0) return false;
  std::memcpy(match.point, from.point, sizeof match.point);
  std::memcpy(match.measured, from.measured, sizeof match.measured);
  match.u_right = from.u_right;
  match.depth = from.depth;
  match.sigma = from.sigma;
  match.covariance = from.covariance;
  match.jacobian = from.jacobian;
  match.id = from.id;
  match.camera_id = from.camera_id;
  match.is_required = from.is_required != 0;
  match.point_id = from.point_id;
  match.keyframe = from.keyframe;
  return true;
}

bool read(const maxlogdet_executor* given, maxlogdet_executor& executor) noexcept {
  maxlogdet_executor from = default_executor();
  if (!complete(given, from) || from.concurrency == nullptr || from.run == nullptr) return false;
  executor = from;
  return true;
}

maxlogdet_error read(const maxlogdet_camera* const* given, const double* T_cb, size_t count,
                     std::vector<RigCamera>& cameras, Rig& rig) noexcept {
  if (count > 0 && (given == nullptr || T_cb == nullptr)) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  const size_t known = count <= max_cameras ? count : 0;
  const maxlogdet_error error = with_memory([&] { cameras.resize(known); });
  if (error != MAXLOGDET_ERROR_NONE) return error;
  for (size_t i = 0; i < known; ++i) {
    if (!read(given[i], cameras[i].camera)) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
    cameras[i].T_cb = RigidTransform::row_major(T_cb + 12 * i);
  }
  rig = Rig(cameras.data(), known);  // 0: refused
  return MAXLOGDET_ERROR_NONE;
}

maxlogdet_match to_c(const FeatureMatch& match) noexcept {
  maxlogdet_match to{};
  to.struct_size = sizeof to;
  std::memcpy(to.point, match.point, sizeof to.point);
  std::memcpy(to.measured, match.measured, sizeof to.measured);
  to.u_right = match.u_right;
  to.depth = match.depth;
  to.sigma = match.sigma;
  to.covariance = match.covariance;
  to.jacobian = match.jacobian;
  to.id = match.id;
  to.camera_id = match.camera_id;
  to.is_required = match.is_required ? 1 : 0;
  to.point_id = match.point_id;
  to.keyframe = match.keyframe;
  return to;
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
  to.indices = selection.indices;
  to.size = selection.size;
  to.searched = selection.searched;
  to.gains = selection.gains;
  to.log_det = selection.log_det;
  to.evaluations = selection.evaluations;
  to.float64_decisions = selection.float64_decisions;
  to.invalid_candidates = selection.invalid_candidates;
  to.upper_bound = selection.upper_bound;
  to.strategy = static_cast<maxlogdet_strategy>(selection.strategy);
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

maxlogdet_error maxlogdet_match_init(maxlogdet_match* match, size_t struct_size) {
  return init(match, struct_size, maxlogdet::c_api::default_match());
}

maxlogdet_error maxlogdet_executor_init(maxlogdet_executor* executor, size_t struct_size) {
  return init(executor, struct_size, maxlogdet::c_api::default_executor());
}
