// SPDX-License-Identifier: MIT
#include <maxlogdet/match_information.hpp>

#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/camera_checks.hpp"
#include "simd/jacobian.hpp"
#include "simd/triangle.hpp"
#include "simd/whitening.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

template <int Rows>
using Square = double[Rows][Rows];

// A match as append_blocks sees it.
struct Seen {
  simd::BlockInput input;
  DepthCue depth_cue;
  double sigma;
  simd::PointOf<double> p_c;
};

simd::BlockInput block_input(const simd::CameraInput& camera, const RigidTransform& T_bw,
                             const MatchNoise& noise) noexcept {
  simd::BlockInput input{};
  input.weighting = Weighting::measurement_and_map;
  input.camera = camera;
  input.camera_count = 1;
  input.T_bw = T_bw.data();
  input.map_sigma = noise.map_sigma;
  input.depth_sigma = noise.depth_sigma;
  input.map_covariances = noise.covariance;
  return input;
}

// A with A S A^T = I, S the covariance of coordinates that are G times those of the residual: along the ray of a
// stereo row dZ = -Z^2 / bf (du - du_right), and by the rows of J that row is rotated with that of u. False where S is
// not positive definite or keeps no digits.
template <DepthCue third, int Rows>
bool whiten_coordinates(const Seen& seen, Square<Rows>& A, Square<Rows>& G) noexcept {
  constexpr int last = Rows - 1;
  const double* const covariance = seen.input.map_covariances;
  const auto noise =
      simd::noise_of(seen.input, seen.sigma, true, [&](int e) { return covariance[simd::upper_triangle[e]]; });
  if (simd::is_by_jacobian(seen.input)) {
    double rows[Rows][3];
    if (!simd::image_jacobian(seen.input.camera, seen.p_c, rows)) return false;
    simd::add_third_row<third>(seen.input.camera.bf, seen.p_c.z, true, rows);
    if (seen.input.camera.T_cb != nullptr) simd::rotate_to_body(seen.input.camera.T_cb, rows);
    for (int a = 0; a < Rows; ++a) G[a][a] = 1;
    if (third == DepthCue::stereo) {
      G[0][0] = G[0][last] = G[last][last] = simd::root_half;
      G[last][0] = -simd::root_half;
    }
    return simd::whiten(noise, simd::covariance_by_rows<third>(seen.input, noise, rows), A);
  }
  if (!(seen.p_c.z > 0)) return false;
  const double inverse_z = 1 / seen.p_c.z;
  const simd::PointOf<double> ray = {seen.p_c.x * inverse_z, seen.p_c.y * inverse_z, seen.p_c.z};
  const double by_disparity = ray.z * ray.z / seen.input.camera.bf;
  G[0][last] = third == DepthCue::stereo ? by_disparity : 1;
  if (third == DepthCue::stereo) G[0][0] = -by_disparity;
  G[last - 1][1] = ray.z / seen.input.camera.fy;
  G[last][0] = ray.z / seen.input.camera.fx;
  return simd::whiten(noise, simd::covariance_along_ray<third>(seen.input, noise, ray), A);
}

// W = Q A G, lower triangular with a positive diagonal: with rows and columns in the opposite order it is an upper
// triangle.
template <DepthCue third>
bool whiten_by_map(const Seen& seen, double* W) noexcept {
  constexpr int last = simd::rows_with(third) - 1;
  double A[last + 1][last + 1], G[last + 1][last + 1] = {};
  if (!whiten_coordinates<third>(seen, A, G)) return false;
  double product[last + 1][3] = {};
  for (int a = 0; a <= last; ++a) {
    for (int j = 0; j <= last; ++j) {
      for (int k = 0; k <= a; ++k) product[last - a][last - j] += A[a][k] * G[k][j];
    }
  }
  const auto triangle = simd::triangle_of(product);
  for (int a = 0; a <= last; ++a) {
    const double sign = triangle.a[last - a][last - a] < 0 ? -1 : 1;
    for (int j = 0; j <= last; ++j) *W++ = j > a ? 0 : sign * triangle.a[last - a][last - j];
  }
  return true;
}

bool whiten_by_measurement(const Seen& seen, double* W) noexcept {
  const std::size_t rows = residual_rows(seen.depth_cue);
  const double of_third = seen.depth_cue == DepthCue::depth ? seen.input.depth_sigma : seen.sigma;
  const double deviations[3] = {seen.sigma, seen.sigma, of_third};
  std::fill_n(W, rows * rows, 0.0);
  for (std::size_t a = 0; a < rows; ++a) {
    if (!simd::is_positive(deviations[a] * deviations[a])) return false;
    W[(rows + 1) * a] = 1 / deviations[a];
  }
  double J[2][3];
  return simd::is_by_jacobian(seen.input) ? simd::image_jacobian(seen.input.camera, seen.p_c, J) : seen.p_c.z > 0;
}

bool whiten(const Seen& seen, double* W) noexcept {
  if (seen.input.map_covariances == nullptr && seen.input.map_sigma == 0) return whiten_by_measurement(seen, W);
  switch (seen.depth_cue) {
    case DepthCue::none: return whiten_by_map<DepthCue::none>(seen, W);
    case DepthCue::stereo: return whiten_by_map<DepthCue::stereo>(seen, W);
    case DepthCue::depth: return whiten_by_map<DepthCue::depth>(seen, W);
  }
  return false;
}

bool are_known(const MatchNoise& noise) noexcept {
  return noise.sigma > 0 && noise.depth_sigma > 0 && noise.map_sigma >= 0 && noise.depth_cue >= DepthCue::none &&
         noise.depth_cue <= DepthCue::depth;
}

// W: r x r, written in any case.
bool whiten(const Camera& camera, const RigidTransform& T_bw, const double* p_w, const MatchNoise& noise,
            double* W) noexcept {
  if (!are_known(noise) || check(camera, noise.depth_cue) != Error::none || !is_rigid(T_bw)) return false;
  double p_b[3], p_c[3];
  T_bw.transform(p_w, p_b);
  if (!all_finite(p_b, 3)) return false;
  camera.T_cb.transform(p_b, p_c);
  const Seen seen{
      block_input(camera_input(camera), T_bw, noise), noise.depth_cue, noise.sigma, {p_c[0], p_c[1], p_c[2]}};
  const std::size_t rows = residual_rows(noise.depth_cue);
  return whiten(seen, W) && all_finite(W, rows * rows);
}

}  // namespace

MatchNoise match_noise(const Matches& matches, std::size_t i, const BlockOptions& options) noexcept {
  MatchNoise noise;
  if (matches.sigmas != nullptr) noise.sigma = matches.sigmas[i];
  if (matches.has_depth_cue == nullptr || matches.has_depth_cue[i] != 0) noise.depth_cue = options.depth_cue;
  noise.depth_sigma = options.depth_sigma;
  if (options.weighting != Weighting::measurement_and_map) return noise;
  noise.map_sigma = options.map_sigma;
  if (matches.map_covariances != nullptr) noise.covariance = matches.map_covariances + 9 * i;
  return noise;
}

bool match_whitening(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                     double* W) noexcept {
  double entries[9];
  if (!whiten(camera, T_cw, p_w, noise, entries)) return false;
  std::copy_n(entries, residual_rows(noise.depth_cue) * residual_rows(noise.depth_cue), W);
  return true;
}

bool match_information(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                       double* omega) noexcept {
  double W[9], entries[9];
  if (!whiten(camera, T_cw, p_w, noise, W)) return false;
  const std::size_t count = residual_rows(noise.depth_cue);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      double sum = 0;
      for (std::size_t k = std::max(i, j); k < count; ++k) sum += W[count * k + i] * W[count * k + j];
      entries[count * i + j] = sum;
    }
  }
  if (!all_finite(entries, count * count)) return false;
  std::copy_n(entries, count * count, omega);
  return true;
}

}  // namespace maxlogdet
