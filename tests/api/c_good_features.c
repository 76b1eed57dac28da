// SPDX-License-Identifier: MIT
// The front door: a frame is selected from and judged, and whatever is refused, there is something to optimise with.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

enum { n = 200, budget = 40 };

static const maxlogdet_error refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;

static maxlogdet_good_features* new_good_features(size_t capacity) {
  maxlogdet_good_features* good = NULL;
  REQUIRE(maxlogdet_good_features_create(capacity, NULL, &good) == MAXLOGDET_ERROR_NONE);
  return good;
}

static maxlogdet_camera usual_camera(void) {
  maxlogdet_camera camera;
  REQUIRE(maxlogdet_camera_init(&camera, sizeof camera) == MAXLOGDET_ERROR_NONE);
  camera.fx = camera.fy = 450;
  camera.cx = 320;
  camera.cy = 240;
  return camera;
}

// Seen from the identity pose without noise, by a camera as usual.
static maxlogdet_match random_match(uint32_t id) {
  maxlogdet_match match;
  REQUIRE(maxlogdet_match_init(&match, sizeof match) == MAXLOGDET_ERROR_NONE);
  match.id = id;
  match.point[0] = 2 * random_entry();
  match.point[1] = 2 * random_entry();
  match.point[2] = 5 + 2 * random_entry();
  match.measured[0] = 320 + 450 * match.point[0] / match.point[2];
  match.measured[1] = 240 + 450 * match.point[1] / match.point[2];
  return match;
}

// A frame of n matches.
static void add_frame(maxlogdet_good_features* good) {
  const maxlogdet_camera camera = usual_camera();
  CHECK(maxlogdet_good_features_start(good, &camera, identity_pose) == MAXLOGDET_ERROR_NONE);
  for (uint32_t i = 0; i < n; ++i) {
    const maxlogdet_match match = random_match(1000 + i);
    CHECK(maxlogdet_good_features_add(good, &match) == MAXLOGDET_ERROR_NONE);
  }
}

static maxlogdet_options with_budget(size_t size) {
  maxlogdet_options options = default_options();
  options.budget = size;
  return options;
}

// That all matches are selected, in their order, for this reason.
static void check_all(const maxlogdet_good_features* good, size_t size, maxlogdet_error error) {
  const maxlogdet_selection* const selection = maxlogdet_good_features_selection(good);
  CHECK(selection->status == MAXLOGDET_STATUS_ERROR && selection->error == error && selection->size == size);
  CHECK(strcmp(maxlogdet_good_features_reason(good), maxlogdet_error_name(error)) == 0);
  for (size_t j = 0; j < selection->size; ++j) {
    CHECK(selection->indices[j] == j && maxlogdet_good_features_is_selected(good, j) == 1);
  }
}

void a_frame_is_selected_from_and_judged(void) {
  maxlogdet_good_features* const good = new_good_features(n);
  CHECK(maxlogdet_good_features_size(good) == 0 && maxlogdet_good_features_selection(good)->size == 0);
  add_frame(good);
  CHECK(maxlogdet_good_features_size(good) == n && maxlogdet_good_features_id(good, 3) == 1003);
  const maxlogdet_options options = with_budget(budget);
  const maxlogdet_selection* const selection = maxlogdet_good_features_select(good, &options);
  CHECK(selection == maxlogdet_good_features_selection(good) && selection->status == MAXLOGDET_STATUS_OK);
  CHECK(selection->error == MAXLOGDET_ERROR_NONE && selection->size == budget && selection->searched == budget);
  CHECK(strcmp(maxlogdet_good_features_reason(good), "ok") == 0);
  size_t selected = 0;
  for (size_t i = 0; i < n + 1; ++i) selected += maxlogdet_good_features_is_selected(good, i) == 1 ? 1 : 0;
  CHECK(selected == budget);
  CHECK(maxlogdet_good_features_is_selected(good, selection->indices[budget - 1]) == 1);
  CHECK(maxlogdet_good_features_block_report(good)->appended == n);
  const double efficiency = maxlogdet_good_features_efficiency(good);
  CHECK(efficiency > 0.1 && efficiency < 1);

  const uint32_t* outliers = NULL;
  CHECK(maxlogdet_good_features_outliers(good, identity_pose, &outliers) == 0);
  double moved[12];
  memcpy(moved, identity_pose, sizeof moved);
  moved[3] = 0.5;  // m: 50 px and more
  CHECK(maxlogdet_good_features_outliers(good, moved, &outliers) == n - budget);
  for (size_t j = 0; j < n - budget; ++j) {
    CHECK(maxlogdet_good_features_is_selected(good, outliers[j]) == 0);
    CHECK(maxlogdet_good_features_is_outlier(good, outliers[j]) == 1);
    CHECK(maxlogdet_good_features_chi2(good, outliers[j]) > 5.991);
  }
  CHECK(isnan(maxlogdet_good_features_chi2(good, selection->indices[0])));

  double omega[4] = {0}, W[4] = {0};
  CHECK(maxlogdet_good_features_information(good, 0, omega) == 1 && omega[0] == 1 && omega[1] == 0);
  CHECK(maxlogdet_good_features_whitening(good, 0, W) == 1 && W[0] == 1 && W[2] == 0);
  CHECK(maxlogdet_good_features_information(good, n, omega) == 0);
  maxlogdet_good_features_destroy(good);
}

// Every field after its end is the default.
static void check_older_matches(maxlogdet_good_features* good) {
  maxlogdet_match match = random_match(7);
  const maxlogdet_camera camera = usual_camera();
  maxlogdet_good_features_start(good, &camera, identity_pose);
  size_t refusals = 0;
  for (size_t size = 8; size <= sizeof match + 8; ++size) {
    unsigned char* const given = malloc(size);
    REQUIRE(given != NULL);
    memset(given, 0, size);
    memcpy(given, &match, size < sizeof match ? size : sizeof match);
    memcpy(given, &size, sizeof size);
    const maxlogdet_error error = maxlogdet_good_features_add(good, (const maxlogdet_match*)(const void*)given);
    const int is_known = size >= 16 && size % 8 == 0 && size <= sizeof match;
    CHECK(error == (is_known ? MAXLOGDET_ERROR_NONE : refused));
    const size_t i = maxlogdet_good_features_size(good) - 1;
    CHECK(maxlogdet_good_features_id(good, i) == (is_known && size > offsetof(maxlogdet_match, id) ? 7U : 0U));
    refusals += is_known ? 0 : 1;
    free(given);
  }
  match.reserved = 1;
  CHECK(maxlogdet_good_features_add(good, &match) == refused);
  CHECK(maxlogdet_good_features_add(good, NULL) == refused);
  const maxlogdet_options options = with_budget(n);
  const maxlogdet_selection* const selection = maxlogdet_good_features_select(good, &options);
  CHECK(selection->size == maxlogdet_good_features_size(good) - refusals - 2);
  CHECK(maxlogdet_good_features_is_selected(good, maxlogdet_good_features_size(good) - 1) == 0);
}

static void check_refused_options(maxlogdet_good_features* good) {
  add_frame(good);
  maxlogdet_good_features_select(good, NULL);
  check_all(good, n, refused);
  maxlogdet_options options = with_budget(budget);
  options.reserved = 1;
  maxlogdet_good_features_select(good, &options);
  check_all(good, n, refused);
  options = with_budget(budget);
  options.strategy = 1000;
  maxlogdet_good_features_select(good, &options);
  check_all(good, n, MAXLOGDET_ERROR_INVALID_STRATEGY);
  CHECK(isnan(maxlogdet_good_features_efficiency(good)));
  options = with_budget(budget);
  CHECK(maxlogdet_good_features_set_spread(good, -1) == MAXLOGDET_ERROR_NONE);
  maxlogdet_good_features_select(good, &options);
  check_all(good, n, MAXLOGDET_ERROR_INVALID_GROUPS);
  CHECK(maxlogdet_good_features_set_spread(good, 0) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_good_features_select(good, &options)->status == MAXLOGDET_STATUS_OK);
  maxlogdet_block_options block_options;
  CHECK(maxlogdet_block_options_init(&block_options, sizeof block_options) == MAXLOGDET_ERROR_NONE);
  block_options.min_depth = 100;
  CHECK(maxlogdet_good_features_set_block_options(good, NULL) == refused);
  CHECK(maxlogdet_good_features_select(good, &options)->status == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_good_features_set_block_options(good, &block_options) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_good_features_select(good, &options)->status == MAXLOGDET_STATUS_FEW_CANDIDATES);
  CHECK(maxlogdet_good_features_block_report(good)->too_near == n);
  block_options.min_depth = 0.01;
  CHECK(maxlogdet_good_features_set_block_options(good, &block_options) == MAXLOGDET_ERROR_NONE);
}

// After this start, with one match: it is selected for that reason.
static void check_start(maxlogdet_good_features* good, maxlogdet_error of_start, maxlogdet_error returned,
                        maxlogdet_error of_select) {
  CHECK(returned == of_start);
  const maxlogdet_match match = random_match(1);
  CHECK(maxlogdet_good_features_add(good, &match) == MAXLOGDET_ERROR_NONE);
  const maxlogdet_options options = with_budget(budget);
  maxlogdet_good_features_select(good, &options);
  check_all(good, 1, of_select);
}

static void check_refused_starts(maxlogdet_good_features* good) {
  const maxlogdet_camera right = usual_camera();
  maxlogdet_camera wrong = right;
  wrong.reserved = 1;
  const maxlogdet_camera* cameras[2] = {&right, &wrong};
  const maxlogdet_error none = MAXLOGDET_ERROR_NONE;
  const double zeros[12] = {0};
  double T_cb[24];
  for (size_t i = 0; i < 24; ++i) T_cb[i] = identity_pose[i % 12];
  check_start(good, refused, maxlogdet_good_features_start(good, NULL, identity_pose), refused);
  check_start(good, refused, maxlogdet_good_features_start(good, &wrong, identity_pose), refused);
  check_start(good, refused, maxlogdet_good_features_start(good, &right, NULL), refused);
  check_start(good, none, maxlogdet_good_features_start(good, &right, zeros), MAXLOGDET_ERROR_INVALID_POSE);
  check_start(good, refused, maxlogdet_good_features_start_rig(good, cameras, T_cb, 2, identity_pose), refused);
  check_start(good, refused, maxlogdet_good_features_start_rig(good, NULL, T_cb, 1, identity_pose), refused);
  check_start(good, refused, maxlogdet_good_features_start_rig(good, cameras, NULL, 1, identity_pose), refused);
  check_start(good, refused, maxlogdet_good_features_start_rig(good, cameras, T_cb, 1, NULL), refused);
  check_start(good, none, maxlogdet_good_features_start_rig(good, NULL, NULL, 0, identity_pose),
              MAXLOGDET_ERROR_INVALID_CAMERA_ID);
  check_start(good, none, maxlogdet_good_features_start_rig(good, cameras, T_cb, 257, identity_pose),
              MAXLOGDET_ERROR_INVALID_CAMERA_ID);
  wrong = right;
  CHECK(maxlogdet_good_features_start_rig(good, cameras, T_cb, 2, identity_pose) == none);
  maxlogdet_match match = random_match(1);
  match.camera_id = 1;
  CHECK(maxlogdet_good_features_add(good, &match) == none);
  const maxlogdet_options options = with_budget(budget);
  CHECK(maxlogdet_good_features_select(good, &options)->status == MAXLOGDET_STATUS_ALL_SELECTED);
}

void whatever_is_refused_all_usable_matches_are_selected(void) {
  maxlogdet_good_features* const good = new_good_features(n);
  check_older_matches(good);
  check_refused_options(good);
  check_refused_starts(good);
  add_frame(good);  // a right start makes up for it
  const maxlogdet_match match = random_match(1);
  CHECK(maxlogdet_good_features_add(good, &match) == MAXLOGDET_ERROR_CAPACITY_EXCEEDED);
  CHECK(maxlogdet_good_features_size(good) == n + 1 && maxlogdet_good_features_id(good, n) == MAXLOGDET_NONE);
  const maxlogdet_options options = with_budget(budget);
  CHECK(maxlogdet_good_features_select(good, &options)->status == MAXLOGDET_STATUS_OK);
  CHECK(strcmp(maxlogdet_good_features_reason(good), "capacity_exceeded") == 0);
  maxlogdet_good_features_destroy(good);
}

// Finds every second match.
static int32_t find_even(void* context, size_t i, maxlogdet_match* match) {
  size_t* const calls = context;
  ++*calls;
  CHECK(match->struct_size == sizeof *match && match->id == 1000 + i);
  match->measured[0] += 1;
  return i % 2 == 0;
}

// Finds them, but spoils the struct.
static int32_t find_spoilt(void* context, size_t i, maxlogdet_match* match) {
  (void)context;
  (void)i;
  match->struct_size = 3;
  return 1;
}

void active_matching_selects_what_is_found(void) {
  maxlogdet_good_features* const good = new_good_features(n);
  add_frame(good);
  const maxlogdet_options options = with_budget(budget);
  size_t calls = 0;
  const maxlogdet_selection* selection = maxlogdet_good_features_match(good, &options, find_even, &calls);
  CHECK(selection == maxlogdet_good_features_selection(good) && selection->size == budget && calls > budget);
  for (size_t j = 0; j < selection->size; ++j) CHECK(selection->indices[j] % 2 == 0);
  const uint32_t* outliers = NULL;
  CHECK(maxlogdet_good_features_outliers(good, identity_pose, &outliers) == 0);

  add_frame(good);
  CHECK(maxlogdet_good_features_match(good, &options, find_spoilt, NULL)->size == 0);
  add_frame(good);
  calls = 0;
  selection = maxlogdet_good_features_match(good, NULL, find_even, &calls);  // in their order
  CHECK(selection->status == MAXLOGDET_STATUS_ERROR && selection->error == refused && selection->size == n / 2);
  CHECK(calls == n && selection->indices[1] == 2);
  add_frame(good);
  CHECK(maxlogdet_good_features_match(good, &options, NULL, NULL)->error == refused);
  CHECK(maxlogdet_good_features_select(good, &options)->status == MAXLOGDET_STATUS_OK);
  maxlogdet_good_features_destroy(good);
}

static void check_no_handle(void) {
  const maxlogdet_camera camera = usual_camera();
  const maxlogdet_camera* const cameras[1] = {&camera};
  const maxlogdet_options options = default_options();
  const maxlogdet_match match = random_match(1);
  maxlogdet_block_options block_options;
  maxlogdet_block_options_init(&block_options, sizeof block_options);
  size_t calls = 0;
  maxlogdet_good_features_destroy(NULL);
  CHECK(maxlogdet_good_features_create(1, NULL, NULL) == refused);
  CHECK(maxlogdet_good_features_set_block_options(NULL, &block_options) == refused);
  CHECK(maxlogdet_good_features_set_spread(NULL, 1) == refused);
  CHECK(maxlogdet_good_features_set_weighted(NULL, 1) == refused);
  CHECK(maxlogdet_good_features_start(NULL, &camera, identity_pose) == refused);
  CHECK(maxlogdet_good_features_start_rig(NULL, cameras, identity_pose, 1, identity_pose) == refused);
  CHECK(maxlogdet_good_features_add(NULL, &match) == refused);
  CHECK(maxlogdet_good_features_size(NULL) == 0 && maxlogdet_good_features_id(NULL, 0) == MAXLOGDET_NONE);
  const maxlogdet_selection* const answers[3] = {maxlogdet_good_features_select(NULL, &options),
                                                 maxlogdet_good_features_match(NULL, &options, find_even, &calls),
                                                 maxlogdet_good_features_selection(NULL)};
  for (size_t i = 0; i < 3; ++i) CHECK(answers[i]->error == refused && answers[i]->size == 0);
  CHECK(calls == 0 && strcmp(maxlogdet_good_features_reason(NULL), "invalid_argument") == 0);
  CHECK(maxlogdet_good_features_is_selected(NULL, 0) == 0 && maxlogdet_good_features_is_outlier(NULL, 0) == 0);
  CHECK(maxlogdet_good_features_block_report(NULL)->error == refused);
  CHECK(isnan(maxlogdet_good_features_efficiency(NULL)) && isnan(maxlogdet_good_features_chi2(NULL, 0)));
  double entries[9];
  CHECK(maxlogdet_good_features_information(NULL, 0, entries) == 0);
  CHECK(maxlogdet_good_features_whitening(NULL, 0, entries) == 0);
  CHECK(maxlogdet_good_features_record(NULL, "folder") == 0);
  const uint32_t* outliers = answers[0]->indices;
  CHECK(maxlogdet_good_features_outliers(NULL, identity_pose, &outliers) == 0 && outliers == NULL);
}

void no_good_features_are_refused(void) {
  check_no_handle();
  int something = 0;  // what may not stay in the pointer
  maxlogdet_good_features* good = (maxlogdet_good_features*)&something;
  CHECK(maxlogdet_good_features_create(SIZE_MAX, NULL, &good) == MAXLOGDET_ERROR_OUT_OF_MEMORY && good == NULL);
  maxlogdet_executor executor;
  maxlogdet_executor_init(&executor, sizeof executor);
  good = (maxlogdet_good_features*)&something;
  CHECK(maxlogdet_good_features_create(1, &executor, &good) == refused && good == NULL);  // it has no functions

  good = new_good_features(n);
  add_frame(good);
  const uint32_t* outliers = NULL;
  CHECK(maxlogdet_good_features_outliers(good, NULL, &outliers) == 0 && outliers == NULL);
  CHECK(maxlogdet_good_features_outliers(good, identity_pose, NULL) == 0);
  CHECK(maxlogdet_good_features_information(good, 0, NULL) == 0);
  CHECK(maxlogdet_good_features_whitening(good, 0, NULL) == 0);
  CHECK(maxlogdet_good_features_record(good, NULL) == 0 && maxlogdet_good_features_record(good, "") == 0);
  maxlogdet_good_features_destroy(good);
}
