// SPDX-License-Identifier: MIT
#include <maxlogdet/match_information.hpp>

#include "kernel/blocks/block_checks.hpp"
#include "simd/blocks.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

constexpr std::size_t max_rows = 3;
using Matrix = double[max_rows][3];

bool are_finite(const double* values, std::size_t count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

// The third row of d (u, v, third) / d p_c, given that of u.
bool add_third(const Camera& camera, DepthCue third, double depth, Matrix& rows) noexcept {
  if (third == DepthCue::none) return true;
  std::fill_n(rows[2], 3, 0.0);
  rows[2][2] = 1;
  if (third == DepthCue::depth) return true;
  const double bf = camera.pinhole.bf;
  std::copy_n(rows[0], 3, rows[2]);
  rows[2][2] += bf / (depth * depth);
  return third == DepthCue::stereo && camera.model == CameraModel::pinhole && bf > 0 && std::isfinite(bf);
}

// d (u, v, third) / d p_c; false if the point has no image.
bool linearise(const Camera& camera, const double* p_c, const MatchNoise& noise, Matrix& rows) noexcept {
  double uv[2], of_camera[6];
  const double* jacobian = noise.jacobian;
  if (jacobian == nullptr) {
    if (!project(camera, p_c, uv, of_camera)) return false;
    jacobian = of_camera;
  } else if (!(p_c[2] > 0) || !are_finite(p_c, 3)) {
    return false;
  }
  std::copy_n(jacobian, 3, rows[0]);
  std::copy_n(jacobian + 3, 3, rows[1]);
  return add_third(camera, noise.depth_cue, p_c[2], rows);
}

void rotate_to_world(const RigidTransform& T_cw, std::size_t count, Matrix& rows) noexcept {
  const double* const T = T_cw.data();
  for (std::size_t a = 0; a < count; ++a) {
    const double row[3] = {rows[a][0], rows[a][1], rows[a][2]};
    for (std::size_t j = 0; j < 3; ++j) rows[a][j] = row[0] * T[j] + row[1] * T[4 + j] + row[2] * T[8 + j];
  }
}

void read_covariance(const MatchNoise& noise, Matrix& to) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double round = i == j ? noise.map_sigma * noise.map_sigma : 0;
      to[i][j] = noise.covariance == nullptr ? round : noise.covariance[3 * std::min(i, j) + std::max(i, j)];
    }
  }
}

// The lower triangle of J Sigma_p J^T.
void map_rows(const Matrix& rows, std::size_t count, const Matrix& covariance, Matrix& mapped) noexcept {
  for (std::size_t a = 0; a < count; ++a) {
    double product[3] = {};
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) product[j] += rows[a][k] * covariance[k][j];
    }
    for (std::size_t b = 0; b <= a; ++b) {
      mapped[a][b] = product[0] * rows[b][0] + product[1] * rows[b][1] + product[2] * rows[b][2];
    }
  }
}

// W = L^-1 of S = L L^T, of which the lower triangle is read; false where S is not positive definite.
bool whiten(const Matrix& S, std::size_t count, Matrix& W) noexcept {
  double L[max_rows][max_rows];
  for (std::size_t a = 0; a < count; ++a) {
    double pivot = S[a][a];
    for (std::size_t b = 0; b < a; ++b) {
      double rest = S[a][b];
      for (std::size_t k = 0; k < b; ++k) rest -= L[a][k] * L[b][k];
      L[a][b] = rest * W[b][b];
      pivot -= L[a][b] * L[a][b];
    }
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    W[a][a] = 1 / std::sqrt(pivot);
    for (std::size_t b = 0; b < a; ++b) {
      double sum = 0;
      for (std::size_t k = b; k < a; ++k) sum += L[a][k] * W[k][b];
      W[a][b] = -sum * W[a][a];
      W[b][a] = 0;
    }
  }
  return true;
}

// As in simd/block_factors.inl, but in other axes, so that the two may differ near the limit (docs/numerics.md).
bool keeps_digits(const Matrix& rows, const Matrix& covariance, std::size_t count, const Matrix& W) noexcept {
  double square = 0, norms = 0;
  for (const auto& row : covariance) square += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
  for (std::size_t a = 0; a < count; ++a) {
    double of_row = 0;
    for (std::size_t b = 0; b <= a; ++b) {
      of_row += std::abs(W[a][b]) * (std::abs(rows[b][0]) + std::abs(rows[b][1]) + std::abs(rows[b][2]));
    }
    norms += of_row * of_row;
  }
  return square * (norms * norms) <= simd::max_whitened_covariance * simd::max_whitened_covariance;
}

bool are_known(const MatchNoise& noise) noexcept {
  return noise.sigma > 0 && noise.depth_sigma > 0 && noise.map_sigma >= 0 && noise.depth_cue >= DepthCue::none &&
         noise.depth_cue <= DepthCue::depth;
}

bool whiten(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
            Matrix& W) noexcept {
  const std::size_t count = residual_rows(noise.depth_cue);
  double p_c[3];
  T_cw.transform(p_w, p_c);
  Matrix rows, covariance, S;
  if (!are_known(noise) || check(camera, noise.jacobian != nullptr, noise.depth_cue) != Error::none) return false;
  if (!is_rigid(T_cw) || !linearise(camera, p_c, noise, rows)) return false;
  rotate_to_world(T_cw, count, rows);
  read_covariance(noise, covariance);
  map_rows(rows, count, covariance, S);
  for (std::size_t a = 0; a < count; ++a) {
    const double deviation = a == 2 && noise.depth_cue == DepthCue::depth ? noise.depth_sigma : noise.sigma;
    if (!(deviation * deviation > 0)) return false;
    S[a][a] += deviation * deviation;
  }
  return whiten(S, count, W) && keeps_digits(rows, covariance, count, W);
}

bool write(const double (&entries)[9], std::size_t count, double* to) noexcept {
  if (!are_finite(entries, count * count)) return false;
  std::copy_n(entries, count * count, to);
  return true;
}

RigidTransform of_camera(const RigCamera& camera, const RigidTransform& T_bw) noexcept {
  const double* const T = T_bw.data();
  double R[9], t[3];
  const double position[3] = {T[3], T[7], T[11]};
  camera.T_cb.transform(position, t);
  const double* const of_body = camera.T_cb.data();
  for (std::size_t i = 0; i < 3; ++i) {
    const double* const r = of_body + 4 * i;
    for (std::size_t j = 0; j < 3; ++j) R[3 * i + j] = r[0] * T[j] + r[1] * T[4 + j] + r[2] * T[8 + j];
  }
  return RigidTransform::from(R, t);
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
  if (!whiten(camera, T_cw, p_w, noise, W)) return false;
  const std::size_t count = residual_rows(noise.depth_cue);
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

bool match_whitening(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                     double* W) noexcept {
  Matrix rows;
  if (!whiten(camera, T_cw, p_w, noise, rows)) return false;
  const std::size_t count = residual_rows(noise.depth_cue);
  double entries[9];
  for (std::size_t i = 0; i < count; ++i) std::copy_n(rows[i], count, entries + count * i);
  return write(entries, count, W);
}

bool match_information(const RigCamera& camera, const RigidTransform& T_bw, const double* p_w, const MatchNoise& noise,
                       double* omega) noexcept {
  return is_rigid(camera.T_cb) && match_information(camera.camera, of_camera(camera, T_bw), p_w, noise, omega);
}

bool match_whitening(const RigCamera& camera, const RigidTransform& T_bw, const double* p_w, const MatchNoise& noise,
                     double* W) noexcept {
  return is_rigid(camera.T_cb) && match_whitening(camera.camera, of_camera(camera, T_bw), p_w, noise, W);
}

}  // namespace maxlogdet
