// SPDX-License-Identifier: MIT
// The enumerators of the C API: the values of those of C++, and their names. A test asks the header for every strategy
// and camera model.
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/isa.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/version.hpp>

namespace {

using maxlogdet::BlockStatus;
using maxlogdet::CameraModel;
using maxlogdet::Status;
using maxlogdet::Strategy;
using maxlogdet::ThirdMeasurement;
using maxlogdet::Weighting;

template <class Enum>
constexpr bool is_same(int c, Enum value) noexcept {
  return c == static_cast<int>(value);
}

static_assert(is_same(MAXLOGDET_STATUS_OK, Status::ok) &&
                  is_same(MAXLOGDET_STATUS_ALL_SELECTED, Status::all_selected) &&
                  is_same(MAXLOGDET_STATUS_DEADLINE_REACHED, Status::deadline_reached) &&
                  is_same(MAXLOGDET_STATUS_INVALID_BUDGET, Status::invalid_budget) &&
                  is_same(MAXLOGDET_STATUS_INVALID_EPSILON, Status::invalid_epsilon) &&
                  is_same(MAXLOGDET_STATUS_INVALID_PRIOR, Status::invalid_prior) &&
                  is_same(MAXLOGDET_STATUS_CAPACITY_EXCEEDED, Status::capacity_exceeded) &&
                  is_same(MAXLOGDET_STATUS_INVALID_STRATEGY, Status::invalid_strategy) &&
                  is_same(MAXLOGDET_STATUS_INVALID_TIME_LIMIT, Status::invalid_time_limit) &&
                  is_same(MAXLOGDET_STATUS_INVALID_THREADS, Status::invalid_threads) &&
                  is_same(MAXLOGDET_STATUS_INVALID_GROUPS, Status::invalid_groups) &&
                  is_same(MAXLOGDET_STATUS_INFEASIBLE, Status::infeasible) &&
                  is_same(MAXLOGDET_STATUS_UNSUPPORTED_GROUPS, Status::unsupported_groups) &&
                  is_same(MAXLOGDET_STATUS_NOTHING_PROPOSED, Status::nothing_proposed) &&
                  is_same(MAXLOGDET_STATUS_INVALID_BLOCK, Status::invalid_block) &&
                  is_same(MAXLOGDET_STATUS_UNSUPPORTED_ISA, Status::unsupported_isa) &&
                  is_same(MAXLOGDET_STATUS_TARGET_REACHED, Status::target_reached) &&
                  is_same(MAXLOGDET_STATUS_INVALID_TARGET, Status::invalid_target) &&
                  is_same(MAXLOGDET_STATUS_UNSUPPORTED_TARGET, Status::unsupported_target),
              "values of the C API are permanent: a new Status goes to the end");
static_assert(is_same(MAXLOGDET_WEIGHTING_MAP_BIAS, Weighting::map_bias) &&
                  is_same(MAXLOGDET_WEIGHTING_MAP_BIAS_WORLD, Weighting::map_bias_world) &&
                  is_same(MAXLOGDET_WEIGHTING_MEASUREMENT, Weighting::measurement) &&
                  is_same(MAXLOGDET_WEIGHTING_MEASUREMENT_AND_MAP, Weighting::measurement_and_map),
              "values of the C API are permanent: a new Weighting goes to the end");
static_assert(is_same(MAXLOGDET_THIRD_MEASUREMENT_NONE, ThirdMeasurement::none) &&
                  is_same(MAXLOGDET_THIRD_MEASUREMENT_STEREO, ThirdMeasurement::stereo) &&
                  is_same(MAXLOGDET_THIRD_MEASUREMENT_DEPTH, ThirdMeasurement::depth),
              "values of the C API are permanent: a new ThirdMeasurement goes to the end");
static_assert(is_same(MAXLOGDET_CAMERA_MODEL_PINHOLE, CameraModel::pinhole) &&
                  is_same(MAXLOGDET_CAMERA_MODEL_RADIAL_TANGENTIAL, CameraModel::radial_tangential) &&
                  is_same(MAXLOGDET_CAMERA_MODEL_KANNALA_BRANDT, CameraModel::kannala_brandt) &&
                  is_same(MAXLOGDET_CAMERA_MODEL_DOUBLE_SPHERE, CameraModel::double_sphere),
              "values of the C API are for ever: a new CameraModel goes to the end, and a test finds its enumerator");
static_assert(is_same(MAXLOGDET_BLOCK_STATUS_OK, BlockStatus::ok) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_SINGULAR_RAYS, BlockStatus::singular_rays) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA, BlockStatus::invalid_camera) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_INVALID_POSE, BlockStatus::invalid_pose) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_INVALID_OPTIONS, BlockStatus::invalid_options) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_MISSING_POINTS, BlockStatus::missing_points) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_INVALID_STRIDE, BlockStatus::invalid_stride) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_UNKNOWN_CAMERA_MODEL, BlockStatus::unknown_camera_model) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA_ID, BlockStatus::invalid_camera_id) &&
                  is_same(MAXLOGDET_BLOCK_STATUS_INVALID_JACOBIANS, BlockStatus::invalid_jacobians),
              "values of the C API are permanent: a new BlockStatus goes to the end");
static_assert(int{MAXLOGDET_STATUS_INVALID_ARGUMENT} == int{MAXLOGDET_BLOCK_STATUS_INVALID_ARGUMENT} &&
                  int{MAXLOGDET_STATUS_OUT_OF_MEMORY} == int{MAXLOGDET_BLOCK_STATUS_OUT_OF_MEMORY},
              "a status that C++ lacks has the same value in both");

// nullptr for a status that C++ has.
const char* name_in_c(std::int32_t status) noexcept {
  switch (status) {
    case MAXLOGDET_STATUS_INVALID_ARGUMENT: return "invalid_argument";
    case MAXLOGDET_STATUS_OUT_OF_MEMORY: return "out_of_memory";
    default: return nullptr;
  }
}

}  // namespace

const char* maxlogdet_status_name(maxlogdet_status status) {
  const char* const name = name_in_c(status);
  return name != nullptr ? name : to_string(static_cast<Status>(status));
}

const char* maxlogdet_strategy_name(maxlogdet_strategy strategy) { return to_string(static_cast<Strategy>(strategy)); }

const char* maxlogdet_weighting_name(maxlogdet_weighting weighting) {
  return to_string(static_cast<Weighting>(weighting));
}

const char* maxlogdet_camera_model_name(maxlogdet_camera_model model) {
  return to_string(static_cast<CameraModel>(model));
}

const char* maxlogdet_block_status_name(maxlogdet_block_status status) {
  const char* const name = name_in_c(status);
  return name != nullptr ? name : to_string(static_cast<BlockStatus>(status));
}

const char* maxlogdet_version() { return maxlogdet::version(); }

const char* maxlogdet_active_isa() { return maxlogdet::active_isa(); }

const char* maxlogdet_built_in_isa(int32_t i) { return maxlogdet::built_in_isa(i); }

int32_t maxlogdet_isa_is_supported(const char* name) { return maxlogdet::isa_is_supported(name) ? 1 : 0; }
