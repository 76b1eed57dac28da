// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/observability.hpp"

#include "bench/world/scene.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::uint32_t>;
using sim::Frame;
using sim::Matrix12;
using sim::Pose;
using Rows12 = Eigen::Matrix<double, Eigen::Dynamic, 12>;

constexpr double step = 1e-6;

Eigen::Vector2d project(const Frame& frame, const Pose& T_cw, const sim::Match& match) {
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  return {frame.camera.fx * p.x() / p.z() + frame.camera.cx, frame.camera.fy * p.y() / p.z() + frame.camera.cy};
}

Eigen::Matrix<double, 2, 12> derivative_of_projection(const Frame& frame, const Pose& T_cw, const sim::Match& match) {
  Eigen::Matrix<double, 2, 12> H = Eigen::Matrix<double, 2, 12>::Zero();
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

// A frame, some of its matches, and its camera's earlier poses, the last one first.
struct Case {
  Frame frame;
  Indices candidates;
  std::vector<Pose> before;

  Case(Random& random, int poses, std::uint64_t seed) : frame(make_scene(sim::Scene::euroc_like, 60, seed)) {
    for (std::uint32_t i = 0; i < 60; ++i) {
      if (random.chance(0.7)) candidates.push_back(i);
    }
    Pose T = sim::pose_of(frame.T_cw_prior);
    for (int i = 0; i < poses; ++i) {
      Vector6 v;
      for (double& entry : v) entry = random.uniform(-0.05, 0.05);
      T = sim::exp_se3(v) * T;
      before.push_back(T);
    }
  }

  sim::ObservabilitySelection selection() const {
    sim::ObservabilitySelection selection;
    for (auto pose = before.rbegin(); pose != before.rend(); ++pose) selection.add_pose(*pose);
    return selection;
  }

  // [H; H F] of the last three segments: the first ends at the frame's pose, each other where the one before begins.
  std::vector<Rows12> rows() const {
    std::vector<Rows12> rows(candidates.size(), Rows12(0, 12));
    Pose end = sim::pose_of(frame.T_cw_prior);
    for (std::size_t segment = 0; segment < std::clamp<std::size_t>(before.size(), 1, 3); ++segment) {
      const Pose begin = before.empty() ? end : before[segment];
      const Matrix12 F = derivative_of_motion(sim::log_se3(end * begin.inverse()));
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        const auto H = derivative_of_projection(frame, end, frame.matches[candidates[c]]);
        rows[c].conservativeResize(rows[c].rows() + 4, 12);
        rows[c].bottomRows<4>() << H, H * F;
      }
      end = begin;
    }
    return rows;
  }
};

TEST(Observability, information_is_that_of_rows_differentiated_numerically) {
  TracedRandom random;
  for (const int poses : {0, 1, 2, 3, 5}) {
    const Case given(random, poses, random.seed());
    const auto rows = given.rows();
    const auto information = given.selection().information(given.frame, given.candidates);
    ASSERT_EQ(information.size(), given.candidates.size());
    for (std::size_t c = 0; c < rows.size(); ++c) {
      EXPECT_LT(relative_difference(information[c], gram(rows[c])), 1e-7) << poses << " poses";
    }
  }
}

// Decomposes each candidate of the same samples, of ceil(n / k ln(1 / epsilon)): none is better than the selected one.
TEST(Observability, selects_the_best_of_every_sample) {
  TracedRandom random;
  constexpr std::size_t k = 15;
  for (std::size_t trial = 3 * trials(6); trial > 0; --trial) {
    const Case given(random, static_cast<int>(trial % 3), random.seed() + trial);
    sim::Draws draws(trial), same_draws(trial);
    const Indices selected = given.selection().select(given.frame, given.candidates, k, 0.2, draws);
    ASSERT_EQ(selected.size(), k);
    const auto information = given.selection().information(given.frame, given.candidates);
    const auto n = static_cast<double>(given.candidates.size());
    const auto sample = static_cast<std::size_t>(std::ceil(n / static_cast<double>(k) * std::log(5)));
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

}  // namespace
}  // namespace maxlogdet::test
