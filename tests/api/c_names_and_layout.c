// SPDX-License-Identifier: MIT
// What may never change: names, values, layouts.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

typedef const char* (*name_function)(int32_t value);

// Of the values from `first` on; what follows has no name.
static void check_names(name_function name_of, int32_t first, const char* const* names, int32_t count) {
  for (int32_t i = 0; i < count; ++i) CHECK(strcmp(name_of(first + i), names[i]) == 0);
  CHECK(strcmp(name_of(first - 1), "unknown") == 0);
  CHECK(strcmp(name_of(1000), "unknown") == 0);
}

#define COUNT(array) ((int32_t)(sizeof(array) / sizeof *(array)))

void names_of_all_enumerators_and_of_no_other_value(void) {
  // Their values are for ever, whatever is appended.
  static const char* const errors[] = {"out_of_memory",
                                       "invalid_argument",
                                       "none",
                                       "capacity_exceeded",
                                       "invalid_strategy",
                                       "invalid_epsilon",
                                       "invalid_prior",
                                       "invalid_time_limit",
                                       "invalid_threads",
                                       "invalid_groups",
                                       "unsupported_groups",
                                       "invalid_target",
                                       "unsupported_target",
                                       "infeasible",
                                       "unsupported_isa",
                                       "invalid_camera",
                                       "unknown_camera_model",
                                       "invalid_camera_id",
                                       "invalid_pose",
                                       "invalid_block_options",
                                       "missing_points",
                                       "invalid_stride",
                                       "mixed_depth_cues",
                                       "nothing_proposed",
                                       "invalid_block"};
  check_names(maxlogdet_error_name, -2, errors, COUNT(errors));
  CHECK(strcmp(maxlogdet_error_name(MAXLOGDET_ERROR_INVALID_BLOCK), "invalid_block") == 0);
  CHECK(strcmp(maxlogdet_error_name(MAXLOGDET_ERROR_INVALID_BLOCK + 1), "unknown") == 0);
  CHECK(strcmp(maxlogdet_error_name(INT32_MIN), "unknown") == 0);
  for (maxlogdet_error error = -2; error <= MAXLOGDET_ERROR_INVALID_BLOCK; ++error) {
    const char* const explanation = maxlogdet_error_explanation(error);
    CHECK(strlen(explanation) > 10 && explanation[strlen(explanation) - 1] != '.');
  }
  CHECK(strcmp(maxlogdet_error_explanation(MAXLOGDET_ERROR_INVALID_BLOCK + 1), "unknown") == 0);

  static const char* const statuses[] = {"ok",   "all_selected", "target_reached", "deadline_reached", "few_candidates",
                                         "error"};
  check_names(maxlogdet_status_name, 0, statuses, COUNT(statuses));
  CHECK(strcmp(maxlogdet_status_name(MAXLOGDET_STATUS_ERROR), "error") == 0);
  CHECK(strcmp(maxlogdet_status_name(MAXLOGDET_STATUS_ERROR + 1), "unknown") == 0);

  static const char* const strategies[] = {"greedy",  "lazy_greedy",     "stochastic_greedy",
                                           "relaxed", "backward_greedy", "automatic"};
  check_names(maxlogdet_strategy_name, 0, strategies, COUNT(strategies));

  static const char* const weightings[] = {"map_bias", "map_bias_world", "measurement", "measurement_and_map"};
  check_names(maxlogdet_weighting_name, 0, weightings, COUNT(weightings));
  CHECK(strcmp(maxlogdet_weighting_name(4), "unknown") == 0);

  static const char* const models[] = {"pinhole", "radial_tangential", "kannala_brandt", "double_sphere"};
  check_names(maxlogdet_camera_model_name, 0, models, COUNT(models));
}

void the_library_tells_what_it_is(void) {
  CHECK(strcmp(maxlogdet_version(), MAXLOGDET_VERSION) == 0);
  char numbers[64];
  snprintf(numbers, sizeof numbers, "%d.%d.%d", MAXLOGDET_VERSION_MAJOR, MAXLOGDET_VERSION_MINOR,
           MAXLOGDET_VERSION_PATCH);
  CHECK(strcmp(numbers, MAXLOGDET_VERSION) == 0);
  int found = 0;
  int32_t count = 0;
  for (; maxlogdet_built_in_isa(count) != NULL; ++count) {
    if (strcmp(maxlogdet_built_in_isa(count), maxlogdet_active_isa()) == 0) found = 1;
  }
  CHECK(found);
  CHECK(maxlogdet_built_in_isa(-1) == NULL);
  CHECK(maxlogdet_built_in_isa(count + 1) == NULL);
  CHECK(maxlogdet_isa_is_supported(maxlogdet_active_isa()) == 1);
  CHECK(maxlogdet_isa_is_supported("z80") == 0);
  CHECK(maxlogdet_isa_is_supported(NULL) == 0);
}

static void check_layout_of_inputs(void) {
  CHECK(offsetof(maxlogdet_executor, user_data) == 8 && offsetof(maxlogdet_executor, concurrency) == 16);
  CHECK(offsetof(maxlogdet_executor, run) == 24 && sizeof(maxlogdet_executor) >= 32);

  CHECK(offsetof(maxlogdet_camera, fx) == 8 && offsetof(maxlogdet_camera, fy) == 16);
  CHECK(offsetof(maxlogdet_camera, cx) == 24 && offsetof(maxlogdet_camera, cy) == 32);
  CHECK(offsetof(maxlogdet_camera, bf) == 40 && offsetof(maxlogdet_camera, model) == 48);
  CHECK(offsetof(maxlogdet_camera, reserved) == 52 && offsetof(maxlogdet_camera, parameters) == 56);
  CHECK(sizeof(maxlogdet_camera) >= 96);

  CHECK(offsetof(maxlogdet_matches, size) == 8 && offsetof(maxlogdet_matches, points) == 16);
  CHECK(offsetof(maxlogdet_matches, point_stride) == 24 && offsetof(maxlogdet_matches, point_type) == 32);
  CHECK(offsetof(maxlogdet_matches, reserved) == 36 && offsetof(maxlogdet_matches, sigmas) == 40);
  CHECK(offsetof(maxlogdet_matches, has_depth_cue) == 48 && offsetof(maxlogdet_matches, usable) == 56);
  CHECK(offsetof(maxlogdet_matches, weights) == 64 && offsetof(maxlogdet_matches, map_covariances) == 72);
  CHECK(offsetof(maxlogdet_matches, jacobians) == 80 && offsetof(maxlogdet_matches, camera_ids) == 88);
  CHECK(sizeof(maxlogdet_matches) >= 96);

  CHECK(offsetof(maxlogdet_match, point) == 8 && offsetof(maxlogdet_match, measured) == 32);
  CHECK(offsetof(maxlogdet_match, u_right) == 48 && offsetof(maxlogdet_match, depth) == 56);
  CHECK(offsetof(maxlogdet_match, sigma) == 64 && offsetof(maxlogdet_match, covariance) == 72);
  CHECK(offsetof(maxlogdet_match, jacobian) == 80 && offsetof(maxlogdet_match, id) == 88);
  CHECK(offsetof(maxlogdet_match, camera_id) == 92 && offsetof(maxlogdet_match, is_required) == 93);
  CHECK(offsetof(maxlogdet_match, reserved) == 94 && offsetof(maxlogdet_match, point_id) == 96);
  CHECK(offsetof(maxlogdet_match, keyframe) == 104 && sizeof(maxlogdet_match) >= 112);

  CHECK(offsetof(maxlogdet_block_options, weighting) == 8 && offsetof(maxlogdet_block_options, depth_cue) == 12);
  CHECK(offsetof(maxlogdet_block_options, map_sigma) == 16 && offsetof(maxlogdet_block_options, depth_sigma) == 24);
  CHECK(offsetof(maxlogdet_block_options, min_depth) == 32 && offsetof(maxlogdet_block_options, threads) == 40);
  CHECK(offsetof(maxlogdet_block_options, reserved) == 44 && sizeof(maxlogdet_block_options) >= 48);
}

static void check_layout_of_requests_and_answers(void) {
  CHECK(offsetof(maxlogdet_block_report, error) == 0 && offsetof(maxlogdet_block_report, appended) == 8);
  CHECK(offsetof(maxlogdet_block_report, invalid) == 16 && offsetof(maxlogdet_block_report, unusable) == 24);
  CHECK(offsetof(maxlogdet_block_report, behind_camera) == 32 && offsetof(maxlogdet_block_report, too_near) == 40);
  CHECK(offsetof(maxlogdet_block_report, singular_rays) == 48);
  CHECK(offsetof(maxlogdet_block_report, invalid_covariances) == 56);
  CHECK(offsetof(maxlogdet_block_report, invalid_jacobians) == 64);

  CHECK(offsetof(maxlogdet_options, budget) == 8 && offsetof(maxlogdet_options, prior) == 16);
  CHECK(offsetof(maxlogdet_options, time_limit) == 24 && offsetof(maxlogdet_options, strategy) == 32);
  CHECK(offsetof(maxlogdet_options, threads) == 36 && offsetof(maxlogdet_options, required) == 40);
  CHECK(offsetof(maxlogdet_options, excluded) == 48 && offsetof(maxlogdet_options, target_efficiency) == 56);
  CHECK(offsetof(maxlogdet_options, target_translation_sigma) == 64);
  CHECK(offsetof(maxlogdet_options, target_rotation_sigma) == 72 && offsetof(maxlogdet_options, group_ids) == 80);
  CHECK(offsetof(maxlogdet_options, group_count) == 88 && offsetof(maxlogdet_options, group_maximum) == 96);
  CHECK(offsetof(maxlogdet_options, group_maxima) == 104 && offsetof(maxlogdet_options, certificate_compute) == 112);
  CHECK(offsetof(maxlogdet_options, reserved) == 116 && offsetof(maxlogdet_options, certificate_passes) == 120);
  CHECK(offsetof(maxlogdet_options, stochastic_epsilon) == 128 && offsetof(maxlogdet_options, stochastic_seed) == 136);
  CHECK(offsetof(maxlogdet_options, exchange_sweeps) == 144 && sizeof(maxlogdet_options) >= 152);

  CHECK(offsetof(maxlogdet_selection, status) == 0 && offsetof(maxlogdet_selection, error) == 4);
  CHECK(offsetof(maxlogdet_selection, indices) == 8 && offsetof(maxlogdet_selection, size) == 16);
  CHECK(offsetof(maxlogdet_selection, searched) == 24 && offsetof(maxlogdet_selection, gains) == 32);
  CHECK(offsetof(maxlogdet_selection, log_det) == 40 && offsetof(maxlogdet_selection, evaluations) == 48);
  CHECK(offsetof(maxlogdet_selection, float64_decisions) == 56);
  CHECK(offsetof(maxlogdet_selection, invalid_candidates) == 64 && offsetof(maxlogdet_selection, upper_bound) == 72);
  CHECK(offsetof(maxlogdet_selection, strategy) == 80 && offsetof(maxlogdet_selection, threads) == 84);
  CHECK(offsetof(maxlogdet_selection, efficiency) == 88 && offsetof(maxlogdet_selection, translation_sigma) == 96);
  CHECK(offsetof(maxlogdet_selection, rotation_sigma) == 104);
}

// What is compiled into programs and bindings. New fields may follow at the ends, so sizes may grow; nothing else.
void the_layout_of_structs_is_that_of_the_first_version(void) {
  check_layout_of_inputs();
  check_layout_of_requests_and_answers();
}
