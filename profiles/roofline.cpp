// SPDX-License-Identifier: MIT
// Compares the evaluation of a full round with the limits of this core: its peak of float32 fused multiply-adds, and
// the loads from its L2 cache. All measurements take turns in short pieces, so that a transient load slows all of them
// down. Writes JSON. Compiled for this processor, with vector types of gcc and clang.
#include "bench/world/scene.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/factor.hpp"
#include "simd/kernel.hpp"

#include <unistd.h>
#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace maxlogdet::profiles {

namespace {

#if defined(__AVX512F__)
constexpr std::size_t lanes = 16;  // float32 in a vector
constexpr int chains = 16;         // independent sums: more than latency times throughput, and in registers
#elif defined(__AVX2__)
constexpr std::size_t lanes = 8;
constexpr int chains = 12;
#else
constexpr std::size_t lanes = 4;
constexpr int chains = 12;
#endif
using Pack = float __attribute__((vector_size(lanes * sizeof(float))));

template <std::size_t n>
float total(const Pack (&packs)[n]) {
  Pack all = packs[0];
  for (std::size_t i = 1; i < n; ++i) all += packs[i];
  float result = 0;
  for (std::size_t lane = 0; lane < lanes; ++lane) result += all[lane];
  return result;
}

float multiply_add(std::size_t steps, float factor, float addend) {
  Pack x[chains] = {};
  for (int chain = 0; chain < chains; ++chain) x[chain] += static_cast<float>(chain);  // equal ones would be merged
  for (std::size_t step = 0; step < steps; ++step) {
    for (Pack& chain : x) chain = chain * factor + addend;
  }
  return total(x);
}

constexpr std::size_t partial_sums = 8;

float sum(const float* data, std::size_t count, std::size_t passes) {
  Pack x[partial_sums] = {};
  for (std::size_t pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < count; i += partial_sums * lanes) {
      for (std::size_t j = 0; j < partial_sums; ++j) {
        Pack loaded;
        std::memcpy(&loaded, data + i + j * lanes, sizeof loaded);
        x[j] += loaded;
      }
    }
  }
  return total(x);
}

constexpr std::size_t turns = 2000;
constexpr double piece_seconds = 30e-6;  // longer than reading the clock takes, shorter than a time slice

double seconds_of(const std::function<void()>& work, std::size_t times) {
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < times; ++i) work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A piece of work that does `amount` of something in each call.
class Measurement {
 public:
  Measurement(double amount, std::function<void()> work) : amount_(amount), work_(std::move(work)) {
    while (seconds_of(work_, times_) < piece_seconds) times_ *= 2;
  }

  void take_turn() {
    work_();  // fills the caches with its own data again
    highest_ = std::max(highest_, amount_ * static_cast<double>(times_) / seconds_of(work_, times_));
  }

  double highest() const { return highest_; }  // of `amount` per second

 private:
  double amount_;
  std::function<void()> work_;
  std::size_t times_ = 1;
  double highest_ = 0;
};

volatile float sink = 0;  // keeps the compiler from dropping the work

// Of flops.
Measurement peak() {
  constexpr std::size_t steps = 1000;
  return {2.0 * steps * chains * lanes, [] { sink = multiply_add(steps, 0.5F, 1.0F); }};
}

// Of bytes loaded from an array of a fourth of the L2 cache, as the operating system reports it, or of a common size.
Measurement loads() {
  constexpr std::size_t passes = 8;
  const long reported = sysconf(_SC_LEVEL2_CACHE_SIZE);
  const std::size_t bytes = (reported > 0 ? static_cast<std::size_t>(reported) : 524288) / 4;
  const std::size_t count = bytes / sizeof(float) / (partial_sums * lanes) * (partial_sums * lanes);
  const auto memory = std::make_shared<std::vector<float>>(count + lanes, 1.0F);
  void* aligned = memory->data();
  std::size_t space = memory->size() * sizeof(float);
  std::align(sizeof(Pack), count * sizeof(float), aligned, space);
  return {static_cast<double>(passes * count * sizeof(float)),
          [memory, aligned, count] { sink = sum(static_cast<const float*>(aligned), count, passes); }};
}

// The arithmetic of one gain in float32. Y = H W^T takes 6 products and 15 fused multiply-adds per row; a dot product
// of two rows takes 1 and 5; the relative gain takes what relative_gain_by_minors
// in simd/gains.inl does. A fused multiply-add counts as 2 flops and 1 vector operation, a division as 1; conversions,
// loads and comparisons do not count.
struct Arithmetic {
  int rows;
  int flops;
  int vector_operations;

  // Read and written: the entries of a block, whether it remains, and the gain.
  double bytes() const { return static_cast<double>(static_cast<std::size_t>(6 * rows + 2) * sizeof(float)); }
};
constexpr Arithmetic arithmetics[] = {{2, 110, 63}, {3, 200, 118}};

// Evaluates the gains of all candidates, in the middle of a selection.
class FullRound {
 public:
  static constexpr std::size_t candidates = 2000;

  explicit FullRound(int rows) : rows_(rows) {
    for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
      if (std::strcmp(active_isa(), (*kernel)->isa) == 0) kernel_ = *kernel;
    }
    const sim::Frame frame = make_scene(sim::Scene::euroc_like, candidates, 1);
    const DepthCue depth_cue = rows == 3 ? DepthCue::stereo : DepthCue::none;
    BlockStore blocks(candidates);
    build_blocks(frame, feature_matches(frame, depth_cue), BlockOptions(), blocks);
    for (std::size_t i = 0; i < tiles_.size(); ++i) tiles_[i] = static_cast<Tile>(i);
    fill_tiles(blocks);
    InformationFactor factor;
    double prior[simd::dimension * simd::dimension] = {};
    for (std::size_t i = 0; i < std::size(prior); i += simd::dimension + 1) prior[i] = 1e-5;  // weak
    factor.reset(prior);
    for (std::size_t selected = 0; selected < 50; ++selected) {
      double h[max_block_rows][state_dimension];
      Candidates(blocks, *kernel_).read_rows(static_cast<Index>(selected), h);
      factor.add_block(*kernel_, h, rows);
    }
    for (std::size_t i = 0; i < std::size(w_); ++i) w_[i] = static_cast<float>(factor.inverse()[i]);
  }

  void operator()() noexcept {
    const simd::Tiles tiles{entries_.data(), in_each_.size(), remaining_.data(), in_each_.data()};
    const simd::RoundArrays arrays{nullptr, highest_.data(), relative_gains_.data(), nullptr};
    kernel_->evaluate[rows_ - 1](tiles, w_, tiles_.data(), tiles_.size(), arrays);
  }

 private:
  void fill_tiles(const BlockStore& blocks) {
    const simd::Form form = simd::form_of_rows(rows_);
    const simd::LayoutFunctions& layout = kernel_->layouts[form];
    std::vector<float> records(candidates * simd::record_size(form));
    layout.make_records({blocks.planes(), blocks.stride()}, candidates, records.data());
    std::vector<Index> all(candidates);
    for (std::size_t i = 0; i < candidates; ++i) all[i] = static_cast<Index>(i);
    entries_.resize(candidates * simd::entries_of(form));
    layout.gather(records.data(), all.data(), candidates, entries_.data());
  }

  static constexpr std::size_t tile_count = candidates / simd::tile_size;
  int rows_;
  const simd::Kernel* kernel_ = nullptr;
  std::vector<float> entries_;
  float w_[simd::dimension * simd::padded_dimension];
  std::vector<float> remaining_ = std::vector<float>(candidates, 1.0F);
  std::vector<float> relative_gains_ = std::vector<float>(candidates);
  std::vector<float> highest_ = std::vector<float>(tile_count + simd::tile_size);
  std::vector<unsigned char> in_each_ = std::vector<unsigned char>(tile_count, simd::tile_size);
  std::vector<Tile> tiles_ = std::vector<Tile>(tile_count);
};

nlohmann::ordered_json measure() {
  Measurement flops = peak(), bytes = loads();
  std::vector<Measurement> gains;
  for (const Arithmetic& arithmetic : arithmetics) {
    const auto round = std::make_shared<FullRound>(arithmetic.rows);
    gains.emplace_back(FullRound::candidates, [round] { (*round)(); });
  }
  for (std::size_t turn = 0; turn < turns; ++turn) {
    flops.take_turn();
    bytes.take_turn();
    for (Measurement& of_rows : gains) of_rows.take_turn();
  }
  nlohmann::ordered_json result = {
      {"isa", active_isa()}, {"peak_gflops", 1e-9 * flops.highest()}, {"l2_gb_s", 1e-9 * bytes.highest()}};
  for (std::size_t i = 0; i < std::size(arithmetics); ++i) {
    const Arithmetic& arithmetic = arithmetics[i];
    const double per_second = gains[i].highest();
    result["full_round"].push_back({{"rows", arithmetic.rows},
                                    {"ns_per_gain", 1e9 / per_second},
                                    {"share_of_peak", per_second * arithmetic.flops / flops.highest()},
                                    {"share_of_slots", 2 * per_second * arithmetic.vector_operations / flops.highest()},
                                    {"gb_s", 1e-9 * per_second * arithmetic.bytes()}});
  }
  return result;
}

}  // namespace
}  // namespace maxlogdet::profiles

int main() {
  std::printf("%s\n", maxlogdet::profiles::measure().dump(2).c_str());
  return 0;
}
