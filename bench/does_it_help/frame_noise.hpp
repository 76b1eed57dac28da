// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/image_grid.hpp"
#include "bench/world/match_noise.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

// Is the noise of a frame's matches what Max-logDet assumes, of the assumed size and independent? Whitened residuals
// r_i at the pose of all inliers tell: as that pose was fitted to them, E[r_i r_j^T] = delta_ij I - H_i C H_j^T where
// the model is right, H the whitened Jacobians and C = (sum H^T H)^-1.

namespace maxlogdet::sim {

constexpr std::size_t leverage_classes = 10;
constexpr ImageGrid noise_grid{8, 6};  ///< cells within which errors may be shared

/// Sums over pairs of matches that one image cell has, of the residuals of u and v.
struct PairSums {
  double products = 0;     ///< sum of r_i . r_j over pairs
  double fitted = 0;       ///< sum of tr(H_i C H_j^T) over pairs: what the fit took away
  double pairs = 0;        ///< their number
  double squares = 0;      ///< sum of r_i . r_i over matches
  double fitted_self = 0;  ///< sum of tr(H_i C H_i^T) over matches
  double matches = 0;      ///< their number
};

/// Sums of a frame, which add up over frames.
struct FrameNoise {
  std::array<double, leverage_classes> chi2{};  ///< sum of |r_i|^2 by decile of leverage tr(H_i C H_i^T), lowest first
  std::array<double, leverage_classes> freedom{};  ///< sum of rows less leverage: what chi2 is expected to be
  PairSums pairs;
};

/// Sums up the residuals of the inliers at the pose of all, `all`, from `inliers`. `whitenings`: one for each match of
/// the frame.
FrameNoise noise_of(const Frame& frame, const PoseEstimate& all, const std::vector<std::uint32_t>& inliers,
                    const std::vector<Whitening>& whitenings);

/// Returns the correlation of whitened residuals of neighbours, the sum of products over that of squares, each per
/// pair or match and freed from what the fit took away; NaN without pairs.
double correlation_of(const PairSums& sums);

PairSums operator+(const PairSums& a, const PairSums& b);
PairSums operator*(double factor, const PairSums& sums);

}  // namespace maxlogdet::sim
