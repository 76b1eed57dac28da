// SPDX-License-Identifier: MIT
// select() from a filled store, and Eigen's selections from the same blocks: a grid of n, k, epsilon and instruction
// sets, other blocks and frames at its base point, and one thread against several.
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/world/data_folder.hpp"
#include "bench/world/executor.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/names.hpp"
#include "bench/world/scene.hpp"
#include "bench/world/tracker_frames.hpp"
#include "tests/support/processor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace maxlogdet::bench {
namespace {

constexpr const char* nearly_equal_gains = "nearly_equal_gains";
constexpr const char* real_frames = "real_frames";

constexpr sim::TrackerKind two_rows{"2_rows", DepthCue::none, false};
constexpr sim::TrackerKind three_rows{"3_rows", DepthCue::stereo, false};

struct Case {
  std::string kind = "grid";
  Strategy strategy = Strategy::lazy_greedy;
  std::string family = "euroc_like";
  std::size_t n = 2000;
  std::size_t k = 100;
  sim::TrackerKind blocks = two_rows;
  double epsilon = 0.1;  // of stochastic greedy
  std::string isa = active_isa();
  Executor* helpers = nullptr;
  int threads = 1;

  bool is_stochastic() const { return strategy == Strategy::stochastic_greedy; }

  std::string name(const std::string& method, const std::string& on) const {
    char sampled[32] = "";
    if (is_stochastic()) std::snprintf(sampled, sizeof sampled, "/epsilon:%g", epsilon);
    return kind + "/" + method + "/family:" + family + "/n:" + std::to_string(n) + "/k:" + std::to_string(k) +
           "/blocks:" + blocks.name + sampled + "/isa:" + on + "/threads:" + std::to_string(threads);
  }
};

BlockStore store_of(const sim::Frame& frame, const sim::TrackerKind& kind) {
  BlockStore blocks(frame.matches.size());
  build_blocks(frame, feature_matches(frame, kind.depth_cue), BlockOptions(), blocks);
  return blocks;
}

// n copies of a block, each with one entry changed by one float32 ulp, so that only float64 can tell the copies apart:
// in each round all gains are nearly equal and all bounds stale, and laziness saves nothing.
BlockStore near_copies(const BlockStore& blocks, std::size_t n) {
  double block[max_block_rows * state_dimension];
  blocks.block(0, block);
  BlockStore copies(n);
  for (std::size_t i = 0; i < n; ++i) {
    double& entry = block[i % static_cast<std::size_t>(blocks.rows() * state_dimension)];
    const double exact = entry;
    entry = static_cast<double>(std::nextafter(static_cast<float>(exact), i % 2 == 0 ? 1e9F : -1e9F));
    copies.push_back(block, blocks.rows());
    entry = exact;
  }
  return copies;
}

std::string real_frames_folder() {
  const std::string folder = sim::data_folder() + "/orb_slam2_frames";
  return std::filesystem::is_directory(folder) ? folder : "";
}

// What calls select from in turn, made once and kept: one frame of n matches, or all recorded ones, whatever n is.
const std::vector<BlockStore>& stores_of(const Case& at) {
  static std::map<std::tuple<std::string, std::size_t, std::string>, std::vector<BlockStore>> kept;
  std::vector<BlockStore>& stores = kept[{at.family, at.n, at.blocks.name}];
  if (!stores.empty()) return stores;
  if (at.family == real_frames) {
    for (const sim::Frame& frame : sim::read_frames(real_frames_folder())) stores.push_back(store_of(frame, at.blocks));
  } else {
    stores.push_back(store_of(make_scene(sim::Scene::euroc_like, at.n, 1), at.blocks));
    if (at.family == nearly_equal_gains) stores.front() = near_copies(stores.front(), at.n);
  }
  return stores;
}

Work library_work(const Case& at) {
  struct State {
    Selector selector;
    Options options;
    Selection selection{};
  };
  const auto& stores = stores_of(at);
  std::size_t capacity = 0;
  for (const BlockStore& store : stores) capacity = std::max(capacity, store.size());
  const test::ForcedIsa forced(at.isa.c_str());
  const std::shared_ptr<State> state(new State{Selector(capacity, at.helpers), {}});
  state->options.strategy = at.strategy;
  state->options.budget = at.k;
  state->options.prior = common_prior();
  state->options.threads = at.threads;
  state->options.stochastic.epsilon = at.epsilon;
  const auto run = [state, &stores](std::size_t call) {
    state->options.stochastic.seed = call;
    state->selection = state->selector.select(stores[call % stores.size()], state->options);
  };
  const auto record = [state](std::size_t /*call*/, Sums& sums) { sums["log_det"] += state->selection.log_det; };
  return {run, record, {}, stores.size()};
}

Work eigen_work(const Case& at) {
  const auto& stores = stores_of(at);
  const std::shared_ptr<EigenSelector> selector = make_eigen_selector(stores.front());
  const auto run = [selector, at](std::size_t call) {
    if (at.is_stochastic()) return selector->stochastic_greedy(at.k, at.epsilon, call);
    selector->lazy_greedy(at.k);
  };
  const auto load = [selector, &stores](std::size_t call) { selector->load(stores[call % stores.size()]); };
  return {run, {}, load, stores.size()};
}

void add(const Case& at) {
  add_case(at.name(to_string(at.strategy), at.isa), [at] { return library_work(at); });
}

// Eigen's counterpart of the two strategies that save evaluations; of greedy there is none.
void add_eigen(const Case& at) {
  if (at.strategy == Strategy::greedy) return;
  const char* const method = at.is_stochastic() ? "eigen_stochastic" : "eigen_lazy_scan";
  add_case(at.name(method, "native"), [at] { return eigen_work(at); });
}

void add_grid() {
  Case at;
  for (const Strategy strategy : strategies) {
    at.strategy = strategy;
    for (const std::size_t n : {200U, 465U, 2000U, 20000U}) {
      at.n = n;
      for (const std::size_t k : {50U, 100U, 200U}) {
        at.k = k;
        for (const double epsilon : {0.1, 0.5, 0.01}) {
          if (!at.is_stochastic() && epsilon != 0.1) continue;
          at.epsilon = epsilon;
          for (const std::string& isa : sim::supported_isas()) {
            at.isa = isa;
            add(at);
          }
          add_eigen(at);
        }
      }
    }
  }
}

void add_other_frames() {
  std::vector<Case> others(3);
  others[0].blocks = three_rows;
  others[1].family = nearly_equal_gains;
  others[2].family = real_frames;
  if (real_frames_folder().empty()) {
    std::fprintf(stderr, "real frames are skipped: their folder is missing; MAXLOGDET_DATA names it\n");
    others.pop_back();
  }
  for (const Case& at : others) {
    add(at);
    add_eigen(at);
  }
}

// What threads gain over n.
void add_threads() {
  Case at;
  at.kind = "threads";
  at.helpers = sim::executor();
  const int most = at.helpers == nullptr ? 1 : at.helpers->concurrency();
  if (most == 1) return;
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
    at.strategy = strategy;
    for (const std::size_t n : std::vector<std::size_t>{10000, 20000, 50000, 100000}) {
      at.n = n;
      for (const int count : {1, most}) {
        at.threads = count;
        add(at);
      }
    }
  }
}

}  // namespace

void add_selection_cases() {
  add_grid();
  add_other_frames();
  add_threads();
}

}  // namespace maxlogdet::bench
