// SPDX-License-Identifier: MIT
// Matches that cameras of any model see, one of them or a rig's: J = d z / d p_b, p_b the point in the body's frame, by
// the camera's model or as the caller gives it. The factor of a block (seen_factors.inl) does not depend on the model.

namespace {

using maxlogdet::simd::add_third;
using maxlogdet::simd::CameraInput;
using maxlogdet::simd::Derivative;
using maxlogdet::simd::rotate_to_body;

// Why a match has no J; a double, as all else of a batch.
constexpr double is_accepted = 0;
constexpr double is_behind = 1;
constexpr double is_too_near = 2;
constexpr double has_no_jacobian = 3;

struct SeenBatch : Batch {
  alignas(64) double camera[batch_size];  // its number
  std::uint64_t cameras[4];               // a bit for each that sees a match
  alignas(64) double refusal[batch_size];
  alignas(64) double jacobian[9][batch_size];  // first the caller's by p_c, 2 x 3, then J by p_b, 3 x 3
  alignas(64) double ray[3][batch_size];       // from the camera to the point, in the body's axes; map_bias_world
};

inline void fill_seen(const BlockInput& input, SeenBatch& batch) {
  for (std::uint64_t& cameras : batch.cameras) cameras = 0;
  batch.cameras[0] = 1;
  if (input.camera_ids != nullptr) {
    batch.cameras[0] = 0;
    fill<1>(batch.camera, input.camera_ids, 0, batch);
    for (std::size_t i = 0; i < batch.count; ++i) {
      const unsigned char camera = input.camera_ids[batch.number[i]];
      batch.cameras[camera / 64U] |= std::uint64_t{1} << (camera % 64U);
    }
  }
  if (input.jacobians != nullptr) {
    for (std::size_t e = 0; e < 6; ++e) fill<6>(batch.jacobian[e], input.jacobians, e, batch);
  }
}

inline Derivative<Doubles> derivative_of(const CameraInput& camera, const Point& p) {
  return maxlogdet::simd::with_model(camera.model,
                                     [&](auto model) { return decltype(model)::derivative(camera.lens, p); });
}

// d (u, v) / d p_c as rows 0 and 1; returns why there is none.
inline Doubles linearise(const BlockInput& input, const CameraInput& camera, const SeenBatch& batch, std::size_t i,
                         const Point& p, Doubles (&rows)[3][3]) {
  const Doubles zero(0.0);
  const Doubles min_depth(input.min_depth);
  Doubles refusal(is_accepted);
  const auto refuse = [&](const Mask& where, double reason) {
    refusal = xsimd::select(where, Doubles(reason), refusal);
  };
  if (input.jacobians != nullptr) {
    Mask is_given(true);
    for (int e = 0; e < 6; ++e) {
      rows[e / 3][e % 3] = load(batch.jacobian[e], i);
      is_given = is_given & is_finite(rows[e / 3][e % 3]);
    }
    refuse(!is_given, has_no_jacobian);
    refuse(p.z < min_depth, is_too_near);
    refuse(p.z <= zero, is_behind);
    return refusal;
  }
  const Derivative<Doubles> image = derivative_of(camera, p);
  for (int e = 0; e < 3; ++e) {
    rows[0][e] = Doubles(camera.fx) * image.x[e];
    rows[1][e] = Doubles(camera.fy) * image.y[e];
  }
  const Doubles depth = camera.is_depth_along_z ? p.z : xsimd::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  refuse(depth < min_depth, is_too_near);
  refuse(!image.exists, is_behind);
  return refusal;
}

// H_p^n^-1 [J; 0] by p_c, as map_bias_factor has it for a pinhole; returns why there is none.
inline Doubles linearise_bias(const BlockInput& input, const Point& p, const Mask& has_third, Doubles (&rows)[3][3]) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles inverse_z = one / p.z;
  rows[0][0] = rows[1][1] = one;
  rows[0][1] = rows[1][0] = zero;
  rows[0][2] = xsimd::select(has_third, zero, negated(p.x * inverse_z));
  rows[1][2] = xsimd::select(has_third, zero, negated(p.y * inverse_z));
  const Doubles near = xsimd::select(p.z < Doubles(input.min_depth), Doubles(is_too_near), Doubles(is_accepted));
  return xsimd::select(p.z <= zero, Doubles(is_behind), near);
}

// Writes only the lanes of `mask`.
inline void put(const Doubles& values, const Mask& mask, double* to) {
  xsimd::select(mask, values, Doubles::load_aligned(to)).store_aligned(to);
}

// J of the matches of one camera; the batch's points are p_b.
template <BlockWeighting weighting, ThirdRow third>
inline void linearise_with(const BlockInput& input, std::size_t number, SeenBatch& batch) {
  constexpr bool is_by_map = weighting == BlockWeighting::map_bias || weighting == BlockWeighting::map_bias_world;
  const CameraInput& camera = input.cameras[number];
  const double* const T = camera.T_cb;
  for (std::size_t i = 0; i < batch.count; i += double_lanes) {
    Mask is_its(true);
    if (input.camera_ids != nullptr) is_its = load(batch.camera, i) == Doubles(static_cast<double>(number));
    if (!xsimd::any(is_its)) continue;
    Mask has_third(third != ThirdRow::none);
    if (third != ThirdRow::none && input.has_third != nullptr) has_third = load(batch.has_third, i) > Doubles(0.0);
    Point p = load_point(batch, i);
    if (input.is_rig) p = transform(T, p);
    Doubles rows[3][3];
    const Doubles refusal =
        is_by_map ? linearise_bias(input, p, has_third, rows) : linearise(input, camera, batch, i, p, rows);
    add_third<third == ThirdRow::stereo && !is_by_map>(camera.bf, p.z, has_third, rows);
    if (input.is_rig) rotate_to_body(T, rows);
    put(refusal, is_its, batch.refusal + i);
    for (int e = 0; e < 9; ++e) put(rows[e / 3][e % 3], is_its, batch.jacobian[e] + i);
    for (int d = 0; weighting == BlockWeighting::map_bias_world && d < 3; ++d) {
      const Doubles along = Doubles(T[d]) * p.x + Doubles(T[4 + d]) * p.y + Doubles(T[8 + d]) * p.z;
      put(along, is_its, batch.ray[d] + i);
    }
  }
}

inline bool is_weighable(const BlockInput& input, const Batch& batch, std::size_t i) {
  if (input.sigmas != nullptr && !(batch.sigma[i] > 0 && batch.sigma[i] <= largest_double)) return false;
  return input.weights == nullptr || batch.weight[i] >= 0;
}

// Transforms points to the body's frame, finds their J, and removes from the batch matches that have none, or no
// weight.
template <BlockWeighting weighting, ThirdRow third>
inline void linearise_and_filter(const BlockInput& input, SeenBatch& batch, BlockOutput& output) {
  fill_seen(input, batch);
  std::uint32_t kept[batch_size];
  std::uint32_t finite[batch_size / double_lanes];
  for (std::size_t i = 0; i < batch.count; i += double_lanes) {
    const Point p = transform(input.T_cw, load_point(batch, i));
    p.x.store_aligned(batch.point[0] + i);
    p.y.store_aligned(batch.point[1] + i);
    p.z.store_aligned(batch.point[2] + i);
    finite[i / double_lanes] = lanes_of(is_finite(p.x) & is_finite(p.y) & is_finite(p.z));
  }
  for (std::size_t word = 0; word < 4; ++word) {
    for (std::uint64_t rest = batch.cameras[word]; rest != 0; rest &= rest - 1) {
      linearise_with<weighting, third>(input, 64 * word + static_cast<std::size_t>(__builtin_ctzll(rest)), batch);
    }
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < batch.count; ++i) {
    if ((finite[i / double_lanes] >> (i % double_lanes) & 1U) == 0) continue;
    output.behind_camera += batch.refusal[i] == is_behind ? 1 : 0;
    output.too_near += batch.refusal[i] == is_too_near ? 1 : 0;
    output.invalid_jacobians += batch.refusal[i] == has_no_jacobian ? 1 : 0;
    kept[count] = static_cast<std::uint32_t>(i);
    count += batch.refusal[i] == is_accepted && is_weighable(input, batch, i) ? 1 : 0;
  }
  if (count == batch.count) return;
  keep_matches(batch, kept, count);
  for (auto& entry : batch.jacobian) keep(entry, kept, count);
  for (auto& coordinate : batch.ray) keep(coordinate, kept, count);
}

}  // namespace
