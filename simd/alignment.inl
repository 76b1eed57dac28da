// SPDX-License-Identifier: MIT
// The steps of a robust alignment: see simd/matches.hpp. Projections and derivatives are those of blocks.

namespace maxlogdet::simd {
namespace {

static_assert(alignment_lanes % double_lanes == 0, "whole packs");

inline Doubles load(const AlignmentInput& input, std::size_t value, std::size_t i) {
  return Doubles::load_aligned(input.planes + value * input.stride + i);
}
inline void store(const Doubles& pack, std::size_t value, std::size_t i, const AlignmentInput& input) {
  pack.store_aligned(input.planes + value * input.stride + i);
}

// Residuals e = z - h(p) and J = d h / d p_b of a pack, its rows of u and u_right rotated as those of a block.
template <DepthCue third>
struct Linearised {
  static constexpr int row_count = rows_with(third);
  Point p_b, p_c;
  Doubles J[row_count][3];
  Doubles e[row_count];
  Mask exists, has_third;
};

template <DepthCue third>
[[gnu::always_inline]] inline Linearised<third> linearise_at(const AlignmentInput& input, std::size_t i) {
  const CameraInput& camera = input.camera;
  Linearised<third> at;
  at.p_b = transform(
      input.T_bw, {load(input, plane::point, i), load(input, plane::point + 1, i), load(input, plane::point + 2, i)});
  at.has_third = third == DepthCue::none ? Mask(false) : load(input, plane::has_third, i) > Doubles(0.0);
  const Image<Doubles> image = linearise<third>(camera, at.p_b, at.has_third, at.p_c, at.J);
  at.exists = image.exists;
  const Doubles u = Doubles(camera.fx) * image.m_x + Doubles(camera.cx);
  at.e[0] = load(input, plane::measured, i) - u;
  at.e[1] = load(input, plane::measured + 1, i) - (Doubles(camera.fy) * image.m_y + Doubles(camera.cy));
  if constexpr (third != DepthCue::none) {
    const Doubles measured = load(input, plane::measured + 2, i);
    if constexpr (third == DepthCue::stereo) {
      const Doubles of_right = measured - (u - Doubles(camera.bf) / at.p_c.z);
      at.e[2] = Doubles(root_half) * (of_right - at.e[0]);
      at.e[0] = xsimd::select(at.has_third, Doubles(root_half) * (of_right + at.e[0]), at.e[0]);
    } else {
      at.e[2] = measured - at.p_c.z;
    }
    at.e[2] = xsimd::select(at.has_third, at.e[2], Doubles(0.0));
  }
  return at;
}

// W of the noise of measurement and map: W (Sigma_z + B Sigma_p B^T) W^T = I. A point that is known to no better than a
// radian tells nothing, and its error nothing of the scale.
template <DepthCue third>
void whiten_lanes(const AlignmentInput& input) {
  constexpr int row_count = rows_with(third);
  for (std::size_t i = input.begin; i < input.end; i += double_lanes) {
    const auto at = linearise_at<third>(input, i);
    Noise noise;
    noise.sigma = load(input, plane::sigma, i);
    noise.of_depth = Doubles(input.depth_sigma);
    noise.has_third = at.has_third;
    for (std::size_t e = 0; e < 6; ++e) noise.map[e] = load(input, plane::map_covariance + e, i);
    Doubles W[row_count][row_count];
    const auto covariance = covariance_of<third>(input.T_bw, noise, at.J);
    const double fx = input.camera.fx;
    const Mask tells = covariance.entries[0][0] + covariance.entries[1][1] <= Doubles(fx * fx);
    const Mask valid = tells & whiten<third>(noise, covariance, W);
    const Doubles none(std::numeric_limits<double>::quiet_NaN());
    std::size_t entry = plane::whitening;
    for (int a = 0; a < row_count; ++a) {
      for (int b = a; b < row_count; ++b) store(xsimd::select(valid, W[a][b], none), entry++, i, input);
    }
  }
}

// W e and W J.
template <DepthCue third, bool by_map>
[[gnu::always_inline]] inline Linearised<third> whitened_at(const AlignmentInput& input, std::size_t i) {
  constexpr int row_count = rows_with(third);
  Linearised<third> at = linearise_at<third>(input, i);
  if constexpr (by_map) {
    Doubles W[row_count][row_count], e[row_count][1];
    std::size_t entry = plane::whitening;
    for (int a = 0; a < row_count; ++a) {
      for (int b = a; b < row_count; ++b) W[a][b] = load(input, entry++, i);
      e[a][0] = at.e[a];
    }
    multiply_by_upper(W, at.J);
    multiply_by_upper(W, e);
    for (int a = 0; a < row_count; ++a) at.e[a] = e[a][0];
  } else {
    const Doubles weight = load(input, plane::weight, i);
    for (int a = 0; a < row_count; ++a) {
      const Doubles of_row = weight_of_row<third>(a, weight, input.depth_sigma);
      for (Doubles& entry : at.J[a]) entry *= of_row;
      at.e[a] *= of_row;
    }
  }
  return at;
}

// Whether products in the normal equations stay far from an overflow, which would spoil every match: sigma and what is
// measured are moderate, too, and with the error the image is.
template <DepthCue third>
inline Mask is_moderate(const Linearised<third>& at, const Doubles& square) {
  const auto size = [](const Point& p) { return xsimd::abs(p.x) + xsimd::abs(p.y) + xsimd::abs(p.z); };
  return (size(at.p_c) >= Doubles(1e-30)) & (size(at.p_b) <= Doubles(1e60)) & (square <= Doubles(1e40));
}

template <DepthCue third, bool by_map>
void measure_leverage(const AlignmentInput& input) {
  const Doubles infinite(std::numeric_limits<double>::infinity());
  for (std::size_t i = input.begin; i < input.end; i += double_lanes) {
    const auto at = whitened_at<third, by_map>(input, i);
    Doubles leverage(0.0);
    for (const auto& row : at.J) {
      for (const Doubles& entry : row) leverage += entry * entry;
    }
    const Mask counts = at.exists & (leverage <= Doubles(static_cast<double>(std::numeric_limits<float>::max())));
    const Doubles found = xsimd::select(counts, leverage, infinite);
    store(found, plane::leverage, i, input);
    store_narrow(found, input.errors + i);
  }
}

template <DepthCue third, bool by_map>
void measure_errors(const AlignmentInput& input) {
  const Doubles infinite(std::numeric_limits<double>::infinity());
  const Doubles largest(static_cast<double>(std::numeric_limits<float>::max()));
  const Doubles of_two(1 / robust_limits[0].median), of_three(1 / robust_limits[1].median);
  for (std::size_t i = input.begin; i < input.end; i += double_lanes) {
    const auto at = whitened_at<third, by_map>(input, i);
    Doubles square = at.e[0] * at.e[0];
    for (int a = 1; a < Linearised<third>::row_count; ++a) square += at.e[a] * at.e[a];
    const Mask counts = at.exists & is_moderate(at, square);
    const Doubles error = square * (third == DepthCue::none ? of_two : xsimd::select(at.has_third, of_three, of_two));
    store(xsimd::select(counts, error, infinite), plane::error, i, input);
    store_narrow(xsimd::select(counts, xsimd::select(error < largest, error, largest), infinite), input.errors + i);
  }
}

template <DepthCue third, bool by_map>
ThirdRows count_third(const AlignmentInput& input, double limit) {
  const Doubles zero(0.0), one(1.0);
  Doubles counts[3] = {zero, zero, zero};
  for (std::size_t i = input.begin; i < input.end; i += double_lanes) {
    const auto at = whitened_at<third, by_map>(input, i);
    const Doubles& error = at.e[Linearised<third>::row_count - 1];
    const Mask exists = at.exists & at.has_third & (error == error);
    counts[0] += xsimd::select(exists, one, zero);
    counts[1] += xsimd::select(exists & (error < Doubles(-limit)), one, zero);
    counts[2] += xsimd::select(exists & (error > Doubles(limit)), one, zero);
  }
  std::size_t totals[3] = {};
  for (int c = 0; c < 3; ++c) {
    alignas(64) double lanes[double_lanes];
    counts[c].store_aligned(lanes);
    for (const double lane : lanes) totals[c] += static_cast<std::size_t>(lane);
  }
  return {totals[0], totals[1], totals[2]};
}

// A limit of plane::error, whose unit is the median.
template <int Rows>
inline Doubles limit_of(double RobustLimits::*limit, const Mask& has_third, double scale_squared) {
  const auto& two = robust_limits[0];
  const auto& three = robust_limits[1];
  const Doubles of_two(two.*limit / two.median * scale_squared);
  if (Rows == 2) return of_two;
  return xsimd::select(has_third, Doubles(three.*limit / three.median * scale_squared), of_two);
}

// The weights of a pack, bounded by the error and by the leverage.
template <RobustWeight weight, int Rows>
inline Doubles weight_at(const AlignmentInput& input, std::size_t i, const Mask& has_third, double scale_squared) {
  if constexpr (weight == RobustWeight::inliers) return load(input, plane::is_inlier, i);
  const Doubles zero(0.0), one(1.0);
  const Doubles error = load(input, plane::error, i);
  if constexpr (weight == RobustWeight::huber) {
    const Doubles ratio = limit_of<Rows>(&RobustLimits::huber, has_third, scale_squared) / error;
    const Doubles bounded = xsimd::select(ratio < one, xsimd::sqrt(ratio), one);  // 0 / 0 is NaN, and not below 1
    return load(input, plane::leverage, i) * xsimd::select(ratio < Doubles(smallest_huber_ratio), zero, bounded);
  } else {
    const Doubles rest = one - error / limit_of<Rows>(&RobustLimits::tukey, has_third, scale_squared);
    return load(input, plane::leverage, i) * xsimd::select(rest > zero, rest * rest, zero);
  }
}

// Sums of a pack of lanes, in the order of NormalSums.
constexpr std::size_t sum_count = sizeof(NormalSums) / sizeof(double);

// G = J^T w J and g = J^T w e, and C = -G [p]x, whose row i is p x G_i.
struct NormalPack {
  Doubles G[6], g[3], C[3][3];
};

template <int Rows>
[[gnu::always_inline]] inline void multiply(const Doubles (&J)[Rows][3], const Doubles (&e)[Rows], const Doubles& w,
                                            const Point& p, NormalPack& pack) {
  for (int r = 0; r < Rows; ++r) {
    for (int j = 0, entry = 0; j < 3; ++j) {
      const Doubles weighted = w * J[r][j];
      for (int k = j; k < 3; ++k, ++entry) {
        pack.G[entry] = r == 0 ? weighted * J[r][k] : pack.G[entry] + weighted * J[r][k];
      }
      pack.g[j] = r == 0 ? weighted * e[r] : pack.g[j] + weighted * e[r];
    }
  }
  const Doubles(&G)[6] = pack.G;
  cross(p, G[0], G[1], G[2], pack.C[0]);
  cross(p, G[1], G[3], G[4], pack.C[1]);
  cross(p, G[2], G[4], G[5], pack.C[2]);
}

// The same of a pinhole that is its own body, whitened by sigma: its rows (a, 0, c), (0, b, d) and (0, 0, f) save a
// quarter of the operations.
template <int Rows>
[[gnu::always_inline]] inline void multiply_sparse(const Doubles (&J)[Rows][3], const Doubles (&e)[Rows],
                                                   const Doubles& w, const Point& p, NormalPack& pack) {
  const Doubles a = w * J[0][0], c = w * J[0][2], b = w * J[1][1], d = w * J[1][2];
  Doubles(&G)[6] = pack.G;
  G[0] = a * J[0][0];
  G[1] = Doubles(0.0);
  G[2] = a * J[0][2];
  G[3] = b * J[1][1];
  G[4] = b * J[1][2];
  G[5] = c * J[0][2] + d * J[1][2];
  pack.g[0] = a * e[0];
  pack.g[1] = b * e[1];
  pack.g[2] = c * e[0] + d * e[1];
  if constexpr (Rows == 3) {
    const Doubles f = w * J[2][2];
    G[5] += f * J[2][2];
    pack.g[2] += f * e[2];
  }
  cross(p, G[0], Zero(), G[2], pack.C[0]);
  cross(p, Zero(), G[3], G[4], pack.C[1]);
  cross(p, G[2], G[4], G[5], pack.C[2]);
}

template <DepthCue third, bool is_sparse>
[[gnu::always_inline]] inline void add_pack(const Linearised<third>& at, const Doubles& w, const Mask& counts,
                                            Doubles (&sums)[sum_count]) {
  constexpr int row_count = rows_with(third);
  const auto value = [&](const Doubles& entry) { return xsimd::select(counts, entry, Doubles(0.0)); };
  Doubles J[row_count][3], e[row_count];
  for (int r = 0; r < row_count; ++r) {
    for (int j = 0; j < 3; ++j) J[r][j] = value(at.J[r][j]);
    e[r] = value(at.e[r]);
  }
  const Point p = {value(at.p_b.x), value(at.p_b.y), value(at.p_b.z)};
  NormalPack pack;
  is_sparse ? multiply_sparse(J, e, w, p, pack) : multiply(J, e, w, p, pack);
  const auto& [G, g, C] = pack;
  Doubles T[3][3];  // its columns, turned in the same way
  for (int k = 0; k < 3; ++k) cross(p, C[0][k], C[1][k], C[2][k], T[k]);
  Doubles moment[3];
  cross(p, g[0], g[1], g[2], moment);
  std::size_t s = 0;
  for (const Doubles& entry : G) sums[s++] += entry;
  for (const auto& row : C) {
    for (const Doubles& entry : row) sums[s++] += entry;
  }
  for (int j = 0; j < 3; ++j) {
    for (int k = j; k < 3; ++k) sums[s++] += T[j][k];
  }
  for (const Doubles& entry : g) sums[s++] += entry;
  for (const Doubles& entry : moment) sums[s++] += entry;
}

template <DepthCue third, bool by_map, bool is_sparse, RobustWeight weight>
NormalSums add_lanes(const AlignmentInput& input, double scale_squared) {
  alignas(64) double lanes[sum_count][alignment_lanes];
  for (std::size_t lane = 0; lane < alignment_lanes; lane += double_lanes) {
    Doubles sums[sum_count];
    for (Doubles& sum : sums) sum = Doubles(0.0);
    for (std::size_t i = input.begin + lane; i < input.end; i += alignment_lanes) {
      const auto at = whitened_at<third, by_map>(input, i);
      const Doubles w = weight_at<weight, rows_with(third)>(input, i, at.has_third, scale_squared);
      add_pack<third, is_sparse>(at, w, load(input, plane::error, i) <= Doubles(std::numeric_limits<double>::max()),
                                 sums);
    }
    for (std::size_t s = 0; s < sum_count; ++s) sums[s].store_aligned(lanes[s] + lane);
  }
  double totals[sum_count];
  for (std::size_t s = 0; s < sum_count; ++s) {
    totals[s] = lanes[s][0];
    for (std::size_t lane = 1; lane < alignment_lanes; ++lane) totals[s] += lanes[s][lane];
  }
  NormalSums sums;
  std::memcpy(&sums, totals, sizeof sums);
  return sums;
}

template <DepthCue third, bool by_map, bool is_sparse>
NormalSums add_lanes(const AlignmentInput& input, RobustWeight weight, double scale_squared) {
  switch (weight) {
    case RobustWeight::huber: return add_lanes<third, by_map, is_sparse, RobustWeight::huber>(input, scale_squared);
    case RobustWeight::tukey: return add_lanes<third, by_map, is_sparse, RobustWeight::tukey>(input, scale_squared);
    case RobustWeight::inliers: break;
  }
  return add_lanes<third, by_map, is_sparse, RobustWeight::inliers>(input, scale_squared);
}

// visitor(third, by_map) of the frame, as constants.
template <class Visitor>
inline auto with_kind(const AlignmentInput& input, const Visitor& visitor) {
  const auto with_third = [&](auto third) {
    return input.by_map ? visitor(third, std::true_type()) : visitor(third, std::false_type());
  };
  switch (input.third) {
    case DepthCue::none: break;
    case DepthCue::stereo: return with_third(std::integral_constant<DepthCue, DepthCue::stereo>());
    case DepthCue::depth: return with_third(std::integral_constant<DepthCue, DepthCue::depth>());
  }
  return with_third(std::integral_constant<DepthCue, DepthCue::none>());
}

void whiten_matches(const AlignmentInput& input) {
  with_kind(input, [&](auto third, auto /*by_map*/) { whiten_lanes<third()>(input); });
}
void measure_leverage(const AlignmentInput& input) {
  with_kind(input, [&](auto third, auto by_map) { measure_leverage<third(), by_map()>(input); });
}
void measure_errors(const AlignmentInput& input) {
  with_kind(input, [&](auto third, auto by_map) { measure_errors<third(), by_map()>(input); });
}
ThirdRows count_third(const AlignmentInput& input, double limit) {
  return with_kind(input, [&](auto third, auto by_map) { return count_third<third(), by_map()>(input, limit); });
}
NormalSums add_normal_equations(const AlignmentInput& input, RobustWeight weight, double scale_squared) {
  return with_kind(input, [&](auto third, auto by_map) {
    return !by_map() && is_plain(input.camera) ? add_lanes<third(), by_map(), !by_map()>(input, weight, scale_squared)
                                               : add_lanes<third(), by_map(), false>(input, weight, scale_squared);
  });
}

}  // namespace
}  // namespace maxlogdet::simd
