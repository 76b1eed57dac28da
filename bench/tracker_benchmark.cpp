// SPDX-License-Identifier: MIT
// What a tracker pays between two frames: blocks of some hundred matches, and the selection, with caches and branch
// predictors as they come. KITTI-like frames, all matches stereo or all monocular; each case goes round several frames.
// Hot: calls of a case one after the other, over all its frames. Cold: other work before each call.
#include "bench/cases.hpp"
#include "bench/eigen_baselines.hpp"
#include "bench/measure.hpp"
#include "bench/stereo_covariances.hpp"
#include "sim/draws.hpp"
#include "sim/scene.hpp"
#include "tests/support/forced_isa.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t frame_count = 4;  // so that branch predictors do not learn one
constexpr double metres_since_triangulation = 3;
constexpr double pixel_sigma = 0.5;  // of the triangulation

struct Kind {
  const char* name;
  Weighting weighting;
  ThirdMeasurement third;
};
constexpr Kind monocular{"2_rows_measurement", Weighting::measurement, ThirdMeasurement::none};
constexpr Kind stereo{"3_rows_measurement", Weighting::measurement, ThirdMeasurement::stereo};
constexpr Kind stereo_map{"3_rows_measurement_and_map", Weighting::measurement_and_map, ThirdMeasurement::stereo};
constexpr Kind kinds[] = {monocular, stereo, stereo_map};

// Which frames: of `slots` matches each, of which n may be selected, the others not `usable`, or `excluded`; or these n
// with nothing around them.
enum class Rest { absent, unusable, excluded };
struct Which {
  Kind kind;
  std::size_t n;
  std::size_t slots;
  Rest rest = Rest::absent;
};

struct TrackerFrame {
  explicit TrackerFrame(const Which& which, std::uint64_t seed)
      : frame(make_scene(sim::Scene::kitti_like, which.slots, seed)) {
    options.weighting = which.kind.weighting;
    options.third = which.kind.third;
    if (which.kind.weighting == Weighting::measurement_and_map) {
      frame.map_covariances = stereo_covariances(frame, metres_since_triangulation, pixel_sigma);
    }
    std::vector<std::uint32_t> order(which.slots);
    std::iota(order.begin(), order.end(), 0U);
    sim::Draws(seed).shuffle_front(order, which.n);
    is_usable.assign(which.slots, 0);
    for (std::size_t i = 0; i < which.n; ++i) is_usable[order[i]] = 1;
    if (which.rest == Rest::absent) order.resize(which.n);
    std::sort(order.begin(), order.end());
    arrays = std::make_unique<sim::MatchArrays>(frame, order);
    matches = arrays->view();
    matches.has_third = nullptr;  // all of them
    if (which.rest == Rest::unusable) matches.usable = is_usable.data();
    if (which.rest == Rest::excluded) {
      for (const unsigned char usable : is_usable) is_excluded.push_back(usable == 0 ? 1 : 0);
    }
    store.reserve(matches.size);
    build(store);
  }

  void build(BlockStore& blocks) const {
    blocks.clear();
    append_blocks(frame.camera, frame.T_cw_prior.data(), matches, options, blocks);
  }

  sim::Frame frame;
  BlockOptions options;
  std::unique_ptr<sim::MatchArrays> arrays;
  Matches matches;
  std::vector<unsigned char> is_usable;
  std::vector<unsigned char> is_excluded;  // empty: none
  BlockStore store;
};

using Frames = std::vector<std::unique_ptr<TrackerFrame>>;

// Made once and kept.
const Frames& frames_of(const Which& which) {
  static std::map<std::tuple<std::string, std::size_t, std::size_t, Rest>, Frames> kept;
  Frames& frames = kept[{which.kind.name, which.n, which.slots, which.rest}];
  for (std::uint64_t seed = 1; frames.size() < frame_count; ++seed) {
    frames.push_back(std::make_unique<TrackerFrame>(which, seed));
  }
  return frames;
}

const TrackerFrame& frame_of(const Frames& frames, std::size_t call) { return *frames[call % frames.size()]; }

struct Task {
  Which which;
  std::size_t k = 100;
  std::string isa = active_isa();
  Strategy strategy = Strategy::lazy_greedy;
  bool builds = false;   // the blocks
  bool selects = false;  // with a prior from the motion if there is one
  const double* prior = nullptr;
};

Work library_work(const Task& task) {
  struct State {
    explicit State(std::size_t capacity) : blocks(capacity), selector(capacity) {}
    BlockStore blocks;
    Selector selector;
    Options options;
    Selection selection{};
  };
  const sim::ForcedIsa forced(task.isa.c_str());
  const auto state = std::make_shared<State>(task.which.slots);
  state->options.budget = task.k;
  state->options.strategy = task.strategy;
  state->options.prior = task.prior;
  const Frames& frames = frames_of(task.which);
  const auto run = [state, &frames, task](std::size_t call) {
    const TrackerFrame& frame = frame_of(frames, call);
    if (task.builds) frame.build(state->blocks);
    if (!task.selects) return;
    state->options.seed = call;
    state->options.excluded = frame.is_excluded.empty() ? nullptr : frame.is_excluded.data();
    state->selection = state->selector.select(state->blocks, state->options);
  };
  const auto record = [state, selects = task.selects](std::size_t /*call*/, Sums& sums) {
    if (!selects) return;
    sums["log_det"] += state->selection.log_det;
    sums["evaluations"] += static_cast<double>(state->selection.evaluations);
  };
  if (task.builds) return {run, record};
  return {run, record, [state, &frames](std::size_t call) { state->blocks = frame_of(frames, call).store; }};
}

Work eigen_work(EigenMethod method, const Which& which, std::size_t k, double epsilon) {
  const Frames& frames = frames_of(which);
  const std::shared_ptr<EigenSelector> selector = make_eigen_selector(method, frame_of(frames, 0).store);
  const auto run = [=](std::size_t call) { selector->select(k, epsilon, call); };
  const auto record = [=](std::size_t /*call*/, Sums& sums) {
    sums["log_det"] += selector->log_det();
    sums["evaluations"] += static_cast<double>(selector->evaluations());
  };
  return {run, record, [selector, &frames](std::size_t call) { selector->load(frame_of(frames, call).store); }};
}

// Proposals `batch` at a time, of which matching finds this share, until the budget is reached.
Work active_work(const Which& which, const std::string& isa, std::size_t batch, double share) {
  constexpr std::size_t largest_batch = 32;
  struct State {
    explicit State(std::size_t capacity) : blocks(capacity), active(capacity) {}
    BlockStore blocks;
    ActiveSelection active;
    Options options;
    std::vector<unsigned char> is_matched;
    std::size_t proposals = 0;
  };
  const sim::ForcedIsa forced(isa.c_str());
  const auto state = std::make_shared<State>(which.slots);
  for (std::size_t i = 0; i < which.slots; ++i) {
    state->is_matched.push_back(sim::Draws(1, i).chance(share) ? 1 : 0);  // a hash of the index
  }
  const Frames& frames = frames_of(which);
  const auto prepare = [state, &frames](std::size_t call) { state->blocks = frame_of(frames, call).store; };
  const auto one_by_one = [state](std::size_t /*call*/) {
    ActiveSelection& active = state->active;
    active.start(state->blocks, state->options);
    state->proposals = 0;
    for (std::uint32_t i = active.next(); i != ActiveSelection::none; i = active.next()) {
      state->is_matched[i] != 0 ? active.accept() : active.reject();
      ++state->proposals;
    }
  };
  const auto in_batches = [state, batch](std::size_t /*call*/) {
    ActiveSelection& active = state->active;
    active.start(state->blocks, state->options);
    state->proposals = 0;
    std::uint32_t indices[largest_batch];
    unsigned char matched[largest_batch];
    for (std::size_t count = active.next(indices, batch); count > 0; count = active.next(indices, batch)) {
      for (std::size_t j = 0; j < count; ++j) matched[j] = state->is_matched[indices[j]];
      active.answer(matched, count);
      state->proposals += count;
    }
  };
  const auto record = [state](std::size_t /*call*/, Sums& sums) {
    sums["proposals"] += static_cast<double>(state->proposals);
    sums["log_det"] += state->active.selection().log_det;
    sums["evaluations"] += static_cast<double>(state->active.selection().evaluations);
  };
  if (batch == 1) return {one_by_one, record, prepare};
  return {in_batches, record, prepare};
}

// Leaves caches and branch predictors to something else: 8 MiB walked over, and 60 000 random numbers sorted.
class Disturbance {
 public:
  void operator()() {
    constexpr std::size_t cache_line = 64;
    for (std::size_t i = 0; i < memory_.size(); i += cache_line) ++memory_[i];
    for (int& number : numbers_) number = static_cast<int>(random_.bits() >> 33U);
    std::sort(numbers_.begin(), numbers_.end());
    benchmark::DoNotOptimize(memory_.data());
    benchmark::DoNotOptimize(numbers_.data());
    benchmark::ClobberMemory();
  }

 private:
  std::vector<unsigned char> memory_ = std::vector<unsigned char>(std::size_t{8} << 20U);
  std::vector<int> numbers_ = std::vector<int>(60000);
  sim::Draws random_{1};
};

// The cases of one temperature: tracker/METHOD/caches:.../KEY:VALUE/..., which bench/tracker_results.py looks up.
class Cases {
 public:
  Cases(const char* caches, const Turns& turns)
      : caches_(caches), group_(std::string("tracker, ") + caches + " caches", turns) {}

  // `more`: what else tells the case apart, /KEY:VALUE/...
  void library(const char* method, const Task& task, const std::string& more = "") {
    group_.add(name_of(method, task.which, task.k, task.isa) + more, [=] { return library_work(task); });
  }
  void blocks(Task task) {
    task.builds = true;
    library("append_blocks", task);
  }
  void select(Task task, const std::string& more = "") {
    task.selects = true;
    library(to_string(task.strategy), task, more);
  }
  void blocks_and_select(Task task, const std::string& more = "") {
    task.builds = task.selects = true;
    library("blocks_and_select", task, more);
  }
  void eigen(EigenMethod method, const Which& which, std::size_t k = 100) {
    const double epsilon = Options().epsilon;
    group_.add(name_of(to_string(method), which, k, "native"), [=] { return eigen_work(method, which, k, epsilon); });
  }
  void active(const Which& which, const std::string& isa, std::size_t batch, const std::string& share) {
    group_.add(name_of("active", which, 100, isa) + "/batch:" + std::to_string(batch) + "/matched:" + share,
               [=] { return active_work(which, isa, batch, std::stod(share)); });
  }

 private:
  std::string name_of(const std::string& method, const Which& which, std::size_t k, const std::string& isa) const {
    return "tracker/" + method + "/caches:" + caches_ + "/blocks:" + which.kind.name + "/n:" + std::to_string(which.n) +
           "/k:" + std::to_string(k) + "/isa:" + isa;
  }

  std::string caches_;
  Group group_;
};

void add_frame_cases(Cases& cases, const std::vector<std::string>& isas) {
  const auto add = [&](const Which& which, std::size_t k, const std::string& isa) {
    Task task{which, k, isa};
    cases.blocks(task);
    cases.select(task);
    cases.blocks_and_select(task);
  };
  for (const Kind& kind : kinds) {
    for (const std::size_t n : {200U, 350U, 465U, 500U, 1000U, 2000U}) {
      const Which which{kind, n, n};
      for (const std::string& isa : isas) add(which, 100, isa);
      cases.eigen(EigenMethod::lazy_scan, which);
      if (n != 465 && n != 2000) continue;
      for (const std::string& isa : isas) {
        Task task{which, 100, isa};
        task.strategy = Strategy::stochastic_greedy;
        cases.select(task);
      }
      cases.eigen(EigenMethod::stochastic, which);
    }
    for (const std::size_t k : {50U, 200U}) {
      const Which which{kind, 465, 465};
      add(which, k, isas.front());
      cases.eigen(EigenMethod::lazy_scan, which, k);
    }
  }
}

// Slots without a match, and candidates that are excluded, against a frame without them.
void add_sparse_cases(Cases& cases, const std::vector<std::string>& isas) {
  for (const Kind& kind : {monocular, stereo_map}) {
    for (const std::string& isa : isas) {
      cases.blocks_and_select({{kind, 377, 2005, Rest::unusable}, 100, isa}, "/slots:2005");
      cases.blocks_and_select({{kind, 377, 2005, Rest::absent}, 100, isa}, "/slots:377");
      cases.select({{kind, 400, 2000, Rest::excluded}, 100, isa}, "/slots:2000");
      cases.select({{kind, 400, 2000, Rest::absent}, 100, isa}, "/slots:400");
    }
  }
}

// A deviation of 5 cm and 0.6 degrees.
const double* motion_prior() {
  static const auto prior = [] {
    std::array<double, std::size_t{state_dimension} * state_dimension> information{};
    for (std::size_t i = 0; i < state_dimension; ++i) {
      const double deviation = i < 3 ? 0.05 : 0.01;  // m, rad
      information[(state_dimension + 1) * i] = 1 / (deviation * deviation);
    }
    return information;
  }();
  return prior.data();
}

void add_prior_cases(Cases& cases, const std::vector<std::string>& isas) {
  for (const std::string& isa : isas) {
    Task task{{stereo, 465, 465}, 100, isa};
    task.prior = motion_prior();
    cases.select(task, "/prior:motion");
  }
}

void add_active_cases(Cases& cases, const std::vector<std::string>& isas) {
  for (const std::size_t n : {800U, 3000U}) {
    const Which which{stereo_map, n, n};
    for (const std::string& isa : isas) {
      cases.select({which, 100, isa});
      for (const char* const share : {"1", "0.5", "0.2"}) {
        for (const std::size_t batch : {1U, 8U, 32U}) cases.active(which, isa, batch, share);
      }
    }
  }
}

}  // namespace

void add_tracker_cases() {
  std::vector<std::string> isas = {active_isa()};
  if (isas.front() != "avx2" && isa_is_supported("avx2")) isas.emplace_back("avx2");

  Turns hot_turns;
  hot_turns.untimed = frame_count;
  hot_turns.timed = 2 * frame_count;
  hot_turns.seconds_per_case = 0.3;
  Cases hot("hot", hot_turns);
  Turns cold_turns;
  cold_turns.disturb = Disturbance();
  cold_turns.seconds_per_case = 1;
  Cases cold("cold", cold_turns);
  for (Cases* const cases : {&hot, &cold}) {
    add_frame_cases(*cases, isas);
    add_sparse_cases(*cases, isas);
    add_prior_cases(*cases, isas);
  }
  add_active_cases(hot, isas);
}

}  // namespace maxlogdet::bench
