// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory_error.hpp"

#include "bench/world/angles.hpp"
#include "tests/bench/horn_alignment.hpp"
#include "tests/bench/random_similarity.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

namespace maxlogdet::test {
namespace {

using sim::degrees;

// A flight of `seconds` at 20 poses per second, without turns.
Poses flight(double seconds, const std::function<Vector3d(double)>& position) {
  Poses poses;
  for (int i = 0; i <= static_cast<int>(20 * seconds + 1e-6); ++i) {
    poses.push_back({i / 20.0, sim::Pose(Eigen::Translation3d(position(i / 20.0)))});
  }
  return poses;
}

Vector3d on_a_curve(double t) { return {3 * std::sin(0.2 * t), 2 * std::sin(0.3 * t), std::cos(0.5 * t)}; }

// An estimate of the true motion with errors of every kind.
Poses noisy(Random& random, const Poses& truth, double noise) {
  Poses estimate = transformed(random_similarity(random), truth);
  for (sim::StampedPose& pose : estimate) {
    const Vector3d turn = random_vector(random, noise);
    pose.T_wb = pose.T_wb * Eigen::Translation3d(random_vector(random, noise)) *
                Eigen::AngleAxisd(turn.norm(), turn.normalized());
  }
  return estimate;
}

void expect_near(const sim::TrajectoryErrors& a, const sim::TrajectoryErrors& b, double tolerance) {
  EXPECT_NEAR(a.ate_m, b.ate_m, tolerance);
  EXPECT_NEAR(a.rpe_m_per_s, b.rpe_m_per_s, tolerance);
  EXPECT_NEAR(a.roe_deg_per_s, b.roe_deg_per_s, degrees * tolerance);
  EXPECT_EQ(a.windows, b.windows);
}

TEST(TrajectoryErrors, of_a_trajectory_shorter_than_a_window_have_no_drift) {
  const auto truth = flight(2.95, on_a_curve);
  auto estimate = truth;
  estimate[5].T_wb.translation()[2] += 1;
  const auto errors = sim::trajectory_errors(estimate, truth);
  EXPECT_GT(errors.ate_m, 0);
  EXPECT_EQ(errors.windows, 0U);
  EXPECT_TRUE(std::isnan(errors.rpe_m_per_s));
  EXPECT_TRUE(std::isnan(errors.roe_deg_per_s));
  EXPECT_EQ(sim::trajectory_errors(estimate, truth, 2.95).windows, 1U);
}

Poses at_times(const std::vector<double>& times) {
  Poses poses;
  for (const double time : times) poses.push_back({time, sim::Pose(Eigen::Translation3d(on_a_curve(time)))});
  return poses;
}

std::size_t windows_at(const std::vector<double>& times) {
  return sim::trajectory_errors(at_times(times), at_times(times)).windows;
}

TEST(TrajectoryErrors, leave_out_windows_over_a_gap) {
  EXPECT_EQ(windows_at({0, 1, 2, 3, 4, 5}), 3U);
  EXPECT_EQ(windows_at({0, 1, 2, 3, 7, 8, 9, 10}), 2U) << "0 to 3 and 7 to 10";
  EXPECT_EQ(windows_at({0, 1, 2, 3.5}), 1U);
  EXPECT_EQ(windows_at({0, 1, 2, 3.501}), 0U);
  EXPECT_EQ(windows_at({0, 3.6, 4, 6.6}), 1U) << "one behind the gap";
  EXPECT_EQ(windows_at({0, 1, 2, 2.9999996}), 1U) << "time stamps are rounded";
  EXPECT_EQ(windows_at({0, 1, 2, 2.999999}), 0U);
}

void expect_rejected(const Poses& a, const Poses& b, double window = 3) {
  EXPECT_THROW(sim::trajectory_errors(a, b, window), std::invalid_argument);
}

TEST(TrajectoryErrors, reject_what_does_not_correspond) {
  const auto truth = flight(5, on_a_curve);
  const auto with = [&](const std::function<void(Poses&)>& change) {
    auto poses = truth;
    change(poses);
    return poses;
  };
  EXPECT_NO_THROW(sim::trajectory_errors(truth, truth));
  const auto shorter = with([](Poses& poses) { poses.pop_back(); });
  expect_rejected(shorter, truth);
  expect_rejected(truth, shorter);
  expect_rejected({}, {});
  const auto two = with([](Poses& poses) { poses.resize(2); });
  expect_rejected(two, two);
  EXPECT_NO_THROW(sim::trajectory_errors(with([](Poses& poses) { poses[7].time += 2e-7; }), truth));
  expect_rejected(with([](Poses& poses) { poses[7].time += 2e-6; }), truth);
  const auto backwards = with([](Poses& poses) { std::swap(poses[6], poses[7]); });
  expect_rejected(backwards, backwards);
  const auto lost = with([](Poses& poses) { poses[9].T_wb.linear()(0, 0) = std::nan(""); });
  expect_rejected(lost, truth);
  expect_rejected(truth, lost);
  expect_rejected(truth, truth, 0);
  expect_rejected(truth, truth, std::nan(""));
}

// The definition, by 4 x 4 matrices, general inverses, every pair of poses, and Horn's alignment.
sim::TrajectoryErrors errors_by_definition(const Poses& estimate, const Poses& truth, double window) {
  const auto n = static_cast<Eigen::Index>(truth.size());
  Matrix3Xd from(3, n);
  Matrix3Xd to(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    from.col(i) = estimate[static_cast<std::size_t>(i)].T_wb.translation();
    to.col(i) = truth[static_cast<std::size_t>(i)].T_wb.translation();
  }
  const sim::Similarity s = horn(from, to).similarity;
  std::vector<Eigen::Matrix4d> P;
  std::vector<Eigen::Matrix4d> Q;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    Eigen::Matrix4d aligned = Eigen::Matrix4d::Identity();
    aligned.topLeftCorner<3, 3>() = s.R * estimate[i].T_wb.linear();
    aligned.topRightCorner<3, 1>() = transformed(s, Vector3d(estimate[i].T_wb.translation()));
    P.push_back(aligned);
    Q.push_back(truth[i].T_wb.matrix());
  }
  sim::TrajectoryErrors errors;
  errors.scale = s.scale;
  errors.ate_m = std::sqrt(squares(s, from, to) / static_cast<double>(n));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t j = i + 1; j < truth.size(); ++j) {
      const double time = truth[j].time - truth[i].time;
      if (time < window - 0.5e-6) continue;
      if (time <= window + 0.5) {
        const Eigen::Matrix4d drift = product(inverse(product(inverse(Q[i]), Q[j])), product(inverse(P[i]), P[j]));
        const Eigen::Matrix3d turn = drift.topLeftCorner<3, 3>();
        errors.rpe_m_per_s += drift.topRightCorner<3, 1>().norm() / time;
        errors.roe_deg_per_s += degrees * Eigen::AngleAxisd(turn).angle() / time;
        ++errors.windows;
      }
      break;
    }
  }
  errors.rpe_m_per_s /= static_cast<double>(errors.windows);
  errors.roe_deg_per_s /= static_cast<double>(errors.windows);
  return errors;
}

TEST(TrajectoryErrors, are_those_of_the_definition) {
  TracedRandom random;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    auto truth = sim::analytic_trajectory(12).poses;
    for (auto& pose : truth) pose.time += 1403636580.83856 + random.uniform(-0.02, 0.02);
    // Missing poses: single ones, and several in a row.
    for (int i = 0; i < 20; ++i) truth.erase(truth.begin() + random.integer(0, static_cast<int>(truth.size()) - 1));
    const auto gap = truth.begin() + random.integer(60, 120);
    truth.erase(gap, gap + random.integer(5, 40));
    const auto estimate = noisy(random, truth, random.uniform(0, 0.5));
    const double window = random.uniform(0.5, 4);
    const auto errors = sim::trajectory_errors(estimate, truth, window);
    const auto expected = errors_by_definition(estimate, truth, window);
    expect_near(errors, expected, 1e-10);
    EXPECT_NEAR(errors.scale, expected.scale, 1e-11 * expected.scale);
    EXPECT_GT(errors.windows, 0U);
  }
}

}  // namespace
}  // namespace maxlogdet::test
