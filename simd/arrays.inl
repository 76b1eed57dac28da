// SPDX-License-Identifier: MIT
// What is asked of plain arrays of float32.

namespace {

template <class Index>
std::size_t list_between(const float* values, std::size_t count, float lower, float upper, Index* list) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += float_lanes) {
    const Floats value = Floats::load_unaligned(values + i);
    found += list_lanes((value >= Floats(lower)) & !(value >= Floats(upper)), static_cast<Index>(i), list + found);
  }
  while (found > 0 && number(list[found - 1]) >= count) --found;  // beyond the end of values
  return found;
}

float largest(const float* values, std::size_t count) {
  Floats maxima(-1.0F);
  std::size_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) maxima = xsimd::max(maxima, Floats::load_unaligned(values + i));
  float most = largest_lane(maxima);
  for (; i < count; ++i) most = values[i] > most ? values[i] : most;
  return most;
}

float largest_magnitude(const float* values, std::size_t count) {
  Floats magnitudes(0.0F);
  std::size_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) {
    magnitudes = xsimd::max(magnitudes, xsimd::abs(Floats::load_unaligned(values + i)));
  }
  float largest = largest_lane(magnitudes);
  for (; i < count; ++i) {
    const float magnitude = values[i] < 0 ? -values[i] : values[i];
    largest = magnitude > largest ? magnitude : largest;
  }
  return largest;
}

// Values are counted in packs of ones, which are exact up to 2^24 each, in independent sums.
std::size_t count_at_least(const float* values, std::size_t count, float threshold) {
  constexpr std::size_t chains = tile_size / float_lanes < 4 ? 4 : tile_size / float_lanes;
  Floats counts[chains];
  for (Floats& chain : counts) chain = Floats(0.0F);
  const auto ones = [values, threshold](std::size_t i) {
    return xsimd::select(Floats::load_unaligned(values + i) >= Floats(threshold), Floats(1.0F), Floats(0.0F));
  };
  std::size_t i = 0;
  for (; i + chains * float_lanes <= count; i += chains * float_lanes) {
    for (std::size_t chain = 0; chain < chains; ++chain) {
      counts[chain] = counts[chain] + ones(i + chain * float_lanes);
    }
  }
  for (; i < count; i += float_lanes) counts[0] = counts[0] + ones(i);
  std::size_t sum = 0;
  for (const Floats& chain : counts) {
    float lanes[float_lanes];
    chain.store_unaligned(lanes);
    for (const float lane : lanes) sum += static_cast<std::size_t>(lane);
  }
  return sum;
}

}  // namespace
