// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <iterator>
#include <memory>
#include <vector>

namespace maxlogdet::test {

struct DestroyInC {
  void operator()(maxlogdet_block_store* blocks) const { maxlogdet_block_store_destroy(blocks); }
  void operator()(maxlogdet_good_features* good) const { maxlogdet_good_features_destroy(good); }
  void operator()(maxlogdet_selector* selector) const { maxlogdet_selector_destroy(selector); }
  void operator()(maxlogdet_active_selection* active) const { maxlogdet_active_selection_destroy(active); }
};
/// Owns what a function of the C API has created.
template <class Handle>
using Owned = std::unique_ptr<Handle, DestroyInC>;

using CBlocks = Owned<maxlogdet_block_store>;
using CGoodFeatures = Owned<maxlogdet_good_features>;
using CSelector = Owned<maxlogdet_selector>;
using CActive = Owned<maxlogdet_active_selection>;

inline CBlocks c_blocks(std::size_t capacity) {
  maxlogdet_block_store* made = nullptr;
  EXPECT_EQ(maxlogdet_block_store_create(capacity, &made), MAXLOGDET_ERROR_NONE);
  return CBlocks(made);
}

inline CGoodFeatures c_good_features(std::size_t capacity) {
  maxlogdet_good_features* made = nullptr;
  EXPECT_EQ(maxlogdet_good_features_create(capacity, nullptr, &made), MAXLOGDET_ERROR_NONE);
  return CGoodFeatures(made);
}

inline CSelector c_selector(std::size_t capacity) {
  maxlogdet_selector* made = nullptr;
  EXPECT_EQ(maxlogdet_selector_create(capacity, nullptr, &made), MAXLOGDET_ERROR_NONE);
  return CSelector(made);
}

inline CActive c_active(std::size_t capacity) {
  maxlogdet_active_selection* made = nullptr;
  EXPECT_EQ(maxlogdet_active_selection_create(capacity, &made), MAXLOGDET_ERROR_NONE);
  return CActive(made);
}

/// The same as a C caller puts it: what is not 0 is true.
inline maxlogdet_options options_in_c(const Options& options) {
  maxlogdet_options made;
  maxlogdet_options_init(&made, sizeof made);
  made.budget = options.budget;
  made.prior = options.prior;
  made.time_limit = options.time_limit;
  made.strategy = static_cast<maxlogdet_strategy>(options.strategy);
  made.threads = options.threads;
  made.required = options.required;
  made.excluded = options.excluded;
  made.target_efficiency = options.target.efficiency;
  made.target_translation_sigma = options.target.translation_sigma;
  made.target_rotation_sigma = options.target.rotation_sigma;
  made.group_ids = options.groups.ids;
  made.group_count = options.groups.count;
  made.group_maximum = options.groups.maximum;
  made.group_maxima = options.groups.maxima;
  made.certificate_compute = options.certificate.compute ? 7 : 0;
  made.certificate_passes = options.certificate.passes;
  made.stochastic_epsilon = options.stochastic.epsilon;
  made.stochastic_seed = options.stochastic.seed;
  made.exchange_sweeps = options.exchange.sweeps;
  return made;
}

inline maxlogdet_matches in_c(const Matches& matches) {
  maxlogdet_matches made;
  EXPECT_EQ(maxlogdet_matches_init(&made, sizeof made), MAXLOGDET_ERROR_NONE);
  made.size = matches.size;
  made.points = matches.points.data();
  made.point_stride = matches.points.stride();
  made.point_type = matches.points.are_float() ? MAXLOGDET_POINT_TYPE_FLOAT32 : MAXLOGDET_POINT_TYPE_FLOAT64;
  made.sigmas = matches.sigmas;
  made.has_depth_cue = matches.has_depth_cue;
  made.usable = matches.usable;
  made.weights = matches.weights;
  made.map_covariances = matches.map_covariances;
  made.jacobians = matches.jacobians;
  made.camera_ids = matches.camera_ids;
  return made;
}

inline maxlogdet_match in_c(const FeatureMatch& match) {
  maxlogdet_match made;
  EXPECT_EQ(maxlogdet_match_init(&made, sizeof made), MAXLOGDET_ERROR_NONE);
  std::copy(std::begin(match.point), std::end(match.point), made.point);
  std::copy(std::begin(match.measured), std::end(match.measured), made.measured);
  made.u_right = match.u_right;
  made.depth = match.depth;
  made.sigma = match.sigma;
  made.covariance = match.covariance;
  made.jacobian = match.jacobian;
  made.id = match.id;
  made.camera_id = match.camera_id;
  made.is_required = match.is_required ? 5 : 0;
  made.point_id = match.point_id;
  made.keyframe = match.keyframe;
  return made;
}

inline maxlogdet_camera in_c(const Camera& camera) {
  maxlogdet_camera made;
  EXPECT_EQ(maxlogdet_camera_init(&made, sizeof made), MAXLOGDET_ERROR_NONE);
  made.fx = camera.pinhole.fx;
  made.fy = camera.pinhole.fy;
  made.cx = camera.pinhole.cx;
  made.cy = camera.pinhole.cy;
  made.bf = camera.pinhole.bf;
  made.model = static_cast<maxlogdet_camera_model>(camera.model);
  std::copy(std::begin(camera.parameters), std::end(camera.parameters), made.parameters);
  return made;
}

inline maxlogdet_block_options in_c(const BlockOptions& options) {
  maxlogdet_block_options made;
  EXPECT_EQ(maxlogdet_block_options_init(&made, sizeof made), MAXLOGDET_ERROR_NONE);
  made.weighting = static_cast<maxlogdet_weighting>(options.weighting);
  made.depth_cue = static_cast<maxlogdet_depth_cue>(options.depth_cue);
  made.map_sigma = options.map_sigma;
  made.depth_sigma = options.depth_sigma;
  made.min_depth = options.min_depth;
  return made;
}

/// Expects as many candidates, the same of them valid: stored entries are out of sight in C.
inline void expect_same(const maxlogdet_block_store& in_c, const BlockStore& in_cpp) {
  EXPECT_EQ(maxlogdet_block_store_size(&in_c), in_cpp.size());
  EXPECT_EQ(maxlogdet_block_store_rows(&in_c), in_cpp.rows());
  EXPECT_EQ(maxlogdet_block_store_invalid_count(&in_c), in_cpp.invalid_count());
  for (std::size_t i = 0; i < in_cpp.size(); ++i) {
    EXPECT_EQ(maxlogdet_block_store_is_valid(&in_c, i) != 0, in_cpp.is_valid(i)) << i;
  }
}

/// Expects the same selection, bit for bit.
inline void expect_same(const maxlogdet_selection& in_c, const Selection& in_cpp) {
  EXPECT_STREQ(maxlogdet_selection_reason(&in_c), in_cpp.reason());
  ASSERT_EQ(in_c.status, static_cast<int>(in_cpp.status));
  ASSERT_EQ(in_c.error, static_cast<int>(in_cpp.error));
  ASSERT_EQ(in_c.size, in_cpp.size);
  EXPECT_EQ(in_c.searched, in_cpp.searched);
  EXPECT_EQ(std::vector<std::uint32_t>(in_c.indices, in_c.indices + in_c.size), indices_of(in_cpp));
  for (std::size_t i = 0; i < in_c.size; ++i) EXPECT_TRUE(same_value(in_c.gains[i], in_cpp.gains[i])) << i;
  EXPECT_TRUE(same_value(in_c.log_det, in_cpp.log_det));
  EXPECT_TRUE(same_value(in_c.upper_bound, in_cpp.upper_bound));
  EXPECT_TRUE(same_value(maxlogdet_selection_certified_efficiency(&in_c), in_cpp.certified_efficiency()));
  EXPECT_TRUE(same_value(in_c.efficiency, in_cpp.efficiency));
  EXPECT_TRUE(same_value(in_c.translation_sigma, in_cpp.translation_sigma));
  EXPECT_TRUE(same_value(in_c.rotation_sigma, in_cpp.rotation_sigma));
  EXPECT_EQ(in_c.searched, in_cpp.searched);
  EXPECT_EQ(in_c.evaluations, in_cpp.evaluations);
  EXPECT_EQ(in_c.float64_decisions, in_cpp.float64_decisions);
  EXPECT_EQ(in_c.invalid_candidates, in_cpp.invalid_candidates);
  EXPECT_EQ(in_c.strategy, static_cast<int>(in_cpp.strategy));
  EXPECT_EQ(in_c.threads, in_cpp.threads);
  EXPECT_EQ(maxlogdet_selection_has_answer(&in_c) != 0, in_cpp.has_answer());
}

/// Expects the same report.
inline void expect_same(const maxlogdet_block_report& in_c, const BlockReport& in_cpp) {
  EXPECT_EQ(in_c.error, static_cast<int>(in_cpp.error));
  EXPECT_STREQ(maxlogdet_error_name(in_c.error), to_string(in_cpp.error));
  EXPECT_EQ(in_c.appended, in_cpp.appended);
  EXPECT_EQ(in_c.invalid, in_cpp.invalid);
  EXPECT_EQ(in_c.behind_camera, in_cpp.behind_camera);
  EXPECT_EQ(in_c.unusable, in_cpp.unusable);
  EXPECT_EQ(in_c.too_near, in_cpp.too_near);
  EXPECT_EQ(in_c.singular_rays, in_cpp.singular_rays);
  EXPECT_EQ(in_c.invalid_covariances, in_cpp.invalid_covariances);
  EXPECT_EQ(in_c.invalid_jacobians, in_cpp.invalid_jacobians);
}

}  // namespace maxlogdet::test
