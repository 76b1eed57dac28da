// SPDX-License-Identifier: MIT
// The guide's code that belongs to no tracker, run: a tracker of one's own, priors, batches, one memory a thread; and
// what it says of budgets and weightings.
#include "tests/api/integration/general_snippets.hpp"

#include "sim/scene.hpp"
#include "sim/se3.hpp"
#include "tests/api/integration/oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/recording.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <set>
#include <thread>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Pose;

// d xi / d delta of  T_cw(delta) = exp(xi^) T_cw,  by central differences.
template <class Perturb>
Matrix6 jacobian_of(const Pose& T_cw, const Perturb& perturbed) {
  constexpr double step = 1e-6;
  Matrix6 A;
  for (int i = 0; i < 6; ++i) {
    const Vector6 d = step * Vector6::Unit(i);
    A.col(i) =
        (sim::log_se3(perturbed(d) * T_cw.inverse()) - sim::log_se3(perturbed(-d) * T_cw.inverse())) / (2 * step);
  }
  return A;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& vector) {
  return sim::exp_se3((Vector6() << Eigen::Vector3d::Zero(), vector).finished()).linear();
}

Pose transform(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Pose T = Pose::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

void expect_same_information(const Matrix6& prior, const Matrix6& covariance, const Matrix6& A) {
  EXPECT_LT(relative_difference(prior, inverse(product(product(A, covariance), A.transpose()))), 1e-5);
}

TEST(PriorGuide, g2o_counts_rotation_first) {
  Random random;
  SCOPED_TRACE(random.name());
  const Pose T_cw = test::random_pose(random);
  const Matrix6 hessian = random_prior(random);
  const Matrix6 A = jacobian_of(T_cw, [&](const Vector6& d) {  // d = (rotation, translation)
    return Pose(sim::exp_se3((Vector6() << d.tail<3>(), d.head<3>()).finished()) * T_cw);
  });
  expect_same_information(prior_of_g2o(hessian), inverse(hessian), A);
  EXPECT_GT((prior_of_g2o(hessian) - hessian).norm(), 0.1 * hessian.norm());
}

TEST(PriorGuide, body_poses_of_vins_fusion_openvins_and_basalt) {
  Random random;
  SCOPED_TRACE(random.name());
  for (int n = 0; n < 10; ++n) {
    const Pose T_cb = test::random_pose(random);
    const Pose T_wb = test::random_pose(random);
    const Pose T_cw = T_cb * T_wb.inverse();
    const Matrix6 covariance = random_prior(random);

    const Matrix6 vins = jacobian_of(T_cw, [&](const Vector6& d) {
      const Pose moved = transform(T_wb.linear() * rotation(d.tail<3>()), T_wb.translation() + d.head<3>());
      return Pose(T_cb * moved.inverse());
    });
    const Eigen::Matrix3d R_cw = T_cw.linear();
    const Matrix6 prior = prior_of_body_pose(covariance, T_cb.translation(), R_cw, T_cb.linear());
    expect_same_information(prior, covariance, vins);

    const Matrix6 openvins = jacobian_of(T_cw, [&](const Vector6& d) {  // a JPL error: R_GtoI <- (I - [d]x) R_GtoI
      const Eigen::Matrix3d R_GtoI = rotation(-d.tail<3>()) * T_wb.linear().transpose();
      return Pose(T_cb * transform(R_GtoI.transpose(), T_wb.translation() + d.head<3>()).inverse());
    });
    expect_same_information(prior, covariance, openvins);

    const Matrix6 basalt = jacobian_of(T_cw, [&](const Vector6& d) {
      const Pose moved = transform(rotation(d.tail<3>()) * T_wb.linear(), T_wb.translation() + d.head<3>());
      return Pose(T_cb * moved.inverse());
    });
    expect_same_information(prior_of_body_pose(covariance, T_cb.translation(), R_cw, R_cw), covariance, basalt);
  }
}

// As the guide's reader has it: matches of whom every seventh is wrong, a third with a right column.
struct OwnTracker {
  OwnTracker(Random& random, std::size_t n) : T_cw(test::random_pose(random)) {
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d p_c = random_point_in_camera(random);
      const Eigen::Vector3d p_w = T_cw.inverse() * p_c;
      TrackedMatch match{};
      for (int d = 0; d < 3; ++d) match.point[d] = static_cast<float>(p_w(d));
      match.sigma = static_cast<float>(1 + i % 3);
      const double u = camera.fx * p_c.x() / p_c.z() + camera.cx;
      match.pixel[0] = static_cast<float>(u + (i % 7 == 0 ? 10 * match.sigma : 0));
      match.pixel[1] = static_cast<float>(camera.fy * p_c.y() / p_c.z() + camera.cy);
      match.u_right = i % 3 == 0 ? static_cast<float>(u - camera.bf / p_c.z()) : -1;
      match.is_outlier = random.chance(0.5);
      matches.push_back(match);
    }
  }
  PinholeCamera camera = {458, 457, 367, 248, 50};
  Pose T_cw;
  std::vector<TrackedMatch> matches;
};

TEST(OwnTrackerGuide, the_selected_are_optimised_with_and_the_others_judged_at_the_new_pose) {
  Random random;
  SCOPED_TRACE(random.name());
  OwnTracker tracker(random, 400);
  const std::vector<TrackedMatch> before = tracker.matches;
  const Pose guess = sim::exp_se3((Vector6() << 0.2, 0.2, 0, 0, 0.1, 0).finished()) * tracker.T_cw;
  std::set<std::size_t> selected;
  GoodFeatures good(1000);
  track(good, tracker.camera, guess, tracker.matches, [&](const Selection& selection) {
    selected.insert(selection.begin(), selection.end());
    return RigidTransform(tracker.T_cw);
  });
  EXPECT_EQ(selected.size(), 200U);
  for (std::size_t i = 0; i < 400; ++i) {
    EXPECT_EQ(tracker.matches[i].is_outlier, before[i].is_outlier || (selected.count(i) == 0 && i % 7 == 0)) << i;
  }
}

TEST(OwnTrackerGuide, all_are_optimised_with_when_there_is_no_selection) {
  Random random;
  SCOPED_TRACE(random.name());
  OwnTracker tracker(random, 400);
  std::size_t optimised = 0;
  GoodFeatures good(1000);
  track(good, tracker.camera, nullptr, tracker.matches, [&](const Selection& selection) {
    optimised = selection.size;
    return RigidTransform(nullptr);
  });
  EXPECT_EQ(optimised, 400U);
  EXPECT_STREQ(good.reason(), "invalid_pose");
}

void gather(const sim::Frame& frame, GoodFeatures& good) {
  good.start(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()));
  for (const sim::Match& m : frame.matches) {
    FeatureMatch match(m.point, Eigen::Vector2d(m.u, m.v), 1 / std::sqrt(m.inv_sigma2));
    match.u_right = m.u_right;
    good.add(match);
  }
}

TEST(BudgetGuide, of_synthetic_frames_100_of_1000_matches_keep_a_fifth_to_a_third_of_the_information) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 1000, Random().seed());
  GoodFeatures good(1000);
  gather(frame, good);
  ASSERT_EQ(good.select(100).status, Status::ok);
  EXPECT_GT(good.efficiency(), 0.2);
  EXPECT_LT(good.efficiency(), 0.34);
}

TEST(BudgetGuide, a_budget_in_accuracy_takes_as_many_matches_as_the_accuracy_needs) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 1000, Random().seed());
  GoodFeatures good(1000);
  gather(frame, good);
  Options options = budget_in_accuracy();
  ASSERT_EQ(good.select(options).status, Status::target_reached);
  const std::size_t needed = good.selection().size;
  EXPECT_LT(needed, options.budget);
  EXPECT_GE(good.efficiency(), 0.7 - 1e-9);
  options.budget = needed - 1;
  gather(frame, good);
  ASSERT_EQ(good.select(options).status, Status::ok);
}

// GoodFeatures and a Selector select the same, and no two matches of a cell.
TEST(BudgetGuide, spread_over_the_image_no_cell_has_more_than_one_match) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 1000, Random().seed());
  GoodFeatures good(1000);
  spread_over_image(good);
  gather(frame, good);
  std::vector<double> uv;
  for (const sim::Match& match : frame.matches) uv.insert(uv.end(), {match.u, match.v});
  Options options = with_budget(100);
  ASSERT_EQ(good.select(options).status, Status::ok);
  EXPECT_EQ(good.selection().size, 100U);

  ImageCells cells(1000);
  spread_over_image(cells, uv, options);
  std::vector<int> selected_of_cell(cells.count());
  for (std::size_t i = 0; i < good.size(); ++i) selected_of_cell[cells.groups()[i]] += good.is_selected(i) ? 1 : 0;
  EXPECT_EQ(cells.count(), 150U);
  EXPECT_LE(*std::max_element(selected_of_cell.begin(), selected_of_cell.end()), 1);
  Selector selector(1000);
  const Selection selection = selector.select(good.blocks(), options);
  ASSERT_EQ(selection.size, 100U);
  for (const std::uint32_t i : selection) EXPECT_TRUE(good.is_selected(i)) << i;
}

// Points that were seen once in stereo, and their covariances.
struct StereoMap {
  PinholeCamera camera = {718, 718, 607, 185, 386};
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Matrix3d> covariances;
};

// 6 to 400 m away, as many of each disparity as of any other.
StereoMap random_stereo_map(Random& random, std::size_t n) {
  StereoMap map;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = map.camera.bf / random.uniform(1, 60);
    const double x = random.uniform(-0.8, 0.8) * z;
    const double y = random.uniform(-0.2, 0.2) * z;
    map.points.emplace_back(x, y, z);
    PointCovariance point(map.points.back().data());
    point.observe(map.camera, RigidTransform::identity(), 1, true);
    map.covariances.emplace_back();
    EXPECT_TRUE(point.covariance(map.covariances.back().data()));
  }
  return map;
}

// What 50 selected points tell, errors of the map and of measurements counted, nats.
double log_det_of_selected(const StereoMap& map, bool with_covariances) {
  GoodFeatures good(map.points.size());
  good.block_options.weighting = with_covariances ? Weighting::measurement : Weighting::map_bias;
  good.start(map.camera, RigidTransform::identity());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    FeatureMatch match(map.points[i]);
    match.u_right = 0;  // which rows there are; their values change no block
    if (with_covariances) match.covariance = map.covariances[i].data();
    good.add(match);
  }
  EXPECT_EQ(good.select(50).status, Status::ok);
  Matrix6 information = Matrix6::Zero();
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    if (!good.is_selected(i)) continue;
    information += information_of({map.points[i], map.camera.bf, map.camera.fx, map.camera.fy, 1, map.covariances[i]});
  }
  return log_det(information);
}

TEST(WeightingGuide, of_a_stereo_map_covariances_select_the_points_that_tell_more_of_the_pose) {
  Random random;
  SCOPED_TRACE(random.name());
  for (int world = 0; world < 40; ++world) {
    const StereoMap map = random_stereo_map(random, 300);
    EXPECT_GT(log_det_of_selected(map, true), log_det_of_selected(map, false)) << "world " << world;
  }
}

TEST(WeightingGuide, rows_that_are_weighed_have_the_information_of_the_blocks) {
  Random random;
  SCOPED_TRACE(random.name());
  const PinholeCamera camera = {458, 457, 367, 248, 50};
  const double covariance[9] = {0.2, 0.01, 0, 0.01, 0.3, 0, 0, 0, 0.5};
  const SeenPoint seen = {random_point_in_camera(random),
                          camera.bf,
                          camera.fx,
                          camera.fy,
                          2,
                          Eigen::Map<const Eigen::Matrix3d>(covariance)};
  GoodFeatures good(1);
  good.start(camera, RigidTransform::identity());
  FeatureMatch match(seen.p_c, 2);
  match.u_right = 0;
  match.covariance = covariance;
  good.add(match);
  Eigen::Matrix<double, 3, 6> H = Derivatives(seen).H_x;
  const Eigen::Matrix<double, 3, 6> before = H;
  Eigen::Vector3d e(1, 2, 3);
  weigh_rows(good, 0, 2, e, H);
  EXPECT_LT(relative_difference(gram(H), information_of(seen)), 1e-6);
  // e is whitened alike.
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> W;
  ASSERT_TRUE(good.whitening(0, W.data()));
  EXPECT_LT(relative_difference(e, product(W, Eigen::Vector3d(1, 2, 3))), 1e-12);
  H = before;
  weigh_rows(good, 1, 2, e, H);  // there is none
  EXPECT_LT(relative_difference(H, before / 2), 1e-12);
}

TEST(ActiveGuide, batches_are_answered_until_enough_are_found) {
  Random random;
  SCOPED_TRACE(random.name());
  BlockStore blocks(300);
  for (int i = 0; i < 300; ++i) blocks.push_back(random_block(random, 2, 1).data(), 2);
  ActiveSelection active(300);
  Options options;
  options.budget = 50;
  ASSERT_EQ(active.start(blocks, options), Error::none);
  std::vector<std::uint32_t> tried, found;
  match_in_batches(active, [&](const std::uint32_t* indices, std::size_t count, unsigned char* was_found) {
    for (std::size_t j = 0; j < count; ++j) {
      was_found[j] = random.chance(0.5) ? 1 : 0;
      tried.push_back(indices[j]);
      if (was_found[j] != 0) found.push_back(indices[j]);
    }
  });
  EXPECT_EQ(found.size(), 50U);
  EXPECT_EQ(std::set<std::uint32_t>(tried.begin(), tried.end()).size(), tried.size()) << "one was tried twice";
  const Selection selection = active.selection();
  EXPECT_EQ(std::vector<std::uint32_t>(selection.begin(), selection.end()), found);
}

TEST(ActiveGuide, points_are_tried_until_enough_are_found_and_judged_by_what_was_measured) {
  Random random;
  SCOPED_TRACE(random.name());
  const Camera camera(458, 457, 367, 248);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i) points.push_back(random_point_in_camera(random));
  std::vector<std::uint32_t> found;
  std::set<std::size_t> tried;
  GoodFeatures good(300);
  const auto find = [&](std::size_t i, double* pixel) {
    EXPECT_TRUE(tried.insert(i).second) << "tried twice";
    if (random.chance(0.4) || !project(camera, points[i].data(), pixel)) return false;
    pixel[0] += found.size() % 3 == 0 ? 50 : 0;
    found.push_back(static_cast<std::uint32_t>(i));
    return true;
  };
  const Selection matched = match_actively(good, camera, RigidTransform::identity(), points, find);
  EXPECT_EQ(matched.status, Status::ok);
  EXPECT_EQ(std::vector<std::uint32_t>(matched.begin(), matched.end()), found);
  EXPECT_EQ(found.size(), 100U);
  EXPECT_EQ(good.outliers(RigidTransform::identity()).size(), 0U) << "all that are matched are selected";
  const Selection selected = good.select(20);
  ASSERT_EQ(selected.size, 20U);
  for (const std::uint32_t i : selected) EXPECT_EQ(std::count(found.begin(), found.end(), i), 1);
  std::size_t wrong = 0;
  for (std::size_t j = 0; j < found.size(); ++j) wrong += j % 3 == 0 && !good.is_selected(found[j]) ? 1 : 0;
  EXPECT_EQ(good.outliers(RigidTransform::identity()).size(), wrong);
  EXPECT_EQ(good.select(1000).status, Status::all_selected);
  EXPECT_EQ(good.selection().size, 100U) << "what was not matched is not selected";
}

TEST(OwnTrackerGuide, more_options_and_own_types) {
  Random random;
  SCOPED_TRACE(random.name());
  const OwnPose identity = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  GoodFeatures good(400);
  good.start(Camera(458, 457, 367, 248), identity);
  std::vector<unsigned char> excluded(400, 0);
  std::vector<std::uint32_t> cells;
  for (std::uint32_t i = 0; i < 400; ++i) {
    good.add(random_point_in_camera(random));
    excluded[i] = i % 4 == 0 ? 1 : 0;
    cells.push_back(i % 48);
  }
  const Selection selection = select_more(good, excluded, cells);
  EXPECT_TRUE(selection.has_answer());
  std::vector<int> of_cell(48);
  for (const std::uint32_t i : selection) {
    EXPECT_NE(i % 4, 0U);
    EXPECT_LE(++of_cell[i % 48], 2);
  }
  if (selection.status == Status::deadline_reached) return;
  EXPECT_GT(selection.certified_efficiency(), 0.9);
  EXPECT_EQ(selection.size, 72U) << "36 cells are not excluded";
}

TEST(OwnTrackerGuide, own_jacobians) {
  Random random;
  SCOPED_TRACE(random.name());
  std::vector<Eigen::Matrix<double, 2, 6>> jacobians;
  for (int i = 0; i < 300; ++i) jacobians.emplace_back(Eigen::Matrix<double, 2, 6>(random_block(random, 2, 1)));
  BlockStore blocks(300);
  Selector selector(300);
  EXPECT_EQ(select_rows(jacobians, blocks, selector).size, 100U);
}

TEST(RecordGuide, frames_are_written_into_the_folder) {
  const TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  GoodFeatures good(1000);
  EXPECT_TRUE(record_frames(good));
  gather(make_scene(sim::Scene::euroc_like, 300, Random().seed()), good);
  EXPECT_EQ(good.select(Options()).status, Status::ok);
  std::filesystem::current_path(before);
  EXPECT_EQ(RecordedFrame(folder / "frames/frame_000000.csv").rows.size(), 300U);
}

TEST(ThreadsGuide, each_thread_has_its_own_memory) {
  const GoodFeatures* other = nullptr;
  const GoodFeatures* const mine = &good_features_of_this_thread();
  std::thread([&] { other = &good_features_of_this_thread(); }).join();
  EXPECT_NE(other, mine);
  EXPECT_EQ(mine, &good_features_of_this_thread());
}

}  // namespace
}  // namespace maxlogdet::test
