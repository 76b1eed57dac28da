// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/observability.hpp"

#include "tests/bench/selector_cases.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

using sim::Matrix12;
using sim::ObservabilitySelection;
using Rows12 = Eigen::Matrix<double, Eigen::Dynamic, 12>;

constexpr double step = 1e-6;

Eigen::Vector2d project(const Frame& frame, const Pose& T_cw, const sim::Match& match) {
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  return {frame.camera.fx * p.x() / p.z() + frame.camera.cx, frame.camera.fy * p.y() / p.z() + frame.camera.cy};
}

Eigen::Matrix<double, 2, 6> derivative_of_projection(const Frame& frame, const Pose& T_cw, const sim::Match& match) {
  Eigen::Matrix<double, 2, 6> H;
  for (int j = 0; j < 6; ++j) {
    const Vector6 xi = step * Vector6::Unit(j);
    H.col(j) =
        (project(frame, sim::exp_se3(xi) * T_cw, match) - project(frame, sim::exp_se3(-xi) * T_cw, match)) / (2 * step);
  }
  return H;
}

// Propagation of an error of pose and velocity in a step T <- exp(v^) T, differentiated numerically.
Matrix12 derivative_of_motion(const Vector6& v) {
  const auto error_after = [&](const Vector6& pose, const Vector6& velocity) {
    return sim::log_se3(sim::exp_se3(v + velocity) * sim::exp_se3(pose) * sim::exp_se3(-v));
  };
  Matrix12 F = Matrix12::Identity();
  for (int j = 0; j < 6; ++j) {
    const Vector6 xi = step * Vector6::Unit(j), none = Vector6::Zero();
    F.block<6, 1>(0, j) = (error_after(xi, none) - error_after(-xi, none)) / (2 * step);
    F.block<6, 1>(0, 6 + j) = (error_after(none, xi) - error_after(none, -xi)) / (2 * step);
  }
  return F;
}

// [H; H F] of every segment: the first ends at the frame's pose, each other where the one before begins.
std::vector<Rows12> observability_rows(const Frame& frame, const Indices& candidates, const std::vector<Pose>& before) {
  std::vector<Rows12> rows(candidates.size(), Rows12(0, 12));
  Pose end = sim::pose_of(frame.T_cw_prior);
  for (std::size_t segment = 0; segment < std::max<std::size_t>(1, before.size()); ++segment) {
    const Pose begin = before.empty() ? end : before[segment];
    const Matrix12 F = derivative_of_motion(sim::log_se3(end * begin.inverse()));
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      Eigen::Matrix<double, 2, 12> H = Eigen::Matrix<double, 2, 12>::Zero();
      H.leftCols<6>() = derivative_of_projection(frame, end, frame.matches[candidates[c]]);
      rows[c].conservativeResize(rows[c].rows() + 4, 12);
      rows[c].bottomRows<4>() << H, H * F;
    }
    end = begin;
  }
  return rows;
}

double smallest_singular_value(const Rows12& rows) { return rows.rows() < 12 ? 0 : singular_values(rows)[11]; }

Rows12 stacked(const Rows12& above, const Rows12& below) {
  Rows12 both(above.rows() + below.rows(), 12);
  both << above, below;
  return both;
}

TEST(Observability, information_is_that_of_rows_differentiated_numerically) {
  TracedRandom random;
  for (const int poses : {0, 1, 2, 3, 5}) {
    const Frame frame = make_scene(sim::Scene::euroc_like, 60, random.seed());
    const Indices candidates = some_of(random, frame);
    std::vector<Pose> before = poses_before(random, frame, poses);
    ObservabilitySelection selection;
    for (auto pose = before.rbegin(); pose != before.rend(); ++pose) selection.add_pose(*pose);
    before.resize(std::min<std::size_t>(before.size(), 3));  // the last three segments count
    const auto rows = observability_rows(frame, candidates, before);
    const auto information = selection.information(frame, candidates);
    ASSERT_EQ(information.size(), candidates.size());
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      EXPECT_LT(relative_difference(information[c], gram(rows[c])), 1e-7) << poses << " poses";
    }
  }
}

TEST(Observability, a_match_behind_the_camera_has_no_information) {
  Frame frame = make_scene(sim::Scene::euroc_like, 10, 1);
  const Eigen::Vector3d behind = sim::pose_of(frame.T_cw_prior).inverse() * Eigen::Vector3d(0.1, 0.2, -3);
  for (int i = 0; i < 3; ++i) frame.matches[4].point[i] = behind[i];
  const auto information = ObservabilitySelection().information(frame, {3, 4});
  EXPECT_GT(information[0].norm(), 0);
  EXPECT_EQ(information[1].norm(), 0);
}

// Decomposes each candidate of the same samples: none is better than the selected one by more than the error of
// numerical derivatives.
void expect_best_of_samples(const Frame& frame, const Indices& candidates, const std::vector<Pose>& before,
                            std::size_t k, double epsilon, std::uint64_t seed) {
  ObservabilitySelection selection;
  for (auto pose = before.rbegin(); pose != before.rend(); ++pose) selection.add_pose(*pose);
  sim::Draws draws(seed), same_draws(seed);
  const Indices selected = selection.select(frame, candidates, k, epsilon, draws);
  ASSERT_EQ(selected.size(), k);
  const auto rows = observability_rows(frame, candidates, before);
  const double share = static_cast<double>(candidates.size()) / static_cast<double>(k);
  const auto sample = static_cast<std::size_t>(std::ceil(share * std::log(1 / epsilon)));
  Indices remaining(candidates.size());
  std::iota(remaining.begin(), remaining.end(), 0U);
  Rows12 stack(0, 12);
  for (const std::uint32_t chosen : selected) {
    const std::size_t looked_at = std::min(sample, remaining.size());
    same_draws.shuffle_front(remaining, looked_at);
    double best = 0;
    std::size_t winner = looked_at;
    for (std::size_t r = 0; r < looked_at; ++r) {
      best = std::max(best, smallest_singular_value(stacked(stack, rows[remaining[r]])));
      if (candidates[remaining[r]] == chosen) winner = r;
    }
    ASSERT_LT(winner, looked_at) << "not of the sample";
    stack = stacked(stack, rows[remaining[winner]]);
    EXPECT_GT(smallest_singular_value(stack), best * (1 - 1e-6) - 1e-6 * stack.norm());
    std::swap(remaining[winner], remaining.back());
    remaining.pop_back();
  }
}

TEST(Observability, selects_the_best_of_every_sample) {
  TracedRandom random;
  for (std::size_t trial = trials(6); trial > 0; --trial) {
    const Frame frame = make_scene(sim::Scene::euroc_like, 60, random.seed() + trial);
    const Indices candidates = some_of(random, frame);
    for (const int poses : {0, 1, 3}) {
      expect_best_of_samples(frame, candidates, poses_before(random, frame, poses), 15, 0.2, random.seed());
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
