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

using maxlogdet::CameraModel;
using maxlogdet::DepthCue;
using maxlogdet::Error;
using maxlogdet::Status;
using maxlogdet::Strategy;
using maxlogdet::Weighting;

template <class Enum>
constexpr bool is_same(int c, Enum value) noexcept {
  return c == static_cast<int>(value);
}

static_assert(is_same(MAXLOGDET_STATUS_OK, Status::ok) &&
                  is_same(MAXLOGDET_STATUS_ALL_SELECTED, Status::all_selected) &&
                  is_same(MAXLOGDET_STATUS_TARGET_REACHED, Status::target_reached) &&
                  is_same(MAXLOGDET_STATUS_DEADLINE_REACHED, Status::deadline_reached) &&
                  is_same(MAXLOGDET_STATUS_FEW_CANDIDATES, Status::few_candidates) &&
                  is_same(MAXLOGDET_STATUS_ERROR, Status::error),
              "values of the C API are permanent: a new Status goes to the end");
static_assert(is_same(MAXLOGDET_ERROR_NONE, Error::none) &&
                  is_same(MAXLOGDET_ERROR_CAPACITY_EXCEEDED, Error::capacity_exceeded) &&
                  is_same(MAXLOGDET_ERROR_INVALID_STRATEGY, Error::invalid_strategy) &&
                  is_same(MAXLOGDET_ERROR_INVALID_EPSILON, Error::invalid_epsilon) &&
                  is_same(MAXLOGDET_ERROR_INVALID_PRIOR, Error::invalid_prior) &&
                  is_same(MAXLOGDET_ERROR_INVALID_TIME_LIMIT, Error::invalid_time_limit) &&
                  is_same(MAXLOGDET_ERROR_INVALID_THREADS, Error::invalid_threads) &&
                  is_same(MAXLOGDET_ERROR_INVALID_GROUPS, Error::invalid_groups) &&
                  is_same(MAXLOGDET_ERROR_UNSUPPORTED_GROUPS, Error::unsupported_groups) &&
                  is_same(MAXLOGDET_ERROR_INVALID_TARGET, Error::invalid_target) &&
                  is_same(MAXLOGDET_ERROR_UNSUPPORTED_TARGET, Error::unsupported_target) &&
                  is_same(MAXLOGDET_ERROR_INFEASIBLE, Error::infeasible) &&
                  is_same(MAXLOGDET_ERROR_UNSUPPORTED_ISA, Error::unsupported_isa) &&
                  is_same(MAXLOGDET_ERROR_INVALID_CAMERA, Error::invalid_camera) &&
                  is_same(MAXLOGDET_ERROR_UNKNOWN_CAMERA_MODEL, Error::unknown_camera_model) &&
                  is_same(MAXLOGDET_ERROR_INVALID_CAMERA_ID, Error::invalid_camera_id) &&
                  is_same(MAXLOGDET_ERROR_INVALID_POSE, Error::invalid_pose) &&
                  is_same(MAXLOGDET_ERROR_INVALID_BLOCK_OPTIONS, Error::invalid_block_options) &&
                  is_same(MAXLOGDET_ERROR_MISSING_POINTS, Error::missing_points) &&
                  is_same(MAXLOGDET_ERROR_INVALID_STRIDE, Error::invalid_stride) &&
                  is_same(MAXLOGDET_ERROR_MIXED_DEPTH_CUES, Error::mixed_depth_cues) &&
                  is_same(MAXLOGDET_ERROR_NOTHING_PROPOSED, Error::nothing_proposed) &&
                  is_same(MAXLOGDET_ERROR_INVALID_BLOCK, Error::invalid_block),
              "values of the C API are permanent: a new Error goes to the end");
static_assert(is_same(MAXLOGDET_WEIGHTING_MAP_BIAS, Weighting::map_bias) &&
                  is_same(MAXLOGDET_WEIGHTING_MAP_BIAS_WORLD, Weighting::map_bias_world) &&
                  is_same(MAXLOGDET_WEIGHTING_MEASUREMENT, Weighting::measurement) &&
                  is_same(MAXLOGDET_WEIGHTING_MEASUREMENT_AND_MAP, Weighting::measurement_and_map),
              "values of the C API are permanent: a new Weighting goes to the end");
static_assert(is_same(MAXLOGDET_DEPTH_CUE_NONE, DepthCue::none) &&
                  is_same(MAXLOGDET_DEPTH_CUE_STEREO, DepthCue::stereo) &&
                  is_same(MAXLOGDET_DEPTH_CUE_DEPTH, DepthCue::depth),
              "values of the C API are permanent: a new DepthCue goes to the end");
static_assert(is_same(MAXLOGDET_CAMERA_MODEL_PINHOLE, CameraModel::pinhole) &&
                  is_same(MAXLOGDET_CAMERA_MODEL_RADIAL_TANGENTIAL, CameraModel::radial_tangential) &&
                  is_same(MAXLOGDET_CAMERA_MODEL_KANNALA_BRANDT, CameraModel::kannala_brandt) &&
                  is_same(MAXLOGDET_CAMERA_MODEL_DOUBLE_SPHERE, CameraModel::double_sphere),
              "values of the C API are for ever: a new CameraModel goes to the end, and a test finds its enumerator");
// nullptr for an error that C++ has.
const char* name_in_c(maxlogdet_error error) noexcept {
  switch (error) {
    case MAXLOGDET_ERROR_INVALID_ARGUMENT: return "invalid_argument";
    case MAXLOGDET_ERROR_OUT_OF_MEMORY: return "out_of_memory";
    default: return nullptr;
  }
}

}  // namespace

const char* maxlogdet_error_name(maxlogdet_error error) {
  const char* const name = name_in_c(error);
  return name != nullptr ? name : to_string(static_cast<Error>(error));
}

const char* maxlogdet_error_explanation(maxlogdet_error error) {
  switch (error) {
    case MAXLOGDET_ERROR_INVALID_ARGUMENT:
      return "a null pointer, a struct that init has not filled in, or no functions";
    case MAXLOGDET_ERROR_OUT_OF_MEMORY: return "there is no memory";
    default: return explain(static_cast<Error>(error));
  }
}

const char* maxlogdet_status_name(maxlogdet_status status) { return to_string(static_cast<Status>(status)); }

const char* maxlogdet_strategy_name(maxlogdet_strategy strategy) { return to_string(static_cast<Strategy>(strategy)); }

const char* maxlogdet_weighting_name(maxlogdet_weighting weighting) {
  return to_string(static_cast<Weighting>(weighting));
}

const char* maxlogdet_camera_model_name(maxlogdet_camera_model model) {
  return to_string(static_cast<CameraModel>(model));
}

const char* maxlogdet_version() { return maxlogdet::version(); }

const char* maxlogdet_active_isa() { return maxlogdet::active_isa(); }

const char* maxlogdet_built_in_isa(int32_t i) { return maxlogdet::built_in_isa(i); }

int32_t maxlogdet_isa_is_supported(const char* name) { return maxlogdet::isa_is_supported(name) ? 1 : 0; }
