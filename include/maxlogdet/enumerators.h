// SPDX-License-Identifier: MIT
#pragma once

// The enumerators of maxlogdet/maxlogdet.h, with the values and names of those of C++.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What is wrong, as maxlogdet_error_explanation says it in words. Negative values are C's own.
typedef int32_t maxlogdet_error;
enum {
  MAXLOGDET_ERROR_OUT_OF_MEMORY = -2,     ///< there is no memory; nothing has been done
  MAXLOGDET_ERROR_INVALID_ARGUMENT = -1,  ///< a null pointer, a struct that init has not filled in, or no functions
  MAXLOGDET_ERROR_NONE = 0,
  MAXLOGDET_ERROR_CAPACITY_EXCEEDED = 1,
  MAXLOGDET_ERROR_INVALID_STRATEGY = 2,
  MAXLOGDET_ERROR_INVALID_EPSILON = 3,
  MAXLOGDET_ERROR_INVALID_PRIOR = 4,
  MAXLOGDET_ERROR_INVALID_TIME_LIMIT = 5,
  MAXLOGDET_ERROR_INVALID_THREADS = 6,
  MAXLOGDET_ERROR_INVALID_GROUPS = 7,
  MAXLOGDET_ERROR_UNSUPPORTED_GROUPS = 8,
  MAXLOGDET_ERROR_INVALID_TARGET = 9,
  MAXLOGDET_ERROR_UNSUPPORTED_TARGET = 10,
  MAXLOGDET_ERROR_INFEASIBLE = 11,
  MAXLOGDET_ERROR_UNSUPPORTED_ISA = 12,
  MAXLOGDET_ERROR_INVALID_CAMERA = 13,
  MAXLOGDET_ERROR_UNKNOWN_CAMERA_MODEL = 14,
  MAXLOGDET_ERROR_INVALID_CAMERA_ID = 15,
  MAXLOGDET_ERROR_INVALID_POSE = 16,
  MAXLOGDET_ERROR_INVALID_BLOCK_OPTIONS = 17,
  MAXLOGDET_ERROR_MISSING_POINTS = 18,
  MAXLOGDET_ERROR_INVALID_STRIDE = 19,
  MAXLOGDET_ERROR_MIXED_DEPTH_CUES = 20,
  MAXLOGDET_ERROR_NOTHING_PROPOSED = 21,
  MAXLOGDET_ERROR_INVALID_BLOCK = 22
};

/// How a selection ended.
typedef int32_t maxlogdet_status;
enum {
  MAXLOGDET_STATUS_OK = 0,                ///< as many as the budget asks for were selected
  MAXLOGDET_STATUS_ALL_SELECTED = 1,      ///< no more may be selected: all that constraints allow, perhaps none, are in
  MAXLOGDET_STATUS_TARGET_REACHED = 2,    ///< every target given is met
  MAXLOGDET_STATUS_DEADLINE_REACHED = 3,  ///< the time limit passed: the rest of the answer was filled up at once
  MAXLOGDET_STATUS_FEW_CANDIDATES = 4,    ///< good features: fewer matches than the budget have blocks; others fill it
  MAXLOGDET_STATUS_ERROR = 5              ///< the error says why
};

/// How the candidates are searched.
typedef int32_t maxlogdet_strategy;
enum {
  MAXLOGDET_STRATEGY_GREEDY = 0,
  MAXLOGDET_STRATEGY_LAZY_GREEDY = 1,        ///< the default: greedy's answer in a fraction of the time
  MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY = 2,  ///< Algorithm 1 of the paper, with stochastic_epsilon and stochastic_seed
  MAXLOGDET_STRATEGY_RELAXED = 3,            ///< for tens of thousands of candidates
  MAXLOGDET_STRATEGY_BACKWARD_GREEDY = 4,    ///< for budgets of more than half of the candidates
  MAXLOGDET_STRATEGY_AUTOMATIC = 5           ///< another one, depending on the problem
};

/// Which linearised problem a block describes (maxlogdet/jacobian.hpp has the equations).
typedef int32_t maxlogdet_weighting;
enum {
  MAXLOGDET_WEIGHTING_MAP_BIAS = 0,            ///< the paper's H_c, with points in the camera frame
  MAXLOGDET_WEIGHTING_MAP_BIAS_WORLD = 1,      ///< the same with points in the world frame
  MAXLOGDET_WEIGHTING_MEASUREMENT = 2,         ///< the default: H_x / sigma, up to a rotation of its rows
  MAXLOGDET_WEIGHTING_MEASUREMENT_AND_MAP = 3  ///< whitened by the noise of measurement and map
};

/// What a third row measures, for the matches that have one.
typedef int32_t maxlogdet_depth_cue;
enum {
  MAXLOGDET_DEPTH_CUE_NONE = 0,    ///< the default: all are monocular
  MAXLOGDET_DEPTH_CUE_STEREO = 1,  ///< u_right, px; needs the camera's bf > 0
  MAXLOGDET_DEPTH_CUE_DEPTH = 2    ///< depth, m
};

/// How a camera projects a point (maxlogdet/camera.hpp has the equations).
typedef int32_t maxlogdet_camera_model;
enum {
  MAXLOGDET_CAMERA_MODEL_PINHOLE = 0,            ///< the default
  MAXLOGDET_CAMERA_MODEL_RADIAL_TANGENTIAL = 1,  ///< OpenCV's: k1, k2, p1, p2, k3
  MAXLOGDET_CAMERA_MODEL_KANNALA_BRANDT = 2,     ///< OpenCV's fisheye: k1, k2, k3, k4
  MAXLOGDET_CAMERA_MODEL_DOUBLE_SPHERE = 3       ///< Basalt's: xi, alpha
};

/// The type of the coordinates of points.
typedef int32_t maxlogdet_point_type;
enum {
  MAXLOGDET_POINT_TYPE_FLOAT64 = 0,  ///< the default: double
  MAXLOGDET_POINT_TYPE_FLOAT32 = 1   ///< float
};

// The name of the enumerator in lower case ("invalid_prior"), a constant; "unknown" for any other value.
const char* maxlogdet_error_name(maxlogdet_error error);
const char* maxlogdet_status_name(maxlogdet_status status);
const char* maxlogdet_strategy_name(maxlogdet_strategy strategy);
const char* maxlogdet_weighting_name(maxlogdet_weighting weighting);
const char* maxlogdet_camera_model_name(maxlogdet_camera_model model);
/// What is wrong, in words.
const char* maxlogdet_error_explanation(maxlogdet_error error);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)
