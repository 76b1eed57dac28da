// SPDX-License-Identifier: MIT
#pragma once

// The enumerators of maxlogdet/maxlogdet.h, with the values and names of those of C++.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// How a call ended. A selection that is ok, all_selected, deadline_reached or target_reached carries an answer; with
/// any other status it is empty, and its log_det is NaN.
typedef int32_t maxlogdet_status;
enum {
  MAXLOGDET_STATUS_OUT_OF_MEMORY = -2,       ///< no memory; the call had no effect
  MAXLOGDET_STATUS_INVALID_ARGUMENT = -1,    ///< a null pointer, no struct_size, no functions
  MAXLOGDET_STATUS_OK = 0,                   ///< done; of a selection: as many as the budget asks for
  MAXLOGDET_STATUS_ALL_SELECTED = 1,         ///< no more may be selected
  MAXLOGDET_STATUS_DEADLINE_REACHED = 2,     ///< time_limit passed: the answer so far
  MAXLOGDET_STATUS_INVALID_BUDGET = 3,       ///< budget above the capacity
  MAXLOGDET_STATUS_INVALID_EPSILON = 4,      ///< stochastic_greedy with epsilon not in (0, 1)
  MAXLOGDET_STATUS_INVALID_PRIOR = 5,        ///< prior not finite, not symmetric, or not safely positive definite
  MAXLOGDET_STATUS_CAPACITY_EXCEEDED = 6,    ///< more candidates than the capacity
  MAXLOGDET_STATUS_INVALID_STRATEGY = 7,     ///< not an enumerator, or not one that an active selection has
  MAXLOGDET_STATUS_INVALID_TIME_LIMIT = 8,   ///< negative or NaN
  MAXLOGDET_STATUS_INVALID_THREADS = 9,      ///< negative
  MAXLOGDET_STATUS_INVALID_GROUPS = 10,      ///< a group not below group_count
  MAXLOGDET_STATUS_INFEASIBLE = 11,          ///< what is required is excluded, invalid, or more than is allowed
  MAXLOGDET_STATUS_UNSUPPORTED_GROUPS = 12,  ///< the strategy does not support groups
  MAXLOGDET_STATUS_NOTHING_PROPOSED = 13,    ///< an answer without a proposal
  MAXLOGDET_STATUS_INVALID_BLOCK = 14,       ///< the measured block is null, not finite, or has not 1 to 3 rows
  MAXLOGDET_STATUS_UNSUPPORTED_ISA = 15,     ///< MAXLOGDET_ISA names an unavailable instruction set
  MAXLOGDET_STATUS_TARGET_REACHED = 16,      ///< every target given is met: an answer
  MAXLOGDET_STATUS_INVALID_TARGET = 17,      ///< negative, NaN or infinite, or target_efficiency above 1
  MAXLOGDET_STATUS_UNSUPPORTED_TARGET = 18   ///< with relaxed, backward_greedy or exchange_sweeps
};

/// How the candidates are searched.
typedef int32_t maxlogdet_strategy;
enum {
  MAXLOGDET_STRATEGY_GREEDY = 0,
  MAXLOGDET_STRATEGY_LAZY_GREEDY = 1,        ///< the default: greedy's answer in a fraction of the time
  MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY = 2,  ///< Algorithm 1 of the paper, with epsilon and seed
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
typedef int32_t maxlogdet_third_measurement;
enum {
  MAXLOGDET_THIRD_MEASUREMENT_NONE = 0,    ///< the default: all are monocular
  MAXLOGDET_THIRD_MEASUREMENT_STEREO = 1,  ///< u_right, px; needs the camera's bf > 0
  MAXLOGDET_THIRD_MEASUREMENT_DEPTH = 2    ///< depth, m
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

/// How append_blocks ended. Nothing is appended unless it is ok, singular_rays or invalid_jacobians.
typedef int32_t maxlogdet_block_status;
enum {
  MAXLOGDET_BLOCK_STATUS_OUT_OF_MEMORY = -2,
  MAXLOGDET_BLOCK_STATUS_INVALID_ARGUMENT = -1,  ///< as MAXLOGDET_STATUS_INVALID_ARGUMENT
  MAXLOGDET_BLOCK_STATUS_OK = 0,                 ///< n blocks; those without a Jacobian as invalid candidates
  MAXLOGDET_BLOCK_STATUS_SINGULAR_RAYS = 1,    ///< map_bias_world: as ok, but some rays are orthogonal to the world's z
                                               ///< axis: their blocks are invalid
  MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA = 2,   ///< a parameter out of its range, or stereo rows without bf > 0
  MAXLOGDET_BLOCK_STATUS_INVALID_POSE = 3,     ///< T_cw or T_bw null; these or T_cb not finite or not a rotation
  MAXLOGDET_BLOCK_STATUS_INVALID_OPTIONS = 4,  ///< a sigma, min_depth, threads or an enumerator out of its range
  MAXLOGDET_BLOCK_STATUS_MISSING_POINTS = 5,   ///< size > 0 without points
  MAXLOGDET_BLOCK_STATUS_INVALID_STRIDE = 6,   ///< less than three coordinates, or not a whole number of them
  MAXLOGDET_BLOCK_STATUS_UNKNOWN_CAMERA_MODEL = 7,  ///< not an enumerator
  MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA_ID = 8,     ///< no such camera, ids without a rig, no camera or more than 256
  MAXLOGDET_BLOCK_STATUS_INVALID_JACOBIANS = 9  ///< as ok, but some of the caller's are not finite: their blocks are
                                                ///< invalid
};

/// Name of the enumerator in lower case ("all_selected"); "unknown" for any other value. A constant.
const char* maxlogdet_status_name(maxlogdet_status status);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_strategy_name(maxlogdet_strategy strategy);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_weighting_name(maxlogdet_weighting weighting);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_camera_model_name(maxlogdet_camera_model model);
/// Name of the enumerator; "unknown" for any other value.
const char* maxlogdet_block_status_name(maxlogdet_block_status status);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)
