// SPDX-License-Identifier: MIT
#include "kernel/c/c_structs.hpp"

#include "kernel/blocks/camera_checks.hpp"
#include "kernel/c/c_handles.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace maxlogdet {
namespace c_api {
namespace {

// A field.
template <class To, class From>
void assign(To& to, const From& from) noexcept {
  to = static_cast<To>(from);
}
// An array of them.
template <std::size_t n>
void assign(double (&to)[n], const double (&from)[n]) noexcept {
  std::copy_n(from, n, to);
}

// Which field of C is which of C++. `copy` assigns either to the other.

template <class Copy>
void copy_fields(maxlogdet_camera& c, Camera& cpp, const Copy& copy) noexcept {
  copy(c.fx, cpp.pinhole.fx);
  copy(c.fy, cpp.pinhole.fy);
  copy(c.cx, cpp.pinhole.cx);
  copy(c.cy, cpp.pinhole.cy);
  copy(c.bf, cpp.pinhole.bf);
  copy(c.model, cpp.model);
  copy(c.parameters, cpp.parameters);
}

// All but the points.
template <class Copy>
void copy_fields(maxlogdet_matches& c, Matches& cpp, const Copy& copy) noexcept {
  copy(c.size, cpp.size);
  copy(c.sigmas, cpp.sigmas);
  copy(c.has_depth_cue, cpp.has_depth_cue);
  copy(c.usable, cpp.usable);
  copy(c.weights, cpp.weights);
  copy(c.map_covariances, cpp.map_covariances);
  copy(c.jacobians, cpp.jacobians);
  copy(c.camera_ids, cpp.camera_ids);
}

template <class Copy>
void copy_fields(maxlogdet_block_options& c, BlockOptions& cpp, const Copy& copy) noexcept {
  copy(c.weighting, cpp.weighting);
  copy(c.depth_cue, cpp.depth_cue);
  copy(c.map_sigma, cpp.map_sigma);
  copy(c.depth_sigma, cpp.depth_sigma);
  copy(c.min_depth, cpp.min_depth);
  copy(c.threads, cpp.threads);
}

template <class Copy>
void copy_fields(maxlogdet_options& c, Options& cpp, const Copy& copy) noexcept {
  copy(c.budget, cpp.budget);
  copy(c.prior, cpp.prior);
  copy(c.time_limit, cpp.time_limit);
  copy(c.strategy, cpp.strategy);
  copy(c.threads, cpp.threads);
  copy(c.required, cpp.required);
  copy(c.excluded, cpp.excluded);
  copy(c.target_efficiency, cpp.target.efficiency);
  copy(c.target_translation_sigma, cpp.target.translation_sigma);
  copy(c.target_rotation_sigma, cpp.target.rotation_sigma);
  copy(c.group_ids, cpp.groups.ids);
  copy(c.group_count, cpp.groups.count);
  copy(c.group_maximum, cpp.groups.maximum);
  copy(c.group_maxima, cpp.groups.maxima);
  copy(c.certificate_compute, cpp.certificate.compute);
  copy(c.certificate_passes, cpp.certificate.passes);
  copy(c.stochastic_epsilon, cpp.stochastic.epsilon);
  copy(c.stochastic_seed, cpp.stochastic.seed);
  copy(c.exchange_sweeps, cpp.exchange.sweeps);
}

template <class Copy>
void copy_fields(maxlogdet_match& c, FeatureMatch& cpp, const Copy& copy) noexcept {
  copy(c.point, cpp.point);
  copy(c.measured, cpp.measured);
  copy(c.u_right, cpp.u_right);
  copy(c.depth, cpp.depth);
  copy(c.sigma, cpp.sigma);
  copy(c.covariance, cpp.covariance);
  copy(c.jacobian, cpp.jacobian);
  copy(c.id, cpp.id);
  copy(c.camera_id, cpp.camera_id);
  copy(c.is_required, cpp.is_required);
  copy(c.point_id, cpp.point_id);
  copy(c.keyframe, cpp.keyframe);
}

static_assert(std::is_same<std::int32_t, int>::value && sizeof(std::size_t) == 8,
              "every field, entry of an array, or run of small fields takes 8 bytes: a struct cut at a multiple of 8 "
              "has all of it");
constexpr std::size_t min_size = 16;
constexpr std::size_t size_step = 8;

template <class C>
bool is_size_of(std::size_t size) noexcept {
  return size >= min_size && size <= sizeof(C) && size % size_step == 0;
}

// With struct_size and, where C++ has no such field, zeros.
template <class C, class Cpp>
C whole(Cpp cpp) noexcept {
  C c{};
  c.struct_size = sizeof c;
  copy_fields(c, cpp, [](auto& in_c, const auto& in_cpp) { assign(in_c, in_cpp); });
  return c;
}

template <class C>
maxlogdet_error init(C* given, std::size_t size, const C& defaults) noexcept {
  if (given == nullptr) return refused;
  if (!is_size_of<C>(size)) {
    if (size >= sizeof given->struct_size) given->struct_size = 0;  // refused wherever it is read
    return refused;
  }
  std::memcpy(given, &defaults, size);
  given->struct_size = size;
  return MAXLOGDET_ERROR_NONE;
}

// Overwrites the defaults in `full` with the fields that `given` has.
template <class C>
bool complete(const C* given, C& full) noexcept {
  if (given == nullptr || !is_size_of<C>(given->struct_size)) return false;
  std::memcpy(&full, given, given->struct_size);
  return true;
}

template <class C, class Cpp>
void copy_to_cpp(C& c, Cpp& cpp) noexcept {
  copy_fields(c, cpp, [](const auto& in_c, auto& in_cpp) { assign(in_cpp, in_c); });
}

template <class C, class Cpp>
bool read_struct(const C* given, Cpp& cpp) noexcept {
  C c = whole<C>(Cpp());
  if (!complete(given, c) || c.reserved != 0) return false;
  copy_to_cpp(c, cpp);
  return true;
}

template <class Scalar>
Points points_of(const maxlogdet_matches& c) noexcept {
  return {static_cast<const Scalar*>(c.points), c.point_stride == 0 ? 3 * sizeof(Scalar) : c.point_stride};
}

}  // namespace

bool read(const maxlogdet_camera* given, Camera& camera) noexcept { return read_struct(given, camera); }
bool read(const maxlogdet_block_options* given, BlockOptions& options) noexcept { return read_struct(given, options); }
bool read(const maxlogdet_options* given, Options& options) noexcept { return read_struct(given, options); }
bool read(const maxlogdet_match* given, FeatureMatch& match) noexcept { return read_struct(given, match); }

bool read(const maxlogdet_matches* given, Matches& matches) noexcept {
  auto c = whole<maxlogdet_matches>(Matches());
  if (!complete(given, c) || c.reserved != 0) return false;
  const bool are_float = c.point_type == MAXLOGDET_POINT_TYPE_FLOAT32;
  if (!are_float && c.point_type != MAXLOGDET_POINT_TYPE_FLOAT64) return false;
  copy_to_cpp(c, matches);
  matches.points = are_float ? points_of<float>(c) : points_of<double>(c);
  return true;
}

bool read(const maxlogdet_executor* given, maxlogdet_executor& executor) noexcept {
  maxlogdet_executor c{};
  if (given != nullptr && (!complete(given, c) || c.concurrency == nullptr || c.run == nullptr)) return false;
  executor = c;
  return true;
}

maxlogdet_error read(const maxlogdet_camera* const* given, const double* T_cb, size_t count,
                     std::vector<RigCamera>& cameras, Rig& rig) noexcept {
  if (count > 0 && (given == nullptr || T_cb == nullptr)) return refused;
  const size_t known = count <= max_cameras ? count : 0;
  const maxlogdet_error error = with_memory([&] { cameras.resize(known); });
  if (error != MAXLOGDET_ERROR_NONE) return error;
  for (size_t i = 0; i < known; ++i) {
    if (!read(given[i], cameras[i].camera)) return refused;
    cameras[i].T_cb = RigidTransform::row_major(T_cb + 12 * i);
  }
  rig = Rig(cameras.data(), known);  // 0: refused
  return MAXLOGDET_ERROR_NONE;
}

maxlogdet_match to_c(const FeatureMatch& match) noexcept { return whole<maxlogdet_match>(match); }

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
using maxlogdet::c_api::whole;

maxlogdet_error maxlogdet_camera_init(maxlogdet_camera* camera, size_t struct_size) {
  return init(camera, struct_size, whole<maxlogdet_camera>(maxlogdet::Camera()));
}

maxlogdet_error maxlogdet_matches_init(maxlogdet_matches* matches, size_t struct_size) {
  return init(matches, struct_size, whole<maxlogdet_matches>(maxlogdet::Matches()));
}

maxlogdet_error maxlogdet_block_options_init(maxlogdet_block_options* options, size_t struct_size) {
  return init(options, struct_size, whole<maxlogdet_block_options>(maxlogdet::BlockOptions()));
}

maxlogdet_error maxlogdet_options_init(maxlogdet_options* options, size_t struct_size) {
  return init(options, struct_size, whole<maxlogdet_options>(maxlogdet::Options()));
}

maxlogdet_error maxlogdet_match_init(maxlogdet_match* match, size_t struct_size) {
  return init(match, struct_size, whole<maxlogdet_match>(maxlogdet::FeatureMatch()));
}

maxlogdet_error maxlogdet_executor_init(maxlogdet_executor* executor, size_t struct_size) {
  return init(executor, struct_size, maxlogdet_executor{});
}
