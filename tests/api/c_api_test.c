// SPDX-License-Identifier: MIT
// The C API as C99 sees it: that it compiles and links, that every kind of handle works, and what may never change,
// which is names, values, layouts and defaults. C++ tests the rest: c_api_equals_cpp_test.cpp, c_api_misuse_test.cpp.
#include "tests/api/c_check.h"

typedef const char* (*name_function)(int32_t value);

// Of the values from `first` on; what follows has no name.
static void check_names(name_function name_of, int32_t first, const char* const* names, int32_t count) {
  for (int32_t i = 0; i < count; ++i) CHECK(strcmp(name_of(first + i), names[i]) == 0);
  CHECK(strcmp(name_of(first - 1), "unknown") == 0);
  CHECK(strcmp(name_of(first + count), "unknown") == 0);
  CHECK(strcmp(name_of(INT32_MIN), "unknown") == 0);
}

#define COUNT(array) ((int32_t)(sizeof(array) / sizeof *(array)))

// Values are for ever, whatever is appended.
static void names_of_all_enumerators_and_of_no_other_value(void) {
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
  static const char* const statuses[] = {"ok",   "all_selected", "target_reached", "deadline_reached", "few_candidates",
                                         "error"};
  static const char* const strategies[] = {"greedy",  "lazy_greedy",     "stochastic_greedy",
                                           "relaxed", "backward_greedy", "automatic"};
  static const char* const weightings[] = {"map_bias", "map_bias_world", "measurement", "measurement_and_map"};
  static const char* const models[] = {"pinhole", "radial_tangential", "kannala_brandt", "double_sphere"};
  check_names(maxlogdet_error_name, MAXLOGDET_ERROR_OUT_OF_MEMORY, errors, COUNT(errors));
  check_names(maxlogdet_status_name, MAXLOGDET_STATUS_OK, statuses, COUNT(statuses));
  check_names(maxlogdet_strategy_name, MAXLOGDET_STRATEGY_GREEDY, strategies, COUNT(strategies));
  check_names(maxlogdet_weighting_name, MAXLOGDET_WEIGHTING_MAP_BIAS, weightings, COUNT(weightings));
  check_names(maxlogdet_camera_model_name, MAXLOGDET_CAMERA_MODEL_PINHOLE, models, COUNT(models));
  CHECK(MAXLOGDET_ERROR_OUT_OF_MEMORY == -2 && MAXLOGDET_ERROR_INVALID_BLOCK == 22 && MAXLOGDET_STATUS_ERROR == 5);
  for (maxlogdet_error error = -2; error <= MAXLOGDET_ERROR_INVALID_BLOCK; ++error) {
    const char* const explanation = maxlogdet_error_explanation(error);
    CHECK(strlen(explanation) > 10 && explanation[strlen(explanation) - 1] != '.');
  }
  CHECK(strcmp(maxlogdet_error_explanation(MAXLOGDET_ERROR_INVALID_BLOCK + 1), "unknown") == 0);
}

static void the_library_tells_what_it_is(void) {
  char numbers[64];
  snprintf(numbers, sizeof numbers, "%d.%d.%d", MAXLOGDET_VERSION_MAJOR, MAXLOGDET_VERSION_MINOR,
           MAXLOGDET_VERSION_PATCH);
  CHECK(strcmp(maxlogdet_version(), MAXLOGDET_VERSION) == 0 && strcmp(numbers, MAXLOGDET_VERSION) == 0);
  int found = 0;
  int32_t count = 0;
  for (; maxlogdet_built_in_isa(count) != NULL; ++count) {
    if (strcmp(maxlogdet_built_in_isa(count), maxlogdet_active_isa()) == 0) found = 1;
  }
  CHECK(found && maxlogdet_built_in_isa(-1) == NULL && maxlogdet_built_in_isa(count + 1) == NULL);
  CHECK(maxlogdet_isa_is_supported(maxlogdet_active_isa()) == 1);
  CHECK(maxlogdet_isa_is_supported("z80") == 0 && maxlogdet_isa_is_supported(NULL) == 0);
}

// Where a field is, and where it was in the first version.
typedef struct place {
  size_t offset, first;
} place;

static void check_places(const place* places, int32_t count, size_t size, size_t first_size) {
  for (int32_t i = 0; i < count; ++i) CHECK(places[i].offset == places[i].first);
  CHECK(size >= first_size);
}

static void check_layout_of_inputs(void) {
  static const place executor[] = {{offsetof(maxlogdet_executor, struct_size), 0},
                                   {offsetof(maxlogdet_executor, user_data), 8},
                                   {offsetof(maxlogdet_executor, concurrency), 16},
                                   {offsetof(maxlogdet_executor, run), 24}};
  static const place camera[] = {
      {offsetof(maxlogdet_camera, struct_size), 0}, {offsetof(maxlogdet_camera, fx), 8},
      {offsetof(maxlogdet_camera, fy), 16},         {offsetof(maxlogdet_camera, cx), 24},
      {offsetof(maxlogdet_camera, cy), 32},         {offsetof(maxlogdet_camera, bf), 40},
      {offsetof(maxlogdet_camera, model), 48},      {offsetof(maxlogdet_camera, reserved), 52},
      {offsetof(maxlogdet_camera, parameters), 56}};
  static const place matches[] = {
      {offsetof(maxlogdet_matches, size), 8},           {offsetof(maxlogdet_matches, points), 16},
      {offsetof(maxlogdet_matches, point_stride), 24},  {offsetof(maxlogdet_matches, point_type), 32},
      {offsetof(maxlogdet_matches, reserved), 36},      {offsetof(maxlogdet_matches, sigmas), 40},
      {offsetof(maxlogdet_matches, has_depth_cue), 48}, {offsetof(maxlogdet_matches, usable), 56},
      {offsetof(maxlogdet_matches, weights), 64},       {offsetof(maxlogdet_matches, map_covariances), 72},
      {offsetof(maxlogdet_matches, jacobians), 80},     {offsetof(maxlogdet_matches, camera_ids), 88}};
  static const place match[] = {
      {offsetof(maxlogdet_match, point), 8},      {offsetof(maxlogdet_match, measured), 32},
      {offsetof(maxlogdet_match, u_right), 48},   {offsetof(maxlogdet_match, depth), 56},
      {offsetof(maxlogdet_match, sigma), 64},     {offsetof(maxlogdet_match, covariance), 72},
      {offsetof(maxlogdet_match, jacobian), 80},  {offsetof(maxlogdet_match, id), 88},
      {offsetof(maxlogdet_match, camera_id), 92}, {offsetof(maxlogdet_match, is_required), 93},
      {offsetof(maxlogdet_match, reserved), 94},  {offsetof(maxlogdet_match, point_id), 96},
      {offsetof(maxlogdet_match, keyframe), 104}};
  static const place block_options[] = {
      {offsetof(maxlogdet_block_options, weighting), 8},  {offsetof(maxlogdet_block_options, depth_cue), 12},
      {offsetof(maxlogdet_block_options, map_sigma), 16}, {offsetof(maxlogdet_block_options, depth_sigma), 24},
      {offsetof(maxlogdet_block_options, min_depth), 32}, {offsetof(maxlogdet_block_options, threads), 40},
      {offsetof(maxlogdet_block_options, reserved), 44}};
  static const place options[] = {{offsetof(maxlogdet_options, budget), 8},
                                  {offsetof(maxlogdet_options, prior), 16},
                                  {offsetof(maxlogdet_options, time_limit), 24},
                                  {offsetof(maxlogdet_options, strategy), 32},
                                  {offsetof(maxlogdet_options, threads), 36},
                                  {offsetof(maxlogdet_options, required), 40},
                                  {offsetof(maxlogdet_options, excluded), 48},
                                  {offsetof(maxlogdet_options, target_efficiency), 56},
                                  {offsetof(maxlogdet_options, target_translation_sigma), 64},
                                  {offsetof(maxlogdet_options, target_rotation_sigma), 72},
                                  {offsetof(maxlogdet_options, group_ids), 80},
                                  {offsetof(maxlogdet_options, group_count), 88},
                                  {offsetof(maxlogdet_options, group_maximum), 96},
                                  {offsetof(maxlogdet_options, group_maxima), 104},
                                  {offsetof(maxlogdet_options, certificate_compute), 112},
                                  {offsetof(maxlogdet_options, reserved), 116},
                                  {offsetof(maxlogdet_options, certificate_passes), 120},
                                  {offsetof(maxlogdet_options, stochastic_epsilon), 128},
                                  {offsetof(maxlogdet_options, stochastic_seed), 136},
                                  {offsetof(maxlogdet_options, exchange_sweeps), 144}};
  check_places(executor, COUNT(executor), sizeof(maxlogdet_executor), 32);
  check_places(camera, COUNT(camera), sizeof(maxlogdet_camera), 96);
  check_places(matches, COUNT(matches), sizeof(maxlogdet_matches), 96);
  check_places(match, COUNT(match), sizeof(maxlogdet_match), 112);
  check_places(block_options, COUNT(block_options), sizeof(maxlogdet_block_options), 48);
  check_places(options, COUNT(options), sizeof(maxlogdet_options), 152);
}

static void check_layout_of_answers(void) {
  static const place report[] = {{offsetof(maxlogdet_block_report, error), 0},
                                 {offsetof(maxlogdet_block_report, appended), 8},
                                 {offsetof(maxlogdet_block_report, invalid), 16},
                                 {offsetof(maxlogdet_block_report, unusable), 24},
                                 {offsetof(maxlogdet_block_report, behind_camera), 32},
                                 {offsetof(maxlogdet_block_report, too_near), 40},
                                 {offsetof(maxlogdet_block_report, singular_rays), 48},
                                 {offsetof(maxlogdet_block_report, invalid_covariances), 56},
                                 {offsetof(maxlogdet_block_report, invalid_jacobians), 64}};
  static const place selection[] = {{offsetof(maxlogdet_selection, status), 0},
                                    {offsetof(maxlogdet_selection, error), 4},
                                    {offsetof(maxlogdet_selection, indices), 8},
                                    {offsetof(maxlogdet_selection, size), 16},
                                    {offsetof(maxlogdet_selection, searched), 24},
                                    {offsetof(maxlogdet_selection, gains), 32},
                                    {offsetof(maxlogdet_selection, log_det), 40},
                                    {offsetof(maxlogdet_selection, evaluations), 48},
                                    {offsetof(maxlogdet_selection, float64_decisions), 56},
                                    {offsetof(maxlogdet_selection, invalid_candidates), 64},
                                    {offsetof(maxlogdet_selection, upper_bound), 72},
                                    {offsetof(maxlogdet_selection, strategy), 80},
                                    {offsetof(maxlogdet_selection, threads), 84},
                                    {offsetof(maxlogdet_selection, efficiency), 88},
                                    {offsetof(maxlogdet_selection, translation_sigma), 96},
                                    {offsetof(maxlogdet_selection, rotation_sigma), 104}};
  check_places(report, COUNT(report), sizeof(maxlogdet_block_report), 72);
  check_places(selection, COUNT(selection), sizeof(maxlogdet_selection), 112);
}

// What is not named is 0; no struct has padding.
static void init_sets_the_documented_defaults(void) {
  const maxlogdet_options options = {.struct_size = sizeof options,
                                     .budget = 200,
                                     .strategy = MAXLOGDET_STRATEGY_LAZY_GREEDY,
                                     .group_maximum = 1,
                                     .stochastic_epsilon = 0.1};
  const maxlogdet_block_options block_options = {.struct_size = sizeof block_options,
                                                 .weighting = MAXLOGDET_WEIGHTING_MEASUREMENT,
                                                 .map_sigma = 0.05,
                                                 .depth_sigma = 0.05,
                                                 .min_depth = 0.01};
  const maxlogdet_camera camera = {.struct_size = sizeof camera, .model = MAXLOGDET_CAMERA_MODEL_PINHOLE};
  const maxlogdet_matches matches = {.struct_size = sizeof matches, .point_type = MAXLOGDET_POINT_TYPE_FLOAT64};
  const maxlogdet_match match = {.struct_size = sizeof match,
                                 .measured = {-DBL_MAX, -DBL_MAX},
                                 .u_right = -DBL_MAX,
                                 .depth = -DBL_MAX,
                                 .sigma = 1,
                                 .point_id = -1,
                                 .keyframe = -1};
  const maxlogdet_executor executor = {.struct_size = sizeof executor};
  struct {
    maxlogdet_options options;
    maxlogdet_block_options block_options;
    maxlogdet_camera camera;
    maxlogdet_matches matches;
    maxlogdet_match match;
    maxlogdet_executor executor;
  } made;
  memset(&made, 0xA5, sizeof made);
  CHECK(maxlogdet_options_init(&made.options, sizeof options) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_options_init(&made.block_options, sizeof block_options) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_camera_init(&made.camera, sizeof camera) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_matches_init(&made.matches, sizeof matches) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_match_init(&made.match, sizeof match) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_executor_init(&made.executor, sizeof executor) == MAXLOGDET_ERROR_NONE);
  CHECK(memcmp(&made.options, &options, sizeof options) == 0);
  CHECK(memcmp(&made.block_options, &block_options, sizeof block_options) == 0);
  CHECK(memcmp(&made.camera, &camera, sizeof camera) == 0);
  CHECK(memcmp(&made.matches, &matches, sizeof matches) == 0);
  CHECK(memcmp(&made.match, &match, sizeof match) == 0);
  CHECK(memcmp(&made.executor, &executor, sizeof executor) == 0);
  CHECK(MAXLOGDET_UNMEASURED == -DBL_MAX);
}

enum { n = 100, budget = 30 };

// A store, a selector, and an active selection that accepts all, which is the same.
static void a_store_is_selected_from(void) {
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_selector* selector = NULL;
  maxlogdet_active_selection* active = NULL;
  REQUIRE(maxlogdet_selector_create(n, NULL, &selector) == MAXLOGDET_ERROR_NONE);
  REQUIRE(maxlogdet_active_selection_create(n, &active) == MAXLOGDET_ERROR_NONE);
  maxlogdet_options options = default_options();
  options.budget = budget;
  const maxlogdet_selection* const selection = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(selection->status == MAXLOGDET_STATUS_OK && selection->size == budget && selection->invalid_candidates == 2);
  CHECK(maxlogdet_selection_has_answer(selection) == 1 && strcmp(maxlogdet_selection_reason(selection), "ok") == 0);
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_ERROR_NONE);
  while (maxlogdet_active_selection_next(active) != MAXLOGDET_NONE) {
    CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_ERROR_NONE);
  }
  CHECK(same_answer(maxlogdet_active_selection_selection(active), selection));
  maxlogdet_active_selection_destroy(active);
  maxlogdet_selector_destroy(selector);
  maxlogdet_block_store_destroy(blocks);
}

// The loop of a tracker, and the same blocks from arrays.
static void a_frame_is_selected_from_and_judged(void) {
  maxlogdet_camera camera;
  maxlogdet_match match;
  maxlogdet_matches matches;
  maxlogdet_block_options block_options;
  maxlogdet_good_features* good = NULL;
  maxlogdet_block_store* blocks = NULL;
  maxlogdet_camera_init(&camera, sizeof camera);
  maxlogdet_match_init(&match, sizeof match);
  maxlogdet_matches_init(&matches, sizeof matches);
  maxlogdet_block_options_init(&block_options, sizeof block_options);
  REQUIRE(maxlogdet_good_features_create(n, NULL, &good) == MAXLOGDET_ERROR_NONE);
  REQUIRE(maxlogdet_block_store_create(n, &blocks) == MAXLOGDET_ERROR_NONE);
  camera.fx = camera.fy = 450;
  double points[3 * n];
  CHECK(maxlogdet_good_features_start(good, &camera, identity_pose) == MAXLOGDET_ERROR_NONE);
  for (size_t i = 0; i < n; ++i) {
    for (size_t d = 0; d < 3; ++d) match.point[d] = points[3 * i + d] = 2 * random_entry() + (d == 2 ? 5 : 0);
    for (size_t d = 0; d < 2; ++d) match.measured[d] = 450 * match.point[d] / match.point[2];
    CHECK(maxlogdet_good_features_add(good, &match) == MAXLOGDET_ERROR_NONE);
  }
  maxlogdet_options options = default_options();
  options.budget = budget;
  const maxlogdet_selection* const selection = maxlogdet_good_features_select(good, &options);
  CHECK(selection->status == MAXLOGDET_STATUS_OK && selection->size == budget);
  const uint32_t* outliers = NULL;
  CHECK(maxlogdet_good_features_outliers(good, identity_pose, &outliers) == 0);
  double moved[12];
  memcpy(moved, identity_pose, sizeof moved);
  moved[3] = 0.5;  // m: 30 px and more
  CHECK(maxlogdet_good_features_outliers(good, moved, &outliers) == n - budget);
  CHECK(maxlogdet_good_features_is_selected(good, outliers[0]) == 0);
  CHECK(maxlogdet_good_features_chi2(good, outliers[0]) > 5.991);

  matches.size = n;
  matches.points = points;
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &block_options, blocks, NULL)->appended == n);
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_selector_create(n, NULL, &selector) == MAXLOGDET_ERROR_NONE);
  CHECK(same_answer(maxlogdet_selector_select(selector, blocks, &options), selection));
  maxlogdet_selector_destroy(selector);
  maxlogdet_block_store_destroy(blocks);
  maxlogdet_good_features_destroy(good);
}

int main(void) {
  names_of_all_enumerators_and_of_no_other_value();
  the_library_tells_what_it_is();
  check_layout_of_inputs();
  check_layout_of_answers();
  init_sets_the_documented_defaults();
  a_store_is_selected_from();
  a_frame_is_selected_from_and_judged();
  return report();
}
