// SPDX-License-Identifier: MIT
// What a tracker pays between two frames: building the blocks of some hundred matches, and the selection; and all that
// GoodFeatures does, which aligns the pose before. KITTI-like frames, all matches stereo or all monocular; each case
// cycles through several frames. Hot caches: calls of a case follow each other, over all its frames. Cold caches: other
// work comes before each call.
#include "bench/how_fast/cases.hpp"
#include "bench/how_fast/eigen_alignment.hpp"
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/how_fast/tracker_frames.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/forced_isa.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

struct Task {
  Which which;
  std::size_t k = 100;
  std::string isa = active_isa();
  Strategy strategy = Strategy::lazy_greedy;
  bool builds = false;  // the blocks
  bool selects = false;
  const double* prior = nullptr;  // of the selection
};

Work library_work(const Task& task) {
  struct State {
    explicit State(std::size_t capacity) : blocks(capacity), selector(capacity) {}
    BlockStore blocks;
    Selector selector;
    Options options;
    Selection selection{};
  };
  const test::ForcedIsa forced(task.isa.c_str());
  const auto state = std::make_shared<State>(task.which.slots);
  state->options.budget = task.k;
  state->options.strategy = task.strategy;
  state->options.prior = task.prior;
  const TrackerFrames& frames = frames_of(task.which);
  const auto run = [state, &frames, task](std::size_t call) {
    const TrackerFrame& frame = frame_of(frames, call);
    if (task.builds) frame.build(state->blocks);
    if (!task.selects) return;
    state->options.stochastic.seed = call;
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
  const TrackerFrames& frames = frames_of(which);
  const std::shared_ptr<EigenSelector> selector = make_eigen_selector(method, frame_of(frames, 0).store);
  const auto run = [=](std::size_t call) { selector->select(k, epsilon, call); };
  const auto record = [=](std::size_t /*call*/, Sums& sums) {
    sums["log_det"] += selector->log_det();
    sums["evaluations"] += static_cast<double>(selector->evaluations());
  };
  return {run, record, [selector, &frames](std::size_t call) { selector->load(frame_of(frames, call).store); }};
}

// What an alignment found, beside its time: `aligned` has pose() and is_inlier().
template <class Aligned>
void record_alignment(const TrackerFrame& frame, const Aligned& aligned, Sums& sums) {
  std::size_t inliers = 0, wrong = 0;
  for (std::size_t i = 0; i < frame.measured.size(); ++i) {
    inliers += aligned.is_inlier(i) ? 1U : 0U;
    wrong += aligned.is_inlier(i) && frame.is_wrong[i] != 0 ? 1U : 0U;
  }
  std::array<double, 12> rows{};
  std::copy_n(aligned.pose().data(), rows.size(), rows.begin());
  sums["inliers"] += static_cast<double>(inliers);
  sums["wrong_percent"] += 100 * static_cast<double>(wrong) / static_cast<double>(inliers);
  sums["deviation_mm"] += 1e3 * sim::camera_distance(sim::pose_of(rows), sim::pose_of(frame.frame.T_cw_prior));
}

// align() of matches that are added already; or all that a tracker calls, with a selection of `k`.
Work good_features_work(const Task& task) {
  const test::ForcedIsa forced(task.isa.c_str());
  const auto good = std::make_shared<GoodFeatures>(task.which.slots);
  const TrackerFrames& frames = frames_of(task.which);
  const auto fill = [good, &frames](std::size_t call) {
    const TrackerFrame& frame = frame_of(frames, call);
    good->start(Camera(frame.frame.camera), frame.T_predicted);
    for (const FeatureMatch& match : frame.measured) good->add(match);
  };
  const auto record = [good, &frames](std::size_t call, Sums& sums) {
    record_alignment(frame_of(frames, call), *good, sums);
  };
  if (!task.selects) return {[good](std::size_t /*call*/) { good->align(); }, record, fill};
  const auto run = [good, fill, k = task.k](std::size_t call) {
    fill(call);
    good->select(k);
  };
  return {run, record};
}

Work eigen_alignment_work(const Which& which) {
  const auto aligner = std::make_shared<EigenAligner>();
  const TrackerFrames& frames = frames_of(which);
  const auto run = [aligner, &frames](std::size_t call) {
    const TrackerFrame& frame = frame_of(frames, call);
    aligner->align(frame.frame.camera, frame.T_predicted, frame.measured);
  };
  const auto record = [aligner, &frames](std::size_t call, Sums& sums) {
    record_alignment(frame_of(frames, call), *aligner, sums);
  };
  return {run, record};
}

// Evicts the caches and retrains the branch predictors: walks over 8 MiB and sorts 60 000 random numbers.
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

// The cases of one temperature: tracker/METHOD/caches:.../KEY:VALUE/..., which bench/how_fast/tracker_results.py looks
// up.
class Cases {
 public:
  Cases(const char* caches, const Turns& turns)
      : caches_(caches), group_(std::string("tracker, ") + caches + " caches", turns) {}

  // `more`: the rest of the case's name, /KEY:VALUE/...
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
  void align(const Task& task) {
    group_.add(name_of("align", task.which, task.k, task.isa), [=] { return good_features_work(task); });
  }
  void align_and_select(Task task) {
    task.selects = true;
    group_.add(name_of("good_features", task.which, task.k, task.isa), [=] { return good_features_work(task); });
  }
  void eigen_align(const Which& which) {
    group_.add(name_of("eigen_align", which, 100, "native"), [=] { return eigen_alignment_work(which); });
  }
  void eigen(EigenMethod method, const Which& which, std::size_t k = 100) {
    const double epsilon = Options().stochastic.epsilon;
    group_.add(name_of(to_string(method), which, k, "native"), [=] { return eigen_work(method, which, k, epsilon); });
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

void add_alignment_cases(Cases& cases, const std::vector<std::string>& isas) {
  for (const Kind& kind : {monocular, stereo_map}) {
    for (const std::size_t n : {200U, 465U, 1000U, 2000U}) {
      const Which which{kind, n, n};
      for (const std::string& isa : isas) {
        cases.align({which, 100, isa});
        cases.align_and_select({which, 100, isa});
      }
      cases.eigen_align(which);
    }
    cases.align_and_select({{kind, 465, 465}, 200, isas.front()});
  }
}

// Frames with unusable slots, against the same frames without these.
void add_sparse_cases(Cases& cases, const std::vector<std::string>& isas) {
  for (const Kind& kind : {monocular, stereo_map}) {
    for (const std::string& isa : isas) {
      cases.blocks_and_select({{kind, 377, 2005, Rest::unusable}, 100, isa}, "/slots:2005");
      cases.blocks_and_select({{kind, 377, 2005, Rest::absent}, 100, isa}, "/slots:377");
    }
  }
}

// The information of a prior with standard deviations of 5 cm and 0.6 degrees.
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
    add_alignment_cases(*cases, isas);
    add_sparse_cases(*cases, isas);
    add_prior_cases(*cases, isas);
  }
}

}  // namespace maxlogdet::bench
