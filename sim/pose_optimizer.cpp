// SPDX-License-Identifier: MIT
#include "sim/pose_optimizer.hpp"

#include "sim/projection.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t min_matches = 3;  // 6 rows

// With the diagonal scaled to 1, a direction whose undamped pivot is not above this is unobserved: sums of 2000 matches
// round to some 1e-14.
constexpr double min_pivot = 1e-13;

// Levenberg-Marquardt adds lambda diag to the normal equations. lambda starts almost at Gauss-Newton, falls tenfold
// with each accepted step, and grows tenfold, to at least 0.01, with each rejected one.
constexpr double first_damping = 1e-6;
constexpr double min_damping_after_rise = 1e-2;

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

// H^T W H (upper triangle, row by row) and H^T W e.
struct Sums {
  double h[21] = {};
  double g[6] = {};
  double rho = 0;
  std::size_t used = 0;
};

// Adds a row a = (1/Z, 0, -q/Z, -q y, 1 + q x, -y): u with q = x, u_right with q = (X - baseline) / Z, both over fx.
inline void add_column(Sums& sums, const Sight& at, double q, double weight, double weighted_error) {
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
inline void add_line(Sums& sums, const Sight& at, double weight, double weighted_error) {
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

void add_row(Sums& sums, const double (&a)[6], double weight, double error) {
  double* h = sums.h;
  for (int i = 0; i < 6; ++i) {
    sums.g[i] += weight * error * a[i];
    for (int j = i; j < 6; ++j) *h++ += weight * a[i] * a[j];
  }
}

struct Problem {
  const FrameCamera& camera;
  const std::vector<Match>& matches;
  const std::vector<std::uint32_t>& subset;
  const PoseOptions& options;
  const std::vector<Whitening>& whitenings;

  View view(const Pose& T_cw) const { return {camera, T_cw, options.stereo}; }
  double threshold(bool has_third) const {
    const double given = has_third ? options.huber_stereo : options.huber_monocular;
    return given > 0 ? given : infinity;
  }
  // nullptr: the measurement's noise alone whitens.
  const Whitening* whitening(std::uint32_t i) const { return whitenings.empty() ? nullptr : &whitenings[i]; }
};

// One pass with measurement noise alone: the hot loop.
Sums add_up(const Problem& problem, const View& seen_from) {
  const View view = seen_from;  // copies on the stack: the sums cannot alias them
  const double threshold_2 = problem.options.huber_monocular > 0 ? problem.options.huber_monocular : infinity;
  const double threshold_3 = problem.options.huber_stereo > 0 ? problem.options.huber_stereo : infinity;
  const double fx_2 = view.fx * view.fx;
  const double fy_2 = view.fy * view.fy;
  Sums sums;
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
Sums add_up_whitened(const Problem& problem, const View& view) {
  Sums sums;
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
Sums add_up_any(const Problem& problem, const Pose& T_cw) {
  Sums sums;
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

Sums add_up(const Problem& problem, const Pose& T_cw) {
  if (!problem.camera.is_pinhole()) return add_up_any(problem, T_cw);
  const View view = problem.view(T_cw);
  return problem.whitenings.empty() ? add_up(problem, view) : add_up_whitened(problem, view);
}

Matrix6 to_matrix(const Sums& sums) {
  Matrix6 result;
  const double* h = sums.h;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) result(i, j) = result(j, i) = *h++;
  }
  return result;
}

// A symmetric matrix with its diagonal scaled to 1, so that metres and radians are comparable.
struct Scaled {
  explicit Scaled(const Matrix6& A) : scale(A.diagonal().array().sqrt().inverse()) {
    matrix = scale.asDiagonal() * A * scale.asDiagonal();
    is_regular = matrix.allFinite() && A.allFinite() && factorize(0);
  }

  // Factorises A + damping diag(A).
  bool factorize(double damping) {
    Matrix6 damped = matrix;
    damped.diagonal().array() += damping;
    factor.compute(damped);
    if (factor.info() != Eigen::Success) return false;
    const Vector6 diagonal = factor.matrixLLT().diagonal();
    return (diagonal.array().square() > min_pivot).all();
  }

  Vector6 solve(const Vector6& b) const { return scale.asDiagonal() * factor.solve(Vector6(scale.asDiagonal() * b)); }

  Vector6 scale;
  Matrix6 matrix;
  Eigen::LLT<Matrix6> factor;
  bool is_regular = false;
};

struct Linearization {
  Linearization(const Problem& problem, const Pose& at)
      : T_cw(at), sums(add_up(problem, at)), equations(to_matrix(sums)) {}

  bool is_regular() const { return sums.used >= min_matches && equations.is_regular && std::isfinite(sums.rho); }

  bool solve(double damping, Vector6& step) {
    if (!is_regular() || !equations.factorize(damping)) return false;
    step = equations.solve(Eigen::Map<const Vector6>(sums.g));
    return step.allFinite();
  }

  Pose T_cw;
  Sums sums;
  Scaled equations;
};

// Squared error of a match in deviations, and its rows: infinite where the camera has no image, NaN where a number is.
struct SquaredError {
  double value;
  bool has_third;
};

SquaredError whitened_square(const Whitening* whitening, double inv_sigma2, double (&e)[3], bool has_third) {
  if (whitening == nullptr) return {inv_sigma2 * squared_norm(e), has_third};
  whitening->apply(e[0], e[1], e[2]);
  return {squared_norm(e), has_third};
}

SquaredError squared_error_of_any(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
                                  const Whitening* whitening) {
  LinearizedMatch at;
  if (!linearize(camera, T_cw, match, stereo, at)) return {infinity, false};
  const Whitening of_measurement = measurement_whitening(camera, match);
  double e[3] = {at.residual[0], at.residual[1], at.residual[2]};
  return whitened_square(whitening == nullptr ? &of_measurement : whitening, 1, e, at.rows == 3);
}

SquaredError squared_error(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
                           const Whitening* whitening) {
  if (!camera.is_pinhole()) return squared_error_of_any(camera, T_cw, match, stereo, whitening);
  Sight at;
  if (!look(View(camera, T_cw, stereo), match, at)) return {infinity, false};
  return whitened_square(whitening, match.inv_sigma2, at.error, at.has_right);
}

// sum rho at `to` of the matches that were linearised at `from`, so that the two are comparable: infinite if a point
// moves behind the camera, and without points that come in front of it.
double rho_after_step(const Problem& problem, const Pose& from, const Pose& to) {
  double sum = 0;
  for (const std::uint32_t i : problem.subset) {
    const auto error_at = [&](const Pose& T_cw) {
      return squared_error(problem.camera, T_cw, problem.matches[i], problem.options.stereo, problem.whitening(i));
    };
    if (!(error_at(from).value < infinity)) continue;
    const SquaredError after = error_at(to);
    if (after.value == infinity) return infinity;
    sum += huber(after.value, problem.threshold(after.has_third)).rho;
  }
  return sum;
}

bool cost_rises(const Problem& problem, const Linearization& from, const Linearization& to) {
  const std::size_t all = problem.subset.size();
  const bool same_terms = from.sums.used == all && to.sums.used == all;
  return !((same_terms ? to.sums.rho : rho_after_step(problem, from.T_cw, to.T_cw)) <= from.sums.rho);
}

// Steps from `current`, which becomes the last accepted linearisation; returns why the steps terminated.
PoseStatus iterate(const Problem& problem, Linearization& current, int& iterations) {
  if (current.sums.used < min_matches) return PoseStatus::too_few_matches;
  if (!current.is_regular()) return PoseStatus::singular;
  const bool damps = problem.options.method == PoseMethod::levenberg_marquardt;
  double damping = damps ? first_damping : 0;
  while (iterations < problem.options.max_iterations) {
    ++iterations;
    Vector6 step;
    if (!current.solve(damping, step)) return PoseStatus::singular;
    if (step.lpNorm<Eigen::Infinity>() <= problem.options.step_tolerance) return PoseStatus::converged;
    const Linearization next(problem, orthonormal(exp_se3(step) * current.T_cw));
    if (damps && cost_rises(problem, current, next)) {
      damping = std::fmax(10 * damping, min_damping_after_rise);
      continue;
    }
    if (!next.is_regular()) return PoseStatus::singular;
    damping /= 10;
    current = next;
  }
  return PoseStatus::iteration_limit;
}

}  // namespace

const char* to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::converged: return "converged";
    case PoseStatus::iteration_limit: return "iteration_limit";
    case PoseStatus::too_few_matches: return "too_few_matches";
    case PoseStatus::singular: return "singular";
  }
  return "unknown";
}

Matrix6 invert_information(const Matrix6& information) {
  const Scaled scaled(information);
  if (!scaled.is_regular) return Matrix6::Constant(std::numeric_limits<double>::quiet_NaN());
  Matrix6 inverse;
  for (int i = 0; i < 6; ++i) inverse.col(i) = scaled.solve(Vector6::Unit(i));
  return 0.5 * (inverse + inverse.transpose());
}

Matrix6 PoseEstimate::covariance() const { return invert_information(information); }

double chi2(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo, const Whitening* whitening) {
  const double s = squared_error(camera, T_cw, match, stereo, whitening).value;
  return s < infinity ? s : infinity;  // NaN is no match either
}

PoseEstimate optimize_pose(const FrameCamera& camera, const std::vector<Match>& matches,
                           const std::vector<std::uint32_t>& subset, const Pose& start, const PoseOptions& options,
                           const std::vector<Whitening>& whitenings) {
  const Problem problem{camera, matches, subset, options, whitenings};
  Linearization current(problem, orthonormal(start));
  PoseEstimate estimate;
  estimate.status = iterate(problem, current, estimate.iterations);
  estimate.T_cw = estimate.status == PoseStatus::too_few_matches ? start : current.T_cw;
  estimate.cost = 0.5 * current.sums.rho;
  estimate.information = to_matrix(current.sums);
  return estimate;
}

}  // namespace maxlogdet::sim
