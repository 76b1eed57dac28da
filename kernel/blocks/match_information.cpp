// SPDX-License-Identifier: MIT
#include <maxlogdet/match_information.hpp>

#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/camera_input.hpp"
#include "simd/cameras/models.hpp"
#include "simd/whitening.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

constexpr std::size_t max_rows = 3;
using Matrix = double[max_rows][3];
using Point = simd::PointOf<double>;
using simd::ThirdRow;

bool are_finite(const double* values, std::size_t count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

// A match as append_blocks sees it: by a pinhole alone without the caller's Jacobian along its ray (is_along_ray), else
// by the rows of J.
struct Seen {
  const MatchNoise& noise;
  simd::BlockInput input;
  simd::CameraInput camera;
  bool is_rig;
  bool is_along_ray;
  Point p_c;
};

Seen seen_by(const RigCamera& camera, bool is_rig, const RigidTransform& T_bw, const MatchNoise& noise) noexcept {
  Seen seen{noise, {}, camera_input(camera), is_rig, false, {}};
  seen.is_along_ray = !is_rig && camera.camera.model == CameraModel::pinhole && noise.jacobian == nullptr;
  simd::BlockInput& input = seen.input;
  input.fx = seen.camera.fx;
  input.fy = seen.camera.fy;
  input.bf = seen.camera.bf;
  input.T_cw = T_bw.data();
  input.map_sigma = noise.map_sigma;
  input.depth_sigma = noise.depth_sigma;
  input.map_covariances = noise.covariance;
  return seen;
}

// d (u, v) / d p_c; false if the point has no image.
bool linearise(const Seen& seen, Matrix& rows) noexcept {
  if (seen.noise.jacobian != nullptr) {
    for (std::size_t e = 0; e < 6; ++e) rows[e / 3][e % 3] = seen.noise.jacobian[e];
    return seen.p_c.z > 0 && are_finite(seen.noise.jacobian, 6);
  }
  const auto image = simd::with_model(
      seen.camera.model, [&](auto model) { return decltype(model)::derivative(seen.camera.lens, seen.p_c); });
  for (std::size_t j = 0; j < 3; ++j) {
    rows[0][j] = seen.camera.fx * image.x[j];
    rows[1][j] = seen.camera.fy * image.y[j];
  }
  return image.exists;
}

// V <- V G.
void multiply(int count, const Matrix& G, Matrix& V) noexcept {
  for (int a = 0; a < count; ++a) {
    const double row[3] = {V[a][0], V[a][1], V[a][2]};
    for (int j = 0; j < count; ++j) V[a][j] = row[0] * G[0][j] + row[1] * G[1][j] + row[2] * G[2][j];
  }
}

// V with V^T V = Sigma^-1, by the factor along the ray, whose coordinates are G times those of the residual: of a
// stereo row, dZ = -Z^2 / bf (du - du_right). False where Sigma is not positive definite or keeps no digits.
template <ThirdRow third, int Rows>
bool whiten_along_ray(const Seen& seen, Matrix& V) noexcept {
  if (!(seen.p_c.z > 0)) return false;
  const double inverse_z = 1 / seen.p_c.z;
  const Point ray = {seen.p_c.x * inverse_z, seen.p_c.y * inverse_z, seen.p_c.z};
  const auto covariance = [&](int e) { return seen.noise.covariance[simd::upper_triangle[e]]; };
  simd::FactorOf<double, Rows> factor;
  if (!simd::whiten_along_ray<third>(seen.input, seen.noise.sigma, covariance, ray, true, factor)) return false;
  for (int a = 0; a < Rows; ++a) {
    for (int j = 0; j < 3; ++j) V[a][j] = j < a ? 0 : factor.a[a][j];
  }
  const double by_disparity = ray.z * ray.z / seen.camera.bf;
  const bool is_stereo = third == ThirdRow::stereo;
  const Matrix G = {{ray.z / seen.camera.fx, 0, 0},
                    {0, ray.z / seen.camera.fy, 0},
                    {is_stereo ? -by_disparity : 0, 0, is_stereo ? by_disparity : 1}};
  multiply(Rows, G, V);
  return true;
}

// The same by the rows of J, of which simd/cameras.inl rotates a stereo row with that of u.
template <ThirdRow third, int Rows>
bool whiten_rows(const Seen& seen, Matrix& V) noexcept {
  constexpr bool is_stereo = third == ThirdRow::stereo;
  Matrix all;
  if (!linearise(seen, all)) return false;
  simd::add_third<is_stereo>(seen.camera.bf, seen.p_c.z, true, all);
  if (seen.is_rig) simd::rotate_to_body(seen.camera.T_cb, all);
  double rows[Rows][3], inverse[Rows][Rows];
  for (int a = 0; a < Rows; ++a) std::copy_n(all[a], 3, rows[a]);
  const auto covariance = [&](int e) { return seen.noise.covariance[simd::upper_triangle[e]]; };
  if (!simd::whiten_rows<third>(seen.input, seen.noise.sigma, covariance, true, rows, inverse)) return false;
  for (int a = 0; a < Rows; ++a) {
    for (int j = 0; j < 3; ++j) V[a][j] = j > a ? 0 : inverse[a][j];
  }
  constexpr double r = simd::root_half;
  const Matrix G = {{r, 0, r}, {0, 1, 0}, {-r, 0, r}};
  if (is_stereo) multiply(Rows, G, V);
  return true;
}

// Rotates rows a and b of V so that a has a zero in column b, and b what is positive.
void rotate(int a, int b, Matrix& V) noexcept {
  const double norm = std::sqrt(V[a][b] * V[a][b] + V[b][b] * V[b][b]);
  const double cosine = V[b][b] / norm;
  const double sine = V[a][b] / norm;
  for (int j = 0; j < b; ++j) {
    const double kept = V[a][j];
    V[a][j] = cosine * kept - sine * V[b][j];
    V[b][j] = cosine * V[b][j] + sine * kept;
  }
  V[a][b] = 0;
  V[b][b] = norm;
}

bool has_image(const Seen& seen) noexcept {
  Matrix rows;
  return seen.is_along_ray ? seen.p_c.z > 0 : linearise(seen, rows);
}

// W = V rotated to a lower triangle.
template <ThirdRow third, int Rows>
bool whiten_by_map(const Seen& seen, Matrix& W) noexcept {
  if (!(seen.is_along_ray ? whiten_along_ray<third, Rows>(seen, W) : whiten_rows<third, Rows>(seen, W))) return false;
  for (int b = Rows - 1; b > 0; --b) {
    for (int a = 0; a < b; ++a) rotate(a, b, W);
  }
  return true;
}

bool whiten_by_measurement(const Seen& seen, Matrix& W) noexcept {
  const double of_third = seen.noise.depth_cue == DepthCue::depth ? seen.noise.depth_sigma : seen.noise.sigma;
  const double deviations[max_rows] = {seen.noise.sigma, seen.noise.sigma, of_third};
  for (std::size_t a = 0; a < residual_rows(seen.noise.depth_cue); ++a) {
    if (!simd::is_positive(deviations[a] * deviations[a])) return false;
    std::fill_n(W[a], max_rows, 0.0);
    W[a][a] = 1 / deviations[a];
  }
  return has_image(seen);
}

bool whiten(const Seen& seen, Matrix& W) noexcept {
  if (seen.noise.covariance == nullptr && seen.noise.map_sigma == 0) return whiten_by_measurement(seen, W);
  switch (seen.noise.depth_cue) {
    case DepthCue::none: return whiten_by_map<ThirdRow::none, 2>(seen, W);
    case DepthCue::stereo: return whiten_by_map<ThirdRow::stereo, 3>(seen, W);
    case DepthCue::depth: return whiten_by_map<ThirdRow::depth, 3>(seen, W);
  }
  return false;
}

bool are_known(const MatchNoise& noise) noexcept {
  return noise.sigma > 0 && noise.depth_sigma > 0 && noise.map_sigma >= 0 && noise.depth_cue >= DepthCue::none &&
         noise.depth_cue <= DepthCue::depth;
}

// `is_rig` as in append_blocks: a camera alone is its own body.
bool whiten(const RigCamera& camera, bool is_rig, const RigidTransform& T_bw, const double* p_w,
            const MatchNoise& noise, Matrix& W) noexcept {
  const bool has_jacobian = noise.jacobian != nullptr;
  if (!are_known(noise) || check(camera.camera, has_jacobian, noise.depth_cue) != Error::none) return false;
  if (!is_rigid(T_bw) || (is_rig && !is_rigid(camera.T_cb))) return false;
  Seen seen = seen_by(camera, is_rig, T_bw, noise);
  double p_b[3], p_c[3];
  T_bw.transform(p_w, p_b);
  camera.T_cb.transform(p_b, p_c);
  const double* const p = is_rig ? p_c : p_b;
  seen.p_c = {p[0], p[1], p[2]};
  return are_finite(p_b, 3) && whiten(seen, W);
}

bool write(const double (&entries)[9], std::size_t count, double* to) noexcept {
  if (!are_finite(entries, count * count)) return false;
  std::copy_n(entries, count * count, to);
  return true;
}

bool write_information(bool is_there, std::size_t count, const Matrix& W, double* omega) noexcept {
  if (!is_there) return false;
  double entries[9];
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      double sum = 0;
      for (std::size_t k = std::max(i, j); k < count; ++k) sum += W[k][i] * W[k][j];
      entries[count * i + j] = sum;
    }
  }
  return write(entries, count, omega);
}

bool write_whitening(bool is_there, std::size_t count, const Matrix& W, double* to) noexcept {
  if (!is_there) return false;
  double entries[9];
  for (std::size_t i = 0; i < count; ++i) std::copy_n(W[i], count, entries + count * i);
  return write(entries, count, to);
}

}  // namespace

MatchNoise match_noise(const Matches& matches, std::size_t i, const BlockOptions& options) noexcept {
  MatchNoise noise;
  if (matches.sigmas != nullptr) noise.sigma = matches.sigmas[i];
  if (matches.jacobians != nullptr) noise.jacobian = matches.jacobians + 6 * i;
  if (matches.has_depth_cue == nullptr || matches.has_depth_cue[i] != 0) noise.depth_cue = options.depth_cue;
  noise.depth_sigma = options.depth_sigma;
  if (options.weighting != Weighting::measurement_and_map) return noise;
  noise.map_sigma = options.map_sigma;
  if (matches.map_covariances != nullptr) noise.covariance = matches.map_covariances + 9 * i;
  return noise;
}

bool match_information(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                       double* omega) noexcept {
  Matrix W;
  const bool is_there = whiten(camera, false, T_cw, p_w, noise, W);
  return write_information(is_there, residual_rows(noise.depth_cue), W, omega);
}

bool match_whitening(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                     double* W) noexcept {
  Matrix root;
  const bool is_there = whiten(camera, false, T_cw, p_w, noise, root);
  return write_whitening(is_there, residual_rows(noise.depth_cue), root, W);
}

bool match_information(const RigCamera& camera, const RigidTransform& T_bw, const double* p_w, const MatchNoise& noise,
                       double* omega) noexcept {
  Matrix W;
  const bool is_there = whiten(camera, true, T_bw, p_w, noise, W);
  return write_information(is_there, residual_rows(noise.depth_cue), W, omega);
}

bool match_whitening(const RigCamera& camera, const RigidTransform& T_bw, const double* p_w, const MatchNoise& noise,
                     double* W) noexcept {
  Matrix root;
  const bool is_there = whiten(camera, true, T_bw, p_w, noise, root);
  return write_whitening(is_there, residual_rows(noise.depth_cue), root, W);
}

}  // namespace maxlogdet
