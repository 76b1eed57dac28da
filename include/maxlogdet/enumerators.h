// SPDX-License-Identifier: MIT
#pragma once

// The enumerators of maxlogdet/maxlogdet.h, with the values and names of those of C++.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What is wrong; maxlogdet_error_explanation says it in words. Negative values are C's own.
typedef int32_t maxlogdet_error;
enum {
  MAXLOGDET_ERROR_OUT_OF_MEMORY = -2,       ///< there is no memory; nothing has been done
  MAXLOGDET_ERROR_INVALID_ARGUMENT = -1,    ///< a null pointer, a struct that init has not filled in, or no functions
  MAXLOGDET_ERROR_NONE = 0,                 ///< nothing is wrong
  MAXLOGDET_ERROR_CAPACITY_EXCEEDED = 1,    ///< more candidates, or matches, than the capacity
  MAXLOGDET_ERROR_INVALID_STRATEGY = 2,     ///< not one of the enumerators, or not one that active matching has
  MAXLOGDET_ERROR_INVALID_EPSILON = 3,      ///< stochastic_epsilon is not in (0, 1)
  MAXLOGDET_ERROR_INVALID_PRIOR = 4,        ///< not finite, not symmetric, or not safely positive definite
                                            ///< (docs/numerics.md)
  MAXLOGDET_ERROR_INVALID_TIME_LIMIT = 5,   ///< time_limit is negative or NaN
  MAXLOGDET_ERROR_INVALID_THREADS = 6,      ///< threads is negative
  MAXLOGDET_ERROR_INVALID_GROUPS = 7,       ///< a group is not below group_count, or the spread is negative or not
                                            ///< finite
  MAXLOGDET_ERROR_UNSUPPORTED_GROUPS = 8,   ///< the strategy does not support groups
  MAXLOGDET_ERROR_INVALID_TARGET = 9,       ///< negative, NaN or infinite, or target_efficiency is above 1
  MAXLOGDET_ERROR_UNSUPPORTED_TARGET = 10,  ///< relaxed, backward_greedy and exchanges have no order in which a target
                                            ///< could end them
  MAXLOGDET_ERROR_INFEASIBLE = 11,          ///< a required candidate is excluded or has no block, or more are required
                                            ///< than may be selected
  MAXLOGDET_ERROR_UNSUPPORTED_ISA = 12,     ///< MAXLOGDET_ISA names an instruction set that is not built in, or not
                                            ///< supported by this machine
  MAXLOGDET_ERROR_INVALID_CAMERA = 13,      ///< fx or fy is not positive, a parameter is out of its range, or a right
                                            ///< column needs bf > 0
  MAXLOGDET_ERROR_UNKNOWN_CAMERA_MODEL = 14,   ///< the model is not an enumerator
  MAXLOGDET_ERROR_INVALID_CAMERA_ID = 15,      ///< a camera_id is not below the size of the rig, which has 1 to 256
                                               ///< cameras
  MAXLOGDET_ERROR_INVALID_POSE = 16,           ///< missing, not finite, or not a rotation and a translation
  MAXLOGDET_ERROR_INVALID_BLOCK_OPTIONS = 17,  ///< a deviation, min_depth or threads is out of its range, or an
                                               ///< enumerator is unknown
  MAXLOGDET_ERROR_MISSING_POINTS = 18,         ///< there are matches, but no points
  MAXLOGDET_ERROR_INVALID_STRIDE = 19,         ///< not a whole number of coordinates, three at least, side by side
  MAXLOGDET_ERROR_MIXED_DEPTH_CUES = 20,       ///< some matches of the frame have a right column, and some a depth
  MAXLOGDET_ERROR_NOTHING_PROPOSED = 21,       ///< this candidate is not proposed
  MAXLOGDET_ERROR_INVALID_BLOCK = 22           ///< the measured block is missing, has not 1 to 3 rows, or is not finite
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
  MAXLOGDET_WEIGHTING_MAP_BIAS = 0,        ///< the paper's H_c, with points in the camera frame
  MAXLOGDET_WEIGHTING_MAP_BIAS_WORLD = 1,  ///< the same with points in the world frame
  MAXLOGDET_WEIGHTING_MEASUREMENT = 2,     ///< the default: H_x / sigma, up to a rotation of its rows
  MAXLOGDET_WEIGHTING_MEASUREMENT_AND_MAP =
      3  ///< H_x whitened by the noise of measurement and map: with map_covariances
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

/// Name of the enumerator in lower case ("invalid_prior"); "unknown" for any other value. A constant.
const char* maxlogdet_error_name(maxlogdet_error error);
/// What is wrong, in words.
const char* maxlogdet_error_explanation(maxlogdet_error error);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_status_name(maxlogdet_status status);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_strategy_name(maxlogdet_strategy strategy);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_weighting_name(maxlogdet_weighting weighting);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_camera_model_name(maxlogdet_camera_model model);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)
