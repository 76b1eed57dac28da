// SPDX-License-Identifier: MIT
#pragma once

// maxlogdet for C99, and for everything that calls C: other languages, other compilers. The C++ headers of the same
// names document what the functions compute; this header documents what a caller in C must know. docs/c_api.md has a
// program.
//
// Handles. A block store, a selector and an active selection are opaque. create makes one (or returns a status that
// says why not, and then stores a null pointer), destroy destroys it; null is a no-op. One thread at a time may use a
// handle; several may read a block store. What is returned by pointer belongs to the handle, and is read-only.
//
// Structs, and later versions. A struct that the caller fills begins with struct_size; NAME_init(&s, sizeof s) sets
// that and the defaults. A later version of the library may append fields: it reads at most struct_size bytes, and uses
// the defaults of fields beyond. A program or binding made for this header therefore works with every later library of
// the same major version, and while that is 0, of the same minor version. struct_size must be a multiple of 8, at least
// 16, and at most the size of the library's own struct. Any other (a struct without init, or a longer one, of a header
// newer than the library) is refused as invalid_argument. Structs that the library fills are reached through pointers,
// and may also grow at their ends. Within such versions, values of enumerators, and the order and types of fields, do
// not change.
//
// Errors. No pointer may be null where its comment does not allow it: functions answer invalid_argument, or where they
// return no status 0, none or NaN. Neither pointers nor lengths of arrays are checked otherwise. No function throws,
// prints or ends the program; only create, reserve, push_back, push_back_invalid, append_blocks and
// append_blocks_of_rig allocate.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <maxlogdet/enumerators.h>
#include <maxlogdet/version.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Version of the linked library; MAXLOGDET_VERSION is that of the header.
const char* maxlogdet_version(void);

/// The instruction set of a selector made now: "sse2", "avx2", "avx512", "neon"; "none" if the environment variable
/// MAXLOGDET_ISA names an unavailable one.
const char* maxlogdet_active_isa(void);
/// Name of the i-th instruction set built in, narrowest first; null when there are fewer.
const char* maxlogdet_built_in_isa(int32_t i);
/// Returns 1 if this machine supports the instruction set of that name, else 0, also for null.
int32_t maxlogdet_isa_is_supported(const char* name);

/// The function that an executor runs: on the calling thread with `worker` 0, on every other with a distinct number.
typedef void (*maxlogdet_body)(void* context, int32_t worker);

/// Provides helper threads for a selection: a pool of the caller's (docs/threading.md), or oneTBB (maxlogdet/tbb.h).
/// The struct is copied; what user_data points to must outlive its users. Both functions are called on the selecting
/// thread, and concurrently if several selectors of the caller share one pool.
typedef struct maxlogdet_executor {
  size_t struct_size;  ///< set by init
  void* user_data;     ///< passed to both functions
  /// Returns the maximum number of workers of a run called from this thread, including the caller; at least 1.
  int32_t (*concurrency)(void* user_data);
  /// Calls body(context, 0) on the calling thread, and offers body(context, w), w in [1, workers), to other threads.
  /// Helpers may come late or never. Returns when body(context, 0) and all helpers that have started have returned, and
  /// none will start any more.
  void (*run)(void* user_data, int32_t workers, maxlogdet_body body, void* context);
} maxlogdet_executor;

/// Sets struct_size, and no functions. Returns invalid_argument for a null pointer or another size, and marks a struct
/// of 8 bytes or more so that every function refuses it. All init functions do so.
maxlogdet_error maxlogdet_executor_init(maxlogdet_executor* executor, size_t struct_size);

/// Candidate blocks H_i, one per match. Fill it once a frame; clear keeps its memory.
typedef struct maxlogdet_block_store maxlogdet_block_store;

/// Makes a store with room for `capacity` candidates; it grows beyond, up to 2^32 - 1. Returns none, out_of_memory (also
/// above 2^32 - 1) or invalid_argument.
maxlogdet_error maxlogdet_block_store_create(size_t capacity, maxlogdet_block_store** blocks);
/// Destroys the store; null is a no-op.
void maxlogdet_block_store_destroy(maxlogdet_block_store* blocks);

/// Makes room for `capacity` candidates, and keeps those stored. Returns none, out_of_memory (without effect; also above
/// 2^32 - 1) or invalid_argument.
maxlogdet_error maxlogdet_block_store_reserve(maxlogdet_block_store* blocks, size_t capacity);
/// Removes all candidates; keeps the memory.
maxlogdet_error maxlogdet_block_store_clear(maxlogdet_block_store* blocks);

/// The number of candidates, including invalid ones.
size_t maxlogdet_block_store_size(const maxlogdet_block_store* blocks);
/// The number of candidates that fit without allocating.
size_t maxlogdet_block_store_capacity(const maxlogdet_block_store* blocks);
/// The maximum number of rows of a block since clear; 0 while no block is valid.
int32_t maxlogdet_block_store_rows(const maxlogdet_block_store* blocks);
/// Returns 1 if there is a candidate of that index and it has a block, else 0.
int32_t maxlogdet_block_store_is_valid(const maxlogdet_block_store* blocks, size_t index);
/// The number of candidates without a block.
size_t maxlogdet_block_store_invalid_count(const maxlogdet_block_store* blocks);

/// Appends a block, rows x 6 row-major, columns (translation, rotation), rows in {1, 2, 3}, rounded to float32; its
/// index is the previous size. A null block, other rows, or entries that float32 cannot hold are no error but make an
/// invalid candidate, which is never selected. Returns none, out_of_memory (only when the capacity does not suffice) or
/// invalid_argument.
maxlogdet_error maxlogdet_block_store_push_back(maxlogdet_block_store* blocks, const double* block, int32_t rows);
/// Appends an invalid candidate, a match without a block.
maxlogdet_error maxlogdet_block_store_push_back_invalid(maxlogdet_block_store* blocks);

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
/// Sets struct_size and the defaults, as maxlogdet_executor_init.
maxlogdet_error maxlogdet_camera_init(maxlogdet_camera* camera, size_t struct_size);

/// n matches as arrays of the caller, which are not kept. A null optional array means its default for all matches.
typedef struct maxlogdet_matches {
  size_t struct_size;               ///< set by init
  size_t size;                      ///< n
  const void* points;               ///< n: x, y, z in the world frame, m
  size_t point_stride;              ///< bytes from one point to the next; 0, the default: n x 3 row-major
  maxlogdet_point_type point_type;  ///< default float64
  int32_t reserved;                 ///< 0, else invalid_argument
  const double* sigmas;             ///< n: standard deviation of u, v, u_right, px; default 1
  const uint8_t* has_depth_cue;         ///< n: nonzero where the third measurement exists; default: all have it
  const uint8_t* usable;            ///< n: zero keeps a match as an invalid candidate; default: all are usable
  const double* weights;            ///< n: w >= 0 multiplies H^T H; default 1
  const double* map_covariances;    ///< n x 3 x 3: of the points, world frame, m^2, the upper triangle is read;
                                    ///< default map_sigma^2 I
  const double* jacobians;          ///< n x 2 x 3 row-major: d (u, v) / d p_c, px per m, of a model of the caller's
                                    ///< own; default: the camera's
  const uint8_t* camera_ids;        ///< n: index of the match's camera in the rig; default 0
} maxlogdet_matches;
/// Sets struct_size and the defaults, as maxlogdet_executor_init.
maxlogdet_error maxlogdet_matches_init(maxlogdet_matches* matches, size_t struct_size);

/// How blocks are made of matches.
typedef struct maxlogdet_block_options {
  size_t struct_size;                 ///< set by init
  maxlogdet_weighting weighting;      ///< default measurement
  maxlogdet_depth_cue depth_cue;  ///< default none
  double map_sigma;                   ///< m, standard deviation of a map point (measurement_and_map); default 0.05
  double depth_sigma;                 ///< m, standard deviation of a depth measurement; default 0.05
  double min_depth;                   ///< m: a nearer match is no candidate; default 0.01
  int32_t threads;                    ///< as that of maxlogdet_options; the blocks do not depend on it
  int32_t reserved;                   ///< 0, else invalid_argument
} maxlogdet_block_options;
/// Sets struct_size and the defaults, as maxlogdet_executor_init.
maxlogdet_error maxlogdet_block_options_init(maxlogdet_block_options* options, size_t struct_size);

/// The result of append_blocks.
typedef struct maxlogdet_block_report {
  maxlogdet_error error;          ///< none, or why nothing was appended
  size_t appended;                ///< n, or 0 after an error
  size_t invalid;                 ///< of these, the invalid candidates, for whatever reason
  size_t unusable;                ///< matches with `usable` 0
  size_t behind_camera;           ///< depth <= 0, or where the camera's model has no image
  size_t too_near;                ///< in front of the camera, nearer than min_depth
  size_t singular_rays;           ///< rays orthogonal to the world's z axis (map_bias_world)
  size_t invalid_covariances;     ///< not positive definite, or so large that no digits are left (docs/numerics.md)
  size_t invalid_jacobians;       ///< the caller's Jacobians that are not finite
} maxlogdet_block_report;

/// Appends one block per match, in their order. `T_cw`: 3 x 4 row-major, world to camera. `executor` may be null: only
/// the calling thread works. The report belongs to the store, and is valid until its next append_blocks or its
/// destruction; never null.
const maxlogdet_block_report* maxlogdet_append_blocks(const maxlogdet_camera* camera, const double* T_cw,
                                                      const maxlogdet_matches* matches,
                                                      const maxlogdet_block_options* options,
                                                      maxlogdet_block_store* blocks,
                                                      const maxlogdet_executor* executor);

/// The same for a rig of `camera_count` cameras, 1 to 256; the blocks are about the pose of its body, `T_bw`.
/// `cameras`: a pointer to each; `T_cb`: camera_count x 3 x 4 row-major, body to camera. camera_ids of the matches says
/// which camera has seen each match.
const maxlogdet_block_report* maxlogdet_append_blocks_of_rig(const maxlogdet_camera* const* cameras, const double* T_cb,
                                                             size_t camera_count, const double* T_bw,
                                                             const maxlogdet_matches* matches,
                                                             const maxlogdet_block_options* options,
                                                             maxlogdet_block_store* blocks,
                                                             const maxlogdet_executor* executor);

/// Writes Omega, the weight of the residual of match i, (u, v) or (u, v, third), in an optimiser that holds the points
/// fixed: the inverse covariance of the noise that whitens its block (maxlogdet/match_information.hpp), r x r
/// row-major, r = 3 where the match has a third measurement, else 2. `camera` is the one that has seen the match, also
/// on a rig, `T_cw` its pose; usable, weights, camera_ids and min_depth are not read. Returns 1, or 0 without writing
/// anything: for a null pointer, an invalid i, a point without an image, or unusable numbers.
int32_t maxlogdet_match_information(const maxlogdet_camera* camera, const double* T_cw,
                                    const maxlogdet_matches* matches, size_t i, const maxlogdet_block_options* options,
                                    double* omega);
/// Likewise writes W, lower triangular, W^T W = Omega, by which the residual is multiplied.
int32_t maxlogdet_match_whitening(const maxlogdet_camera* camera, const double* T_cw, const maxlogdet_matches* matches,
                                  size_t i, const maxlogdet_block_options* options, double* W);

/// What to select and how; n is the number of candidates. Arrays belong to the caller.
typedef struct maxlogdet_options {
  size_t struct_size;           ///< set by init
  size_t budget;                ///< how many to select, at most the capacity; default 200
  maxlogdet_strategy strategy;  ///< default lazy_greedy
  int32_t threads;      ///< 1: only the calling one; 0, the default: as many of the executor as pay off; m: at most m
  double epsilon;       ///< stochastic_greedy: in (0, 1); default 0.1
  uint64_t seed;        ///< stochastic_greedy: same seed, same answer; default 0
  const double* prior;  ///< information before any match, 6 x 6 row-major, symmetric positive definite, in the units of
                        ///< the blocks; null, the default: 1e-5 I
  double time_limit;    ///< s, read between rounds; 0, the default: none
  int32_t certificate;      ///< nonzero: fill upper_bound; default 0
  int32_t reserved;     ///< 0, else invalid_argument
  size_t certificate_passes;  ///< maximum Frank-Wolfe passes that tighten upper_bound, if time allows; default 0
  size_t exchange_sweeps;     ///< maximum sweeps that swap a selected candidate for a better one; default 0
  const uint8_t* required;    ///< n: nonzero is selected in any case, first; null: none
  const uint8_t* excluded;    ///< n: nonzero is not selected; null: none
  const uint32_t* groups;     ///< n: group of each candidate, < group_count; null: no groups, whatever the three below
  size_t group_count;         ///< any number: groups without a candidate cost nothing
  size_t max_per_group;       ///< maximum to select of a group; default 1
  const uint32_t* group_maxima;  ///< group_count: maximum to select of each; null: max_per_group
  double target_efficiency;  ///< in (0, 1]: stop when (det of the information / det of that of all candidates that are
                             ///< valid and not excluded)^(1/6) is that high; 0, the default: none
  double target_translation_sigma;  ///< m: stop when the expected standard deviation of the translation, the root of
                                    ///< the trace of its block of the inverse information, is at most that; 0, the
                                    ///< default: none
  double target_rotation_sigma;  ///< rad: the same of the rotation; 0, the default: none. If several targets are given,
                                 ///< all must be met
} maxlogdet_options;
/// Sets struct_size and the defaults, as maxlogdet_executor_init.
maxlogdet_error maxlogdet_options_init(maxlogdet_options* options, size_t struct_size);

/// The answer.
typedef struct maxlogdet_selection {
  maxlogdet_status status;      ///< how the selection ended
  maxlogdet_error error;        ///< what is wrong; none if status is not error
  maxlogdet_strategy strategy;  ///< the requested one, or what `automatic` chose
  int32_t threads;              ///< how many threads the work was offered to, including the calling one
  size_t size;                  ///< number selected
  const uint32_t* indices;      ///< `size` candidate indices, in order of selection (maxlogdet/selection.hpp)
  const double* gains;          ///< `size` gains: the increase of log det by each after those before it, nats
  double log_det;               ///< log det of prior and selected blocks together, nats
  double upper_bound;  ///< no selection within the budget has a greater log det, nats; infinite where float64 may have
                       ///< no digits left (docs/numerics.md); NaN if not asked for
  size_t evaluations;  ///< gains computed; may differ between machines
  size_t float64_decisions;   ///< of these, computed again in float64; may differ, too
  size_t invalid_candidates;  ///< candidates without a block: never selected
  double efficiency;   ///< value for target_efficiency; NaN without that target
  double translation_sigma;   ///< m, value for target_translation_sigma; NaN without that target
  double rotation_sigma;      ///< rad, value for target_rotation_sigma; NaN without that target
} maxlogdet_selection;

/// Returns 1 for an answer (perhaps cut short by the deadline or a target), 0 for an error or a null pointer.
int32_t maxlogdet_selection_has_answer(const maxlogdet_selection* selection);
/// Returns (det of the information / det of the bound)^(1/6), a lower bound of the share of the best selection's
/// information. NaN without upper_bound, and for a null pointer.
double maxlogdet_selection_certified_efficiency(const maxlogdet_selection* selection);

/// Selects candidates; owns all the memory for this. Use one per thread, kept for the life of the tracker.
typedef struct maxlogdet_selector maxlogdet_selector;

/// Makes a selector for stores of up to `capacity` candidates. `executor` may be null: only the calling thread works.
/// Returns none, out_of_memory (also above 2^32 - 1) or invalid_argument.
maxlogdet_error maxlogdet_selector_create(size_t capacity, const maxlogdet_executor* executor,
                                           maxlogdet_selector** selector);
/// Destroys the selector; null is a no-op.
void maxlogdet_selector_destroy(maxlogdet_selector* selector);
/// The maximum number of candidates, and the maximum budget, of select.
size_t maxlogdet_selector_capacity(const maxlogdet_selector* selector);

/// Selects options->budget of the candidates, or the first of them that meet the targets; neither allocates nor locks.
/// The selection belongs to the selector, and is valid until its next select or its destruction; never null.
const maxlogdet_selection* maxlogdet_selector_select(maxlogdet_selector* selector, const maxlogdet_block_store* blocks,
                                                     const maxlogdet_options* options);

/// Active matching: it proposes candidates, one by one or in batches, which the tracker tries to match and answers.
/// Nothing allocates after create.
typedef struct maxlogdet_active_selection maxlogdet_active_selection;

/// The value of next when there is nothing to propose.
#define MAXLOGDET_NONE UINT32_C(0xFFFFFFFF)

/// As maxlogdet_selector_create.
maxlogdet_error maxlogdet_active_selection_create(size_t capacity, maxlogdet_active_selection** active);
/// Destroys the active selection; null is a no-op.
void maxlogdet_active_selection_destroy(maxlogdet_active_selection* active);
/// The maximum number of candidates, and the maximum budget, of start.
size_t maxlogdet_active_selection_capacity(const maxlogdet_active_selection* active);

/// Starts a new selection and its time limit. The candidates and all arrays of the options (groups above all) must not
/// change until the last call of any other function. The options in use are budget, prior, time_limit, the targets and
/// the constraints; strategy must be greedy, lazy_greedy or automatic. The statuses are those of a selection; after an
/// error nothing is proposed.
maxlogdet_error maxlogdet_active_selection_start(maxlogdet_active_selection* active,
                                                  const maxlogdet_block_store* candidates,
                                                  const maxlogdet_options* options);

/// Returns the candidate of maximum gain that is neither accepted nor rejected; while proposals are unanswered, the
/// first of these again. MAXLOGDET_NONE when the budget is reached, nothing is left, or the time limit has passed; and
/// once the targets are met, even if proposals of a batch are unanswered, which may still be answered.
uint32_t maxlogdet_active_selection_next(maxlogdet_active_selection* active);
/// Writes the `count` candidates of maximum current gain to `indices`, best first, ties to the lowest index, and
/// returns how many. There are fewer only where no more may all be accepted: by what is left, by the budget, and by the
/// maximum of a group, in whose place the next best are proposed. While proposals are unanswered, returns these again,
/// at most `count`. 0 where next is MAXLOGDET_NONE, and for a `count` of 0 or a null pointer, which change nothing.
size_t maxlogdet_active_selection_next_batch(maxlogdet_active_selection* active, uint32_t* indices, size_t count);

/// Adds the first unanswered proposal to the selection, with its block as proposed. Returns none or nothing_proposed.
maxlogdet_error maxlogdet_active_selection_accept(maxlogdet_active_selection* active);
/// Adds it with the block as measured, rows x 6 row-major, rows in {1, 2, 3}. Returns none, nothing_proposed, or
/// invalid_block (null, other rows, not finite), after which it is still proposed.
maxlogdet_error maxlogdet_active_selection_accept_block(maxlogdet_active_selection* active, const double* block,
                                                         int32_t rows);
/// Rejects it: it is not proposed again. Returns none or nothing_proposed.
maxlogdet_error maxlogdet_active_selection_reject(maxlogdet_active_selection* active);

/// The same for any unanswered proposal, in any order; nothing_proposed if this candidate is not one.
maxlogdet_error maxlogdet_active_selection_accept_index(maxlogdet_active_selection* active, uint32_t index);
/// As accept_block.
maxlogdet_error maxlogdet_active_selection_accept_block_index(maxlogdet_active_selection* active, uint32_t index,
                                                               const double* block, int32_t rows);
/// As reject.
maxlogdet_error maxlogdet_active_selection_reject_index(maxlogdet_active_selection* active, uint32_t index);
/// Answers all unanswered proposals in their order: `matched` has `count` bytes, where nonzero accepts. Returns none, or
/// nothing_proposed, without effect, if there are none or not as many, or for a null pointer.
maxlogdet_error maxlogdet_active_selection_answer(maxlogdet_active_selection* active, const uint8_t* matched,
                                                   size_t count);

/// Returns what has been accepted, in that order; valid until the next call with this handle; never null.
const maxlogdet_selection* maxlogdet_active_selection_selection(maxlogdet_active_selection* active);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)
