// SPDX-License-Identifier: MIT
// The C API as C99 sees it: every function, what is refused, and what may never change. That its answers are those of
// C++ is for c_api_equals_cpp_test.cpp to say.
#include "tests/api/c_check.h"

#include <float.h>

static const double identity_pose[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static void names_of_all_enumerators_and_of_no_other_value(void) {
  static const char* const statuses[] = {"out_of_memory",    "invalid_argument",   "ok",
                                         "all_selected",     "deadline_reached",   "invalid_budget",
                                         "invalid_epsilon",  "invalid_prior",      "capacity_exceeded",
                                         "invalid_strategy", "invalid_time_limit", "invalid_threads",
                                         "invalid_groups",   "infeasible",         "unsupported_groups",
                                         "nothing_proposed", "invalid_block",      "unsupported_isa",
                                         "target_reached",   "invalid_target",     "unsupported_target",
                                         "unknown"};
  for (int32_t i = 0; i < 22; ++i) CHECK(strcmp(maxlogdet_status_name(i - 2), statuses[i]) == 0);
  CHECK(strcmp(maxlogdet_status_name(-3), "unknown") == 0);
  CHECK(strcmp(maxlogdet_status_name(INT32_MIN), "unknown") == 0);
  CHECK(strcmp(maxlogdet_status_name(MAXLOGDET_STATUS_UNSUPPORTED_ISA), "unsupported_isa") == 0);
  CHECK(strcmp(maxlogdet_status_name(MAXLOGDET_STATUS_UNSUPPORTED_TARGET), "unsupported_target") == 0);
  CHECK(strcmp(maxlogdet_status_name(MAXLOGDET_STATUS_INVALID_TIME_LIMIT), "invalid_time_limit") == 0);

  static const char* const strategies[] = {
      // their values are for ever, whatever is appended
      "greedy", "lazy_greedy", "stochastic_greedy", "relaxed", "backward_greedy", "automatic"};
  for (int32_t i = 0; i < 6; ++i) CHECK(strcmp(maxlogdet_strategy_name(i), strategies[i]) == 0);
  CHECK(strcmp(maxlogdet_strategy_name(-1), "unknown") == 0);
  CHECK(strcmp(maxlogdet_strategy_name(1000), "unknown") == 0);

  static const char* const weightings[] = {"map_bias", "map_bias_world", "measurement", "measurement_and_map",
                                           "unknown"};
  for (int32_t i = 0; i < 5; ++i) CHECK(strcmp(maxlogdet_weighting_name(i), weightings[i]) == 0);

  static const char* const models[] = {"pinhole", "radial_tangential", "kannala_brandt", "double_sphere"};
  for (int32_t i = 0; i < 4; ++i) CHECK(strcmp(maxlogdet_camera_model_name(i), models[i]) == 0);
  CHECK(strcmp(maxlogdet_camera_model_name(1000), "unknown") == 0);

  static const char* const block_statuses[] = {"out_of_memory",
                                               "invalid_argument",
                                               "ok",
                                               "singular_rays",
                                               "invalid_camera",
                                               "invalid_pose",
                                               "invalid_options",
                                               "missing_points",
                                               "invalid_stride",
                                               "unknown_camera_model",
                                               "invalid_camera_id",
                                               "invalid_jacobians",
                                               "unknown"};
  for (int32_t i = 0; i < 13; ++i) CHECK(strcmp(maxlogdet_block_status_name(i - 2), block_statuses[i]) == 0);
}

static void the_library_tells_what_it_is(void) {
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

// What is compiled into programs and bindings. New fields may follow at the ends, so sizes may grow; nothing else.
static void the_layout_of_structs_is_that_of_the_first_version(void) {
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
  CHECK(offsetof(maxlogdet_matches, has_third) == 48 && offsetof(maxlogdet_matches, usable) == 56);
  CHECK(offsetof(maxlogdet_matches, weights) == 64 && offsetof(maxlogdet_matches, map_covariances) == 72);
  CHECK(offsetof(maxlogdet_matches, jacobians) == 80 && offsetof(maxlogdet_matches, camera_ids) == 88);
  CHECK(sizeof(maxlogdet_matches) >= 96);

  CHECK(offsetof(maxlogdet_block_options, weighting) == 8 && offsetof(maxlogdet_block_options, third) == 12);
  CHECK(offsetof(maxlogdet_block_options, map_sigma) == 16 && offsetof(maxlogdet_block_options, depth_sigma) == 24);
  CHECK(offsetof(maxlogdet_block_options, min_depth) == 32 && offsetof(maxlogdet_block_options, threads) == 40);
  CHECK(offsetof(maxlogdet_block_options, reserved) == 44 && sizeof(maxlogdet_block_options) >= 48);

  CHECK(offsetof(maxlogdet_block_report, status) == 0 && offsetof(maxlogdet_block_report, appended) == 8);
  CHECK(offsetof(maxlogdet_block_report, invalid) == 16 && offsetof(maxlogdet_block_report, unusable) == 24);
  CHECK(offsetof(maxlogdet_block_report, behind_camera) == 32 && offsetof(maxlogdet_block_report, too_near) == 40);
  CHECK(offsetof(maxlogdet_block_report, singular_rays) == 48);
  CHECK(offsetof(maxlogdet_block_report, unsound_covariances) == 56);
  CHECK(offsetof(maxlogdet_block_report, invalid_jacobians) == 64);

  CHECK(offsetof(maxlogdet_options, budget) == 8 && offsetof(maxlogdet_options, strategy) == 16);
  CHECK(offsetof(maxlogdet_options, threads) == 20 && offsetof(maxlogdet_options, epsilon) == 24);
  CHECK(offsetof(maxlogdet_options, seed) == 32 && offsetof(maxlogdet_options, prior) == 40);
  CHECK(offsetof(maxlogdet_options, time_limit) == 48 && offsetof(maxlogdet_options, certify) == 56);
  CHECK(offsetof(maxlogdet_options, reserved) == 60 && offsetof(maxlogdet_options, certificate_passes) == 64);
  CHECK(offsetof(maxlogdet_options, exchange_sweeps) == 72 && offsetof(maxlogdet_options, required) == 80);
  CHECK(offsetof(maxlogdet_options, excluded) == 88 && offsetof(maxlogdet_options, groups) == 96);
  CHECK(offsetof(maxlogdet_options, group_count) == 104 && offsetof(maxlogdet_options, max_per_group) == 112);
  CHECK(offsetof(maxlogdet_options, group_maxima) == 120 && offsetof(maxlogdet_options, target_efficiency) == 128);
  CHECK(offsetof(maxlogdet_options, target_translation_sigma) == 136);
  CHECK(offsetof(maxlogdet_options, target_rotation_sigma) == 144 && sizeof(maxlogdet_options) >= 152);

  CHECK(offsetof(maxlogdet_selection, status) == 0 && offsetof(maxlogdet_selection, strategy) == 4);
  CHECK(offsetof(maxlogdet_selection, size) == 8 && offsetof(maxlogdet_selection, indices) == 16);
  CHECK(offsetof(maxlogdet_selection, gains) == 24 && offsetof(maxlogdet_selection, log_det) == 32);
  CHECK(offsetof(maxlogdet_selection, upper_bound) == 40 && offsetof(maxlogdet_selection, evaluations) == 48);
  CHECK(offsetof(maxlogdet_selection, float64_decisions) == 56);
  CHECK(offsetof(maxlogdet_selection, invalid_candidates) == 64 && offsetof(maxlogdet_selection, threads) == 72);
  CHECK(offsetof(maxlogdet_selection, reserved) == 76);
}

static void init_sets_the_defaults(void) {
  maxlogdet_options options;
  memset(&options, 0xA5, sizeof options);
  CHECK(maxlogdet_options_init(&options, sizeof options) == MAXLOGDET_STATUS_OK);
  CHECK(options.struct_size == sizeof options && options.budget == 100);
  CHECK(options.strategy == MAXLOGDET_STRATEGY_LAZY_GREEDY && options.threads == 0);
  CHECK(options.epsilon == 0.1 && options.seed == 0 && options.prior == NULL && options.time_limit == 0);
  CHECK(options.certify == 0 && options.reserved == 0 && options.certificate_passes == 0);
  CHECK(options.exchange_sweeps == 0 && options.required == NULL && options.excluded == NULL);
  CHECK(options.groups == NULL && options.group_count == 0 && options.max_per_group == 1);
  CHECK(options.group_maxima == NULL && options.target_efficiency == 0);
  CHECK(options.target_translation_sigma == 0 && options.target_rotation_sigma == 0);

  maxlogdet_block_options block_options;
  memset(&block_options, 0xA5, sizeof block_options);
  CHECK(maxlogdet_block_options_init(&block_options, sizeof block_options) == MAXLOGDET_STATUS_OK);
  CHECK(block_options.struct_size == sizeof block_options);
  CHECK(block_options.weighting == MAXLOGDET_WEIGHTING_MEASUREMENT);
  CHECK(block_options.third == MAXLOGDET_THIRD_MEASUREMENT_NONE && block_options.threads == 0);
  CHECK(block_options.min_depth == 0.01);
  CHECK(block_options.map_sigma == 0.05 && block_options.depth_sigma == 0.05 && block_options.reserved == 0);

  maxlogdet_camera camera;
  memset(&camera, 0xA5, sizeof camera);
  CHECK(maxlogdet_camera_init(&camera, sizeof camera) == MAXLOGDET_STATUS_OK);
  CHECK(camera.struct_size == sizeof camera);
  CHECK(camera.fx == 0 && camera.fy == 0 && camera.cx == 0 && camera.cy == 0 && camera.bf == 0);
  CHECK(camera.model == MAXLOGDET_CAMERA_MODEL_PINHOLE && camera.reserved == 0);
  for (int i = 0; i < 5; ++i) CHECK(camera.parameters[i] == 0);

  maxlogdet_matches matches;
  memset(&matches, 0xA5, sizeof matches);
  CHECK(maxlogdet_matches_init(&matches, sizeof matches) == MAXLOGDET_STATUS_OK);
  CHECK(matches.struct_size == sizeof matches && matches.size == 0 && matches.points == NULL);
  CHECK(matches.sigmas == NULL && matches.has_third == NULL && matches.usable == NULL && matches.weights == NULL);
  CHECK(matches.map_covariances == NULL && matches.jacobians == NULL && matches.camera_ids == NULL);
  CHECK(matches.point_stride == 0 && matches.point_type == MAXLOGDET_POINT_TYPE_FLOAT64 && matches.reserved == 0);

  maxlogdet_executor executor;
  memset(&executor, 0xA5, sizeof executor);
  CHECK(maxlogdet_executor_init(&executor, sizeof executor) == MAXLOGDET_STATUS_OK);
  CHECK(executor.struct_size == sizeof executor && executor.user_data == NULL);
  CHECK(executor.concurrency == NULL && executor.run == NULL);
}

// One struct's init, called as if for that type.
typedef maxlogdet_status (*init_function)(void* given, size_t struct_size);
static maxlogdet_status init_options(void* s, size_t size) { return maxlogdet_options_init(s, size); }
static maxlogdet_status init_block_options(void* s, size_t size) { return maxlogdet_block_options_init(s, size); }
static maxlogdet_status init_camera(void* s, size_t size) { return maxlogdet_camera_init(s, size); }
static maxlogdet_status init_matches(void* s, size_t size) { return maxlogdet_matches_init(s, size); }
static maxlogdet_status init_executor(void* s, size_t size) { return maxlogdet_executor_init(s, size); }

// Memory of exactly `size` bytes: a sanitizer sees whoever goes beyond.
static void* exactly(size_t size, const void* content) {
  void* const memory = malloc(size);
  REQUIRE(memory != NULL);
  if (content != NULL) memcpy(memory, content, size);
  return memory;
}

static void init_takes_older_sizes_and_marks_what_it_refuses(void) {
  static const init_function inits[] = {init_options, init_block_options, init_camera, init_matches, init_executor};
  static const size_t sizes[] = {sizeof(maxlogdet_options), sizeof(maxlogdet_block_options), sizeof(maxlogdet_camera),
                                 sizeof(maxlogdet_matches), sizeof(maxlogdet_executor)};
  for (size_t kind = 0; kind < sizeof sizes / sizeof *sizes; ++kind) {
    CHECK(inits[kind](NULL, sizes[kind]) == MAXLOGDET_STATUS_INVALID_ARGUMENT);
    unsigned char full[256];
    CHECK(inits[kind](full, sizes[kind]) == MAXLOGDET_STATUS_OK);
    for (size_t size = 1; size <= sizes[kind] + 16; ++size) {
      unsigned char* const given = exactly(size, NULL);
      memset(given, 0xA5, size);
      const int is_known = size >= 16 && size % 8 == 0 && size <= sizes[kind];
      CHECK(inits[kind](given, size) == (is_known ? MAXLOGDET_STATUS_OK : MAXLOGDET_STATUS_INVALID_ARGUMENT));
      size_t struct_size = 1;
      if (size >= sizeof struct_size) memcpy(&struct_size, given, sizeof struct_size);
      if (is_known) {
        CHECK(struct_size == size && memcmp(given + 8, full + 8, size - 8) == 0);
      } else {
        CHECK(struct_size == (size >= sizeof struct_size ? 0U : 1U));
      }
      free(given);
    }
    unsigned char untouched[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    CHECK(inits[kind](untouched, 0) == MAXLOGDET_STATUS_INVALID_ARGUMENT);
    CHECK(untouched[0] == 1 && untouched[7] == 8);
  }
}

static void select_takes_older_options_and_refuses_sizes_that_are_none(void) {
  enum { n = 200 };
  static uint8_t required[n], excluded[n];
  static uint32_t groups[n], maxima[4] = {30, 30, 30, 30};
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_selector* selector = NULL;
  maxlogdet_selector* other = NULL;
  REQUIRE(maxlogdet_selector_create(n, NULL, &selector) == MAXLOGDET_STATUS_OK);
  REQUIRE(maxlogdet_selector_create(n, NULL, &other) == MAXLOGDET_STATUS_OK);
  required[3] = excluded[4] = 1;
  for (uint32_t i = 0; i < n; ++i) groups[i] = i % 4;

  maxlogdet_options all = default_options();  // every field other than its default
  double prior[36] = {0};
  for (size_t i = 0; i < 6; ++i) prior[7 * i] = 2;
  all.budget = 40;
  all.strategy = MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY;
  all.threads = 1;
  all.epsilon = 0.3;
  all.seed = 7;
  all.prior = prior;
  all.time_limit = 1000;
  all.certify = 1;
  all.certificate_passes = 2;
  all.exchange_sweeps = 1;
  all.required = required;
  all.excluded = excluded;
  all.groups = groups;
  all.group_count = 4;
  all.max_per_group = 30;
  all.group_maxima = maxima;
  all.target_efficiency = all.target_translation_sigma = all.target_rotation_sigma = 0.5;

  for (size_t size = 8; size <= sizeof all + 8; ++size) {
    unsigned char content[sizeof all + 8] = {0};
    memcpy(content, &all, sizeof all);
    memcpy(content, &size, sizeof size);
    maxlogdet_options* const given = exactly(size, content);
    const maxlogdet_selection* const answer = maxlogdet_selector_select(selector, blocks, given);
    if (size < 16 || size % 8 != 0 || size > sizeof all) {
      CHECK(answer->status == MAXLOGDET_STATUS_INVALID_ARGUMENT && answer->size == 0);
    } else {
      maxlogdet_options expected = default_options();
      memcpy((unsigned char*)&expected + 8, content + 8, size - 8);
      CHECK(same_answer(answer, maxlogdet_selector_select(other, blocks, &expected)));
      maxlogdet_status status = MAXLOGDET_STATUS_OK;
      if (size == offsetof(maxlogdet_options, group_count)) status = MAXLOGDET_STATUS_INVALID_GROUPS;
      if (size == offsetof(maxlogdet_options, max_per_group)) status = MAXLOGDET_STATUS_ALL_SELECTED;  // one of each
      if (size > offsetof(maxlogdet_options, target_efficiency))
        status = MAXLOGDET_STATUS_UNSUPPORTED_TARGET;  // sweeps
      CHECK(answer->status == status);
    }
    free(given);
  }
  all.struct_size = SIZE_MAX;
  CHECK(maxlogdet_selector_select(selector, blocks, &all)->status == MAXLOGDET_STATUS_INVALID_ARGUMENT);
  all.struct_size = (size_t)0xA5A5A5A5A5A5A5A8;
  CHECK(maxlogdet_selector_select(selector, blocks, &all)->status == MAXLOGDET_STATUS_INVALID_ARGUMENT);
  all = default_options();
  all.reserved = 1;
  CHECK(maxlogdet_selector_select(selector, blocks, &all)->status == MAXLOGDET_STATUS_INVALID_ARGUMENT);
  maxlogdet_selector_destroy(selector);
  maxlogdet_selector_destroy(other);
  maxlogdet_block_store_destroy(blocks);
}

static void a_store_counts_what_it_holds(void) {
  maxlogdet_block_store* blocks = NULL;
  CHECK(maxlogdet_block_store_create(4, &blocks) == MAXLOGDET_STATUS_OK);
  REQUIRE(blocks != NULL);
  CHECK(maxlogdet_block_store_size(blocks) == 0 && maxlogdet_block_store_capacity(blocks) == 4);
  CHECK(maxlogdet_block_store_rows(blocks) == 0 && maxlogdet_block_store_is_valid(blocks, 0) == 0);
  double block[24];
  for (size_t e = 0; e < 24; ++e) block[e] = random_entry();
  CHECK(maxlogdet_block_store_push_back(blocks, block, 1) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_rows(blocks) == 1);
  CHECK(maxlogdet_block_store_push_back(blocks, block, 3) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_rows(blocks) == 3 && maxlogdet_block_store_invalid_count(blocks) == 0);
  CHECK(maxlogdet_block_store_push_back_invalid(blocks) == MAXLOGDET_STATUS_OK);
  // Kept as invalid: without a block, of a number of rows that is none, not finite, beyond float32.
  CHECK(maxlogdet_block_store_push_back(blocks, NULL, 2) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_push_back(blocks, block, 0) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_push_back(blocks, block, 4) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_push_back(blocks, block, INT32_MIN) == MAXLOGDET_STATUS_OK);
  block[5] = (double)NAN;
  CHECK(maxlogdet_block_store_push_back(blocks, block, 2) == MAXLOGDET_STATUS_OK);
  block[5] = DBL_MAX;
  CHECK(maxlogdet_block_store_push_back(blocks, block, 2) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_size(blocks) == 9 && maxlogdet_block_store_invalid_count(blocks) == 7);
  CHECK(maxlogdet_block_store_capacity(blocks) >= 9);
  for (size_t i = 0; i < 9; ++i) CHECK(maxlogdet_block_store_is_valid(blocks, i) == (i < 2));
  CHECK(maxlogdet_block_store_is_valid(blocks, 9) == 0 && maxlogdet_block_store_is_valid(blocks, SIZE_MAX) == 0);

  CHECK(maxlogdet_block_store_reserve(blocks, 1000) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_capacity(blocks) == 1000 && maxlogdet_block_store_size(blocks) == 9);
  CHECK(maxlogdet_block_store_reserve(blocks, SIZE_MAX) == MAXLOGDET_STATUS_OUT_OF_MEMORY);
  CHECK(maxlogdet_block_store_reserve(blocks, (size_t)UINT32_MAX + 1) == MAXLOGDET_STATUS_OUT_OF_MEMORY);
  CHECK(maxlogdet_block_store_capacity(blocks) == 1000 && maxlogdet_block_store_is_valid(blocks, 1) == 1);
  CHECK(maxlogdet_block_store_clear(blocks) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_block_store_size(blocks) == 0 && maxlogdet_block_store_capacity(blocks) == 1000);
  CHECK(maxlogdet_block_store_invalid_count(blocks) == 0 && maxlogdet_block_store_rows(blocks) == 0);
  maxlogdet_block_store_destroy(blocks);
}

static void what_cannot_be_created_is_told_and_null(void) {
  maxlogdet_block_store* blocks = (maxlogdet_block_store*)&failures;
  CHECK(maxlogdet_block_store_create(SIZE_MAX, &blocks) == MAXLOGDET_STATUS_OUT_OF_MEMORY && blocks == NULL);
  maxlogdet_selector* selector = (maxlogdet_selector*)&failures;
  CHECK(maxlogdet_selector_create(SIZE_MAX, NULL, &selector) == MAXLOGDET_STATUS_OUT_OF_MEMORY && selector == NULL);
  maxlogdet_active_selection* active = (maxlogdet_active_selection*)&failures;
  CHECK(maxlogdet_active_selection_create(SIZE_MAX, &active) == MAXLOGDET_STATUS_OUT_OF_MEMORY && active == NULL);
}

static void null_is_refused_everywhere(void) {
  const maxlogdet_status refused = MAXLOGDET_STATUS_INVALID_ARGUMENT;
  const double block[6] = {1, 2, 3, 4, 5, 6};
  maxlogdet_options options = default_options();

  CHECK(maxlogdet_block_store_create(1, NULL) == refused);
  CHECK(maxlogdet_block_store_reserve(NULL, 1) == refused);
  CHECK(maxlogdet_block_store_clear(NULL) == refused);
  CHECK(maxlogdet_block_store_push_back(NULL, block, 1) == refused);
  CHECK(maxlogdet_block_store_push_back_invalid(NULL) == refused);
  CHECK(maxlogdet_block_store_size(NULL) == 0 && maxlogdet_block_store_capacity(NULL) == 0);
  CHECK(maxlogdet_block_store_rows(NULL) == 0 && maxlogdet_block_store_is_valid(NULL, 0) == 0);
  CHECK(maxlogdet_block_store_invalid_count(NULL) == 0);
  maxlogdet_block_store_destroy(NULL);

  CHECK(maxlogdet_selector_create(1, NULL, NULL) == refused);
  CHECK(maxlogdet_selector_capacity(NULL) == 0);
  maxlogdet_selector_destroy(NULL);
  maxlogdet_block_store* const blocks = random_blocks(10);
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_selector_create(10, NULL, &selector) == MAXLOGDET_STATUS_OK);
  const maxlogdet_selection* const refusals[5] = {
      maxlogdet_selector_select(NULL, blocks, &options), maxlogdet_selector_select(selector, NULL, &options),
      maxlogdet_selector_select(selector, blocks, NULL), maxlogdet_selector_select(NULL, NULL, NULL),
      maxlogdet_active_selection_selection(NULL)};
  for (size_t i = 0; i < 5; ++i) {
    CHECK(refusals[i]->status == refused && refusals[i]->size == 0 && refusals[i]->indices == NULL);
    CHECK(isnan(refusals[i]->log_det) && isnan(refusals[i]->upper_bound));
    CHECK(isnan(refusals[i]->efficiency_of_all) && isnan(refusals[i]->translation_sigma));
    CHECK(isnan(refusals[i]->rotation_sigma) && refusals[i]->reserved == 0);
    CHECK(maxlogdet_selection_has_answer(refusals[i]) == 0 && isnan(maxlogdet_selection_efficiency(refusals[i])));
  }
  CHECK(maxlogdet_selection_has_answer(NULL) == 0 && isnan(maxlogdet_selection_efficiency(NULL)));
  maxlogdet_selector_destroy(selector);

  CHECK(maxlogdet_active_selection_create(1, NULL) == refused);
  CHECK(maxlogdet_active_selection_capacity(NULL) == 0);
  CHECK(maxlogdet_active_selection_start(NULL, blocks, &options) == refused);
  CHECK(maxlogdet_active_selection_next(NULL) == MAXLOGDET_NONE);
  CHECK(maxlogdet_active_selection_accept(NULL) == refused);
  CHECK(maxlogdet_active_selection_accept_block(NULL, block, 1) == refused);
  CHECK(maxlogdet_active_selection_reject(NULL) == refused);
  uint32_t index = 5;
  const uint8_t matched[1] = {1};
  CHECK(maxlogdet_active_selection_next_batch(NULL, &index, 1) == 0 && index == 5);
  CHECK(maxlogdet_active_selection_accept_index(NULL, 0) == refused);
  CHECK(maxlogdet_active_selection_accept_block_index(NULL, 0, block, 1) == refused);
  CHECK(maxlogdet_active_selection_reject_index(NULL, 0) == refused);
  CHECK(maxlogdet_active_selection_answer(NULL, matched, 1) == refused);
  maxlogdet_active_selection_destroy(NULL);
  maxlogdet_block_store_destroy(blocks);
}

static void blocks_are_made_for_any_camera(void) {
  typedef struct point {
    float x, y, z, brightness;
  } point;
  const point points[3] = {
      {0, 0, 5, 1}, {3, -1, 0.5F, 1}, {3, 1, -2, 1}};  // the last one is behind all but the fisheye
  const double jacobians[18] = {90, 0, 0, 0, 90, 0, 10, 0, 5, 0, 0, 5, 90, 0, 1, 0, 90, 1};
  const uint8_t ids[3] = {0, 1, 1};
  const double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0};
  maxlogdet_camera fisheye, pinhole;
  maxlogdet_matches matches;
  maxlogdet_block_options options;
  maxlogdet_camera_init(&fisheye, sizeof fisheye);
  maxlogdet_camera_init(&pinhole, sizeof pinhole);
  maxlogdet_matches_init(&matches, sizeof matches);
  maxlogdet_block_options_init(&options, sizeof options);
  fisheye.fx = fisheye.fy = pinhole.fx = pinhole.fy = 190;
  fisheye.model = MAXLOGDET_CAMERA_MODEL_KANNALA_BRANDT;
  fisheye.parameters[0] = 0.003;
  matches.size = 3;
  matches.points = points;
  matches.point_type = MAXLOGDET_POINT_TYPE_FLOAT32;
  matches.point_stride = sizeof *points;
  maxlogdet_block_store* blocks = NULL;
  CHECK(maxlogdet_block_store_create(3, &blocks) == MAXLOGDET_STATUS_OK);
  const maxlogdet_block_report* report =
      maxlogdet_append_blocks(&fisheye, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->status == MAXLOGDET_BLOCK_STATUS_OK && report->appended == 3 && report->invalid == 0);
  options.min_depth = 5.1;  // |p_c| of a fisheye
  report = maxlogdet_append_blocks(&fisheye, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->too_near == 3 && report->invalid == 3);
  options.min_depth = 0.01;

  matches.camera_ids = ids;
  const maxlogdet_camera* cameras[2] = {&pinhole, &fisheye};
  report = maxlogdet_append_blocks_of_rig(cameras, T_cb, 2, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->status == MAXLOGDET_BLOCK_STATUS_OK && report->appended == 3 && report->invalid == 0);
  cameras[1] = &pinhole;
  report = maxlogdet_append_blocks_of_rig(cameras, T_cb, 2, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->invalid == 1 && report->behind_camera == 1);
  matches.jacobians = jacobians;
  report = maxlogdet_append_blocks_of_rig(cameras, T_cb, 2, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->status == MAXLOGDET_BLOCK_STATUS_OK && report->invalid == 1 && report->invalid_jacobians == 0);

  CHECK(maxlogdet_append_blocks(&pinhole, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA_ID);
  CHECK(maxlogdet_append_blocks_of_rig(cameras, T_cb, 1, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA_ID);
  CHECK(maxlogdet_append_blocks_of_rig(cameras, T_cb, 257, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA_ID);
  CHECK(maxlogdet_append_blocks_of_rig(NULL, NULL, 0, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA_ID);
  const maxlogdet_block_status refused = MAXLOGDET_BLOCK_STATUS_INVALID_ARGUMENT;
  CHECK(maxlogdet_append_blocks_of_rig(NULL, T_cb, 2, identity_pose, &matches, &options, blocks, NULL)->status ==
        refused);
  CHECK(maxlogdet_append_blocks_of_rig(cameras, NULL, 2, identity_pose, &matches, &options, blocks, NULL)->status ==
        refused);
  CHECK(maxlogdet_append_blocks_of_rig(cameras, T_cb, 2, identity_pose, &matches, &options, NULL, NULL)->status ==
        refused);
  cameras[1] = NULL;
  CHECK(maxlogdet_append_blocks_of_rig(cameras, T_cb, 2, identity_pose, &matches, &options, blocks, NULL)->status ==
        refused);
  matches.camera_ids = NULL;
  matches.jacobians = NULL;
  fisheye.model = 1000;
  CHECK(maxlogdet_append_blocks(&fisheye, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_UNKNOWN_CAMERA_MODEL);
  matches.point_stride = 10;
  CHECK(maxlogdet_append_blocks(&pinhole, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_STRIDE);
  matches.point_type = 2;
  CHECK(maxlogdet_append_blocks(&pinhole, identity_pose, &matches, &options, blocks, NULL)->status == refused);
  CHECK(maxlogdet_block_store_size(blocks) == 15);
  maxlogdet_block_store_destroy(blocks);
}

static void blocks_are_made_of_matches(void) {
  const double points[12] = {0, 0, 5, 1, -1, 4, 2, 1, -3, 0.5, 1, 8};  // the third is behind the camera
  const uint8_t usable[4] = {1, 0, 1, 1};
  maxlogdet_camera camera;
  maxlogdet_matches matches;
  maxlogdet_block_options options;
  maxlogdet_camera_init(&camera, sizeof camera);
  maxlogdet_matches_init(&matches, sizeof matches);
  maxlogdet_block_options_init(&options, sizeof options);
  camera.fx = camera.fy = 450;
  matches.size = 4;
  matches.points = points;
  matches.usable = usable;
  maxlogdet_block_store* blocks = NULL;
  REQUIRE(maxlogdet_block_store_create(0, &blocks) == MAXLOGDET_STATUS_OK);
  const maxlogdet_block_report* report =
      maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->status == MAXLOGDET_BLOCK_STATUS_OK && report->appended == 4 && report->invalid == 2);
  CHECK(report->behind_camera == 1 && report->unusable == 1 && report->too_near == 0 && report->singular_rays == 0);
  CHECK(maxlogdet_block_store_size(blocks) == 4 && maxlogdet_block_store_rows(blocks) == 2);
  CHECK(maxlogdet_block_store_is_valid(blocks, 0) == 1 && maxlogdet_block_store_is_valid(blocks, 1) == 0);

  // Every pointer that may not be null, and every struct that is none.
  const maxlogdet_block_status refused = MAXLOGDET_BLOCK_STATUS_INVALID_ARGUMENT;
  CHECK(maxlogdet_append_blocks(NULL, identity_pose, &matches, &options, blocks, NULL)->status == refused);
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, NULL, &options, blocks, NULL)->status == refused);
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, NULL, blocks, NULL)->status == refused);
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, NULL, NULL)->status == refused);
  CHECK(maxlogdet_append_blocks(&camera, NULL, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_POSE);
  maxlogdet_executor executor;
  maxlogdet_executor_init(&executor, sizeof executor);
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, &executor)->status == refused);
  size_t* const sizes[] = {&camera.struct_size, &matches.struct_size, &options.struct_size};
  for (size_t i = 0; i < 3; ++i) {
    const size_t right = *sizes[i];
    const size_t wrong[] = {0, 8, 15, right - 1, right + 8, SIZE_MAX};
    for (size_t j = 0; j < sizeof wrong / sizeof *wrong; ++j) {
      *sizes[i] = wrong[j];
      report = maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL);
      CHECK(report->status == refused && report->appended == 0);
    }
    *sizes[i] = right;
  }
  options.reserved = 1;
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL)->status == refused);
  options.reserved = 0;

  // Weights of single matches: 1 and four numbers, or 0 and none.
  double weight[4] = {-7, -7, -7, -7};
  CHECK(maxlogdet_match_information(NULL, identity_pose, &matches, 0, &options, weight) == 0);
  CHECK(maxlogdet_match_information(&camera, NULL, &matches, 0, &options, weight) == 0);
  CHECK(maxlogdet_match_information(&camera, identity_pose, NULL, 0, &options, weight) == 0);
  CHECK(maxlogdet_match_information(&camera, identity_pose, &matches, 4, &options, weight) == 0);
  CHECK(maxlogdet_match_information(&camera, identity_pose, &matches, 0, NULL, weight) == 0);
  CHECK(maxlogdet_match_information(&camera, identity_pose, &matches, 0, &options, NULL) == 0);
  CHECK(maxlogdet_match_whitening(&camera, identity_pose, &matches, 4, &options, weight) == 0);
  matches.points = NULL;
  CHECK(maxlogdet_match_information(&camera, identity_pose, &matches, 0, &options, weight) == 0);
  matches.points = points;
  CHECK(weight[0] == -7);
  CHECK(maxlogdet_match_information(&camera, identity_pose, &matches, 0, &options, weight) == 1);
  CHECK(weight[0] == 1 && weight[1] == 0 && weight[2] == 0 && weight[3] == 1);
  CHECK(maxlogdet_match_whitening(&camera, identity_pose, &matches, 0, &options, weight) == 1);
  CHECK(weight[0] == 1 && weight[1] == 0 && weight[2] == 0 && weight[3] == 1);

  // What C++ refuses, by its name.
  matches.points = NULL;
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_MISSING_POINTS);
  matches.points = points;
  options.weighting = 77;
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_OPTIONS);
  options.weighting = MAXLOGDET_WEIGHTING_MEASUREMENT;
  options.third = MAXLOGDET_THIRD_MEASUREMENT_STEREO;
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_INVALID_CAMERA);
  options.third = MAXLOGDET_THIRD_MEASUREMENT_NONE;
  matches.size = SIZE_MAX;  // more than there can be, whatever is stored already
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_OUT_OF_MEMORY);
  matches.size = SIZE_MAX - 3;
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL)->status ==
        MAXLOGDET_BLOCK_STATUS_OUT_OF_MEMORY);
  CHECK(maxlogdet_block_store_size(blocks) == 4);

  // Older structs: a camera without its principal point, matches without the arrays after their points.
  camera.struct_size = offsetof(maxlogdet_camera, cx);
  matches.size = 4;
  matches.struct_size = offsetof(maxlogdet_matches, point_stride);
  options.struct_size = offsetof(maxlogdet_block_options, map_sigma);
  report = maxlogdet_append_blocks(&camera, identity_pose, &matches, &options, blocks, NULL);
  CHECK(report->status == MAXLOGDET_BLOCK_STATUS_OK && report->appended == 4 && report->invalid == 1);
  maxlogdet_block_store_destroy(blocks);
}

static void selections_answer_and_name_errors(void) {
  enum { n = 300 };
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_selector_create(n, NULL, &selector) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_selector_capacity(selector) == n);
  maxlogdet_options options = default_options();
  options.certify = 1;
  options.budget = 50;
  const maxlogdet_selection* answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_OK && answer->size == 50 && answer->threads == 1);
  CHECK(answer->strategy == MAXLOGDET_STRATEGY_LAZY_GREEDY && answer->invalid_candidates == 6);
  CHECK(answer->evaluations > n && answer->reserved == 0 && maxlogdet_selection_has_answer(answer) == 1);
  CHECK(answer->log_det <= answer->upper_bound);
  const double efficiency = maxlogdet_selection_efficiency(answer);
  CHECK(efficiency > 0.5 && efficiency <= 1);
  double sum = 6 * log(1e-5);
  for (size_t i = 0; i < 50; ++i) {
    sum += answer->gains[i];
    CHECK(answer->indices[i] < n && maxlogdet_block_store_is_valid(blocks, answer->indices[i]) == 1);
  }
  CHECK(fabs(sum - answer->log_det) < 1e-6);

  options.certify = 0;
  options.target_efficiency = 0.1;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_TARGET_REACHED && maxlogdet_selection_has_answer(answer) == 1);
  CHECK(answer->size > 0 && answer->size < 50 && answer->efficiency_of_all >= 0.1 - 1e-12);
  CHECK(isnan(answer->translation_sigma) && isnan(answer->rotation_sigma));
  options.target_efficiency = 1.5;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_INVALID_TARGET && maxlogdet_selection_has_answer(answer) == 0);
  options.target_efficiency = 0;
  options.target_translation_sigma = options.target_rotation_sigma = 100;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_TARGET_REACHED && answer->translation_sigma <= 100);
  CHECK(answer->rotation_sigma <= 100 && isnan(answer->efficiency_of_all));
  options.target_translation_sigma = options.target_rotation_sigma = 0;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(isnan(answer->upper_bound) && isnan(maxlogdet_selection_efficiency(answer)));
  options.budget = 295;
  options.strategy = MAXLOGDET_STRATEGY_AUTOMATIC;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_ALL_SELECTED && answer->size == 294);
  CHECK(answer->strategy == MAXLOGDET_STRATEGY_BACKWARD_GREEDY && maxlogdet_selection_has_answer(answer) == 1);

  options = default_options();
  options.time_limit = 1e-9;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_DEADLINE_REACHED && maxlogdet_selection_has_answer(answer) == 1);
  options.time_limit = (double)NAN;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_INVALID_TIME_LIMIT && maxlogdet_selection_has_answer(answer) == 0);
  CHECK(answer->size == 0 && isnan(answer->log_det));
  options = default_options();
  options.budget = n + 1;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->status == MAXLOGDET_STATUS_INVALID_BUDGET);
  options = default_options();
  options.strategy = 1000;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->status == MAXLOGDET_STATUS_INVALID_STRATEGY);
  options.strategy = MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY;
  options.epsilon = 1;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->status == MAXLOGDET_STATUS_INVALID_EPSILON);
  options = default_options();
  options.threads = -1;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->status == MAXLOGDET_STATUS_INVALID_THREADS);
  const double zeros[36] = {0};
  options = default_options();
  options.prior = zeros;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->status == MAXLOGDET_STATUS_INVALID_PRIOR);
  maxlogdet_selector_destroy(selector);

  REQUIRE(maxlogdet_selector_create(n - 1, NULL, &selector) == MAXLOGDET_STATUS_OK);
  options = default_options();
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->status == MAXLOGDET_STATUS_CAPACITY_EXCEEDED);
  maxlogdet_selector_destroy(selector);
  maxlogdet_block_store_destroy(blocks);
}

static void active_selection_proposes_and_takes_answers(void) {
  enum { n = 100 };
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_active_selection* active = NULL;
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_active_selection_create(n, &active) == MAXLOGDET_STATUS_OK);
  REQUIRE(maxlogdet_selector_create(n, NULL, &selector) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_capacity(active) == n);
  CHECK(maxlogdet_active_selection_next(active) == MAXLOGDET_NONE);
  CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_selection(active)->status == MAXLOGDET_STATUS_NOTHING_PROPOSED);

  maxlogdet_options options = default_options();
  options.budget = 30;
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_STATUS_OK);
  size_t accepted = 0;
  while (maxlogdet_active_selection_next(active) != MAXLOGDET_NONE) {
    CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_STATUS_OK);
    CHECK(maxlogdet_active_selection_selection(active)->size == ++accepted);
  }
  CHECK(accepted == 30);
  CHECK(
      same_answer(maxlogdet_active_selection_selection(active), maxlogdet_selector_select(selector, blocks, &options)));

  const double block[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const double not_finite[6] = {1, 2, 3, 4, 5, (double)INFINITY};
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_STATUS_OK);
  const uint32_t first = maxlogdet_active_selection_next(active);
  CHECK(maxlogdet_active_selection_accept_block(active, NULL, 2) == MAXLOGDET_STATUS_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 0) == MAXLOGDET_STATUS_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 4) == MAXLOGDET_STATUS_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block(active, not_finite, 1) == MAXLOGDET_STATUS_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_next(active) == first);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 2) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 2) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  const uint32_t second = maxlogdet_active_selection_next(active);
  CHECK(second != first && second < n);
  CHECK(maxlogdet_active_selection_reject(active) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_reject(active) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_next(active) != second);
  const maxlogdet_selection* const selection = maxlogdet_active_selection_selection(active);
  CHECK(selection->size == 1 && selection->indices[0] == first && selection->status == MAXLOGDET_STATUS_OK);

  options.strategy = MAXLOGDET_STRATEGY_RELAXED;
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_STATUS_INVALID_STRATEGY);
  maxlogdet_active_selection_destroy(active);
  maxlogdet_selector_destroy(selector);
  maxlogdet_block_store_destroy(blocks);
}

static void active_selection_proposes_batches(void) {
  enum { n = 100 };
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_active_selection* active = NULL;
  REQUIRE(maxlogdet_active_selection_create(n, &active) == MAXLOGDET_STATUS_OK);
  maxlogdet_options options = default_options();
  options.budget = 10;
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_STATUS_OK);

  const double block[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  uint32_t batch[n];
  uint32_t again[n];
  CHECK(maxlogdet_active_selection_next_batch(active, NULL, 5) == 0);
  CHECK(maxlogdet_active_selection_next_batch(active, batch, 0) == 0);
  REQUIRE(maxlogdet_active_selection_next_batch(active, batch, 6) == 6);
  CHECK(maxlogdet_active_selection_next_batch(active, again, n) == 6 && memcmp(again, batch, 6 * sizeof *batch) == 0);
  CHECK(maxlogdet_active_selection_next(active) == batch[0]);
  CHECK(maxlogdet_active_selection_accept_index(active, batch[4]) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_accept_index(active, batch[4]) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_reject_index(active, batch[0]) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_reject_index(active, n) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_accept_block_index(active, batch[2], NULL, 2) == MAXLOGDET_STATUS_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block_index(active, batch[2], block, 2) == MAXLOGDET_STATUS_OK);
  const uint8_t matched[3] = {0, 1, 1};  // of 1, 3, 5
  CHECK(maxlogdet_active_selection_answer(active, matched, 2) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_answer(active, NULL, 3) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_answer(active, matched, 3) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_answer(active, matched, 3) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
  const maxlogdet_selection* const selection = maxlogdet_active_selection_selection(active);
  CHECK(selection->size == 4 && selection->indices[0] == batch[4] && selection->indices[1] == batch[2]);
  CHECK(selection->indices[2] == batch[3] && selection->indices[3] == batch[5]);
  CHECK(maxlogdet_active_selection_next_batch(active, batch, n) == 6);  // what the budget leaves
  maxlogdet_active_selection_destroy(active);
  maxlogdet_block_store_destroy(blocks);
}

// The candidates of the start before may be gone: nothing may look at them any more.
static void a_start_that_is_refused_ends_what_was_under_way(void) {
  maxlogdet_block_store* blocks = random_blocks(20);
  maxlogdet_active_selection* active = NULL;
  REQUIRE(maxlogdet_active_selection_create(20, &active) == MAXLOGDET_STATUS_OK);
  maxlogdet_options options = default_options();
  options.budget = 10;
  maxlogdet_options broken = options;
  broken.struct_size = 3;
  for (int way = 0; way < 3; ++way) {
    CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_STATUS_OK);
    const uint8_t matched[1] = {1};
    uint32_t index = MAXLOGDET_NONE;
    CHECK(maxlogdet_active_selection_next_batch(active, &index, 1) == 1 && index < 20);
    const maxlogdet_status status = maxlogdet_active_selection_start(active, way == 0 ? NULL : blocks,
                                                                     way == 1   ? NULL
                                                                     : way == 2 ? &broken
                                                                                : &options);
    CHECK(status == MAXLOGDET_STATUS_INVALID_ARGUMENT);
    maxlogdet_block_store_destroy(blocks);
    CHECK(maxlogdet_active_selection_next(active) == MAXLOGDET_NONE);
    CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_accept_block(active, NULL, 1) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_reject(active) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_next_batch(active, &index, 1) == 0);
    CHECK(maxlogdet_active_selection_accept_index(active, index) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_accept_block_index(active, index, NULL, 1) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_reject_index(active, index) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_answer(active, matched, 1) == MAXLOGDET_STATUS_NOTHING_PROPOSED);
    CHECK(maxlogdet_active_selection_selection(active)->status == MAXLOGDET_STATUS_INVALID_ARGUMENT);
    CHECK(maxlogdet_active_selection_selection(active)->size == 0);
    blocks = random_blocks(20);
  }
  maxlogdet_active_selection_destroy(active);
  maxlogdet_block_store_destroy(blocks);
}

int main(void) {
  names_of_all_enumerators_and_of_no_other_value();
  the_library_tells_what_it_is();
  the_layout_of_structs_is_that_of_the_first_version();
  init_sets_the_defaults();
  init_takes_older_sizes_and_marks_what_it_refuses();
  select_takes_older_options_and_refuses_sizes_that_are_none();
  a_store_counts_what_it_holds();
  what_cannot_be_created_is_told_and_null();
  null_is_refused_everywhere();
  blocks_are_made_of_matches();
  blocks_are_made_for_any_camera();
  selections_answer_and_name_errors();
  active_selection_proposes_and_takes_answers();
  active_selection_proposes_batches();
  a_start_that_is_refused_ends_what_was_under_way();
  return report();
}
