// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {

/// How a selection ended.
enum class Status {
  ok,                ///< as many as the budget asks for were selected (none for a budget of 0, or an empty store)
  all_selected,      ///< no more may be selected: all that constraints allow, perhaps none, are in
  target_reached,    ///< Options::target_efficiency is met. Reported also if the budget or the candidates are used up
                     ///< at the same time. With any other status it is not met
  deadline_reached,  ///< the time limit passed: the rest of the answer was filled up at once
  few_candidates,    ///< GoodFeatures: fewer matches than the budget have blocks; others fill it
  few_inliers,       ///< GoodFeatures: fewer matches than the budget fit the aligned pose: all of them are selected
  error,             ///< Error says why
};

/// How a robust alignment ended (docs/alignment.md). With any other status than `aligned` no match is rejected.
enum class AlignmentStatus {
  none,           ///< there was no alignment since the last start(), or the frame has an error
  aligned,        ///< there are inliers, a pose and its information
  few_matches,    ///< fewer than ten matches are measured and have an image at the predicted pose
  no_consensus,   ///< fewer than half of them fit one pose, or it is at quite another distance from the points
  singular,       ///< the matches do not determine all six dimensions of the pose
  not_converged,  ///< the iterations diverged, or did not come to a pose that fits better than the predicted one
};

/// X(name, what is wrong) for each error. The names and the Python module use this list.
#define MAXLOGDET_ERRORS(X)                                                                                            \
  X(none, "nothing is wrong")                                                                                          \
  X(capacity_exceeded, "more candidates than the selector's capacity")                                                 \
  X(invalid_strategy, "the strategy is not one of the enumerators")                                                    \
  X(invalid_epsilon, "stochastic.epsilon is not in (0, 1)")                                                            \
  X(invalid_prior,                                                                                                     \
    "the prior is not finite, not symmetric to 1e-4, or has a negative eigenvalue beyond the rounding "                \
    "of float32: check that both triangles are filled, and that it is J^T J or an inverse covariance")                 \
  X(invalid_time_limit, "time_limit is negative or NaN")                                                               \
  X(invalid_threads, "threads is negative")                                                                            \
  X(invalid_groups, "a group is not below groups.count, or the spread is negative or not finite")                      \
  X(invalid_target, "target_efficiency is not in [0, 1]")                                                              \
  X(infeasible, "a required candidate has no block, or more are required than the budget or a group allows")           \
  X(misplaced_required, "GoodFeatures takes FeatureMatch::is_required, not Options::required")                         \
  X(unsupported_isa, "MAXLOGDET_ISA names an instruction set that is not built in, or not supported by this machine")  \
  X(invalid_camera, "there are not 1 to 256 cameras, a parameter is out of its range, or a right column needs bf > 0") \
  X(unknown_camera_model, "Camera::model is not an enumerator")                                                        \
  X(invalid_pose,                                                                                                      \
    "a pose is missing, not finite, or not a rotation and a translation: an entry of R R^T - I is "                    \
    "above 1e-3 (RigidTransform::rotation_error() tells how far), or R is a reflection")                               \
  X(invalid_block_options, "map_sigma is negative, depth_sigma is not positive, or one of them is not finite")         \
  X(missing_matches, "the array of matches is a null pointer")                                                         \
  X(mixed_depth_cues, "some matches of the frame have a right column, and some a depth")

/// X(name, what is suspicious, and the usual mistake) for each warning. The names and the Python module use this list.
#define MAXLOGDET_WARNINGS(X)                                                                                         \
  X(none, "nothing is suspicious")                                                                                    \
  X(behind_camera, "matches are behind the camera, or where its model has no image: is the pose T_cw, and not T_wc?") \
  X(invalid_covariances,                                                                                              \
    "covariances are not finite, negative, or huge, and these matches not used: give none where it is unknown")       \
  X(unbounded_blocks, "blocks exceed float32: points lie at the centre of the camera, or sigmas are almost zero")     \
  X(not_aligned, "the matches could not be aligned, so that none was rejected: alignment() of GoodFeatures says why") \
  X(large_errors,                                                                                                     \
    "the residuals that fit best are more than three times as large as the sigmas say, so that the pose may be off: " \
    "check the sigmas and the camera, and whether most matches are right")                                            \
  X(unusable_matches,                                                                                                 \
    "half of the matches or more are not usable: not finite, with a sigma that is not positive, or of a camera that " \
    "is not there")                                                                                                   \
  X(misfitting_right_columns,                                                                                         \
    "u and v fit, but most right columns do not, and were not used: check bf (baseline times fx, in the unit of the " \
    "points) and cx_right")                                                                                           \
  X(misfitting_depths,                                                                                                \
    "u and v fit, but most depths do not, and were not used: check their unit, that of the points, and depth_sigma")

/// What is suspicious of a frame that is answered: of at least 5 % of the usable matches, or of most matches or cues.
enum class Warning {
#define MAXLOGDET_ENUMERATOR(name, explanation) name,
  MAXLOGDET_WARNINGS(MAXLOGDET_ENUMERATOR)
#undef MAXLOGDET_ENUMERATOR
};

/// What is wrong; explain() says it in words.
enum class Error {
#define MAXLOGDET_ENUMERATOR(name, explanation) name,
  MAXLOGDET_ERRORS(MAXLOGDET_ENUMERATOR)
#undef MAXLOGDET_ENUMERATOR
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Status status) noexcept;
/// Name of the enumerator; "unknown" for any other value.
const char* to_string(AlignmentStatus status) noexcept;
/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Error error) noexcept;
/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Warning warning) noexcept;
/// What is wrong, in one line without a full stop; "unknown" for any other value.
const char* explain(Error error) noexcept;
/// What is suspicious, in one line without a full stop; "unknown" for any other value.
const char* explain(Warning warning) noexcept;

}  // namespace maxlogdet
