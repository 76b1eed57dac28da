// SPDX-License-Identifier: MIT
// J = d z / d p_b of matches that cameras of any model see, one of them or a rig's, p_b the point in the body's frame;
// by the map's bias H_p^n^-1 [J; 0]. The factor of a block (factors_by_jacobian.inl) depends on nothing else.

namespace {

using maxlogdet::simd::CameraInput;
using maxlogdet::simd::rows_with;

// The rows of J by p_c; returns why there are none.
template <Weighting weighting, DepthCue third>
inline Doubles linearise(const BlockInput& input, const CameraInput& camera, const Batch& batch, std::size_t i,
                         const Point& p, Doubles (&rows)[rows_with(third)][3]) {
  const Mask has_third = third_of<third>(input, batch, i);
  Doubles refusal(is_accepted);
  Doubles depth = p.z;
  Mask is_behind = p.z <= Doubles(0.0);
  if constexpr (is_by_map_bias(weighting)) {
    const Factor<rows_with(third)> factor = map_bias_factor<third>(p, has_third);
    for (int e = 0; e < 3 * rows_with(third); ++e) {
      rows[e / 3][e % 3] = e % 3 < e / 3 ? Doubles(0.0) : factor.a[e / 3][e % 3];
    }
  } else {
    is_behind = !maxlogdet::simd::image_jacobian(camera, p, rows);
    if (!camera.is_depth_along_z) depth = xsimd::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    maxlogdet::simd::add_third_row<third>(camera.bf, p.z, has_third, rows);
  }
  refuse_near(input, depth, is_behind, refusal);
  return refusal;
}

// Writes only the lanes of `mask`.
inline void put(const Doubles& pack, const Mask& mask, std::size_t value, std::size_t i, Batch& batch) {
  store(xsimd::select(mask, pack, load(batch, value, i)), value, i, batch);
}

// J of the matches that this camera sees; the batch's points are p_b.
template <Weighting weighting, DepthCue third>
inline void linearise_with(const BlockInput& input, const CameraInput& camera, std::size_t number, Batch& batch) {
  const double* const T = camera.T_cb;
  for (std::size_t i = 0; i < batch.count; i += double_lanes) {
    Mask is_its(true);
    if (input.camera_ids != nullptr) is_its = load(batch, value::camera, i) == Doubles(static_cast<double>(number));
    if (!xsimd::any(is_its)) continue;
    const Point p_b = load_point(batch, value::point, i);
    const Point p = T == nullptr ? p_b : transform(T, p_b);
    Doubles rows[rows_with(third)][3];
    Doubles refusal = linearise<weighting, third>(input, camera, batch, i, p, rows);
    refuse(!(is_finite(p_b.x) & is_finite(p_b.y) & is_finite(p_b.z)), is_not_finite, refusal);
    put(refusal, is_its, value::refusal, i, batch);
    if constexpr (weighting == Weighting::map_bias_world) {
      Doubles ray[1][3] = {{p.x, p.y, p.z}};
      if (T != nullptr) maxlogdet::simd::rotate_to_body(T, ray);
      for (std::size_t d = 0; d < 3; ++d) put(ray[0][d], is_its, value::ray + d, i, batch);
    } else {
      if (T != nullptr) maxlogdet::simd::rotate_to_body(T, rows);
      for (std::size_t e = 0; e < std::size_t{3} * rows_with(third); ++e) {
        put(rows[e / 3][e % 3], is_its, value::jacobian + e, i, batch);
      }
    }
  }
}

template <Weighting weighting, DepthCue third>
inline void linearise(const BlockInput& input, Batch& batch) {
  for (std::size_t i = 0; i < batch.count; i += double_lanes) transform(input, batch, i);
  const std::size_t cameras = input.camera_ids == nullptr ? 1 : input.camera_count;
  for (std::size_t number = 0; number < cameras; ++number) {
    linearise_with<weighting, third>(input, input.cameras[number], number, batch);
  }
}

}  // namespace
