// SPDX-License-Identifier: MIT
#include "sim/trajectory_error.hpp"

#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

namespace maxlogdet::test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Poses = std::vector<sim::StampedPose>;

constexpr double degrees = 180 / 3.14159265358979323846;

Vector3d random_vector(Random& random, double scale = 1) {
  Vector3d v;
  for (double& entry : v) entry = scale * random.uniform(-1, 1);  // in this order, unlike arguments of a call
  return v;
}

Eigen::Quaterniond random_rotation(Random& random) {
  Eigen::Vector4d q(0, 0, 0, 0);
  while (q.norm() < 0.1) q << random_vector(random), random.uniform(-1, 1);
  return Eigen::Quaterniond(q.normalized());
}

sim::Similarity random_similarity(Random& random) {
  return {std::exp(random.uniform(-2, 2)), random_rotation(random).toRotationMatrix(), random_vector(random, 10)};
}

Vector3d transformed(const sim::Similarity& s, const Vector3d& point) {
  const Vector3d turned = s.R * point;
  return s.scale * turned + s.t;
}

Matrix3Xd transformed(const sim::Similarity& s, const Matrix3Xd& points) {
  Matrix3Xd result(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) result.col(i) = transformed(s, Vector3d(points.col(i)));
  return result;
}

Poses transformed(const sim::Similarity& s, Poses poses) {
  for (sim::StampedPose& pose : poses) {
    pose.T_wb = Eigen::Translation3d(transformed(s, Vector3d(pose.T_wb.translation()))) *
                Eigen::Quaterniond(Eigen::Matrix3d(s.R * pose.T_wb.linear()));
  }
  return poses;
}

double squares(const sim::Similarity& s, const Matrix3Xd& from, const Matrix3Xd& to) {
  return (transformed(s, from) - to).squaredNorm();
}

// Points to align, of a kind: round about, on a plane, close to a line, with and without noise, or mirrored.
struct PointSets {
  std::string kind;
  Matrix3Xd from;
  Matrix3Xd to;
  sim::Similarity known;
  bool exact = false;  // known is the answer
};

PointSets random_points(Random& random) {
  struct Kind {
    const char* name;
    Vector3d extent;
    double noise;
    bool mirrored;
  };
  static const Kind kinds[] = {
      {"exact", {3, 2, 1}, 0, false},      {"noisy", {3, 2, 1}, 0.3, false},
      {"planar", {3, 2, 0}, 0, false},     {"noisy plane", {3, 2, 0}, 0.1, false},
      {"thin", {3, 0.02, 0.01}, 0, false}, {"noisy thin", {3, 0.1, 0.1}, 0.01, false},
      {"mirrored", {3, 2, 1}, 0.1, true},  {"tiny", {3e-6, 2e-6, 1e-6}, 0, false},
  };
  const Kind& kind = kinds[random.integer(0, 7)];
  PointSets sets;
  sets.kind = kind.name;
  sets.exact = kind.noise == 0 && !kind.mirrored;
  sets.known = random_similarity(random);
  const int n = random.integer(kind.mirrored ? 20 : 3, 60);
  sets.from.resize(3, n);
  sets.to.resize(3, n);
  const Eigen::Quaterniond turn = random_rotation(random);
  const Vector3d centre = kind.extent[0] * random_vector(random);
  for (int i = 0; i < n; ++i) {
    const Vector3d point = kind.extent.cwiseProduct(random_vector(random));
    const Vector3d seen = kind.mirrored ? Vector3d(point[0], point[1], -point[2]) : point;
    sets.from.col(i) = turn * point + centre;
    sets.to.col(i) = turn * seen + centre + random_vector(random, kind.noise);
  }
  // Three points that chance puts on a line leave the rotation open.
  sets.from.col(1) += turn * Vector3d(kind.extent[0], 0, 0);
  sets.to.col(1) += turn * Vector3d(kind.extent[0], 0, 0);
  sets.from.col(2) += turn * Vector3d(0, kind.extent[1], 0);
  sets.to.col(2) += turn * Vector3d(0, kind.extent[1], 0);
  sets.to = transformed(sets.known, sets.to);
  return sets;
}

struct HornAlignment {
  sim::Similarity similarity;
  double symmetric_scale = 1;
  double separation = 0;  // of the largest eigenvalue from the next, relative
};

// Horn, Closed-form solution of absolute orientation using unit quaternions, 1987.
HornAlignment horn(const Matrix3Xd& from, const Matrix3Xd& to) {
  const Vector3d from_mean = from.rowwise().mean();
  const Vector3d to_mean = to.rowwise().mean();
  const Matrix3Xd p = from.colwise() - from_mean;
  const Matrix3Xd q = to.colwise() - to_mean;
  const Eigen::Matrix3d M = product(p, q.transpose());
  Eigen::Matrix4d N;
  N << M.trace(), M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0),                    //
      M(1, 2) - M(2, 1), M(0, 0) - M(1, 1) - M(2, 2), M(0, 1) + M(1, 0), M(2, 0) + M(0, 2),   //
      M(2, 0) - M(0, 2), M(0, 1) + M(1, 0), -M(0, 0) + M(1, 1) - M(2, 2), M(1, 2) + M(2, 1),  //
      M(0, 1) - M(1, 0), M(2, 0) + M(0, 2), M(1, 2) + M(2, 1), -M(0, 0) - M(1, 1) + M(2, 2);
  const Spectrum4 of_N = spectrum(N);
  const Eigen::Vector4d w = of_N.vectors.col(3);
  HornAlignment result;
  sim::Similarity& s = result.similarity;
  s.R = Eigen::Quaterniond(w[0], w[1], w[2], w[3]).normalized().toRotationMatrix();
  s.scale = q.cwiseProduct(transformed(s, p)).sum() / p.squaredNorm();
  const Vector3d centre = transformed(s, from_mean);
  s.t = to_mean - centre;
  result.symmetric_scale = std::sqrt(q.squaredNorm() / p.squaredNorm());
  result.separation = (of_N.values[3] - of_N.values[2]) / of_N.values[3];
  return result;
}

void expect_rotation(const Eigen::Matrix3d& R) {
  EXPECT_TRUE(R.isUnitary(1e-13)) << R;
  EXPECT_GT(R.determinant(), 0) << R;
}

TEST(TrajectoryAlignment, is_that_of_horn) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(1000); trial > 0; --trial) {
    const PointSets sets = random_points(random);
    SCOPED_TRACE(sets.kind);
    const HornAlignment expected = horn(sets.from, sets.to);
    const double tolerance = 1e-12 / expected.separation;  // what rounding of the 4 x 4 matrix does to its eigenvector
    const sim::Similarity sim3 = sim::align_sim3(sets.from, sets.to);
    const sim::Similarity rigid = sim::align_rigid(sets.from, sets.to);
    expect_rotation(sim3.R);
    EXPECT_TRUE(sim3.R.isApprox(expected.similarity.R, tolerance)) << sim3.R << "\n\n" << expected.similarity.R;
    EXPECT_TRUE(rigid.R.isApprox(expected.similarity.R, tolerance));
    EXPECT_NEAR(sim3.scale, expected.similarity.scale, 1e-11 * sim3.scale);
    EXPECT_NEAR((sim3.t - expected.similarity.t).norm(), 0, tolerance * (1 + sim3.t.norm()));
    EXPECT_EQ(rigid.scale, 1);
    const Vector3d mean = sets.from.rowwise().mean();
    EXPECT_TRUE((rigid.R * mean + rigid.t).isApprox(sets.to.rowwise().mean(), 1e-12));
  }
}

TEST(TrajectoryAlignment, scales_less_than_the_ratio_of_the_spreads_by_what_it_cannot_explain) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(1000); trial > 0; --trial) {
    const PointSets sets = random_points(random);
    SCOPED_TRACE(sets.kind);
    const double scale = sim::align_sim3(sets.from, sets.to).scale;
    const double symmetric = horn(sets.from, sets.to).symmetric_scale;
    const double back = sim::align_sim3(sets.to, sets.from).scale;
    EXPECT_LE(scale, symmetric * (1 + 1e-12));
    // Both ways see the same rotation, hence the same sum of products.
    EXPECT_NEAR(scale / symmetric, back * symmetric, 1e-10);
    if (sets.exact) {
      EXPECT_NEAR(scale, symmetric, 1e-11 * scale);
    } else {
      EXPECT_LT(scale, symmetric * (1 - 1e-9));
    }
  }
}

TEST(TrajectoryAlignment, finds_what_was_applied) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(1000); trial > 0; --trial) {
    const PointSets sets = random_points(random);
    if (!sets.exact) continue;
    SCOPED_TRACE(sets.kind);
    const sim::Similarity found = sim::align_sim3(sets.from, sets.to);
    EXPECT_NEAR(found.scale, sets.known.scale, 1e-8 * sets.known.scale) << "tiny sets are rounded to 1e-9";
    EXPECT_TRUE(found.R.isApprox(sets.known.R, 1e-7));
    EXPECT_NEAR(squares(found, sets.from, sets.to), 0, 1e-20);
  }
}

TEST(TrajectoryAlignment, is_the_best_near_and_far) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(300); trial > 0; --trial) {
    const PointSets sets = random_points(random);
    SCOPED_TRACE(sets.kind);
    const sim::Similarity sim3 = sim::align_sim3(sets.from, sets.to);
    const sim::Similarity rigid = sim::align_rigid(sets.from, sets.to);
    const double spread = (sets.to.colwise() - Vector3d(sets.to.rowwise().mean())).squaredNorm();
    const double least = squares(sim3, sets.from, sets.to) - 1e-13 * spread;
    const double min_rigid = squares(rigid, sets.from, sets.to) - 1e-13 * spread;
    EXPECT_GE(squares(rigid, sets.from, sets.to), least);
    for (int i = 0; i < 50; ++i) {
      const double size = std::pow(10.0, random.uniform(-6, 0.5));
      const Vector3d axis = random_vector(random).normalized();
      const Eigen::Matrix3d turn = Eigen::AngleAxisd(size * random.uniform(-1, 1), axis).toRotationMatrix();
      const Vector3d shift = random_vector(random, size);
      const double stretch = std::exp(size * random.uniform(-1, 1));
      EXPECT_GE(squares({sim3.scale * stretch, turn * sim3.R, sim3.t + shift}, sets.from, sets.to), least);
      EXPECT_GE(squares({1, turn * rigid.R, rigid.t + shift}, sets.from, sets.to), min_rigid);
      // Turned about the centre, which moves no point far.
      const Vector3d centre = sets.to.rowwise().mean();
      EXPECT_GE(squares({sim3.scale, turn * sim3.R, turn * (sim3.t - centre) + centre}, sets.from, sets.to), least);
    }
  }
}

TEST(TrajectoryAlignment, keeps_scale_and_rotation_where_points_coincide) {
  Random random;
  SCOPED_TRACE(random.name());
  Matrix3Xd spread(3, 10);
  for (auto point : spread.colwise()) point = random_vector(random);
  const Vector3d place = random_vector(random, 100);
  const Matrix3Xd origin = Matrix3Xd::Zero(3, 10);
  Matrix3Xd together = place.replicate(1, 10);
  together(0, 3) = std::nextafter(together(0, 3), 1e9);
  const Matrix3Xd sets[] = {spread, origin, together};
  for (const Matrix3Xd& from : sets) {
    for (const Matrix3Xd& to : sets) {
      if (&from == &to && &from == &sets[0]) continue;
      for (const auto& align : {sim::align_sim3, sim::align_rigid}) {
        const sim::Similarity found = align(from, to);
        EXPECT_EQ(found.scale, 1);
        EXPECT_TRUE(found.R.isIdentity(0));
        EXPECT_NEAR((found.t - (to.rowwise().mean() - from.rowwise().mean())).norm(), 0, 1e-12);
      }
    }
  }
}

TEST(TrajectoryAlignment, of_points_on_a_line_brings_the_lines_together) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(300); trial > 0; --trial) {
    const int n = random.integer(3, 20);
    const Vector3d a = random_vector(random, 5);
    const Vector3d b = random_vector(random, 5);
    const Vector3d along_a = random.chance(0.3) ? Vector3d(Vector3d::UnitX()) : random_vector(random).normalized();
    const Vector3d along_b = random.chance(0.3) ? Vector3d(-along_a) : random_vector(random).normalized();
    Matrix3Xd from(3, n);
    Matrix3Xd to(3, n);
    for (int i = 0; i < n; ++i) {
      from.col(i) = a + (i + random.uniform(0, 0.5)) * along_a;
      to.col(i) = b + 2 * (from.col(i) - a).norm() * along_b;
    }
    const sim::Similarity found = sim::align_sim3(from, to);
    expect_rotation(found.R);
    EXPECT_NEAR(found.scale, 2, 1e-12);
    EXPECT_NEAR((found.R * along_a - along_b).norm(), 0, 1e-12);
    EXPECT_NEAR(squares(found, from, to), 0, 1e-20);
    expect_rotation(sim::align_rigid(from, to).R);
  }
}

TEST(TrajectoryAlignment, of_what_has_nothing_in_common_is_a_similarity) {
  // Sums of products are exactly 0 in all directions: the best scale is 0, and any rotation does.
  Matrix3Xd from(3, 4);
  from << 1, -1, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0;
  Matrix3Xd to(3, 4);
  to << 1, 1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0;
  const sim::Similarity found = sim::align_sim3(from, to);
  expect_rotation(found.R);
  EXPECT_EQ(found.scale, 0);
  EXPECT_TRUE(found.t.isZero(0));
}

TEST(TrajectoryAlignment, rejects_what_does_not_correspond) {
  const Matrix3Xd three = Matrix3Xd::Random(3, 3);
  const Matrix3Xd two = three.leftCols(2);
  Matrix3Xd not_finite = three;
  not_finite(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(sim::align_sim3(three, three));
  EXPECT_THROW(sim::align_sim3(three, two), std::invalid_argument);
  EXPECT_THROW(sim::align_rigid(two, two), std::invalid_argument);
  EXPECT_THROW(sim::align_sim3(Matrix3Xd(3, 0), Matrix3Xd(3, 0)), std::invalid_argument);
  EXPECT_THROW(sim::align_sim3(not_finite, three), std::invalid_argument);
  EXPECT_THROW(sim::align_rigid(three, not_finite), std::invalid_argument);
}

// A flight of `seconds` at 20 poses a second, through places and with yaw as told.
Poses flight(
    double seconds, const std::function<Vector3d(double)>& position,
    const std::function<double(double)>& yaw = [](double) { return 0.0; }) {
  Poses poses;
  for (int i = 0; i <= static_cast<int>(20 * seconds + 1e-6); ++i) {
    const double t = i / 20.0;
    poses.push_back({t, Eigen::Translation3d(position(t)) * sim::Pose(Eigen::AngleAxisd(yaw(t), Vector3d::UnitZ()))});
  }
  return poses;
}

Vector3d on_a_curve(double t) { return {3 * std::sin(0.2 * t), 2 * std::sin(0.3 * t), std::cos(0.5 * t)}; }

// Real motion and an estimate whose errors are of every kind.
Poses noisy(Random& random, const Poses& truth, double noise = 0.05) {
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

void expect_zero(const sim::TrajectoryErrors& errors, double tolerance = 1e-12) {
  EXPECT_NEAR(errors.ate_m, 0, tolerance);
  EXPECT_NEAR(errors.rpe_m_per_s, 0, tolerance);
  EXPECT_NEAR(errors.roe_deg_per_s, 0, degrees * tolerance);
}

TEST(TrajectoryErrors, of_a_trajectory_with_itself_are_zero) {
  const auto poses = sim::analytic_trajectory().poses;
  const auto errors = sim::trajectory_errors(poses, poses);
  expect_zero(errors);
  EXPECT_NEAR(errors.scale, 1, 1e-14);
  EXPECT_EQ(errors.windows, 1141U) << "1201 poses, the last 60 without a window";
}

TEST(TrajectoryErrors, do_not_see_a_scale) {
  auto estimate = sim::analytic_trajectory().poses;
  const auto truth = estimate;
  for (auto& pose : estimate) pose.T_wb.translation() *= 2;
  const auto errors = sim::trajectory_errors(estimate, truth);
  expect_zero(errors);
  EXPECT_NEAR(errors.scale, 0.5, 1e-14);
}

TEST(TrajectoryErrors, of_four_poses_by_hand) {
  // Along a line: x = -3, -1, 1, 3 m; the estimate leaves it by y = 1, -1, -1, 1 m, which no similarity explains.
  // Squares of x sum to 20, of y to 4, products to 0: the best scale is 20 / 24, and 20 * 4 / 24 is what remains of the
  // squares.
  Poses truth;
  Poses estimate;
  for (const auto& [x, y] : {std::pair{-3, 1}, {-1, -1}, {1, -1}, {3, 1}}) {
    const double time = (x + 3) / 2.0;
    truth.push_back({time, sim::Pose(Eigen::Translation3d(x, 0, 0))});
    estimate.push_back({time, sim::Pose(Eigen::Translation3d(x, y, 0))});
  }
  const auto errors = sim::trajectory_errors(estimate, truth);
  EXPECT_NEAR(errors.scale, 5.0 / 6, 1e-15);
  EXPECT_NEAR(errors.ate_m, std::sqrt(5.0 / 6), 1e-15);
  EXPECT_EQ(errors.windows, 1U);
  EXPECT_NEAR(errors.rpe_m_per_s, (6 - 5) / 3.0, 1e-15) << "from first to last: 6 m, by the estimate 6 * 5 / 6";
  EXPECT_NEAR(errors.roe_deg_per_s, 0, 1e-12);
  // Windows of 1 s: along the line 2 m by the truth and 5/3 m by the estimate, across it 5/3, 0 and 5/3 m.
  const auto short_windows = sim::trajectory_errors(estimate, truth, 1);
  EXPECT_EQ(short_windows.windows, 3U);
  EXPECT_NEAR(short_windows.rpe_m_per_s, (2 * std::sqrt(26.0) + 1) / 9, 1e-15);
}

TEST(TrajectoryErrors, of_a_yaw_that_drifts_are_its_rate) {
  const double rate = 0.5 / degrees;  // 0.5 deg/s
  const auto yaw = [](double t) { return 0.4 * std::sin(t); };
  const auto truth = flight(20, on_a_curve, yaw);
  const auto estimate = flight(20, on_a_curve, [&](double t) { return yaw(t) + rate * t; });
  const auto errors = sim::trajectory_errors(estimate, truth);
  EXPECT_NEAR(errors.ate_m, 0, 1e-12);
  EXPECT_NEAR(errors.roe_deg_per_s, 0.5, 1e-10);
  EXPECT_EQ(errors.windows, 341U);
}

TEST(TrajectoryErrors, of_a_yaw_that_drifts_are_seen_in_its_own_frame) {
  // Motion straight on at 0.7 m/s: seen from a pose whose yaw is wrong by a, it goes wrong by 2 sin(a / 2) times
  // itself.
  const double rate = 2 / degrees;
  const auto ahead = [](double t) { return Vector3d(0.7 * t, 0, 1); };
  const auto errors = sim::trajectory_errors(flight(10, ahead, [&](double t) { return rate * t; }), flight(10, ahead));
  double expected = 0;
  for (int i = 0; i <= 140; ++i) expected += 0.7 * 2 * std::sin(rate * i / 20 / 2) / 141;
  EXPECT_NEAR(errors.ate_m, 0, 1e-12);
  EXPECT_NEAR(errors.roe_deg_per_s, 2, 1e-10);
  EXPECT_NEAR(errors.rpe_m_per_s, expected, 1e-12);
  EXPECT_EQ(errors.windows, 141U);
}

TEST(TrajectoryErrors, of_a_jump_are_its_size_over_the_windows_with_it) {
  // The truth jumps up between its poses 99 and 100 of 200, the estimate does not. Motion is level, and the same before
  // the jump as backwards after it: neither scale nor rotation can explain any of it, and half of the jump remains.
  const double jump = 0.3;
  const auto level = [](double t) {
    const double s = std::abs(t - 4.975);
    return Vector3d(s, 0.2 * s * s, 0);
  };
  const auto estimate = flight(9.95, level);
  const auto truth =
      flight(9.95, [&](double t) -> Vector3d { return level(t) + Vector3d(0, 0, t > 4.975 ? jump : 0); });
  const auto errors = sim::trajectory_errors(estimate, truth);
  EXPECT_NEAR(errors.scale, 1, 1e-13);
  EXPECT_NEAR(errors.ate_m, jump / 2, 1e-13);
  EXPECT_EQ(errors.windows, 140U);
  EXPECT_NEAR(errors.rpe_m_per_s, 60 * jump / 3 / 140, 1e-13);
  EXPECT_NEAR(errors.roe_deg_per_s, 0, 1e-12);
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

TEST(TrajectoryErrors, are_over_the_time_that_a_window_takes) {
  const auto truth = at_times({0, 1, 2, 3.5});
  auto estimate = truth;
  estimate[3].T_wb.linear() = Eigen::AngleAxisd(7 / degrees, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_NEAR(sim::trajectory_errors(estimate, truth).roe_deg_per_s, 2, 1e-12);
}

TEST(TrajectoryErrors, of_a_camera_that_stands_still_are_finite) {
  const auto still = flight(5, [](double) { return Vector3d(1, 2, 3); });
  expect_zero(sim::trajectory_errors(still, still));
  const auto moving = flight(5, [](double t) { return Vector3d(0.1 * t, 0, 0); });
  const auto errors = sim::trajectory_errors(moving, still);
  EXPECT_EQ(errors.scale, 1);
  EXPECT_NEAR(errors.rpe_m_per_s, 0.1, 1e-12);
  const auto missed = sim::trajectory_errors(still, moving);
  EXPECT_NEAR(missed.rpe_m_per_s, 0.1, 1e-12);
  EXPECT_NEAR(missed.ate_m, errors.ate_m, 1e-12);
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

TEST(TrajectoryErrors, do_not_depend_on_the_frame_and_scale_of_the_estimate) {
  Random random;
  SCOPED_TRACE(random.name());
  const auto truth = sim::analytic_trajectory(20).poses;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    const auto estimate = noisy(random, truth);
    const sim::Similarity moved = random_similarity(random);
    const auto errors = sim::trajectory_errors(estimate, truth);
    const auto same = sim::trajectory_errors(transformed(moved, estimate), truth);
    EXPECT_GT(errors.ate_m, 1e-3);
    EXPECT_GT(errors.roe_deg_per_s, 0.1);
    expect_near(same, errors, 1e-11);
    EXPECT_NEAR(same.scale * moved.scale, errors.scale, 1e-11 * errors.scale);
  }
}

TEST(TrajectoryErrors, do_not_depend_on_the_frame_of_both) {
  Random random;
  SCOPED_TRACE(random.name());
  const auto truth = sim::analytic_trajectory(20).poses;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    const auto estimate = noisy(random, truth);
    sim::Similarity moved = random_similarity(random);
    moved.scale = 1;
    const auto errors = sim::trajectory_errors(estimate, truth);
    const auto same = sim::trajectory_errors(transformed(moved, estimate), transformed(moved, truth));
    expect_near(same, errors, 1e-11);
    EXPECT_NEAR(same.scale, errors.scale, 1e-11 * errors.scale);
  }
}

// The definition once more, with 4 x 4 matrices, general inverses, every pair of poses, and Horn's alignment.
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
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    auto truth = sim::analytic_trajectory(12).poses;
    for (auto& pose : truth) pose.time += 1403636580.83856 + random.uniform(-0.02, 0.02);
    // Poses that are missing: some alone, and some in a row.
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

TEST(RealTrajectoryErrors, of_the_truth_in_another_frame_are_zero) {
  const std::string folder = data_folder() + "/euroc_ground_truth";
  std::error_code error;
  if (data_folder().empty() || !std::filesystem::is_directory(folder, error)) GTEST_SKIP() << no_real_frames;
  Random random;
  SCOPED_TRACE(random.name());
  const auto trajectories = sim::read_trajectories(folder);
  EXPECT_EQ(trajectories.size(), 11U);
  for (const auto& trajectory : trajectories) {
    SCOPED_TRACE(trajectory.name);
    const auto itself = sim::trajectory_errors(trajectory.poses, trajectory.poses);
    expect_zero(itself);
    EXPECT_NEAR(itself.scale, 1, 1e-13);
    EXPECT_GT(itself.windows, trajectory.poses.size() * 9 / 10);
    const sim::Similarity moved = random_similarity(random);
    const auto errors = sim::trajectory_errors(transformed(moved, trajectory.poses), trajectory.poses);
    expect_zero(errors, 1e-11);
    EXPECT_NEAR(errors.scale * moved.scale, 1, 1e-12);
    EXPECT_EQ(errors.windows, itself.windows);
  }
}

TEST(TrajectoryErrors, a_rigid_alignment_keeps_an_error_of_scale) {
  Poses truth(20), estimate;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].time = static_cast<double>(i);
    truth[i].T_wb = sim::Pose::Identity();
    truth[i].T_wb.translation() = Eigen::Vector3d(static_cast<double>(i), 0.1 * static_cast<double>(i * i), 0);
  }
  estimate = truth;
  for (sim::StampedPose& pose : estimate) pose.T_wb.translation() *= 1.1;
  EXPECT_NEAR(sim::trajectory_errors(estimate, truth, 1).rpe_m_per_s, 0, 1e-12);
  const auto rigid = sim::trajectory_errors(estimate, truth, 1, sim::TrajectoryAlignment::rigid);
  EXPECT_EQ(rigid.scale, 1);
  double expected = 0;  // a tenth of what is travelled
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    expected += 0.1 * (truth[i + 1].T_wb.translation() - truth[i].T_wb.translation()).norm() / 19;
  }
  EXPECT_NEAR(rigid.rpe_m_per_s, expected, 1e-12);
}

}  // namespace
}  // namespace maxlogdet::test
