// SPDX-License-Identifier: MIT
// What is asked of plain arrays of float32.

namespace {

std::size_t list_tiles(const float* values, std::size_t count, float lower, float upper, Tile* list) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += float_lanes) {
    const Floats value = Floats::load_unaligned(values + i);
    found += list_lanes((value >= Floats(lower)) & !(value >= Floats(upper)), static_cast<Tile>(i), list + found);
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

}  // namespace
