// SPDX-License-Identifier: MIT
// Structs: their defaults, and declarations of them that end earlier.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

#include <float.h>

static void check_defaults_of_options(void) {
  maxlogdet_options options;
  memset(&options, 0xA5, sizeof options);
  CHECK(maxlogdet_options_init(&options, sizeof options) == MAXLOGDET_ERROR_NONE);
  CHECK(options.struct_size == sizeof options && options.budget == 200 && options.prior == NULL);
  CHECK(options.time_limit == 0 && options.strategy == MAXLOGDET_STRATEGY_LAZY_GREEDY && options.threads == 0);
  CHECK(options.required == NULL && options.excluded == NULL && options.target_efficiency == 0);
  CHECK(options.target_translation_sigma == 0 && options.target_rotation_sigma == 0);
  CHECK(options.group_ids == NULL && options.group_count == 0 && options.group_maximum == 1);
  CHECK(options.group_maxima == NULL && options.certificate_compute == 0 && options.reserved == 0);
  CHECK(options.certificate_passes == 0 && options.stochastic_epsilon == 0.1 && options.stochastic_seed == 0);
  CHECK(options.exchange_sweeps == 0);
}

static void check_defaults_of_block_options(void) {
  maxlogdet_block_options block_options;
  memset(&block_options, 0xA5, sizeof block_options);
  CHECK(maxlogdet_block_options_init(&block_options, sizeof block_options) == MAXLOGDET_ERROR_NONE);
  CHECK(block_options.struct_size == sizeof block_options);
  CHECK(block_options.weighting == MAXLOGDET_WEIGHTING_MEASUREMENT);
  CHECK(block_options.depth_cue == MAXLOGDET_DEPTH_CUE_NONE && block_options.threads == 0);
  CHECK(block_options.min_depth == 0.01);
  CHECK(block_options.map_sigma == 0.05 && block_options.depth_sigma == 0.05 && block_options.reserved == 0);
}

static void check_defaults_of_camera(void) {
  maxlogdet_camera camera;
  memset(&camera, 0xA5, sizeof camera);
  CHECK(maxlogdet_camera_init(&camera, sizeof camera) == MAXLOGDET_ERROR_NONE);
  CHECK(camera.struct_size == sizeof camera);
  CHECK(camera.fx == 0 && camera.fy == 0 && camera.cx == 0 && camera.cy == 0 && camera.bf == 0);
  CHECK(camera.model == MAXLOGDET_CAMERA_MODEL_PINHOLE && camera.reserved == 0);
  for (int i = 0; i < 5; ++i) CHECK(camera.parameters[i] == 0);
}

static void check_defaults_of_matches(void) {
  maxlogdet_matches matches;
  memset(&matches, 0xA5, sizeof matches);
  CHECK(maxlogdet_matches_init(&matches, sizeof matches) == MAXLOGDET_ERROR_NONE);
  CHECK(matches.struct_size == sizeof matches && matches.size == 0 && matches.points == NULL);
  CHECK(matches.sigmas == NULL && matches.has_depth_cue == NULL && matches.usable == NULL && matches.weights == NULL);
  CHECK(matches.map_covariances == NULL && matches.jacobians == NULL && matches.camera_ids == NULL);
  CHECK(matches.point_stride == 0 && matches.point_type == MAXLOGDET_POINT_TYPE_FLOAT64 && matches.reserved == 0);
}

static void check_defaults_of_match(void) {
  maxlogdet_match match;
  memset(&match, 0xA5, sizeof match);
  CHECK(maxlogdet_match_init(&match, sizeof match) == MAXLOGDET_ERROR_NONE);
  CHECK(match.struct_size == sizeof match && match.point[0] == 0 && match.point[1] == 0 && match.point[2] == 0);
  CHECK(match.measured[0] == MAXLOGDET_UNMEASURED && match.measured[1] == MAXLOGDET_UNMEASURED);
  CHECK(match.u_right == MAXLOGDET_UNMEASURED && match.depth == MAXLOGDET_UNMEASURED && match.sigma == 1);
  CHECK(MAXLOGDET_UNMEASURED == -DBL_MAX);
  CHECK(match.covariance == NULL && match.jacobian == NULL && match.id == 0 && match.camera_id == 0);
  CHECK(match.is_required == 0 && match.reserved == 0 && match.point_id == -1 && match.keyframe == -1);
}

static void check_defaults_of_executor(void) {
  maxlogdet_executor executor;
  memset(&executor, 0xA5, sizeof executor);
  CHECK(maxlogdet_executor_init(&executor, sizeof executor) == MAXLOGDET_ERROR_NONE);
  CHECK(executor.struct_size == sizeof executor && executor.user_data == NULL);
  CHECK(executor.concurrency == NULL && executor.run == NULL);
}

void init_sets_the_defaults(void) {
  check_defaults_of_options();
  check_defaults_of_block_options();
  check_defaults_of_camera();
  check_defaults_of_matches();
  check_defaults_of_match();
  check_defaults_of_executor();
}

// One struct's init, called as if for that type.
typedef maxlogdet_error (*init_function)(void* given, size_t struct_size);
static maxlogdet_error init_options(void* s, size_t size) { return maxlogdet_options_init(s, size); }
static maxlogdet_error init_block_options(void* s, size_t size) { return maxlogdet_block_options_init(s, size); }
static maxlogdet_error init_camera(void* s, size_t size) { return maxlogdet_camera_init(s, size); }
static maxlogdet_error init_matches(void* s, size_t size) { return maxlogdet_matches_init(s, size); }
static maxlogdet_error init_match(void* s, size_t size) { return maxlogdet_match_init(s, size); }
static maxlogdet_error init_executor(void* s, size_t size) { return maxlogdet_executor_init(s, size); }

// Memory of exactly `size` bytes, so that a sanitizer sees accesses beyond.
static void* exactly(size_t size, const void* content) {
  void* const memory = malloc(size);
  REQUIRE(memory != NULL);
  if (content != NULL) memcpy(memory, content, size);
  return memory;
}

void init_takes_older_sizes_and_marks_what_it_refuses(void) {
  static const init_function inits[] = {init_options, init_block_options, init_camera,
                                        init_matches, init_match,         init_executor};
  static const size_t sizes[] = {sizeof(maxlogdet_options), sizeof(maxlogdet_block_options),
                                 sizeof(maxlogdet_camera),  sizeof(maxlogdet_matches),
                                 sizeof(maxlogdet_match),   sizeof(maxlogdet_executor)};
  for (size_t kind = 0; kind < sizeof sizes / sizeof *sizes; ++kind) {
    CHECK(inits[kind](NULL, sizes[kind]) == MAXLOGDET_ERROR_INVALID_ARGUMENT);
    unsigned char full[256];
    CHECK(inits[kind](full, sizes[kind]) == MAXLOGDET_ERROR_NONE);
    for (size_t size = 1; size <= sizes[kind] + 16; ++size) {
      unsigned char* const given = exactly(size, NULL);
      memset(given, 0xA5, size);
      const int is_known = size >= 16 && size % 8 == 0 && size <= sizes[kind];
      CHECK(inits[kind](given, size) == (is_known ? MAXLOGDET_ERROR_NONE : MAXLOGDET_ERROR_INVALID_ARGUMENT));
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
    CHECK(inits[kind](untouched, 0) == MAXLOGDET_ERROR_INVALID_ARGUMENT);
    CHECK(untouched[0] == 1 && untouched[7] == 8);
  }
}

enum { n = 200 };

// Every field other than its default.
static maxlogdet_options unusual_options(void) {
  static uint8_t required[n], excluded[n];
  static uint32_t groups[n], maxima[4] = {30, 30, 30, 30};
  static double prior[36];
  required[3] = excluded[4] = 1;
  for (uint32_t i = 0; i < n; ++i) groups[i] = i % 4;
  for (size_t i = 0; i < 6; ++i) prior[7 * i] = 2;
  maxlogdet_options all = default_options();
  all.budget = 40;
  all.prior = prior;
  all.time_limit = 1000;
  all.strategy = MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY;
  all.threads = 1;
  all.required = required;
  all.excluded = excluded;
  all.target_efficiency = all.target_translation_sigma = all.target_rotation_sigma = 0.5;
  all.group_ids = groups;
  all.group_count = 4;
  all.group_maximum = 30;
  all.group_maxima = maxima;
  all.certificate_compute = 1;
  all.certificate_passes = 2;
  all.stochastic_epsilon = 0.3;
  all.stochastic_seed = 7;
  all.exchange_sweeps = 1;
  return all;
}

// What an answer to these options has to be if the caller's declaration of them ends after `size` bytes.
static maxlogdet_error error_of_older(size_t size) {
  if (size == offsetof(maxlogdet_options, group_count)) return MAXLOGDET_ERROR_INVALID_GROUPS;
  return size > offsetof(maxlogdet_options, exchange_sweeps) ? MAXLOGDET_ERROR_UNSUPPORTED_TARGET
                                                             : MAXLOGDET_ERROR_NONE;
}
static maxlogdet_status status_of_older(size_t size) {
  if (error_of_older(size) != MAXLOGDET_ERROR_NONE) return MAXLOGDET_STATUS_ERROR;
  const int is_one_of_each = size == offsetof(maxlogdet_options, group_maximum);
  return is_one_of_each ? MAXLOGDET_STATUS_ALL_SELECTED : MAXLOGDET_STATUS_OK;
}

static void check_size(maxlogdet_selector* const selectors[2], const maxlogdet_block_store* blocks,
                       const maxlogdet_options* all, size_t size) {
  unsigned char content[sizeof *all + 8] = {0};
  memcpy(content, all, sizeof *all);
  memcpy(content, &size, sizeof size);
  maxlogdet_options* const given = exactly(size, content);
  const maxlogdet_selection* const answer = maxlogdet_selector_select(selectors[0], blocks, given);
  if (size < 16 || size % 8 != 0 || size > sizeof *all) {
    CHECK(answer->error == MAXLOGDET_ERROR_INVALID_ARGUMENT && answer->size == 0);
  } else {
    maxlogdet_options expected = default_options();
    memcpy((unsigned char*)&expected + 8, content + 8, size - 8);
    CHECK(same_answer(answer, maxlogdet_selector_select(selectors[1], blocks, &expected)));
    CHECK(answer->status == status_of_older(size) && answer->error == error_of_older(size));
  }
  free(given);
}

void select_takes_older_options_and_refuses_sizes_that_are_none(void) {
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_selector* selectors[2] = {NULL, NULL};
  for (int i = 0; i < 2; ++i) REQUIRE(maxlogdet_selector_create(n, NULL, &selectors[i]) == MAXLOGDET_ERROR_NONE);
  maxlogdet_options all = unusual_options();
  for (size_t size = 8; size <= sizeof all + 8; ++size) check_size(selectors, blocks, &all, size);
  all.struct_size = SIZE_MAX;
  CHECK(maxlogdet_selector_select(selectors[0], blocks, &all)->error == MAXLOGDET_ERROR_INVALID_ARGUMENT);
  all.struct_size = (size_t)0xA5A5A5A5A5A5A5A8;
  CHECK(maxlogdet_selector_select(selectors[0], blocks, &all)->error == MAXLOGDET_ERROR_INVALID_ARGUMENT);
  all = default_options();
  all.reserved = 1;
  CHECK(maxlogdet_selector_select(selectors[0], blocks, &all)->error == MAXLOGDET_ERROR_INVALID_ARGUMENT);
  for (int i = 0; i < 2; ++i) maxlogdet_selector_destroy(selectors[i]);
  maxlogdet_block_store_destroy(blocks);
}
