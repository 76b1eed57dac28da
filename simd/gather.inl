// SPDX-License-Identifier: MIT
// Candidates gathered into tiles of similar gains.

namespace maxlogdet::simd {
namespace {

// Transposes every 4 x 4 floats of four packs: between planes or tiles (one entry per row) and records (one candidate
// per row).
inline void transpose(Floats (&m)[4]) {
  const Floats ac_low = zip_low(m[0], m[2]);
  const Floats ac_high = zip_high(m[0], m[2]);
  const Floats bd_low = zip_low(m[1], m[3]);
  const Floats bd_high = zip_high(m[1], m[3]);
  m[0] = zip_low(ac_low, bd_low);
  m[1] = zip_high(ac_low, bd_low);
  m[2] = zip_low(ac_high, bd_high);
  m[3] = zip_high(ac_high, bd_high);
}

template <Form form>
void make_records(const Planes& planes, std::size_t count, float* records) {
  constexpr std::size_t size = record_size(form);
  constexpr std::size_t entries = entries_of(form);
  for (std::size_t i = 0; i < count; i += float_lanes, records += float_lanes * size) {
    float* to[float_lanes];
    for (std::size_t lane = 0; lane < float_lanes; ++lane) to[lane] = records + lane * size;
    for (std::size_t e = 0; e < size; e += 4) {
      Floats m[4];
      for (std::size_t j = 0; j < 4; ++j) {  // beyond the last entry: padding
        m[j] = Floats::load_unaligned(planes.data + plane_of(form, e + j < entries ? e + j : 0) * planes.stride + i);
      }
      transpose(m);
      for (std::size_t j = 0; j < 4; ++j) store_parts(m[j], to + j, e);
    }
  }
}

template <Form form>
void gather(const float* records, const Index* listed, std::size_t count, float* tiles) {
  constexpr std::size_t size = record_size(form);
  constexpr std::size_t entries = entries_of(form);
  for (std::size_t j = 0; j < count; j += tile_size, tiles += entries * tile_size) {
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      const float* from[float_lanes];
      for (std::size_t l = 0; l < float_lanes; ++l) from[l] = records + number(listed[j + lane + l]) * size;
      for (std::size_t e = 0; e < size; e += 4) {
        Floats m[4];
        for (std::size_t d = 0; d < 4; ++d) m[d] = load_parts(from + d, e);
        transpose(m);
        for (std::size_t d = 0; d < 4 && e + d < entries; ++d) m[d].store_unaligned(tiles + (e + d) * tile_size + lane);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::simd
