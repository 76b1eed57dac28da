// SPDX-License-Identifier: MIT
// The names of the enumerators of the C API, which have the values of those of C++: tests/api/c_api_equals_cpp_test.cpp
// asks the header for each.
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/isa.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/version.hpp>

using maxlogdet::CameraModel;
using maxlogdet::Error;
using maxlogdet::Status;
using maxlogdet::Strategy;
using maxlogdet::Weighting;

const char* maxlogdet_error_name(maxlogdet_error error) {
  switch (error) {
    case MAXLOGDET_ERROR_INVALID_ARGUMENT: return "invalid_argument";
    case MAXLOGDET_ERROR_OUT_OF_MEMORY: return "out_of_memory";
    default: return to_string(static_cast<Error>(error));
  }
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
