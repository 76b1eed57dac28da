// SPDX-License-Identifier: MIT
// What a tracker pays between two frames: building the blocks of some hundred matches, and the selection; and all that
// GoodFeatures does, which aligns the pose before. KITTI-like frames, all matches stereo or all monocular.
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/how_fast/tracker_frames.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/processor.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::bench {
namespace {

struct Task {
  Kind kind;
  std::size_t n;
  std::size_t k = 100;
  std::string isa = active_isa();
  Strategy strategy = Strategy::lazy_greedy;
};

// append_blocks, select, or both.
Work library_work(const Task& task, bool builds, bool selects) {
  struct State {
    explicit State(std::size_t capacity) : blocks(capacity), selector(capacity) {}
    BlockStore blocks;
    Selector selector;
    Options options;
    Selection selection{};
  };
  const test::ForcedIsa forced(task.isa.c_str());
  const auto state = std::make_shared<State>(task.n);
  state->options.budget = task.k;
  state->options.strategy = task.strategy;
  const TrackerFrames& frames = frames_of(task.kind, task.n);
  const auto run = [=, &frames](std::size_t call) {
    if (builds) frame_of(frames, call).build(state->blocks);
    if (!selects) return;
    state->options.stochastic.seed = call;
    state->selection = state->selector.select(state->blocks, state->options);
  };
  const auto record = [=](std::size_t /*call*/, Sums& sums) {
    if (selects) sums["log_det"] += state->selection.log_det;
  };
  const auto prepare = [=, &frames](std::size_t call) {
    if (!builds) state->blocks = frame_of(frames, call).store;
  };
  return {run, record, prepare, frame_count};
}

Work eigen_work(const Task& task) {
  const TrackerFrames& frames = frames_of(task.kind, task.n);
  const std::shared_ptr<EigenSelector> selector = make_eigen_selector(frame_of(frames, 0).store);
  const auto run = [=](std::size_t call) {
    if (task.strategy == Strategy::lazy_greedy) return selector->lazy_greedy(task.k);
    selector->stochastic_greedy(task.k, Options().stochastic.epsilon, call);
  };
  const auto load = [selector, &frames](std::size_t call) { selector->load(frame_of(frames, call).store); };
  return {run, {}, load, frame_count};
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

// align() of matches that are added already; or all that a tracker calls, with a selection.
Work good_features_work(const Task& task, bool selects) {
  const test::ForcedIsa forced(task.isa.c_str());
  const auto good = std::make_shared<GoodFeatures>(task.n);
  const TrackerFrames& frames = frames_of(task.kind, task.n);
  const auto fill = [good, &frames](std::size_t call) {
    const TrackerFrame& frame = frame_of(frames, call);
    good->start(Camera(frame.frame.camera), frame.T_predicted);
    for (const FeatureMatch& match : frame.measured) good->add(match);
  };
  const auto record = [good, &frames](std::size_t call, Sums& sums) {
    record_alignment(frame_of(frames, call), *good, sums);
  };
  if (!selects) return {[good](std::size_t /*call*/) { good->align(); }, record, fill, frame_count};
  const auto run = [good, fill, k = task.k](std::size_t call) {
    fill(call);
    good->select(k);
  };
  return {run, record, {}, frame_count};
}

Work eigen_alignment_work(const Task& task) {
  const auto aligner = std::make_shared<EigenAligner>();
  const TrackerFrames& frames = frames_of(task.kind, task.n);
  const auto run = [aligner, &frames](std::size_t call) {
    const TrackerFrame& frame = frame_of(frames, call);
    aligner->align(frame.frame.camera, frame.T_predicted, frame.measured);
  };
  return {run, {}, {}, frame_count};
}

std::string name_of(const std::string& method, const Task& task, Caches caches, const std::string& isa) {
  return "tracker/" + method + "/caches:" + to_string(caches) + "/matches:" + task.kind.name +
         "/n:" + std::to_string(task.n) + "/k:" + std::to_string(task.k) + "/isa:" + isa;
}

// The steps of a frame, with the library and with Eigen.
void add_frame(const Task& task, Caches caches) {
  const auto ours = [&](const char* method, std::function<Work()> make_work) {
    add_case(name_of(method, task, caches, task.isa), std::move(make_work), caches);
  };
  ours("align", [task] { return good_features_work(task, false); });
  ours("good_features", [task] { return good_features_work(task, true); });
  ours("append_blocks", [task] { return library_work(task, true, false); });
  ours("lazy_greedy", [task] { return library_work(task, false, true); });
  ours("blocks_and_select", [task] { return library_work(task, true, true); });
  if (task.isa != active_isa()) return;
  add_case(
      name_of("eigen_align", task, caches, "native"), [task] { return eigen_alignment_work(task); }, caches);
  add_case(
      name_of("eigen_lazy_scan", task, caches, "native"), [task] { return eigen_work(task); }, caches);
}

void add_stochastic(Task task) {
  task.strategy = Strategy::stochastic_greedy;
  add_case(name_of("stochastic_greedy", task, Caches::hot, task.isa),
           [task] { return library_work(task, false, true); });
  add_case(name_of("eigen_stochastic", task, Caches::hot, "native"), [task] { return eigen_work(task); });
}

}  // namespace

void add_tracker_cases() {
  std::vector<std::string> isas = {active_isa()};
  if (isas.front() != "avx2" && isa_is_supported("avx2")) isas.emplace_back("avx2");
  for (const Kind& kind : kinds) {
    for (const std::size_t n : {200U, 465U, 1000U, 2000U}) {
      for (const Caches caches : {Caches::hot, Caches::cold}) {
        for (const std::string& isa : isas) add_frame({kind, n, 100, isa}, caches);
      }
      add_stochastic({kind, n});
    }
    const Task larger{kind, 465, 200};
    add_case(
        name_of("good_features", larger, Caches::cold, larger.isa),
        [larger] { return good_features_work(larger, true); }, Caches::cold);
  }
  const Task baseline{stereo, 465};
  add_case(
      "baseline/eigen_lazy_scan", [baseline] { return eigen_work(baseline); }, Caches::hot, 80);
}

}  // namespace maxlogdet::bench
