// SPDX-License-Identifier: MIT
// GoodFeatures against append_blocks and a Selector on the same matches, chi2 against projections written down here,
// every way in which nothing is selected, and one object over many frames of all kinds.
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/good_features.hpp>
#include <maxlogdet/select.hpp>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

using WideVector3 = Eigen::Matrix<long double, 3, 1>;
using Isometry = Eigen::Transform<double, 3, Eigen::Isometry>;

RigidTransform rows_of(const Isometry& T) { return rigid_transform(T.matrix()); }

Eigen::Vector3d random_vector(Random& random, double largest) {
  return {random.uniform(-largest, largest), random.uniform(-largest, largest), random.uniform(-largest, largest)};
}

Isometry random_isometry(Random& random, double metres, double radians) {
  Isometry T(Eigen::AngleAxisd(random.uniform(-radians, radians), random_vector(random, 1).normalized()));
  T.translation() = random_vector(random, metres);
  return T;
}

// As the models' papers write it, for points in front of the camera.
std::array<long double, 2> image_of(const Camera& camera, const WideVector3& p) {
  const double* const k = camera.parameters;
  long double x = p.x() / p.z(), y = p.y() / p.z();
  const long double rho = x * x + y * y;
  if (camera.model == CameraModel::radial_tangential) {
    const long double radial = 1 + k[0] * rho + k[1] * rho * rho + k[4] * rho * rho * rho;
    const long double a = x * radial + 2 * k[2] * x * y + k[3] * (rho + 2 * x * x);
    y = y * radial + k[2] * (rho + 2 * y * y) + 2 * k[3] * x * y;
    x = a;
  } else if (camera.model == CameraModel::kannala_brandt) {
    const long double theta = std::atan(std::sqrt(rho));
    long double d = theta;
    for (int i = 0; i < 4; ++i) d += k[i] * std::pow(theta, 3 + 2 * i);
    x *= d / std::sqrt(rho);
    y *= d / std::sqrt(rho);
  } else if (camera.model == CameraModel::double_sphere) {
    const long double z = k[0] * p.norm() + p.z();
    const long double divisor = k[1] * std::hypot(std::hypot(p.x(), p.y()), z) + (1 - k[1]) * z;
    x = p.x() / divisor;
    y = p.y() / divisor;
  }
  return {{camera.pinhole.fx * x + camera.pinhole.cx, camera.pinhole.fy * y + camera.pinhole.cy}};
}

Camera camera_of(CameraModel model) {
  const PinholeCamera pinhole = {458, 457, 367, 248, 50};
  switch (model) {
    default: break;
    case CameraModel::radial_tangential: return Camera::radial_tangential(pinhole, -0.05, 0.01, 2e-4, -1e-4, 1e-3);
    case CameraModel::kannala_brandt: return Camera::kannala_brandt(pinhole, -0.01, 0.02, -0.003, 0.0004);
    case CameraModel::double_sphere: return Camera::double_sphere(pinhole, -0.2, 0.6);
  }
  return pinhole;
}

// What the matches of a frame have.
struct Kind {
  CameraModel model = CameraModel::pinhole;
  ThirdMeasurement third = ThirdMeasurement::none;
  bool has_rig = false;
  bool has_jacobians = false;
  enum class Covariances { none, some, all } covariances = Covariances::none;
};

Kind random_kind(Random& random) {
  Kind kind;
  kind.model = camera_models[random.integer(0, 3)];
  kind.third = kind.model == CameraModel::pinhole ? ThirdMeasurement(random.integer(0, 2)) : ThirdMeasurement::none;
  kind.has_rig = random.chance(0.3);
  kind.has_jacobians = !kind.has_rig && kind.third == ThirdMeasurement::none && random.chance(0.3);
  kind.covariances = Kind::Covariances(random.integer(0, 2));
  return kind;
}

// The same matches as a GoodFeatures and append_blocks take them. Some points are behind the camera, some have no third
// measurement. Measured is what the camera sees, and up to five deviations beside it.
struct Frame {
  Frame(Random& random, std::size_t n, const Kind& what) : kind(what), T_cw(random_isometry(random, 2, 1)) {
    options.third = kind.third;
    options.map_sigma = 0.11;
    options.depth_sigma = 0.07;
    rig_cameras[0].camera = camera_of(kind.model);
    rig_cameras[1].camera = camera_of(kind.third == ThirdMeasurement::stereo ? kind.model : CameraModel::double_sphere);
    for (Isometry& T : T_cb) T = random_isometry(random, 0.2, 0.2);
    for (std::size_t c = 0; c < 2; ++c) rig_cameras[c].T_cb = rows_of(T_cb[c]);
    for (std::size_t i = 0; i < n; ++i) add(random, i);
  }

  std::size_t camera_of_match(std::size_t i) const { return kind.has_rig ? i % 2 : 0; }

  WideVector3 in_camera(std::size_t i, const Isometry& pose) const {
    Eigen::Vector3d p = pose * Eigen::Vector3d(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    if (kind.has_rig) p = T_cb[camera_of_match(i)] * p;
    return p.cast<long double>();
  }

  void add(Random& random, std::size_t i) {
    const std::size_t c = camera_of_match(i);
    const double z = random.chance(0.05) ? -3 : random.uniform(1, 20);
    const Eigen::Vector3d p_c(random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z);
    const Eigen::Vector3d p_b = kind.has_rig ? Eigen::Vector3d(T_cb[c].inverse() * p_c) : p_c;
    const Eigen::Vector3d p_w = T_cw.inverse() * p_b;
    points.insert(points.end(), p_w.data(), p_w.data() + 3);
    sigmas.push_back(random.uniform(0.5, 3));
    camera_ids.push_back(static_cast<unsigned char>(c));
    has_third.push_back(kind.third != ThirdMeasurement::none && random.chance(0.6) ? 1 : 0);
    const bool has_covariance = kind.covariances == Kind::Covariances::all ||
                                (kind.covariances == Kind::Covariances::some && random.chance(0.5));
    const Eigen::Matrix3d root =
        Eigen::Matrix3d::Identity() * 0.05 + 0.1 * Eigen::Matrix3d(random_vector(random, 1).asDiagonal());
    const Eigen::Matrix3d covariance = has_covariance ? Eigen::Matrix3d(root * root.transpose())
                                                      : Eigen::Matrix3d(0.11 * 0.11 * Eigen::Matrix3d::Identity());
    covariances.insert(covariances.end(), covariance.data(), covariance.data() + 9);
    for (int e = 0; e < 6; ++e) jacobians.push_back(random.uniform(-300, 300));

    FeatureMatch match;
    match.id = static_cast<std::uint32_t>(1000 + i);
    for (int d = 0; d < 3; ++d) match.point[d] = p_w(d);
    const auto uv = image_of(rig_cameras[c].camera, p_c.cast<long double>());
    const double sigma = sigmas.back();
    for (std::size_t axis = 0; axis < 2; ++axis) {
      match.measured[axis] = static_cast<double>(uv[axis]) + random.uniform(-5, 5) * sigma;
    }
    if (has_third.back() != 0) {
      const bool is_depth = kind.third == ThirdMeasurement::depth;
      match.third = is_depth ? p_c.z() + random.uniform(-5, 5) * options.depth_sigma
                             : static_cast<double>(uv[0]) - 50 / p_c.z() + random.uniform(-5, 5) * sigma;
    }
    match.sigma = sigma;
    match.camera_id = camera_ids.back();
    matches.push_back(match);
    knows_covariance.push_back(has_covariance ? 1 : 0);
  }

  void start(GoodFeatures& good) const {
    good.block_options = options;
    good.block_options.third = ThirdMeasurement::none;  // which it is says start()
    if (kind.has_rig) {
      good.start(Rig{rig_cameras, 2}, rows_of(T_cw), kind.third);
    } else {
      good.start(rig_cameras[0].camera, rows_of(T_cw), kind.third);
    }
  }

  void gather(GoodFeatures& good) const {
    start(good);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      FeatureMatch match = matches[i];
      double covariance[9], jacobian[6];  // copied by add()
      std::copy_n(&covariances[9 * i], 9, covariance);
      std::copy_n(&jacobians[6 * i], 6, jacobian);
      if (knows_covariance[i] != 0) match.covariance = covariance;
      if (kind.has_jacobians) match.jacobian = jacobian;
      good.add(match);
      std::fill_n(covariance, 9, nan);
      std::fill_n(jacobian, 6, nan);
    }
  }

  BlockStore blocks() const {
    Matches arrays;
    arrays.size = matches.size();
    arrays.points = points.data();
    arrays.sigmas = sigmas.data();
    arrays.has_third = has_third.data();
    if (kind.has_jacobians) arrays.jacobians = jacobians.data();
    BlockOptions block_options = options;
    bool is_any_known = false;
    for (const unsigned char knows : knows_covariance) is_any_known = is_any_known || knows != 0;
    if (is_any_known) {
      arrays.map_covariances = covariances.data();
      block_options.weighting = Weighting::measurement_and_map;
    }
    BlockStore store(matches.size());
    if (kind.has_rig) {
      arrays.camera_ids = camera_ids.data();
      EXPECT_TRUE(append_blocks(Rig{rig_cameras, 2}, rows_of(T_cw), arrays, block_options, store).is_done());
    } else {
      EXPECT_TRUE(append_blocks(rig_cameras[0].camera, rows_of(T_cw), arrays, block_options, store).is_done());
    }
    return store;
  }

  // Of match i at `pose`, in long double.
  long double chi2(std::size_t i, const Isometry& pose) const {
    const WideVector3 p = in_camera(i, pose);
    if (!(p.z() > 0)) return infinity;
    const auto uv = image_of(rig_cameras[camera_of_match(i)].camera, p);
    const FeatureMatch& match = matches[i];
    long double sum = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) sum += std::pow((match.measured[axis] - uv[axis]) / match.sigma, 2);
    if (has_third[i] == 0) return sum;
    if (kind.third == ThirdMeasurement::depth) return sum + std::pow((match.third - p.z()) / options.depth_sigma, 2);
    return sum + std::pow((match.third - (uv[0] - 50 / p.z())) / match.sigma, 2);
  }

  Kind kind;
  Isometry T_cw;
  Isometry T_cb[2];
  RigCamera rig_cameras[2];
  BlockOptions options;
  std::vector<FeatureMatch> matches;
  std::vector<double> points, sigmas, covariances, jacobians;
  std::vector<unsigned char> camera_ids, has_third, knows_covariance;
};

void expect_equal_blocks(const BlockStore& actual, const BlockStore& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_EQ(actual.is_valid(i), expected.is_valid(i)) << i;
    if (actual.is_valid(i)) {
      EXPECT_EQ(stored_block(actual, i), stored_block(expected, i)) << i;
    }
  }
}

std::vector<std::uint32_t> selected_of(const GoodFeatures& good) {
  std::vector<std::uint32_t> selected;
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (good.is_selected(i)) selected.push_back(static_cast<std::uint32_t>(i));
  }
  return selected;
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

Options budget_of(std::size_t budget) {
  Options options;
  options.budget = budget;
  return options;
}

void expect_all_selected(const GoodFeatures& good, std::size_t count) {
  EXPECT_EQ(good.size(), count);
  EXPECT_EQ(good.selected_count(), count);
  EXPECT_EQ(selected_of(good).size(), count);
}

// One object over all of them: what a frame leaves behind would be seen.
TEST(GoodFeatures, selects_as_append_blocks_and_a_selector_do_on_frames_of_all_kinds_one_after_the_other) {
  GoodFeatures good(300);
  for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Frame frame(random, static_cast<std::size_t>(random.integer(100, 300)), random_kind(random));
    frame.gather(good);
    ASSERT_EQ(good.size(), frame.matches.size());
    EXPECT_EQ(good.id(7), 1007U);
    EXPECT_EQ(good.blocks().size(), 0U) << "of the frame before";
    EXPECT_EQ(good.selected_count(), frame.matches.size()) << "before select()";
    const Options options = budget_of(40);
    const BlockStore blocks = frame.blocks();
    ASSERT_EQ(good.select(options), Status::ok);
    expect_equal_blocks(good.blocks(), blocks);
    EXPECT_EQ(selected_of(good), sorted(select_indices(blocks, options)));
    EXPECT_EQ(good.selected_count(), 40U);
    EXPECT_STREQ(good.reason(), "ok");
  }
}

TEST(GoodFeatures, build_makes_the_same_blocks_and_selects_nothing) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 100, Kind());
  GoodFeatures good(100);
  frame.gather(good);
  EXPECT_TRUE(good.build());
  expect_equal_blocks(good.blocks(), frame.blocks());
  expect_all_selected(good, 100);
}

// The options of blocks may change between two calls for one frame, and what stands for an unknown covariance with
// them.
TEST(GoodFeatures, a_match_without_a_covariance_has_the_map_sigma_of_now) {
  Random random;
  SCOPED_TRACE(random.name());
  Kind kind;
  kind.covariances = Kind::Covariances::some;
  const Frame frame(random, 100, kind);
  GoodFeatures good(100);
  frame.gather(good);
  good.block_options.map_sigma = 3;
  ASSERT_TRUE(good.build());
  good.block_options.map_sigma = 0.11;
  ASSERT_TRUE(good.build());
  expect_equal_blocks(good.blocks(), frame.blocks());
}

TEST(GoodFeatures, a_match_without_a_jacobian_beside_others_with_one_is_no_candidate) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 50, Kind());
  const double jacobian[6] = {300, 0, 10, 0, 300, 20};
  for (const std::size_t without : {std::size_t{0}, std::size_t{20}}) {
    GoodFeatures good(50);
    frame.start(good);
    for (std::size_t i = 0; i < 50; ++i) {
      FeatureMatch match;
      std::copy_n(&frame.points[3 * i], 3, match.point);
      match.jacobian = i == without ? nullptr : jacobian;
      good.add(match);
    }
    good.select(budget_of(10));
    EXPECT_FALSE(good.blocks().is_valid(without));
    EXPECT_EQ(good.block_report().status, BlockStatus::invalid_jacobians);
    EXPECT_EQ(good.block_report().invalid_jacobians, 1U);
    EXPECT_EQ(good.status(), Status::ok);
  }
}

TEST(GoodFeatures, whatever_goes_wrong_all_matches_are_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 200, Kind());
  const auto expect_all = [&](GoodFeatures& good, const Options& options, Status status, const std::string& reason) {
    SCOPED_TRACE(reason);
    EXPECT_EQ(good.select(options), status);
    EXPECT_EQ(good.status(), status);
    EXPECT_EQ(good.reason(), reason);
    expect_all_selected(good, 200);
    good.judge(rows_of(frame.T_cw));
    for (std::size_t i = 0; i < 200; ++i) EXPECT_FALSE(good.is_outlier(i));
  };
  GoodFeatures good(300);
  const auto with = [&](void (*change)(Options&), Status status) {
    Options options = budget_of(50);
    change(options);
    frame.gather(good);
    expect_all(good, options, status, to_string(status));
    // And the next frame is selected from again.
    frame.gather(good);
    EXPECT_EQ(good.select(budget_of(50)), Status::ok);
    EXPECT_EQ(good.selected_count(), 50U);
  };
  with([](Options& o) { o.budget = 200; }, Status::all_selected);
  with([](Options& o) { o.budget = 301; }, Status::invalid_budget);
  with([](Options& o) { o.time_limit = 1e-9; }, Status::deadline_reached);
  with([](Options& o) { o.time_limit = -1; }, Status::invalid_time_limit);
  with([](Options& o) { o.strategy = Strategy(99); }, Status::invalid_strategy);
  with([](Options& o) { o.threads = -1; }, Status::invalid_threads);
  static const double no_prior[36] = {};
  with([](Options& o) { o.prior = no_prior; }, Status::invalid_prior);
  static const std::vector<unsigned char> everything(200, 1);
  with([](Options& o) { o.required = everything.data(); }, Status::infeasible);

  frame.gather(good);
  good.block_options.min_depth = -1;
  expect_all(good, budget_of(50), Status::invalid_block, "invalid_options");
  const auto start_with = [&](const Camera& camera, const RigidTransform& T_cw, const std::string& reason) {
    frame.gather(good);
    std::vector<FeatureMatch> matches = frame.matches;
    good.start(camera, T_cw, ThirdMeasurement::none);
    for (const FeatureMatch& match : matches) good.add(match);
    expect_all(good, budget_of(50), Status::invalid_block, reason);
  };
  start_with(Camera(), rows_of(frame.T_cw), "invalid_camera");
  start_with(camera_of(CameraModel::pinhole), nullptr, "invalid_pose");
  // A rig without cameras is an error, not the camera of the frame before.
  frame.gather(good);
  good.start(Rig(), rows_of(frame.T_cw), ThirdMeasurement::none);
  for (const FeatureMatch& match : frame.matches) good.add(match);
  expect_all(good, budget_of(50), Status::invalid_block, "invalid_camera_id");
}

TEST(GoodFeatures, fewer_are_selected_where_they_meet_the_targets) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 200, Kind());
  GoodFeatures good(200);
  frame.gather(good);
  Options options = budget_of(150);
  options.target_efficiency = 0.4;
  EXPECT_FALSE(good.is_target_reached());
  EXPECT_EQ(good.select(options), Status::ok) << "there are matches that are not selected";
  EXPECT_STREQ(good.reason(), "ok");
  EXPECT_TRUE(good.is_target_reached());
  Selector selector(200);
  const Selection expected = selector.select(good.blocks(), options);
  ASSERT_EQ(expected.status, Status::target_reached);
  EXPECT_EQ(good.selected_count(), expected.size);
  for (const std::uint32_t i : expected) EXPECT_TRUE(good.is_selected(i));
  EXPECT_NEAR(good.share_of_all(), expected.efficiency_of_all, 1e-9);
  good.judge(rows_of(frame.T_cw));
  const auto with = [&](double share, std::size_t budget, Status status, bool is_reached) {
    SCOPED_TRACE(share);
    options.target_efficiency = share;
    options.budget = budget;
    frame.gather(good);
    EXPECT_FALSE(good.is_target_reached()) << "of the frame before";
    EXPECT_EQ(good.select(options), status);
    EXPECT_EQ(good.is_target_reached(), is_reached);
  };
  with(0.4, 10, Status::ok, false);
  const std::size_t valid = good.blocks().stored();
  with(1 - 1e-9, valid - 1, Status::ok, false);
  with(1 - 1e-9, 200, Status::all_selected, true);
  expect_all_selected(good, 200);
  with(0.4, 150, Status::ok, true);
  with(2, 150, Status::invalid_target, false);
  expect_all_selected(good, 200);
  EXPECT_STREQ(good.reason(), "invalid_target");
}

TEST(GoodFeatures, a_frame_of_more_than_the_capacity_is_not_selected_from) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 101, Kind());
  GoodFeatures good(100);
  frame.gather(good);
  EXPECT_FALSE(good.build());
  EXPECT_EQ(good.select(budget_of(10)), Status::capacity_exceeded);
  EXPECT_STREQ(good.reason(), "capacity_exceeded");
  expect_all_selected(good, 101);
  EXPECT_EQ(good.id(100), GoodFeatures::no_id);
  good.judge(rows_of(frame.T_cw));
  EXPECT_TRUE(std::isnan(good.chi2(100)));
  EXPECT_FALSE(good.is_outlier(100));
  frame.start(good);
  for (std::size_t i = 0; i < 100; ++i) good.add(frame.matches[i]);
  EXPECT_EQ(good.select(budget_of(10)), Status::ok) << "the next frame has room";
  GoodFeatures none(0);
  none.start(camera_of(CameraModel::pinhole), rows_of(frame.T_cw), ThirdMeasurement::none);
  none.add(FeatureMatch());
  EXPECT_EQ(none.select(budget_of(0)), Status::capacity_exceeded);
  expect_all_selected(none, 1);
}

// By the match, by the options, or both; again and again for one frame.
TEST(GoodFeatures, what_is_required_is_selected_also_where_it_can_be_no_candidate) {
  Random random;
  SCOPED_TRACE(random.name());
  Frame frame(random, 200, Kind());
  const BlockStore blocks = frame.blocks();
  std::size_t invalid = 0, one = 0;
  while (blocks.is_valid(invalid)) ++invalid;
  while (!blocks.is_valid(one)) ++one;
  std::size_t other = one + 1;
  while (!blocks.is_valid(other)) ++other;
  frame.matches[one].is_required = frame.matches[invalid].is_required = true;
  std::vector<unsigned char> required(200, 0), by_options(200, 0);
  required[one] = by_options[other] = required[other] = 1;
  GoodFeatures good(200);
  frame.gather(good);
  for (int time = 0; time < 3; ++time) {
    Options options = budget_of(20);
    options.required = required.data();
    std::vector<std::uint32_t> expected = select_indices(blocks, options);
    expected.push_back(static_cast<std::uint32_t>(invalid));
    options.required = by_options.data();
    ASSERT_EQ(good.select(options), Status::ok);
    EXPECT_EQ(selected_of(good), sorted(expected)) << "time " << time;
    EXPECT_EQ(good.selected_count(), 21U);
  }
  // What the options required is not required of the next selection.
  Options options = budget_of(20);
  required[other] = 0;
  options.required = required.data();
  std::vector<std::uint32_t> expected = select_indices(blocks, options);
  expected.push_back(static_cast<std::uint32_t>(invalid));
  ASSERT_EQ(good.select(budget_of(20)), Status::ok);
  EXPECT_EQ(selected_of(good), sorted(expected));
}

TEST(GoodFeatures, excluded_matches_and_groups_go_by_the_numbers_of_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 200, Kind());
  std::vector<unsigned char> excluded(200, 0);
  std::vector<std::uint32_t> groups(200);
  for (std::uint32_t i = 0; i < 200; ++i) {
    excluded[i] = i % 5 == 0 ? 1 : 0;
    groups[i] = i % 30;
  }
  Options options = budget_of(20);
  options.excluded = excluded.data();
  options.groups = groups.data();
  options.group_count = 30;
  GoodFeatures good(200);
  frame.gather(good);
  ASSERT_EQ(good.select(options), Status::ok);
  EXPECT_EQ(selected_of(good), sorted(select_indices(frame.blocks(), options)));
}

TEST(GoodFeatures, chi2_is_that_of_the_projection_and_an_outlier_is_above_its_quantile) {
  for (std::uint64_t variation = 0; variation < trials(60); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Kind kind = random_kind(random);
    kind.has_jacobians = false;
    const Frame frame(random, 200, kind);
    GoodFeatures good(200);
    frame.gather(good);
    ASSERT_EQ(good.select(budget_of(50)), Status::ok);
    const Isometry optimised = random_isometry(random, 0.02, 0.002) * frame.T_cw;
    for (std::size_t i = 0; i < 200; ++i) EXPECT_TRUE(std::isnan(good.chi2(i))) << "before judge()";
    good.judge(rows_of(optimised));
    int outliers = 0;
    for (std::size_t i = 0; i < 200; ++i) {
      if (good.is_selected(i)) {
        EXPECT_TRUE(std::isnan(good.chi2(i))) << i;
        EXPECT_FALSE(good.is_outlier(i)) << i;
        continue;
      }
      const auto expected = static_cast<double>(frame.chi2(i, optimised));
      if (std::isinf(expected) && kind.model != CameraModel::pinhole) continue;  // some see behind themselves
      const double quantile = frame.has_third[i] != 0 ? 7.815 : 5.991;
      if (std::isinf(expected)) {
        EXPECT_EQ(good.chi2(i), infinity) << i;
      } else {
        EXPECT_NEAR(good.chi2(i), expected, 1e-7 * (1 + expected)) << i;
      }
      EXPECT_EQ(good.is_outlier(i), good.chi2(i) > quantile) << i;
      outliers += good.is_outlier(i) ? 1 : 0;
    }
    EXPECT_GT(outliers, 20);
    EXPECT_LT(outliers, 145);
  }
}

TEST(GoodFeatures, with_jacobians_of_the_caller_nothing_is_judged) {
  Random random;
  SCOPED_TRACE(random.name());
  Kind kind;
  kind.has_jacobians = true;
  const Frame frame(random, 100, kind);
  GoodFeatures good(100);
  frame.gather(good);
  ASSERT_EQ(good.select(budget_of(50)), Status::ok);
  good.judge(rows_of(frame.T_cw));
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_TRUE(std::isnan(good.chi2(i)));
    EXPECT_FALSE(good.is_outlier(i));
  }
}

TEST(GoodFeatures, the_share_compares_the_selection_with_all_matches) {
  for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Frame frame(random, 200, random_kind(random));
    const BlockStore blocks = frame.blocks();
    GoodFeatures good(300);
    for (const bool has_prior : {false, true}) {
      const Matrix6 prior = has_prior ? Matrix6(1e4 * random_prior(random)) : default_information();
      Options options = budget_of(50);
      const EigenPrior entries(prior);
      if (has_prior) options.prior = entries.data();
      frame.gather(good);
      ASSERT_EQ(good.select(options), Status::ok);
      const std::vector<std::uint32_t> selected = selected_of(good);
      std::vector<std::uint32_t> all;
      for (std::uint32_t i = 0; i < 200; ++i) {
        if (blocks.is_valid(i)) all.push_back(i);
      }
      const long double expected = std::exp((log_det_of(blocks, selected, prior) - log_det_of(blocks, all, prior)) / 6);
      EXPECT_NEAR(good.share_of_all(), static_cast<double>(expected), 1e-6);
      EXPECT_LT(good.share_of_all(), 1) << "again";
      EXPECT_EQ(selected_of(good), selected) << "the selection stays";
    }
    good.select(budget_of(200));
    EXPECT_EQ(good.share_of_all(), 1);
    good.select(budget_of(1000));
    EXPECT_TRUE(std::isnan(good.share_of_all())) << "after an error";
  }
}

// d h / d p_c by differences of image_of, or the caller's.
WideMatrix jacobian_of(const Frame& frame, std::size_t i, const WideVector3& p) {
  const Camera& camera = frame.rig_cameras[frame.camera_of_match(i)].camera;
  const bool is_depth = frame.kind.third == ThirdMeasurement::depth;
  const long double step = 1e-7L * p.norm();
  WideMatrix J(3, 3);
  for (int d = 0; d < 3; ++d) {
    const WideVector3 by = step * WideVector3::Unit(d);
    const auto after = image_of(camera, p + by), before = image_of(camera, p - by);
    for (std::size_t a = 0; a < 2; ++a) J(static_cast<Eigen::Index>(a), d) = (after[a] - before[a]) / (2 * step);
    for (int a = 0; frame.kind.has_jacobians && a < 2; ++a) {
      J(a, d) = frame.jacobians[6 * i + static_cast<std::size_t>(3 * a + d)];
    }
    const long double of_depth = d == 2 ? 1 : 0;
    J(2, d) = is_depth ? of_depth : J(0, d) + 50 / (p.z() * p.z()) * of_depth;
  }
  return J.topRows(frame.has_third[i] != 0 ? 3 : 2);
}

// J Omega J^T of a match, J by the pose.
WideMatrix weighted_information(const Frame& frame, std::size_t i, const double* omega) {
  const WideVector3 p_b =
      (frame.T_cw * Eigen::Vector3d(frame.points[3 * i], frame.points[3 * i + 1], frame.points[3 * i + 2]))
          .cast<long double>();
  WideMatrix by_pose(3, 6);
  by_pose << 1, 0, 0, 0, p_b.z(), -p_b.y(), 0, 1, 0, -p_b.z(), 0, p_b.x(), 0, 0, 1, p_b.y(), -p_b.x(), 0;
  WideMatrix H = jacobian_of(frame, i, frame.in_camera(i, frame.T_cw));
  if (frame.kind.has_rig) H = wide_product(H, frame.T_cb[frame.camera_of_match(i)].linear().cast<long double>());
  H = wide_product(H, by_pose);
  WideMatrix weight(H.rows(), H.rows());
  for (Eigen::Index a = 0; a < H.rows(); ++a) {
    for (Eigen::Index b = 0; b < H.rows(); ++b) weight(a, b) = omega[a * H.rows() + b];
  }
  return wide_product(wide_product(H.transpose(), weight), H);
}

Matrix6 information_of_block(const BlockStore& blocks, std::size_t i) {
  const Block block = stored_block(blocks, i);
  Matrix6 information = Matrix6::Zero();
  for (std::size_t r = 0; r < static_cast<std::size_t>(blocks.rows()); ++r) {
    const Vector6 row = Eigen::Map<const Vector6>(block.data() + 6 * r);
    information += row * row.transpose();
  }
  return information;
}

// An optimiser that weighs by it has the noise model of the blocks, whatever the matches have.
TEST(GoodFeatures, the_information_of_a_match_is_that_of_its_block) {
  GoodFeatures good(200);
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Frame frame(random, 150, random_kind(random));
    frame.gather(good);
    std::vector<std::array<double, 9>> before(150);
    for (std::size_t i = 0; i < 150; ++i) good.information(i, before[i].data());
    ASSERT_EQ(good.select(budget_of(40)), Status::ok);
    Matrix6 actual = Matrix6::Zero(), expected = Matrix6::Zero();
    for (std::size_t i = 0; i < 150; ++i) {
      if (!good.blocks().is_valid(i) || !(frame.in_camera(i, frame.T_cw).z() > 0)) continue;  // see image_of
      double omega[9] = {}, W[9] = {};
      ASSERT_TRUE(good.information(i, omega)) << i;
      ASSERT_TRUE(good.whitening(i, W)) << i;
      const std::size_t rows = frame.has_third[i] != 0 ? 3 : 2;
      for (std::size_t e = 0; e < rows * rows; ++e) EXPECT_EQ(omega[e], before[i][e]) << "before select()";
      double sum = 0;
      for (std::size_t k = 0; k < rows; ++k) sum += W[rows * k] * W[rows * k];
      EXPECT_NEAR(sum, omega[0], 1e-12 * omega[0]);
      const Matrix6 of_match = weighted_information(frame, i, omega).cast<double>();
      const Matrix6 of_block = information_of_block(good.blocks(), i);
      EXPECT_LT(relative_difference(of_match, of_block), 1e-5) << i;
      actual += of_match;
      expected += of_block;
    }
    EXPECT_LT(relative_difference(actual, expected), 1e-6);
  }
}

TEST(GoodFeatures, has_no_information_of_a_match_that_has_no_image_or_is_beyond_the_capacity) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 101, Kind());
  GoodFeatures good(100);
  frame.gather(good);
  std::size_t behind = 0;
  for (std::size_t i = 0; i < 101; ++i) {
    double omega[4] = {-7, -7, -7, -7};
    const bool is_behind = !(frame.in_camera(i, frame.T_cw).z() > 0);
    behind += is_behind ? 1 : 0;
    EXPECT_EQ(good.information(i, omega), !is_behind && i < 100) << i;
    if (is_behind || i == 100) {
      EXPECT_EQ(omega[0], -7);
    } else {
      EXPECT_DOUBLE_EQ(omega[0], 1 / (frame.sigmas[i] * frame.sigmas[i]));
    }
    EXPECT_EQ(good.whitening(i, omega), !is_behind && i < 100) << i;
  }
  EXPECT_GT(behind, 0U);
  good.start(Rig(), rows_of(frame.T_cw), ThirdMeasurement::none);
  good.add(frame.matches[0]);
  double omega[4];
  EXPECT_FALSE(good.information(0, omega)) << "a rig without cameras";
}

TEST(GoodFeatures, judges_by_the_weights_of_the_optimiser_if_it_has_them) {
  for (std::uint64_t variation = 0; variation < trials(60); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Kind kind = random_kind(random);
    kind.has_jacobians = false;
    const Frame frame(random, 200, kind);
    GoodFeatures good(200);
    good.is_weighted = true;
    frame.gather(good);
    ASSERT_EQ(good.select(budget_of(50)), Status::ok);
    const Isometry optimised = random_isometry(random, 0.02, 0.002) * frame.T_cw;
    good.judge(rows_of(optimised));
    for (std::size_t i = 0; i < 200; ++i) {
      const WideVector3 p = frame.in_camera(i, optimised);
      double omega[9];
      if (good.is_selected(i) || !(p.z() > 0) || !good.information(i, omega)) continue;
      const auto uv = image_of(frame.rig_cameras[frame.camera_of_match(i)].camera, p);
      const FeatureMatch& match = frame.matches[i];
      const long double third = kind.third == ThirdMeasurement::depth ? p.z() : uv[0] - 50 / p.z();
      const long double e[3] = {match.measured[0] - uv[0], match.measured[1] - uv[1], match.third - third};
      const std::size_t rows = frame.has_third[i] != 0 ? 3 : 2;
      long double expected = 0;
      for (std::size_t a = 0; a < rows * rows; ++a) expected += e[a / rows] * omega[a] * e[a % rows];
      EXPECT_NEAR(good.chi2(i), static_cast<double>(expected), 1e-6 * (1 + static_cast<double>(expected))) << i;
    }
  }
}

TEST(GoodFeatures, moves_with_its_frame_and_may_be_assigned_to_afterwards) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame(random, 200, Kind());
  GoodFeatures good(200);
  frame.gather(good);
  ASSERT_EQ(good.select(budget_of(50)), Status::ok);
  const std::vector<std::uint32_t> selected = selected_of(good);
  GoodFeatures taker(std::move(good));
  EXPECT_EQ(selected_of(taker), selected);
  good = std::move(taker);  // NOLINT(bugprone-use-after-move): what the class allows
  EXPECT_EQ(selected_of(good), selected);
  frame.gather(good);
  EXPECT_EQ(good.select(budget_of(20)), Status::ok);
  EXPECT_EQ(good.selected_count(), 20U);
  static_assert(!std::is_copy_constructible<GoodFeatures>::value, "its memory is its own");
  static_assert(noexcept(good.select(Options()))&& noexcept(good.add(FeatureMatch())), "it throws nothing");
}

// The one call for scripts.
TEST(Select, of_blocks_is_what_a_selector_gives) {
  for (std::uint64_t variation = 0; variation < trials(20); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 150);
    for (const std::size_t budget : {std::size_t{0}, std::size_t{30}, std::size_t{150}, std::size_t{500}}) {
      const Options options = budget_of(budget);
      Selector selector(500);
      const Selection expected = selector.select(blocks, options);
      const SelectedMatches selected = select(blocks, options);
      EXPECT_EQ(selected.indices, indices_of(expected));
      EXPECT_EQ(selected.status, expected.status);
      EXPECT_EQ(selected.log_det, expected.log_det);
      EXPECT_EQ(selected.invalid, expected.invalid_candidates);
      EXPECT_TRUE(selected.has_answer);
    }
    Options wrong;
    wrong.time_limit = -1;
    const SelectedMatches selected = select(blocks, wrong);
    EXPECT_EQ(selected.status, Status::invalid_time_limit);
    EXPECT_FALSE(selected.has_answer);
    EXPECT_TRUE(selected.indices.empty());
    EXPECT_TRUE(std::isnan(selected.log_det));
  }
}

TEST(Select, of_matches_is_append_blocks_and_a_selector) {
  for (std::uint64_t variation = 0; variation < trials(30); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Kind kind = random_kind(random);
    kind.has_jacobians = false;
    const Frame frame(random, 150, kind);
    Matches matches;
    matches.size = 150;
    matches.points = frame.points.data();
    matches.sigmas = frame.sigmas.data();
    matches.has_third = frame.has_third.data();
    const bool has_covariances = kind.covariances != Kind::Covariances::none;
    if (has_covariances) matches.map_covariances = frame.covariances.data();
    SelectedMatches selected;
    if (kind.has_rig) {
      matches.camera_ids = frame.camera_ids.data();
      selected = select(Rig{frame.rig_cameras, 2}, rows_of(frame.T_cw), matches, budget_of(30), frame.options);
    } else {
      selected = select(frame.rig_cameras[0].camera, rows_of(frame.T_cw), matches, budget_of(30), frame.options);
    }
    EXPECT_EQ(selected.indices, select_indices(frame.blocks(), budget_of(30)));
    EXPECT_EQ(selected.block_status, BlockStatus::ok);
    EXPECT_EQ(selected.status, Status::ok);
    EXPECT_TRUE(selected.has_answer);
  }
}

TEST(Select, of_matches_without_blocks_has_no_answer) {
  const double points[3] = {0, 0, 5};
  Matches matches;
  matches.size = 1;
  matches.points = points;
  const SelectedMatches selected = select(camera_of(CameraModel::pinhole), RigidTransform(nullptr), matches);
  EXPECT_EQ(selected.block_status, BlockStatus::invalid_pose);
  EXPECT_FALSE(selected.has_answer);
  EXPECT_TRUE(selected.indices.empty());
}

// A view of what ends with the statement does not compile.
template <class Taken, class = void>
struct CanSelect : std::false_type {};
template <class Taken>
struct CanSelect<Taken, decltype(static_cast<void>(std::declval<Taken>().select(std::declval<const BlockStore&>(),
                                                                                Options())))> : std::true_type {};
template <class Taken, class = void>
struct HasSelection : std::false_type {};
template <class Taken>
struct HasSelection<Taken, decltype(static_cast<void>(std::declval<Taken>().selection()))> : std::true_type {};

static_assert(CanSelect<Selector&>::value && !CanSelect<Selector>::value, "Selector(10).select(...) would dangle");
static_assert(HasSelection<ActiveSelection&>::value && HasSelection<const ActiveSelection&>::value &&
                  !HasSelection<ActiveSelection>::value && !HasSelection<const ActiveSelection>::value,
              "a temporary ActiveSelection's selection() would dangle");

}  // namespace
}  // namespace maxlogdet::test
