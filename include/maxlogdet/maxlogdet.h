// SPDX-License-Identifier: MIT
#pragma once

// maxlogdet for C99, and for everything that calls C: other languages, other compilers. All that a tracker does with
// selection, once a frame (docs/c_api.md has the program):
//
//   maxlogdet_good_features_create(2000, NULL, &good);              // once a thread: all the memory
//   maxlogdet_good_features_start(good, &camera, T_cw);             // the pose that optimisation starts from
//   for (match of the frame) maxlogdet_good_features_add(good, &match);
//   selection = maxlogdet_good_features_select(good, &options);     // optimise the pose with selection->indices
//   count = maxlogdet_good_features_outliers(good, T_cw, &indices); // unselected, and far off at the optimised pose
//
// The C++ headers of the same names document what the functions compute; docs/c_api.md the rules of handles, of structs
// in later versions, and of errors. Functions without a maxlogdet_error answer 0, none or NaN for a null pointer.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <maxlogdet/enumerators.h>
#include <maxlogdet/structs.h>
#include <maxlogdet/version.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The measurement of a match that has none, yet or at all.
#define MAXLOGDET_UNMEASURED (-1.7976931348623157e308)

/// A match of a frame: a map point, and where the frame sees it.
typedef struct maxlogdet_match {
  size_t struct_size;  ///< set by init
  double point[3];     ///< p_w, world frame, m
  double measured[2];  ///< u, v, px, as the camera's model has them; default MAXLOGDET_UNMEASURED; outliers and record
                       ///< need it
  double u_right;      ///< stereo: the column in the right image, px; negative, the default: not measured
  double depth;        ///< RGB-D: m; not positive, the default: not measured
  double sigma;        ///< standard deviation of u, v and u_right, px; default 1
  const double* covariance;  ///< of the point, 3 x 3, world frame, m^2; copied. null, the default: unknown
  const double* jacobian;    ///< 2 x 3 row-major, d (u, v) / d p_c; copied. null, the default: the camera's; either all
                             ///< matches have one, or those without are no candidates
  uint32_t id;               ///< the caller's: a slot, an index; the library does not read it; default 0
  uint8_t camera_id;         ///< which camera of a rig; default 0
  uint8_t is_required;       ///< nonzero: selected in any case, and counts towards the budget; default 0
  uint16_t reserved;         ///< 0, else invalid_argument
  int64_t point_id;          ///< of the map point, the same in every frame; only record reads it; default -1
  int64_t keyframe;          ///< which one mapped the point; -1, the default: unknown; only record reads it
} maxlogdet_match;
/// Sets struct_size and the defaults, as maxlogdet_camera_init. One struct can serve all matches.
maxlogdet_error maxlogdet_match_init(maxlogdet_match* match, size_t struct_size);

/// The matches of a frame, and what is selected of them.
typedef struct maxlogdet_good_features maxlogdet_good_features;

/// Reserves room for `capacity` matches a frame. `executor` may be null: only the calling thread works. Returns none,
/// out_of_memory (also above 2^32 - 1) or invalid_argument.
maxlogdet_error maxlogdet_good_features_create(size_t capacity, const maxlogdet_executor* executor,
                                               maxlogdet_good_features** good);
/// Destroys it; null is a no-op.
void maxlogdet_good_features_destroy(maxlogdet_good_features* good);

/// How blocks are made, from now on; depth_cue is set by what is measured, and `measurement` becomes
/// `measurement_and_map` in a frame where some match has a covariance. Returns none or invalid_argument.
maxlogdet_error maxlogdet_good_features_set_block_options(maxlogdet_good_features* good,
                                                          const maxlogdet_block_options* options);
/// At most one match of each of spread * budget cells of the image, as GoodFeatures::spread; 0, the default: off.
/// Returns none or invalid_argument.
maxlogdet_error maxlogdet_good_features_set_spread(maxlogdet_good_features* good, double spread);
/// Nonzero: the optimiser weights residuals by information, and so does outliers. Returns none or invalid_argument.
maxlogdet_error maxlogdet_good_features_set_weighted(maxlogdet_good_features* good, int32_t is_weighted);

/// Starts a frame without matches. `T_cw`, world to camera: the first 12 entries of a row-major 3 x 4 or 4 x 4 matrix,
/// as wherever a pose is asked for. Returns none or invalid_argument; the frame starts all the same, and select then
/// returns that error, with all usable matches.
maxlogdet_error maxlogdet_good_features_start(maxlogdet_good_features* good, const maxlogdet_camera* camera,
                                              const double* T_cw);
/// The same on a rig of `camera_count` cameras, 1 to 256, which are copied; `T_bw`: world to body. `cameras`: a pointer
/// to each; `T_cb`: camera_count x 3 x 4 row-major, body to camera. Also returns out_of_memory.
maxlogdet_error maxlogdet_good_features_start_rig(maxlogdet_good_features* good, const maxlogdet_camera* const* cameras,
                                                  const double* T_cb, size_t camera_count, const double* T_bw);

/// Copies and adds a match, number size(). Returns none; capacity_exceeded for a match beyond the capacity, which
/// counts but is never selected; or invalid_argument for a match that is refused, which counts but is not usable.
maxlogdet_error maxlogdet_good_features_add(maxlogdet_good_features* good, const maxlogdet_match* match);
/// The number of matches, with those beyond the capacity.
size_t maxlogdet_good_features_size(const maxlogdet_good_features* good);
/// The id of match i; MAXLOGDET_NONE beyond the capacity.
uint32_t maxlogdet_good_features_id(const maxlogdet_good_features* good, size_t i);

/// Selects options->budget matches, or what else the options ask for. The selection holds match numbers, is never null,
/// and is valid until the next select, match or start. Groups and a target may leave it shorter than the budget; after
/// an error, also for refused options, it is all usable ones: finite, with a positive sigma, and not excluded.
const maxlogdet_selection* maxlogdet_good_features_select(maxlogdet_good_features* good,
                                                          const maxlogdet_options* options);

/// Fills in what it measures of match i, and returns nonzero if it has found it. May not call functions with the
/// handle.
typedef int32_t (*maxlogdet_match_function)(void* context, size_t i, maxlogdet_match* match);
/// Active matching: calls try_to_match(context, i, &match) for required points, then for those of maximum gain until
/// enough are found or the time limit has passed, and returns these, as select does. After an error, also for refused
/// options, points are tried in their order; nothing is tried without try_to_match, and when the first call of a handle
/// finds no memory.
const maxlogdet_selection* maxlogdet_good_features_match(maxlogdet_good_features* good,
                                                         const maxlogdet_options* options,
                                                         maxlogdet_match_function try_to_match, void* context);

/// The last answer of select or match in this frame; never null.
const maxlogdet_selection* maxlogdet_good_features_selection(const maxlogdet_good_features* good);
/// For a log: the name of the error, or of the status; capacity_exceeded if some matches were not kept.
const char* maxlogdet_good_features_reason(const maxlogdet_good_features* good);
/// Returns 1 if match i is selected, else 0.
int32_t maxlogdet_good_features_is_selected(const maxlogdet_good_features* good, size_t i);
/// What was made of the matches, and how many could not be candidates for which reason; valid as the selection is.
const maxlogdet_block_report* maxlogdet_good_features_block_report(const maxlogdet_good_features* good);
/// (det M of the selected / det M of all candidates)^(1/6), in (0, 1]. NaN after an error and without candidates. Needs
/// weighting `measurement` or `measurement_and_map`. Reads all matches once.
double maxlogdet_good_features_efficiency(maxlogdet_good_features* good);

/// Compares the unselected matches with the optimised pose, stores the address of the numbers of outliers, ascending,
/// valid until the next outliers or start, and returns how many there are. `T_cw` as in start, on a rig T_bw.
size_t maxlogdet_good_features_outliers(maxlogdet_good_features* good, const double* T_cw, const uint32_t** indices);
/// Returns 1 if outliers has returned match i: its chi2 is above the 95 % quantile.
int32_t maxlogdet_good_features_is_outlier(const maxlogdet_good_features* good, size_t i);
/// Squared error of match i in standard deviations, after outliers: infinite where the point has no image or the match
/// is not usable; NaN where there is none.
double maxlogdet_good_features_chi2(const maxlogdet_good_features* good, size_t i);

/// Writes Omega of match i, the weight of its residual in an optimiser that holds points fixed, at the pose of start:
/// 2 x 2, or 3 x 3 if the match has a depth cue, row-major, px^-2. Returns 1, or 0 without writing anything.
int32_t maxlogdet_good_features_information(const maxlogdet_good_features* good, size_t i, double* omega);
/// Likewise writes W, lower triangular, W^T W = Omega, by which the residual is multiplied.
int32_t maxlogdet_good_features_whitening(const maxlogdet_good_features* good, size_t i, double* W);

/// From the next start on, writes every frame that is selected from into the folder, for `maxlogdet evaluate FOLDER`;
/// select then allocates and does I/O. Returns 1 if frames will be recorded, else 0; a problem is said on stderr.
int32_t maxlogdet_good_features_record(maxlogdet_good_features* good, const char* folder);

/// Version of the linked library; MAXLOGDET_VERSION is that of the header.
const char* maxlogdet_version(void);
/// The instruction set of a selector made now: "sse2", "avx2", "avx512", "neon"; "none" if the environment variable
/// MAXLOGDET_ISA names an unavailable one.
const char* maxlogdet_active_isa(void);
/// Name of the i-th instruction set built in, narrowest first; null when there are fewer.
const char* maxlogdet_built_in_isa(int32_t i);
/// Returns 1 if this machine supports the instruction set of that name, else 0, also for null.
int32_t maxlogdet_isa_is_supported(const char* name);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)

#include <maxlogdet/selector.h>
