// SPDX-License-Identifier: MIT
#include "bench/does_it_track/matcher.hpp"
#include "tests/odometry/made_features.hpp"
#include "tests/odometry/rendered_world.hpp"
#include "tests/support/allocation_counter.hpp"

#include <set>

namespace maxlogdet::test {
namespace {

using sim::Match;
using sim::RejectionOptions;
using stereo_odometry::Matcher;
using stereo_odometry::StereoFeatures;
using Indices = std::vector<std::uint32_t>;

constexpr double radius = 4;  // px

// A map of two keyframes of the rendered world, and a third image of it.
class Matching : public ::testing::Test {
 protected:
  Matching() {
    for (const std::size_t frame : {0U, 3U}) {
      const StereoFeatures features = extractor_.extract(world_.images(RenderedWorld::T_wc(frame)));
      const sim::Pose T_cw = RenderedWorld::T_wc(frame).inverse();
      Matcher matcher = started(features);
      matcher.predict(map_.points(), T_cw);
      matcher.match_all(map_, radius);
      map_.add_keyframe(T_cw, features, matcher.matches(), matcher.points());
    }
    now_ = extractor_.extract(world_.images(RenderedWorld::T_wc(4)));
  }

  static Matcher started(const StereoFeatures& features) {
    Matcher matcher(RenderedWorld::camera(), RenderedWorld::width, RenderedWorld::height);
    matcher.start(features);
    return matcher;
  }

  // The points that are predicted.
  static Indices all_points(Matcher& matcher, const stereo_odometry::LocalMap& map) {
    Indices points;
    for (const stereo_odometry::Prediction& prediction : matcher.predict(map.points(), T_cw()))
      points.push_back(prediction.point);
    matcher.is_predicted(map.points());
    return points;
  }

  static sim::Pose T_cw() { return RenderedWorld::T_wc(4).inverse(); }

  std::vector<unsigned char> match(Matcher& matcher, const Indices& points) const {
    return matcher.match_some(map_, points, radius, T_cw(), RejectionOptions());
  }

  // The points that are matched if they are searched for one after the other.
  Indices matched_one_by_one(Matcher& matcher, const Indices& points) const {
    Indices matched;
    for (const std::uint32_t point : points) {
      const std::size_t before = matcher.matches().size();
      const bool is_matched = match(matcher, {point}).at(0) != 0;
      if (is_matched) matched.push_back(point);
      EXPECT_EQ(matcher.matches().size(), before + (is_matched ? 1 : 0));
    }
    return matched;
  }

  RenderedWorld world_;
  stereo_odometry::FeatureExtractor extractor_{RenderedWorld::camera(), 600};
  stereo_odometry::LocalMap map_{RenderedWorld::camera(), stereo_odometry::MapOptions()};
  StereoFeatures now_;
};

TEST_F(Matching, finds_points_where_the_camera_sees_them) {
  Matcher matcher = started(now_);
  const std::size_t predicted = all_points(matcher, map_).size();
  matcher.match_all(map_, radius);
  EXPECT_GT(matcher.matches().size(), predicted / 4);
  ASSERT_EQ(matcher.points().size(), matcher.matches().size());
  std::size_t right = 0;
  for (std::size_t i = 0; i < matcher.matches().size(); ++i) {
    const Match& match = matcher.matches()[i];
    EXPECT_EQ(match.map_point_id, map_.points().points[matcher.points()[i]].id);
    if (agrees(RenderedWorld::camera(), match, T_cw(), RejectionOptions())) ++right;
  }
  EXPECT_GT(static_cast<double>(right), 0.8 * static_cast<double>(matcher.matches().size()));
}

TEST_F(Matching, at_once_matches_what_it_matches_one_by_one) {
  Matcher one_by_one = started(now_), at_once = started(now_), all_at_once = started(now_);
  const Indices points = all_points(one_by_one, map_);
  const Indices matched = matched_one_by_one(one_by_one, points);
  EXPECT_GT(matched.size(), points.size() / 4);
  EXPECT_LT(matched.size(), points.size());
  all_points(at_once, map_);
  EXPECT_EQ(match(at_once, matched), std::vector<unsigned char>(matched.size(), 1));
  expect_same_matches(at_once.matches(), one_by_one.matches());
  EXPECT_EQ(at_once.points(), matched);

  all_points(all_at_once, map_);
  const std::vector<unsigned char> is_matched = match(all_at_once, points);  // some are matched, others are not
  Indices told;
  std::set<std::int64_t> keypoints;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (is_matched[j] != 0) told.push_back(points[j]);
  }
  EXPECT_EQ(all_at_once.points(), told);
  for (const Match& match : all_at_once.matches()) {
    EXPECT_TRUE(agrees(RenderedWorld::camera(), match, T_cw(), RejectionOptions()));
    EXPECT_TRUE(keypoints.insert(match.keypoint).second) << "a keypoint has one point";
  }
}

TEST_F(Matching, what_does_not_agree_leaves_its_keypoint_to_others) {
  Matcher matcher = started(now_), fresh = started(now_);
  const Indices points = all_points(matcher, map_);
  RejectionOptions nothing_agrees;
  nothing_agrees.chi2_monocular = nothing_agrees.chi2_stereo = -1;
  const std::vector<unsigned char> none(points.size(), 0);
  EXPECT_EQ(matcher.match_some(map_, points, radius, T_cw(), nothing_agrees), none);
  EXPECT_TRUE(matcher.matches().empty());
  all_points(fresh, map_);
  EXPECT_EQ(match(matcher, points), match(fresh, points));
  expect_same_matches(matcher.matches(), fresh.matches());
}

TEST_F(Matching, predicts_only_what_is_not_matched_yet) {
  Matcher matcher = started(now_);
  const Indices points = all_points(matcher, map_);
  match(matcher, points);
  const std::set<std::uint32_t> matched(matcher.points().begin(), matcher.points().end());
  const Indices rest = all_points(matcher, map_);
  EXPECT_EQ(rest.size(), points.size() - matched.size());
  for (const std::uint32_t point : rest) EXPECT_EQ(matched.count(point), 0U);
  const std::size_t before = matcher.matches().size();
  matcher.match_all(map_, radius);
  std::set<std::int64_t> keypoints;
  for (const Match& match : matcher.matches()) keypoints.insert(match.keypoint);
  EXPECT_GT(matcher.matches().size(), before);
  EXPECT_EQ(keypoints.size(), matcher.matches().size()) << "a matched point keeps its keypoint";
  matcher.start(now_);
  EXPECT_EQ(all_points(matcher, map_), points) << "start() discards the matches";
}

// After the first frame only OpenCV allocates, for the alignment.
TEST_F(Matching, tells_the_library_which_points_are_candidates_and_allocates_nothing) {
  Matcher matcher = started(now_);
  const Indices points = all_points(matcher, map_);
  const std::vector<unsigned char>& is_predicted = matcher.is_predicted(map_.points());
  ASSERT_EQ(is_predicted.size(), map_.points().size());
  Indices told;
  for (std::uint32_t i = 0; i < is_predicted.size(); ++i) {
    if (is_predicted[i] != 0) told.push_back(i);
  }
  EXPECT_EQ(told, points);
  Matches matches = map_.points().arrays();
  matches.usable = is_predicted.data();
  BlockStore blocks;
  BlockOptions options;
  options.weighting = Weighting::measurement_and_map;
  options.depth_cue = DepthCue::stereo;
  append_blocks(RenderedWorld::camera(), T_cw(), matches, options, blocks);
  Indices valid;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) valid.push_back(i);
  }
  EXPECT_EQ(valid, points);

  matcher.search(radius);
  const long before = allocations();
  matcher.start(now_);
  matcher.predict(map_.points(), T_cw());
  matcher.search(radius);
  matcher.is_predicted(map_.points());
  EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace maxlogdet::test
