// SPDX-License-Identifier: MIT
#pragma once

// The parts of maxlogdet_good_features, for callers with arrays or blocks of their own: a store of blocks, a selector,
// and active matching. maxlogdet/maxlogdet.h includes this.

// NOLINTBEGIN(modernize-deprecated-headers,modernize-use-using): this is C
#include <maxlogdet/structs.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Candidate blocks H_i, one per match. Fill it once a frame; clear keeps its memory.
typedef struct maxlogdet_block_store maxlogdet_block_store;

/// Makes a store with room for `capacity` candidates; it grows beyond, up to 2^32 - 1. Returns none, out_of_memory
/// (also above 2^32 - 1) or invalid_argument.
maxlogdet_error maxlogdet_block_store_create(size_t capacity, maxlogdet_block_store** blocks);
/// Destroys the store; null is a no-op.
void maxlogdet_block_store_destroy(maxlogdet_block_store* blocks);

/// Makes room for `capacity` candidates, and keeps those stored. Returns none, out_of_memory (without effect; also
/// above 2^32 - 1) or invalid_argument.
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

/// Appends a block, rows x 6 row-major, columns (translation, rotation), rows in {1, 2, 3}, rounded to float32; what is
/// none is an invalid candidate. Returns none, out_of_memory (only beyond the capacity) or invalid_argument.
maxlogdet_error maxlogdet_block_store_push_back(maxlogdet_block_store* blocks, const double* block, int32_t rows);
/// Appends an invalid candidate, a match without a block.
maxlogdet_error maxlogdet_block_store_push_back_invalid(maxlogdet_block_store* blocks);

/// n matches as arrays of the caller, which are not kept. A null optional array means its default for all matches.
typedef struct maxlogdet_matches {
  size_t struct_size;               ///< set by init
  size_t size;                      ///< n
  const void* points;               ///< n: x, y, z in the world frame, m
  size_t point_stride;              ///< bytes from one point to the next; 0, the default: n x 3 row-major
  maxlogdet_point_type point_type;  ///< default float64
  int32_t reserved;                 ///< 0, else invalid_argument
  const double* sigmas;             ///< n: standard deviation of u, v, u_right, px; default 1
  const uint8_t* has_depth_cue;     ///< n: nonzero where the match has the depth cue; default: all have it
  const uint8_t* usable;            ///< n: zero keeps a match as an invalid candidate; default: all are usable
  const double* weights;            ///< n: w >= 0 multiplies H^T H; default 1
  const double* map_covariances;    ///< n x 3 x 3: of the points, world frame, m^2; default map_sigma^2 I
  const double* jacobians;          ///< n x 2 x 3 row-major: d (u, v) / d p_c, px per m; default: the camera's
  const uint8_t* camera_ids;        ///< n: index of the match's camera in the rig; default 0
} maxlogdet_matches;
/// Sets struct_size and the defaults, as maxlogdet_camera_init.
maxlogdet_error maxlogdet_matches_init(maxlogdet_matches* matches, size_t struct_size);

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

/// As maxlogdet_good_features_information, by the camera and T_cw that saw the match, also on a rig. Returns 0 also for
/// a null pointer or an invalid i.
int32_t maxlogdet_match_information(const maxlogdet_camera* camera, const double* T_cw,
                                    const maxlogdet_matches* matches, size_t i, const maxlogdet_block_options* options,
                                    double* omega);
/// Likewise writes W, lower triangular, W^T W = Omega, by which the residual is multiplied.
int32_t maxlogdet_match_whitening(const maxlogdet_camera* camera, const double* T_cw, const maxlogdet_matches* matches,
                                  size_t i, const maxlogdet_block_options* options, double* W);

/// Selects candidates; owns all the memory for this. Use one per thread, kept for the life of the tracker.
typedef struct maxlogdet_selector maxlogdet_selector;

/// Makes a selector for stores of up to `capacity` candidates. `executor` may be null: only the calling thread works.
/// Returns none, out_of_memory (also above 2^32 - 1) or invalid_argument.
maxlogdet_error maxlogdet_selector_create(size_t capacity, const maxlogdet_executor* executor,
                                          maxlogdet_selector** selector);
/// Destroys the selector; null is a no-op.
void maxlogdet_selector_destroy(maxlogdet_selector* selector);
/// The maximum number of candidates of select.
size_t maxlogdet_selector_capacity(const maxlogdet_selector* selector);

/// Selects options->budget of the candidates, or the first of them that meet the targets; neither allocates nor locks.
/// The selection belongs to the selector, and is valid until its next select or its destruction; never null.
const maxlogdet_selection* maxlogdet_selector_select(maxlogdet_selector* selector, const maxlogdet_block_store* blocks,
                                                     const maxlogdet_options* options);

/// Active matching: it proposes candidates, one by one or in batches, which the tracker tries to match and answers.
/// Nothing allocates after create.
typedef struct maxlogdet_active_selection maxlogdet_active_selection;

/// As maxlogdet_selector_create.
maxlogdet_error maxlogdet_active_selection_create(size_t capacity, maxlogdet_active_selection** active);
/// Destroys the active selection; null is a no-op.
void maxlogdet_active_selection_destroy(maxlogdet_active_selection* active);
/// The maximum number of candidates of start.
size_t maxlogdet_active_selection_capacity(const maxlogdet_active_selection* active);

/// Starts a new selection and its time limit. Candidates and arrays of the options must not change before the last call
/// of any other function. docs/guide.md has options and errors; after an error nothing is proposed.
maxlogdet_error maxlogdet_active_selection_start(maxlogdet_active_selection* active,
                                                 const maxlogdet_block_store* candidates,
                                                 const maxlogdet_options* options);

/// Returns the candidate of maximum gain that is neither accepted nor rejected; while proposals are unanswered, the
/// first of these again. MAXLOGDET_NONE when the budget is reached, the targets are met, nothing is left, or the time
/// limit has passed.
uint32_t maxlogdet_active_selection_next(maxlogdet_active_selection* active);
/// Writes the `count` candidates of maximum current gain that may all be accepted, best first, and returns how many: 0
/// where next is MAXLOGDET_NONE, and for a `count` of 0 or a null pointer. Unanswered proposals are returned again.
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
/// Answers all unanswered proposals in their order: `matched` has `count` bytes, where nonzero accepts. Returns none,
/// or nothing_proposed, without effect, if there are none or not as many, or for a null pointer.
maxlogdet_error maxlogdet_active_selection_answer(maxlogdet_active_selection* active, const uint8_t* matched,
                                                  size_t count);

/// Returns what has been accepted, in that order; valid until the next call with this handle; never null.
const maxlogdet_selection* maxlogdet_active_selection_selection(maxlogdet_active_selection* active);

#ifdef __cplusplus
}
#endif
// NOLINTEND(modernize-deprecated-headers,modernize-use-using)
