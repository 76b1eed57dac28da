// SPDX-License-Identifier: MIT
#pragma once

// The structs of maxlogdet/maxlogdet.h; docs/c_api.md tells how they may grow. Fields are those of C++, in their
// order, with the same defaults; Options::target.efficiency is target_efficiency here. The C++ headers say more.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <maxlogdet/enumerators.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// No candidate, no match.
#define MAXLOGDET_NONE UINT32_C(0xFFFFFFFF)

/// A camera: x right, y down, z forward. Without a model it is a rectified pinhole.
typedef struct maxlogdet_camera {
  size_t struct_size;            ///< set by init
  double fx;                     ///< focal length, px; has no default
  double fy;                     ///< focal length, px; has no default
  double cx;                     ///< principal point, px (no Jacobian depends on it)
  double cy;                     ///< principal point, px
  double bf;                     ///< of a pinhole: stereo baseline times fx, px m; 0: monocular
  maxlogdet_camera_model model;  ///< default pinhole
  int32_t reserved;              ///< 0, else invalid_argument
  double parameters[5];          ///< of the model, in its order; default 0
} maxlogdet_camera;
/// Sets struct_size and the defaults. Returns invalid_argument for a null pointer or another size, and marks a struct
/// of 8 bytes or more so that every function refuses it. All init functions do so.
maxlogdet_error maxlogdet_camera_init(maxlogdet_camera* camera, size_t struct_size);

/// How blocks are made of matches.
typedef struct maxlogdet_block_options {
  size_t struct_size;             ///< set by init
  maxlogdet_weighting weighting;  ///< default measurement
  maxlogdet_depth_cue depth_cue;  ///< which third row; default none; good features set it by what is measured
  double map_sigma;               ///< m, standard deviation of a map point (measurement_and_map); default 0.05
  double depth_sigma;             ///< m, standard deviation of a depth measurement; default 0.05
  double min_depth;               ///< m: a nearer match is no candidate; default 0.01
  int32_t threads;                ///< as that of maxlogdet_options; the blocks do not depend on it
  int32_t reserved;               ///< 0, else invalid_argument
} maxlogdet_block_options;
/// Sets struct_size and the defaults, as maxlogdet_camera_init.
maxlogdet_error maxlogdet_block_options_init(maxlogdet_block_options* options, size_t struct_size);

/// What was made of matches.
typedef struct maxlogdet_block_report {
  maxlogdet_error error;       ///< none, or why nothing was appended
  size_t appended;             ///< n, or 0 after an error
  size_t invalid;              ///< of these, the invalid candidates, for whatever reason
  size_t unusable;             ///< matches with `usable` 0
  size_t behind_camera;        ///< depth <= 0, or where the camera's model has no image
  size_t too_near;             ///< in front of the camera, nearer than min_depth
  size_t singular_rays;        ///< rays orthogonal to the world's z axis (map_bias_world)
  size_t invalid_covariances;  ///< not positive definite, or so large that no digits are left (docs/numerics.md)
  size_t invalid_jacobians;    ///< the caller's Jacobians that are not finite
} maxlogdet_block_report;

/// What to select and how; n is the number of candidates. Arrays belong to the caller.
typedef struct maxlogdet_options {
  size_t struct_size;           ///< set by init
  size_t budget;                ///< how many to select; all, if there are fewer; default 200
  const double* prior;          ///< information, 6 x 6 row-major, in the units of the blocks; null, the default: 1e-5 I
  double time_limit;            ///< s, after which the budget is filled at once; 0, the default: none
  maxlogdet_strategy strategy;  ///< default lazy_greedy
  int32_t threads;              ///< 1: the calling one; 0, the default: as many as pay off; m: at most m
  const uint8_t* required;      ///< n: nonzero is selected in any case, first; null: none
  const uint8_t* excluded;      ///< n: nonzero is not selected; null: none
  double target_efficiency;     ///< in (0, 1]: stop at that share of the information of all; 0, the default: none. If
                                ///< several targets are given, all must be met
  double target_translation_sigma;  ///< m: stop at that expected standard deviation; 0, the default: none
  double target_rotation_sigma;     ///< rad: the same of the rotation; 0, the default: none
  const uint32_t* group_ids;        ///< n: group of each candidate, < group_count; null: no groups
  size_t group_count;               ///< any number: groups without a candidate cost nothing
  size_t group_maximum;             ///< how many to select of a group at most; default 1
  const uint32_t* group_maxima;     ///< group_count: how many of each instead; null: group_maximum
  int32_t certificate_compute;      ///< nonzero: fill upper_bound; default 0
  int32_t reserved;                 ///< 0, else invalid_argument
  size_t certificate_passes;        ///< maximum Frank-Wolfe passes that tighten upper_bound, if time allows; default 0
  double stochastic_epsilon;        ///< stochastic_greedy: in (0, 1); default 0.1
  uint64_t stochastic_seed;         ///< stochastic_greedy: same seed, same answer; default 0
  size_t exchange_sweeps;           ///< maximum sweeps that swap a selected candidate for a better one; default 0
} maxlogdet_options;
/// Sets struct_size and the defaults, as maxlogdet_camera_init.
maxlogdet_error maxlogdet_options_init(maxlogdet_options* options, size_t struct_size);

/// The answer.
typedef struct maxlogdet_selection {
  maxlogdet_status status;    ///< how the selection ended
  maxlogdet_error error;      ///< what is wrong; none if status is not error
  const uint32_t* indices;    ///< `size` candidate indices, in order of selection; null if there never was an answer
  size_t size;                ///< number selected
  size_t searched;            ///< how many of these the search itself selected; fewer than `size` only at a deadline
  const double* gains;        ///< `size` gains: the increase of log det by each after those before it, nats
  double log_det;             ///< log det of prior and selected blocks together, nats
  size_t evaluations;         ///< gains computed; may differ between machines
  size_t float64_decisions;   ///< of these, computed again to decide; may differ, too
  size_t invalid_candidates;  ///< candidates without a block: never selected
  double upper_bound;  ///< no selection that the options allow has a greater log det, nats; infinite where nothing
                       ///< is known; NaN if not asked for
  maxlogdet_strategy strategy;  ///< the requested one, or what `automatic` chose
  int32_t threads;              ///< how many threads the work was offered to, including the calling one
  double efficiency;            ///< value for target_efficiency; NaN without that target
  double translation_sigma;     ///< m, value for target_translation_sigma; NaN without that target
  double rotation_sigma;        ///< rad, value for target_rotation_sigma; NaN without that target
} maxlogdet_selection;

/// Returns 1 for an answer (perhaps cut short by the deadline or a target), 0 for an error or a null pointer.
int32_t maxlogdet_selection_has_answer(const maxlogdet_selection* selection);
/// For a log: the name of the error, or if there is none, of the status.
const char* maxlogdet_selection_reason(const maxlogdet_selection* selection);
/// A lower bound of the share of the best selection's information; NaN without upper_bound, and for a null pointer.
double maxlogdet_selection_certified_efficiency(const maxlogdet_selection* selection);

/// The function that an executor runs: on the calling thread with `worker` 0, on every other with a distinct number.
typedef void (*maxlogdet_body)(void* context, int32_t worker);

/// Provides helper threads for a selection: a pool of the caller's (docs/threading.md), or oneTBB (maxlogdet/tbb.h).
/// The struct is copied; what user_data points to must outlive its users. Handles that share a pool call concurrently.
typedef struct maxlogdet_executor {
  size_t struct_size;  ///< set by init
  void* user_data;     ///< passed to both functions
  /// Returns the maximum number of workers of a run called from this thread, including the caller; at least 1.
  int32_t (*concurrency)(void* user_data);
  /// Calls body(context, 0) on the calling thread, and offers body(context, w), w in [1, workers), to others, which may
  /// come late or never. Returns when all that have started have returned, and none will start any more.
  void (*run)(void* user_data, int32_t workers, maxlogdet_body body, void* context);
} maxlogdet_executor;
/// Sets struct_size, and no functions, as maxlogdet_camera_init.
maxlogdet_error maxlogdet_executor_init(maxlogdet_executor* executor, size_t struct_size);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)
