// SPDX-License-Identifier: MIT
// Blocks and weights of matches: what is made of them, and what is refused.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

static const maxlogdet_error refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;

// What a caller gives, and where blocks go.
typedef struct given {
  maxlogdet_camera camera;
  maxlogdet_matches matches;
  maxlogdet_block_options options;
  maxlogdet_block_store* blocks;
} given;

static given given_matches(size_t size, const void* points) {
  given it;
  maxlogdet_camera_init(&it.camera, sizeof it.camera);
  maxlogdet_matches_init(&it.matches, sizeof it.matches);
  maxlogdet_block_options_init(&it.options, sizeof it.options);
  it.matches.size = size;
  it.matches.points = points;
  it.blocks = NULL;
  REQUIRE(maxlogdet_block_store_create(0, &it.blocks) == MAXLOGDET_ERROR_NONE);
  return it;
}

static const maxlogdet_block_report* append(const given* it) {
  return maxlogdet_append_blocks(&it->camera, identity_pose, &it->matches, &it->options, it->blocks, NULL);
}

// Every pointer that may not be null, and every invalid struct.
static void check_refused_blocks(given* it) {
  CHECK(maxlogdet_append_blocks(NULL, identity_pose, &it->matches, &it->options, it->blocks, NULL)->error == refused);
  CHECK(maxlogdet_append_blocks(&it->camera, identity_pose, NULL, &it->options, it->blocks, NULL)->error == refused);
  CHECK(maxlogdet_append_blocks(&it->camera, identity_pose, &it->matches, NULL, it->blocks, NULL)->error == refused);
  CHECK(maxlogdet_append_blocks(&it->camera, identity_pose, &it->matches, &it->options, NULL, NULL)->error == refused);
  CHECK(maxlogdet_append_blocks(&it->camera, NULL, &it->matches, &it->options, it->blocks, NULL)->error ==
        MAXLOGDET_ERROR_INVALID_POSE);
  maxlogdet_executor executor;
  maxlogdet_executor_init(&executor, sizeof executor);
  CHECK(maxlogdet_append_blocks(&it->camera, identity_pose, &it->matches, &it->options, it->blocks, &executor)->error ==
        refused);
  size_t* const sizes[] = {&it->camera.struct_size, &it->matches.struct_size, &it->options.struct_size};
  for (size_t i = 0; i < 3; ++i) {
    const size_t right = *sizes[i];
    const size_t wrong[] = {0, 8, 15, right - 1, right + 8, SIZE_MAX};
    for (size_t j = 0; j < sizeof wrong / sizeof *wrong; ++j) {
      *sizes[i] = wrong[j];
      CHECK(append(it)->error == refused && append(it)->appended == 0);
    }
    *sizes[i] = right;
  }
  it->options.reserved = 1;
  CHECK(append(it)->error == refused);
  it->options.reserved = 0;
}

// Of single matches: 1 and four numbers, or 0 and none.
static void check_weights(given* it) {
  double weight[4] = {-7, -7, -7, -7};
  const maxlogdet_camera* const camera = &it->camera;
  const maxlogdet_matches* const matches = &it->matches;
  const maxlogdet_block_options* const options = &it->options;
  CHECK(maxlogdet_match_information(NULL, identity_pose, matches, 0, options, weight) == 0);
  CHECK(maxlogdet_match_information(camera, NULL, matches, 0, options, weight) == 0);
  CHECK(maxlogdet_match_information(camera, identity_pose, NULL, 0, options, weight) == 0);
  CHECK(maxlogdet_match_information(camera, identity_pose, matches, 4, options, weight) == 0);
  CHECK(maxlogdet_match_information(camera, identity_pose, matches, 0, NULL, weight) == 0);
  CHECK(maxlogdet_match_information(camera, identity_pose, matches, 0, options, NULL) == 0);
  CHECK(maxlogdet_match_whitening(camera, identity_pose, matches, 4, options, weight) == 0);
  const void* const points = it->matches.points;
  it->matches.points = NULL;
  CHECK(maxlogdet_match_information(camera, identity_pose, matches, 0, options, weight) == 0);
  it->matches.points = points;
  CHECK(weight[0] == -7);
  CHECK(maxlogdet_match_information(camera, identity_pose, matches, 0, options, weight) == 1);
  CHECK(weight[0] == 1 && weight[1] == 0 && weight[2] == 0 && weight[3] == 1);
  CHECK(maxlogdet_match_whitening(camera, identity_pose, matches, 0, options, weight) == 1);
  CHECK(weight[0] == 1 && weight[1] == 0 && weight[2] == 0 && weight[3] == 1);
}

// What C++ refuses, by its name; nothing of the caller's is changed.
static void check_errors_of_cpp(given it) {
  const given right = it;
  it.matches.points = NULL;
  CHECK(append(&it)->error == MAXLOGDET_ERROR_MISSING_POINTS);
  it = right;
  it.options.weighting = 77;
  CHECK(append(&it)->error == MAXLOGDET_ERROR_INVALID_BLOCK_OPTIONS);
  it = right;
  it.options.depth_cue = MAXLOGDET_DEPTH_CUE_STEREO;
  CHECK(append(&it)->error == MAXLOGDET_ERROR_INVALID_CAMERA);
  it = right;
  it.matches.size = SIZE_MAX;  // more than there can be, whatever is stored already
  CHECK(append(&it)->error == MAXLOGDET_ERROR_OUT_OF_MEMORY);
  it.matches.size = SIZE_MAX - 3;
  CHECK(append(&it)->error == MAXLOGDET_ERROR_OUT_OF_MEMORY);
  CHECK(maxlogdet_block_store_size(it.blocks) == 4);
}

void blocks_are_made_of_matches(void) {
  const double points[12] = {0, 0, 5, 1, -1, 4, 2, 1, -3, 0.5, 1, 8};  // the third is behind the camera
  const uint8_t usable[4] = {1, 0, 1, 1};
  given it = given_matches(4, points);
  it.camera.fx = it.camera.fy = 450;
  it.matches.usable = usable;
  const maxlogdet_block_report* report = append(&it);
  CHECK(report->error == MAXLOGDET_ERROR_NONE && report->appended == 4 && report->invalid == 2);
  CHECK(report->behind_camera == 1 && report->unusable == 1 && report->too_near == 0 && report->singular_rays == 0);
  CHECK(maxlogdet_block_store_size(it.blocks) == 4 && maxlogdet_block_store_rows(it.blocks) == 2);
  CHECK(maxlogdet_block_store_is_valid(it.blocks, 0) == 1 && maxlogdet_block_store_is_valid(it.blocks, 1) == 0);
  check_refused_blocks(&it);
  check_weights(&it);
  check_errors_of_cpp(it);

  // Older structs: a camera without its principal point, matches without the arrays after their points.
  it.camera.struct_size = offsetof(maxlogdet_camera, cx);
  it.matches.struct_size = offsetof(maxlogdet_matches, point_stride);
  it.options.struct_size = offsetof(maxlogdet_block_options, map_sigma);
  report = append(&it);
  CHECK(report->error == MAXLOGDET_ERROR_NONE && report->appended == 4 && report->invalid == 1);
  maxlogdet_block_store_destroy(it.blocks);
}

// The second camera looks along the first one's x.
static const double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0};

static const maxlogdet_block_report* append_of_rig(const given* it, const maxlogdet_camera* const* cameras,
                                                   size_t count) {
  return maxlogdet_append_blocks_of_rig(cameras, T_cb, count, identity_pose, &it->matches, &it->options, it->blocks,
                                        NULL);
}

static void check_blocks_of_rigs(given* it, const maxlogdet_camera* pinhole) {
  const double jacobians[18] = {90, 0, 0, 0, 90, 0, 10, 0, 5, 0, 0, 5, 90, 0, 1, 0, 90, 1};
  const maxlogdet_camera* cameras[2] = {pinhole, &it->camera};
  const maxlogdet_block_report* report = append_of_rig(it, cameras, 2);
  CHECK(report->error == MAXLOGDET_ERROR_NONE && report->appended == 3 && report->invalid == 0);
  cameras[1] = pinhole;
  report = append_of_rig(it, cameras, 2);
  CHECK(report->invalid == 1 && report->behind_camera == 1);
  it->matches.jacobians = jacobians;
  report = append_of_rig(it, cameras, 2);
  CHECK(report->error == MAXLOGDET_ERROR_NONE && report->invalid == 1 && report->invalid_jacobians == 0);

  const maxlogdet_error invalid_id = MAXLOGDET_ERROR_INVALID_CAMERA_ID;
  CHECK(maxlogdet_append_blocks(pinhole, identity_pose, &it->matches, &it->options, it->blocks, NULL)->error ==
        invalid_id);
  CHECK(append_of_rig(it, cameras, 1)->error == invalid_id);
  CHECK(append_of_rig(it, cameras, 257)->error == invalid_id);
  CHECK(maxlogdet_append_blocks_of_rig(NULL, NULL, 0, identity_pose, &it->matches, &it->options, it->blocks, NULL)
            ->error == invalid_id);
  CHECK(append_of_rig(it, NULL, 2)->error == refused);
  CHECK(maxlogdet_append_blocks_of_rig(cameras, NULL, 2, identity_pose, &it->matches, &it->options, it->blocks, NULL)
            ->error == refused);
  CHECK(
      maxlogdet_append_blocks_of_rig(cameras, T_cb, 2, identity_pose, &it->matches, &it->options, NULL, NULL)->error ==
      refused);
  cameras[1] = NULL;
  CHECK(append_of_rig(it, cameras, 2)->error == refused);
  it->matches.jacobians = NULL;
}

void blocks_are_made_for_any_camera(void) {
  typedef struct point {
    float x, y, z, brightness;
  } point;
  const point points[3] = {
      {0, 0, 5, 1}, {3, -1, 0.5F, 1}, {3, 1, -2, 1}};  // the last one is behind all but the fisheye
  const uint8_t ids[3] = {0, 1, 1};
  given it = given_matches(3, points);
  it.camera.fx = it.camera.fy = 190;
  it.camera.model = MAXLOGDET_CAMERA_MODEL_KANNALA_BRANDT;
  it.camera.parameters[0] = 0.003;
  it.matches.point_type = MAXLOGDET_POINT_TYPE_FLOAT32;
  it.matches.point_stride = sizeof *points;
  const maxlogdet_block_report* report = append(&it);
  CHECK(report->error == MAXLOGDET_ERROR_NONE && report->appended == 3 && report->invalid == 0);
  it.options.min_depth = 5.1;  // |p_c| of a fisheye
  report = append(&it);
  CHECK(report->too_near == 3 && report->invalid == 3);
  it.options.min_depth = 0.01;

  maxlogdet_camera pinhole;
  maxlogdet_camera_init(&pinhole, sizeof pinhole);
  pinhole.fx = pinhole.fy = 190;
  it.matches.camera_ids = ids;
  check_blocks_of_rigs(&it, &pinhole);

  it.matches.camera_ids = NULL;
  it.camera.model = 1000;
  CHECK(append(&it)->error == MAXLOGDET_ERROR_UNKNOWN_CAMERA_MODEL);
  it.camera = pinhole;
  it.matches.point_stride = 10;
  CHECK(append(&it)->error == MAXLOGDET_ERROR_INVALID_STRIDE);
  it.matches.point_type = 2;
  CHECK(append(&it)->error == refused);
  CHECK(maxlogdet_block_store_size(it.blocks) == 15);
  maxlogdet_block_store_destroy(it.blocks);
}
