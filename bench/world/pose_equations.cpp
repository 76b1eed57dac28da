// SPDX-License-Identifier: MIT
#include "bench/world/pose_equations.hpp"

#include "bench/world/projection.hpp"

#include <cmath>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A pinhole at a pose, in plain doubles.
struct View {
  View(const PinholeCamera& camera, const Pose& T_cw, bool uses_stereo)
      : fx(camera.fx), fy(camera.fy), cx(camera.cx), cy(camera.cy), baseline(camera.bf / camera.fx) {
    for (int i = 0; i < 12; ++i) T[i] = T_cw.matrix()(i / 4, i % 4);
    stereo = uses_stereo;
  }

  double fx, fy, cx, cy;
  double baseline;  // m
  double T[12];     // 3 x 4 row-major
  bool stereo;
};

// A match seen from a view.
struct Sight {
  double x, y;       // X / Z, Y / Z
  double inverse_z;  // 1 / Z
  double right;      // (X - baseline) / Z: x in the right camera
  bool has_right;    // the right-image column counts
  double error[3];   // z - h, px
};

// Returns false where the point is not in front of the camera, or not a number.
inline bool look(const View& view, const Match& match, Sight& sight) {
  const double* const T = view.T;
  const double* const p = match.point;
  const double Z = T[8] * p[0] + T[9] * p[1] + T[10] * p[2] + T[11];
  if (!(Z > 0) || !(match.inv_sigma2 > 0 && match.inv_sigma2 < infinity)) return false;
  sight.inverse_z = 1 / Z;
  sight.x = (T[0] * p[0] + T[1] * p[1] + T[2] * p[2] + T[3]) * sight.inverse_z;
  sight.y = (T[4] * p[0] + T[5] * p[1] + T[6] * p[2] + T[7]) * sight.inverse_z;
  sight.right = sight.x - view.baseline * sight.inverse_z;
  sight.has_right = view.stereo && !(match.u_right < 0);  // NaN is no missing column but a bad one
  sight.error[0] = match.u - (view.fx * sight.x + view.cx);
  sight.error[1] = match.v - (view.fy * sight.y + view.cy);
  sight.error[2] = sight.has_right ? match.u_right - (view.fx * sight.right + view.cx) : 0;
  return true;
}

inline double squared_norm(const double (&e)[3]) { return e[0] * e[0] + e[1] * e[1] + e[2] * e[2]; }

// rho(s) and its derivative.
struct Loss {
  double weight;
  double rho;
};

inline Loss huber(double s, double threshold) {
  if (s <= threshold * threshold) return {1, s};
  const double e = std::sqrt(s);
  return {threshold / e, 2 * threshold * e - threshold * threshold};
}

// Adds a row a = (1/Z, 0, -q/Z, -q y, 1 + q x, -y): u with q = x, u_right with q = (X - baseline) / Z, both over fx.
inline void add_column(PoseSums& sums, const Sight& at, double q, double weight, double weighted_error) {
  const double a0 = at.inverse_z;
  const double a2 = -q * at.inverse_z;
  const double a3 = -q * at.y;
  const double a4 = 1 + q * at.x;
  const double a5 = -at.y;
  const double w0 = weight * a0;
  const double w2 = weight * a2;
  const double w3 = weight * a3;
  const double w4 = weight * a4;
  const double w5 = weight * a5;
  sums.h[0] += w0 * a0;
  sums.h[2] += w0 * a2;
  sums.h[3] += w0 * a3;
  sums.h[4] += w0 * a4;
  sums.h[5] += w0 * a5;
  sums.h[11] += w2 * a2;
  sums.h[12] += w2 * a3;
  sums.h[13] += w2 * a4;
  sums.h[14] += w2 * a5;
  sums.h[15] += w3 * a3;
  sums.h[16] += w3 * a4;
  sums.h[17] += w3 * a5;
  sums.h[18] += w4 * a4;
  sums.h[19] += w4 * a5;
  sums.h[20] += w5 * a5;
  sums.g[0] += weighted_error * a0;
  sums.g[2] += weighted_error * a2;
  sums.g[3] += weighted_error * a3;
  sums.g[4] += weighted_error * a4;
  sums.g[5] += weighted_error * a5;
}

// Adds the row of v over fy: (0, 1/Z, -y/Z, -(1 + y^2), x y, x).
inline void add_line(PoseSums& sums, const Sight& at, double weight, double weighted_error) {
  const double a1 = at.inverse_z;
  const double a2 = -at.y * at.inverse_z;
  const double a3 = -(1 + at.y * at.y);
  const double a4 = at.x * at.y;
  const double a5 = at.x;
  const double w1 = weight * a1;
  const double w2 = weight * a2;
  const double w3 = weight * a3;
  const double w4 = weight * a4;
  const double w5 = weight * a5;
  sums.h[6] += w1 * a1;
  sums.h[7] += w1 * a2;
  sums.h[8] += w1 * a3;
  sums.h[9] += w1 * a4;
  sums.h[10] += w1 * a5;
  sums.h[11] += w2 * a2;
  sums.h[12] += w2 * a3;
  sums.h[13] += w2 * a4;
  sums.h[14] += w2 * a5;
  sums.h[15] += w3 * a3;
  sums.h[16] += w3 * a4;
  sums.h[17] += w3 * a5;
  sums.h[18] += w4 * a4;
  sums.h[19] += w4 * a5;
  sums.h[20] += w5 * a5;
  sums.g[1] += weighted_error * a1;
  sums.g[2] += weighted_error * a2;
  sums.g[3] += weighted_error * a3;
  sums.g[4] += weighted_error * a4;
  sums.g[5] += weighted_error * a5;
}

void add_row(PoseSums& sums, const double (&a)[6], double weight, double error) {
  double* h = sums.h;
  for (int i = 0; i < 6; ++i) {
    sums.g[i] += weight * error * a[i];
    for (int j = i; j < 6; ++j) *h++ += weight * a[i] * a[j];
  }
}

// One pass with measurement noise alone: the hot loop.
PoseSums add_up(const PoseProblem& problem, const View& seen_from) {
  const View view = seen_from;  // copies on the stack: the sums cannot alias them
  const double threshold_2 = problem.options.huber_monocular > 0 ? problem.options.huber_monocular : infinity;
  const double threshold_3 = problem.options.huber_stereo > 0 ? problem.options.huber_stereo : infinity;
  const double fx_2 = view.fx * view.fx;
  const double fy_2 = view.fy * view.fy;
  PoseSums sums;
  for (const std::uint32_t i : problem.subset) {
    const Match& match = problem.matches[i];
    Sight at;
    if (!look(view, match, at)) continue;
    const double s = match.inv_sigma2 * squared_norm(at.error);
    if (!(s < infinity)) continue;
    const Loss loss = huber(s, at.has_right ? threshold_3 : threshold_2);
    const double weight = loss.weight * match.inv_sigma2;
    add_column(sums, at, at.x, weight * fx_2, weight * view.fx * at.error[0]);
    add_line(sums, at, weight * fy_2, weight * view.fy * at.error[1]);
    if (at.has_right) add_column(sums, at, at.right, weight * fx_2, weight * view.fx * at.error[2]);
    sums.rho += loss.rho;
    ++sums.used;
  }
  return sums;
}

// One pass with a whitening for each match.
PoseSums add_up_whitened(const PoseProblem& problem, const View& view) {
  PoseSums sums;
  for (const std::uint32_t i : problem.subset) {
    const Match& match = problem.matches[i];
    Sight at;
    if (!look(view, match, at)) continue;
    const Whitening& whitening = problem.whitenings[i];
    double* const e = at.error;
    whitening.apply(e[0], e[1], e[2]);
    const double s = squared_norm(at.error);
    if (!(s < infinity)) continue;
    const Loss loss = huber(s, problem.threshold(at.has_right));
    const double x = at.x;
    const double y = at.y;
    const double q = at.right;
    const double z = at.inverse_z;
    double u[6] = {view.fx * z, 0, -view.fx * x * z, -view.fx * x * y, view.fx * (1 + x * x), -view.fx * y};
    double v[6] = {0, view.fy * z, -view.fy * y * z, -view.fy * (1 + y * y), view.fy * x * y, view.fy * x};
    double r[6] = {view.fx * z, 0, -view.fx * q * z, -view.fx * q * y, view.fx * (1 + q * x), -view.fx * y};
    for (int column = 0; column < 6; ++column) whitening.apply(u[column], v[column], r[column]);
    add_row(sums, u, loss.weight, e[0]);
    add_row(sums, v, loss.weight, e[1]);
    if (at.has_right) add_row(sums, r, loss.weight, e[2]);
    sums.rho += loss.rho;
    ++sums.used;
  }
  return sums;
}

// One pass with cameras of any model, or depths.
PoseSums add_up_any(const PoseProblem& problem, const Pose& T_cw) {
  PoseSums sums;
  LinearizedMatch at;
  for (const std::uint32_t i : problem.subset) {
    const Match& match = problem.matches[i];
    if (!linearize(problem.camera, T_cw, match, problem.options.stereo, at)) continue;
    const Whitening whitening =
        problem.whitenings.empty() ? measurement_whitening(problem.camera, match) : problem.whitenings[i];
    Eigen::Vector3d& e = at.residual;
    whitening.apply(e[0], e[1], e[2]);
    if (!(e.squaredNorm() < infinity)) continue;
    for (int column = 0; column < 6; ++column) whitening.apply(at.H_x(0, column), at.H_x(1, column), at.H_x(2, column));
    const Loss loss = huber(e.squaredNorm(), problem.threshold(at.rows == 3));
    for (int row = 0; row < at.rows; ++row) {
      const Vector6 a = at.H_x.row(row);
      add_row(sums, {a[0], a[1], a[2], a[3], a[4], a[5]}, loss.weight, e[row]);
    }
    sums.rho += loss.rho;
    ++sums.used;
  }
  return sums;
}

SquaredError whitened_square(const Whitening* whitening, double inv_sigma2, double (&e)[3], bool has_depth_cue) {
  if (whitening == nullptr) return {inv_sigma2 * squared_norm(e), has_depth_cue};
  whitening->apply(e[0], e[1], e[2]);
  return {squared_norm(e), has_depth_cue};
}

SquaredError squared_error_of_any(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
                                  const Whitening* whitening) {
  LinearizedMatch at;
  if (!linearize(camera, T_cw, match, stereo, at)) return {infinity, false};
  const Whitening of_measurement = measurement_whitening(camera, match);
  double e[3] = {at.residual[0], at.residual[1], at.residual[2]};
  return whitened_square(whitening == nullptr ? &of_measurement : whitening, 1, e, at.rows == 3);
}

}  // namespace

PoseSums add_up(const PoseProblem& problem, const Pose& T_cw) {
  if (!problem.camera.is_pinhole()) return add_up_any(problem, T_cw);
  const View view(problem.camera, T_cw, problem.options.stereo);
  return problem.whitenings.empty() ? add_up(problem, view) : add_up_whitened(problem, view);
}

Matrix6 to_matrix(const PoseSums& sums) {
  Matrix6 result;
  const double* h = sums.h;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) result(i, j) = result(j, i) = *h++;
  }
  return result;
}

SquaredError squared_error(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
                           const Whitening* whitening) {
  if (!camera.is_pinhole()) return squared_error_of_any(camera, T_cw, match, stereo, whitening);
  Sight at;
  if (!look(View(camera, T_cw, stereo), match, at)) return {infinity, false};
  return whitened_square(whitening, match.inv_sigma2, at.error, at.has_right);
}

double rho_after_step(const PoseProblem& problem, const Pose& from, const Pose& to) {
  double sum = 0;
  for (const std::uint32_t i : problem.subset) {
    const auto error_at = [&](const Pose& T_cw) {
      return squared_error(problem.camera, T_cw, problem.matches[i], problem.options.stereo, problem.whitening(i));
    };
    if (!(error_at(from).value < infinity)) continue;
    const SquaredError after = error_at(to);
    if (after.value == infinity) return infinity;
    sum += huber(after.value, problem.threshold(after.has_depth_cue)).rho;
  }
  return sum;
}

}  // namespace maxlogdet::sim
