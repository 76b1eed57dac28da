// SPDX-License-Identifier: MIT
// Section V of the paper: the simulated world against its options, observability against numerical derivatives, a run
// against its steps by hand, tables by hand.
#include "bench/does_the_paper_hold/tracking.hpp"
#include "bench/world/hash.hpp"
#include "bench/world/scene.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

using sim::MappedWorld;
using sim::Matrix12;
using sim::PoseTracker;
using sim::SelectorKind;
using sim::WorldOptions;
using Indices = Subset;

// A flight at 20 poses per second through a room, on a smooth curve of up to 1 m/s and 40 deg/s; cam0 looks ahead.
sim::Trajectory flight(double seconds) {
  Eigen::Matrix3d ahead;  // camera axes in a frame of x forward, y left, z up
  ahead << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  sim::Trajectory trajectory{"flight", {}};
  for (int i = 0; i <= static_cast<int>(20 * seconds + 1e-6); ++i) {
    const double t = i / 20.0;
    const Eigen::Translation3d at(3.0 * std::sin(0.22 * t + 1.2), 2.1 * std::sin(0.33 * t),
                                  1.5 + 0.6 * std::sin(0.55 * t));
    const Eigen::Vector3d turn(0.15 * std::sin(1.1 * t), 0.12 * std::sin(0.9 * t + 0.5), 2.3 * std::sin(0.28 * t));
    const Pose T_wc = at * Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) * Eigen::Quaterniond(ahead);
    trajectory.poses.push_back({t, T_wc * sim::euroc_T_bc().inverse()});
  }
  return trajectory;
}

Pose camera_pose(const sim::Trajectory& trajectory, std::size_t i) {
  return (trajectory.poses.at(i).T_wb * sim::euroc_T_bc()).inverse();
}

WorldOptions small_world() {
  WorldOptions options;
  options.landmarks = 4000;
  options.max_matches = 250;
  return options;
}

WorldOptions perfect_world() {
  WorldOptions options = small_world();
  options.outlier_rate = options.pixel_sigma = 0;
  options.batch_translation = options.batch_rotation_deg = options.batch_scale = 0;
  options.depth_sigma = options.lateral_sigma = 0;
  return options;
}

// Calls body(world, frame) for every frame of a flight.
template <class Body>
void for_every_frame(double seconds, const WorldOptions& options, std::uint64_t seed, const Body& body) {
  const sim::Trajectory trajectory = flight(seconds);
  MappedWorld world(trajectory, options, seed);
  Frame frame;
  while (world.next(frame)) body(world, frame);
}

Eigen::Vector2d pixel_of(const Pose& T_cw, const Eigen::Vector3d& point, const PinholeCamera& camera) {
  const Eigen::Vector3d p = T_cw * point;
  return {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy};
}

double distance_between(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

// Outliers are far off in a world of little noise. The nearer a landmark, the larger it is in the image, and the higher
// its octave.
TEST(MappedWorld, pixels_have_the_noise_of_their_octave_and_outliers_their_rate_and_size) {
  WorldOptions options = small_world();
  options.outlier_rate = 0.2;
  options.pixel_sigma = 0.1;
  std::vector<double> squares(8, 0), counts(8, 0);
  double matches = 0, outliers = 0;
  for_every_frame(10, options, 1, [&](const MappedWorld& world, const Frame& frame) {
    EXPECT_NEAR(static_cast<double>(frame.matches.size()), 150, 100);
    for (const Match& match : frame.matches) {
      const auto& landmark = world.landmarks()[static_cast<std::size_t>(match.map_point_id)];
      const double depth = (world.true_T_cw() * landmark.position).z();
      const double octave = landmark.octave + std::log(landmark.reference_depth / depth) / std::log(1.2);
      ASSERT_NEAR(match.octave, std::clamp(octave, 0.0, 7.0), 0.5 + 1e-9);
      EXPECT_NEAR(match.inv_sigma2, std::pow(1.2, -2.0 * match.octave), 1e-12);
      const Eigen::Vector2d pixel = pixel_of(world.true_T_cw(), landmark.position, sim::euroc_camera);
      ASSERT_NEAR(pixel.x(), 376, 376 - 16) << "no corner is near the border";
      ASSERT_NEAR(pixel.y(), 240, 240 - 16);
      const double error = (pixel - Eigen::Vector2d(match.u, match.v)).norm();
      ++matches;
      if (error > 4.9) {  // 13 standard deviations
        ++outliers;
        ASSERT_NEAR(error, 22.5, 17.5 + 1e-9);
        continue;
      }
      const auto place = static_cast<std::size_t>(match.octave);
      squares[place] += std::pow(error / (0.1 * std::pow(1.2, match.octave)), 2);
      counts[place] += 2;
    }
  });
  EXPECT_NEAR(outliers, 0.2 * matches, 5 * std::sqrt(0.16 * matches));
  for (std::size_t octave = 0; octave < 8; ++octave) {
    ASSERT_GT(counts[octave], 100) << octave;
    EXPECT_NEAR(squares[octave] / counts[octave], 1, 5 * std::sqrt(2 / counts[octave])) << octave;
  }
}

// The points that a keyframe maps are moved by one similarity: fits it, in the keyframe's frame, to those of the first.
TEST(MappedWorld, errors_of_keyframes_have_the_deviations_of_the_options) {
  WorldOptions options = small_world();
  options.landmarks = 1000;
  options.depth_sigma = options.lateral_sigma = 0;
  Eigen::Array3d squares(0, 0, 0);  // of translation, rotation and scale, over their expectations
  const auto seeds = static_cast<std::uint64_t>(trials(300));
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    for_every_frame(0, options, seed, [&](const MappedWorld& world, const Frame&) {
      Eigen::Matrix3Xd from(3, 0), to(3, 0);
      for (const auto& landmark : world.landmarks()) {
        if (landmark.batch != 1) continue;
        from.conservativeResize(3, from.cols() + 1);
        to.conservativeResize(3, to.cols() + 1);
        from.rightCols<1>() = world.true_T_cw() * landmark.position;
        to.rightCols<1>() = world.true_T_cw() * landmark.mapped;
      }
      ASSERT_GT(from.cols(), 5);
      const Eigen::Matrix4d moved = Eigen::umeyama(from, to);
      EXPECT_LT((moved.topRows<3>() * from.colwise().homogeneous() - to).colwise().norm().maxCoeff(), 1e-9);
      const double scale = moved.block<3, 1>(0, 0).norm();
      const Eigen::Matrix3d R = moved.topLeftCorner<3, 3>() / scale;
      const Vector6 xi = sim::log_se3(Eigen::Translation3d(moved.topRightCorner<3, 1>()) * Eigen::Quaterniond(R));
      squares +=
          Eigen::Array3d(xi.head<3>().squaredNorm() / (3 * std::pow(options.batch_translation, 2)),
                         xi.tail<3>().squaredNorm() / (3 * std::pow(options.batch_rotation_deg * sim::radians, 2)),
                         std::pow((scale - 1) / options.batch_scale, 2));
    });
  }
  const auto n = static_cast<double>(seeds);
  for (const double square : squares) EXPECT_NEAR(square / n, 1, 5 * std::sqrt(2 / n));
}

// A frame, some of its matches, and its camera's earlier poses, the last one first.
struct Observed {
  Frame frame;
  Indices candidates;
  std::vector<Pose> before;
  sim::ObservabilitySelection selection;

  Observed(Random& random, int poses, std::uint64_t seed) : frame(make_scene(sim::Scene::euroc_like, 60, seed)) {
    for (std::uint32_t i = 0; i < 60; ++i) {
      if (random.chance(0.7)) candidates.push_back(i);
    }
    Pose T = sim::pose_of(frame.T_cw_prior);
    for (int i = 0; i < poses; ++i) {
      Vector6 v;
      for (double& entry : v) entry = random.uniform(-0.05, 0.05);
      before.push_back(T = sim::exp_se3(v) * T);
    }
    std::for_each(before.rbegin(), before.rend(), [&](const Pose& pose) { selection.add_pose(pose); });
  }

  // The pixel of a match a step before `end`, if the errors of pose and velocity there were x; and at `end`.
  Eigen::Vector4d pixels(const Match& match, const Pose& end, const Vector6& v, const Eigen::VectorXd& x) const {
    const Vector6 pose = x.head<6>(), velocity = v + x.tail<6>();
    const Pose now = sim::exp_se3(pose) * end;
    const Pose next = sim::exp_se3(velocity) * sim::exp_se3(pose) * sim::exp_se3(-v) * end;
    const Eigen::Vector3d point(match.point);
    Eigen::Vector4d uv;
    uv << pixel_of(now, point, frame.camera), pixel_of(next, point, frame.camera);
    return uv;
  }

  // The sum of O^T O over the last three segments, O = [H; H F] differentiated numerically.
  Eigen::MatrixXd information(const Match& match) const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(12, 12);
    Pose end = sim::pose_of(frame.T_cw_prior);
    for (std::size_t segment = 0; segment < std::clamp<std::size_t>(before.size(), 1, 3); ++segment) {
      const Pose begin = before.empty() ? end : before[segment];
      const Vector6 v = sim::log_se3(end * begin.inverse());
      Eigen::Matrix<double, 4, 12> O;
      for (int j = 0; j < 12; ++j) {
        const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(12, j);
        O.col(j) = (pixels(match, end, v, step) - pixels(match, end, v, -step)) / 2e-6;
      }
      sum += gram(O);
      end = begin;
    }
    return sum;
  }
};

// Decomposes each candidate of the same samples, of ceil(n / k ln(1 / epsilon)): none is better than the selected one.
TEST(Observability, information_is_that_of_rows_differentiated_numerically_and_the_best_of_a_sample_is_selected) {
  TracedRandom random;
  constexpr std::size_t k = 15;
  for (const int poses : {0, 1, 2, 3, 5}) {
    SCOPED_TRACE(std::to_string(poses) + " poses");
    const Observed given(random, poses, random.seed() + static_cast<std::uint64_t>(poses));
    const auto information = given.selection.information(given.frame, given.candidates);
    ASSERT_EQ(information.size(), given.candidates.size());
    for (std::size_t c = 0; c < information.size(); ++c) {
      const Eigen::MatrixXd expected = given.information(given.frame.matches[given.candidates[c]]);
      EXPECT_LT(relative_difference(information[c], expected), 1e-7);
    }
    sim::Draws draws(random.seed()), same_draws(random.seed());
    const Indices selected = given.selection.select(given.frame, given.candidates, k, 0.2, draws);
    ASSERT_EQ(selected.size(), k);
    const auto sample = static_cast<std::size_t>(std::ceil(static_cast<double>(information.size()) / 15 * std::log(5)));
    Indices remaining(given.candidates.size());
    std::iota(remaining.begin(), remaining.end(), 0U);
    Matrix12 Q = Matrix12::Zero();
    for (const std::uint32_t chosen : selected) {
      same_draws.shuffle_front(remaining, sample);
      const auto end = remaining.begin() + static_cast<std::ptrdiff_t>(std::min(sample, remaining.size()));
      const auto winner = std::find_if(remaining.begin(), end, [&](auto r) { return given.candidates[r] == chosen; });
      ASSERT_NE(winner, end) << "not of the sample";
      // The smallest singular value of a symmetric matrix that is positive is its smallest eigenvalue.
      const double reached = singular_values(Q + information[*winner])[11];
      for (auto r = remaining.begin(); r != end; ++r) {
        const Matrix12 other = Q + information[*r];
        EXPECT_GE(reached, singular_values(other)[11] - 1e-12 * other.trace());
      }
      Q += information[*winner];
      *winner = remaining.back();
      remaining.pop_back();
    }
  }
}

constexpr std::size_t budget = 40;

TEST(PoseTracker, is_exact_in_a_perfect_world_and_follows_its_prediction_without_matches) {
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    std::vector<Pose> poses = {camera_pose(flight(0), 0)};
    PoseTracker tracker(sim::paper_selector(kind, budget), poses[0]);
    const sim::Trajectory trajectory = flight(2);
    for_every_frame(2, perfect_world(), 1, [&](const MappedWorld& world, Frame frame) {
      EXPECT_LT(distance_between(world.true_T_cw(), camera_pose(trajectory, poses.size() - 1)), 1e-9);
      const bool is_blind = poses.size() > 10 && poses.size() < 14;
      if (is_blind) frame.matches.resize(poses.size() == 11 ? 0 : PoseTracker::min_inliers - 1);
      if (poses.size() > 1) {
        const Pose &last = poses.back(), &before = poses[poses.size() - 2];
        // The rotation of EuRoC's camera is given to 12 digits.
        EXPECT_LT(distance_between(tracker.predict(), last * before.inverse() * last), 1e-11);
      }
      const Pose prediction = tracker.predict();
      const sim::TrackedFrame tracked = tracker.track(frame);
      EXPECT_EQ(tracked.is_tracked, !is_blind);
      // A step below 1e-6 is not taken.
      EXPECT_LT(distance_between(tracked.T_cw, is_blind ? prediction : world.true_T_cw()), is_blind ? 1e-15 : 1e-5);
      if (!is_blind) {
        EXPECT_EQ(tracked.selected.size(), has_budget(kind) ? budget : frame.matches.size());
      }
      poses.push_back(tracked.T_cw);
    });
    EXPECT_EQ(poses.size(), 42U);
  }
}

// The pipeline of section V, step by step: of selectors that draw nothing.
TEST(Tracking, a_run_is_its_steps_by_hand) {
  const sim::Trajectory trajectory = flight(5);
  const std::vector<SelectorKind> kinds = {SelectorKind::md, SelectorKind::inl, SelectorKind::all};
  std::vector<sim::SelectorSettings> selectors;
  for (const SelectorKind kind : kinds) selectors.push_back(sim::paper_selector(kind, budget));
  const auto outcomes = run_tracking(small_world(), selectors, trajectory, 5, 2);
  EXPECT_NE(run_tracking(small_world(), selectors, trajectory, 5, 3)[0].errors.ate_m, outcomes[0].errors.ate_m);
  for (std::size_t c = 0; c < kinds.size(); ++c) {
    SCOPED_TRACE(to_string(kinds[c]));
    std::vector<sim::StampedPose> estimate;
    Pose before = camera_pose(trajectory, 0), last = before;
    double matches = 0, used = 0;
    const std::uint64_t seed = sim::Draws(5 ^ sim::hash_of("flight"), 2).bits();
    for_every_frame(5, small_world(), seed, [&](const MappedWorld&, const Frame& frame) {
      sim::RejectionOptions options;
      options.step_tolerance = 1e-6;
      Pose T = sim::orthonormal(last * before.inverse() * last);
      Indices chosen = all_matches(frame);
      matches += static_cast<double>(chosen.size());
      if (kinds[c] != SelectorKind::all) {
        const sim::Rejection of_all = reject_outliers(frame.camera, frame.matches, chosen, T, options);
        T = of_all.estimate.T_cw;
        chosen = of_all.inliers;
      }
      if (kinds[c] == SelectorKind::md && chosen.size() > budget) {
        Frame aligned = frame;
        aligned.T_cw_prior = sim::to_rows(T);
        chosen = selected_by_library(aligned, chosen, with_budget(budget));
      }
      used += static_cast<double>(chosen.size());
      T = reject_outliers(frame.camera, frame.matches, chosen, T, options).estimate.T_cw;
      before = std::exchange(last, T);
      estimate.push_back({trajectory.poses[estimate.size()].time, T.inverse() * sim::euroc_T_bc().inverse()});
    });
    const auto expected = sim::trajectory_errors(estimate, trajectory.poses);
    EXPECT_NEAR(outcomes[c].errors.ate_m, expected.ate_m, 1e-9);
    EXPECT_NEAR(outcomes[c].errors.rpe_m_per_s, expected.rpe_m_per_s, 1e-9);
    EXPECT_NEAR(outcomes[c].errors.roe_deg_per_s, expected.roe_deg_per_s, 1e-7);
    EXPECT_GT(expected.ate_m, 1e-4);
    const auto frames = static_cast<double>(trajectory.poses.size());
    EXPECT_NEAR(outcomes[c].matches, matches / frames, 1e-9);
    EXPECT_NEAR(outcomes[c].used, used / frames, 1e-9);
    EXPECT_EQ(outcomes[c].lost, 0U);
    EXPECT_GT(outcomes[c].ms[2], 0);
  }
}

// Two sequences, two runs; in RPE md is worse than all in A and better in B, in ROE vice versa. In percent of the
// other's mean: RPEs of inl are 0.25 in both runs, of md 0.15 and 0.25. Differences are -40 and 0 %.
TEST(TrackingTables, have_means_over_runs_and_sequences_and_the_intervals_of_pairs) {
  const auto outcome_of = [](double rpe, double roe, double ate) {
    return sim::TrackingOutcome{{ate, rpe, roe, 1}, {rpe, 0.25, 2}, 0, 0, 1};
  };
  const sim::TrackingRuns runs = {{"md", "inl", "all"},
                                  {"A", "B"},
                                  {{{outcome_of(0.2, 1, 1), outcome_of(0.3, 4, 3), outcome_of(0.2, 2, 2)},
                                    {outcome_of(0.4, 1, 3), outcome_of(0.3, 4, 3), outcome_of(0.1, 2, 2)}},
                                   {{outcome_of(0.1, 3, 1), outcome_of(0.2, 1, 3), outcome_of(0.3, 2, 2)},
                                    {outcome_of(0.1, 5, 1), outcome_of(0.2, 3, 3), outcome_of(0.3, 2, 2)}}}};
  EXPECT_EQ(sim::to_csv(sequences_table(runs)),
            "sequence,selector,rpe_m_per_s,roe_deg_per_s,ate_m\n"
            "A,md,0.3000,1.000,2.0000\nA,inl,0.3000,4.000,3.0000\nA,all,0.1500,2.000,2.0000\n"
            "B,md,0.1000,4.000,1.0000\nB,inl,0.2000,2.000,3.0000\nB,all,0.3000,2.000,2.0000\n");
  // Means of runs 0.15 and 0.25: Student's 12.7062 times their deviation over the root of 2.
  const sim::Table means = means_table(runs);
  EXPECT_EQ(means.header.size(), 15U);
  EXPECT_EQ(sim::to_csv({means.rows[0], {means.rows[1]}}),
            "md,0.20000,0.63531,2.50000,6.35310,1.50000,6.35310,1,1,0.1500,-0.2000,1,1,2.000,-1.000\n"
            "inl,0.25000,0.00000,3.00000,6.35310,3.00000,0.00000,1,1,0.1500,-0.1000,1,0,2.000,\n");
  EXPECT_EQ(sim::to_csv(differences_table(runs, {"md"}, {"md", "inl", "all"})),
            "selector,against,error,difference_percent,ci95,verdict\n"
            "md,inl,RPE,-20.0,254.1,open\nmd,inl,ROE,-16.7,0.0,better\nmd,inl,ATE,-50.0,211.8,open\n"
            "md,all,RPE,-11.1,423.5,open\nmd,all,ROE,25.0,317.7,open\nmd,all,ATE,-25.0,317.7,open\n");
  EXPECT_EQ(sim::to_csv({times_table(runs).rows[0], {}}), "md,0.200,0.250,2.000,2.450,0,0,4\n");
}

}  // namespace
}  // namespace maxlogdet::test
