// SPDX-License-Identifier: MIT
// The front door of the C API is that of C++: the same answers, bit for bit, and the same recording.
#include "tests/api/c_api.hpp"
#include "tests/support/recording.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr std::size_t capacity = 120;
constexpr double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 0.2, 0, 1, 0, 0, 1, 0, 0, -0.1};
constexpr double T_cw[12] = {1, 0, 0, 0.1, 0, 1, 0, -0.2, 0, 0, 1, 0.3};
constexpr double T_after[12] = {1, 0, 0, 0.12, 0, 1, 0, -0.2, 0, 0, 1, 0.3};

// One camera or two, matches of all kinds, more than are kept now and then, and what is asked of them.
class Frame {
 public:
  explicit Frame(Random& random) : n_(static_cast<std::size_t>(random.integer(0, capacity + 3))) {
    is_rig_ = random.chance(0.3);
    depth_cue_ = static_cast<DepthCue>(random.integer(0, 2));
    has_covariances_ = random.chance(0.3);
    has_jacobians_ = random.chance(0.1);
    covariances_.resize(9 * n_);
    jacobians_.resize(6 * n_);
    required_.resize(n_);
    excluded_.resize(n_);
    groups_.resize(n_);
    for (std::size_t i = 0; i < n_; ++i) add(random, i);
    draw_options(random);
  }
  Frame(const Frame&) = delete;  // matches and options point into it
  Frame& operator=(const Frame&) = delete;

  // Starts it and adds its matches, in C and in C++.
  void give(maxlogdet_good_features* good, GoodFeatures& expected) const {
    expected.block_options = block_options_;
    expected.spread = spread_;
    expected.is_weighted = is_weighted_;
    const maxlogdet_block_options options = in_c(block_options_);
    EXPECT_EQ(maxlogdet_good_features_set_block_options(good, &options), MAXLOGDET_ERROR_NONE);
    EXPECT_EQ(maxlogdet_good_features_set_spread(good, spread_), MAXLOGDET_ERROR_NONE);
    EXPECT_EQ(maxlogdet_good_features_set_weighted(good, is_weighted_ ? 3 : 0), MAXLOGDET_ERROR_NONE);
    start(good, expected);
    for (std::size_t i = 0; i < n_; ++i) {
      const maxlogdet_match match = in_c(matches_[i]);
      EXPECT_EQ(maxlogdet_good_features_add(good, &match),
                i < capacity ? MAXLOGDET_ERROR_NONE : MAXLOGDET_ERROR_CAPACITY_EXCEEDED);
      expected.add(matches_[i]);
    }
  }

  const Options& options() const { return options_; }

 private:
  void start(maxlogdet_good_features* good, GoodFeatures& expected) const {
    const RigidTransform T = RigidTransform::row_major(T_cw);
    const maxlogdet_camera camera = in_c(rig_[0].camera);
    const maxlogdet_camera* const cameras[2] = {&camera, &camera};
    if (is_rig_) {
      EXPECT_EQ(maxlogdet_good_features_start_rig(good, cameras, T_cb, 2, T_cw), MAXLOGDET_ERROR_NONE);
      expected.start(Rig(rig_, 2), T);
    } else {
      EXPECT_EQ(maxlogdet_good_features_start(good, &camera, T_cw), MAXLOGDET_ERROR_NONE);
      expected.start(rig_[0].camera, T);
    }
  }

  void add(Random& random, std::size_t i) {
    const double p_w[3] = {random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-1, 9)};
    FeatureMatch match(p_w, random.chance(0.02) ? 0 : random.uniform(0.5, 3));
    match.id = static_cast<std::uint32_t>(7 * i);
    if (!random.chance(0.05)) {
      for (int axis = 0; axis < 2; ++axis) {
        match.measured[axis] = 320 + 450 * p_w[axis] / p_w[2] + random.uniform(-20, 20);
      }
    }
    if (depth_cue_ == DepthCue::stereo && random.chance(0.7)) match.u_right = random.uniform(-10, 600);
    if (depth_cue_ == DepthCue::depth && random.chance(0.7)) match.depth = random.uniform(-0.1, 9);
    for (std::size_t e = 0; e < 9; ++e) covariances_[9 * i + e] = e % 4 == 0 ? random.uniform(0.001, 0.1) : 0;
    for (std::size_t e = 0; e < 6; ++e) jacobians_[6 * i + e] = random.uniform(-100, 100);
    if (has_covariances_ && random.chance(0.8)) match.covariance = &covariances_[9 * i];
    if (has_jacobians_ && random.chance(0.95)) match.jacobian = &jacobians_[6 * i];
    match.camera_id = static_cast<std::uint8_t>(is_rig_ ? random.integer(0, 1) : 0);
    match.is_required = random.chance(0.02);
    match.point_id = static_cast<std::int64_t>(i) + 5;
    match.keyframe = random.integer(-1, 4);
    matches_.push_back(match);
    required_[i] = random.chance(0.02) ? 1 : 0;
    excluded_[i] = random.chance(0.1) ? 1 : 0;
    groups_[i] = static_cast<std::uint32_t>(random.integer(0, 4));
  }

  void draw_options(Random& random) {
    block_options_.weighting = weightings[random.index(std::size(weightings))];
    block_options_.map_sigma = random.uniform(0.01, 0.1);
    block_options_.min_depth = random.uniform(0, 1);
    spread_ = random.chance(0.2) ? random.uniform(-0.2, 3) : 0;
    is_weighted_ = random.chance(0.5);
    options_.budget = random.index(capacity + 10);
    options_.strategy = strategies[random.index(std::size(strategies))];
    options_.certificate.compute = random.chance(0.3);
    options_.time_limit = random.chance(0.1) ? 1e-9 : 0;
    if (random.chance(0.3)) options_.required = required_.data();
    if (random.chance(0.3)) options_.excluded = excluded_.data();
    if (random.chance(0.2)) options_.target.efficiency = random.uniform(0, 1);
    if (random.chance(0.2)) {
      options_.groups.ids = groups_.data();
      options_.groups.count = 5;
      options_.groups.maximum = random.index(30);
    }
    if (random.chance(0.7)) options_.strategy = Strategy::lazy_greedy;
  }

  const RigCamera rig_[2] = {{Camera(450, 451, 320, 321, 40), RigidTransform::row_major(T_cb)},
                             {Camera(450, 451, 320, 321, 40), RigidTransform::row_major(T_cb + 12)}};
  std::size_t n_;
  bool is_rig_, has_covariances_, has_jacobians_, is_weighted_ = false;
  DepthCue depth_cue_;
  double spread_ = 0;
  BlockOptions block_options_;
  Options options_;
  std::vector<FeatureMatch> matches_;
  std::vector<double> covariances_, jacobians_;
  std::vector<unsigned char> required_, excluded_;
  std::vector<std::uint32_t> groups_;
};

void expect_same_matches(const maxlogdet_good_features* good, const GoodFeatures& expected) {
  for (std::size_t i = 0; i < expected.size() + 1; ++i) {
    EXPECT_EQ(maxlogdet_good_features_id(good, i), expected.id(i)) << i;
    EXPECT_EQ(maxlogdet_good_features_is_selected(good, i) != 0, expected.is_selected(i)) << i;
    EXPECT_EQ(maxlogdet_good_features_is_outlier(good, i) != 0, expected.is_outlier(i)) << i;
    EXPECT_TRUE(same_value(maxlogdet_good_features_chi2(good, i), expected.chi2(i))) << i;
    double actual[9] = {}, wanted[9] = {};
    EXPECT_EQ(maxlogdet_good_features_information(good, i, actual) != 0, expected.information(i, wanted)) << i;
    EXPECT_TRUE(std::equal(actual, actual + 9, wanted)) << i;
    EXPECT_EQ(maxlogdet_good_features_whitening(good, i, actual) != 0, expected.whitening(i, wanted)) << i;
    EXPECT_TRUE(std::equal(actual, actual + 9, wanted)) << i;
  }
}

// After select() or match().
void expect_same_frame(maxlogdet_good_features* good, GoodFeatures& expected, const maxlogdet_selection* selection) {
  EXPECT_EQ(selection, maxlogdet_good_features_selection(good));
  expect_same(*selection, expected.selection());
  expect_same(*maxlogdet_good_features_block_report(good), expected.block_report());
  EXPECT_STREQ(maxlogdet_good_features_reason(good), expected.reason());
  EXPECT_EQ(maxlogdet_good_features_size(good), expected.size());
  EXPECT_TRUE(same_value(maxlogdet_good_features_efficiency(good), expected.efficiency()));
  const std::uint32_t* outliers = nullptr;
  const std::size_t count = maxlogdet_good_features_outliers(good, T_after, &outliers);
  const IndexRange wanted = expected.outliers(RigidTransform::row_major(T_after));
  EXPECT_EQ(std::vector<std::uint32_t>(outliers, outliers + count),
            std::vector<std::uint32_t>(wanted.begin(), wanted.end()));
  expect_same_matches(good, expected);
}

// Finds three of four points; what it measures depends on the point alone.
template <class Match>
bool find(std::size_t i, Match& match) {
  for (double& coordinate : match.measured) coordinate = static_cast<double>(100 + i);
  match.sigma = 1 + static_cast<double>(i % 5);
  return i % 4 != 1;
}
std::int32_t find_in_c(void* calls, std::size_t i, maxlogdet_match* match) {
  ++*static_cast<int*>(calls);
  return find(i, *match) ? 9 : 0;
}

TEST(CApi, good_features_equal_those_of_cpp) {
  const CGoodFeatures good = c_good_features(capacity);
  GoodFeatures expected(capacity);
  std::size_t selected = 0;
  int calls = 0, wanted_calls = 0;
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Frame frame(random);
    frame.give(good.get(), expected);
    expect_same(*maxlogdet_good_features_selection(good.get()), expected.selection());
    const maxlogdet_options options = options_in_c(frame.options());
    expected.select(frame.options());
    expect_same_frame(good.get(), expected, maxlogdet_good_features_select(good.get(), &options));
    selected += expected.selection().size;
    frame.give(good.get(), expected);
    expected.match(frame.options(), [&](std::size_t i, FeatureMatch& match) {
      ++wanted_calls;
      return find(i, match);
    });
    expect_same_frame(good.get(), expected, maxlogdet_good_features_match(good.get(), &options, find_in_c, &calls));
    EXPECT_EQ(calls, wanted_calls);
    if (HasFailure()) return;
  }
  EXPECT_GE(selected, trials(500));
}

TEST(CApi, recordings_equal_those_of_cpp) {
  const CGoodFeatures good = c_good_features(capacity);
  GoodFeatures expected(capacity);
  const TemporaryFolder in_c, in_cpp;
  EXPECT_EQ(maxlogdet_good_features_record(good.get(), in_c.path().c_str()), 1);
  EXPECT_TRUE(expected.record(in_cpp.path().c_str()));
  // Until a frame that cannot be recorded, which ends both.
  for (std::uint64_t variation = 0; variation < 20; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Frame frame(random);
    frame.give(good.get(), expected);
    const maxlogdet_options options = options_in_c(frame.options());
    maxlogdet_good_features_select(good.get(), &options);
    expected.select(frame.options());
  }
  EXPECT_GT(in_cpp.files().size(), 5U);
  ASSERT_EQ(in_c.files(), in_cpp.files());
  for (const std::string& name : in_cpp.files()) EXPECT_EQ(text_of(in_c / name), text_of(in_cpp / name)) << name;
}

}  // namespace
}  // namespace maxlogdet::test
