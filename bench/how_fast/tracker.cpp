// SPDX-License-Identifier: MIT
// What a tracker pays between two frames: building the blocks of some hundred matches, and the selection; and all that
// GoodFeatures does, which aligns the pose before. KITTI-like frames, all matches stereo or all monocular.
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/world/se3.hpp"
#include "bench/world/tracker_frames.hpp"
#include "tests/support/processor.hpp"

#include <maxlogdet/eigen.hpp>

#include <memory>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

struct Task {
  sim::TrackerKind kind;
  std::size_t n;
  std::size_t k = 100;
  std::string isa = active_isa();

  const sim::TrackerFrames& frames = sim::frames_of(kind, n);

  const sim::TrackerFrame& frame(std::size_t call) const { return frames[call % sim::frame_count]; }
};

// append_blocks, select, or both.
Work library_work(const Task& task, bool builds, bool selects) {
  struct State {
    BlockStore blocks;
    Selector selector;
    Options options;
    Selection selection{};
  };
  const test::ForcedIsa forced(task.isa.c_str());
  const std::shared_ptr<State> state(new State{BlockStore(task.n), Selector(task.n), {}});
  state->options.budget = task.k;
  state->options.prior = common_prior();
  const auto prepare = [=](std::size_t call) {
    if (!builds) task.frame(call).build(state->blocks);
  };
  const auto run = [=](std::size_t call) {
    if (builds) task.frame(call).build(state->blocks);
    if (!selects) return;
    state->selection = state->selector.select(state->blocks, state->options);
  };
  const auto record = [=](std::size_t /*call*/, Sums& sums) {
    if (selects) sums["log_det"] += state->selection.log_det;
  };
  return {run, record, prepare, sim::frame_count};
}

Work eigen_work(const Task& task) {
  const auto blocks = std::make_shared<BlockStore>(task.n);
  task.frame(0).build(*blocks);
  const std::shared_ptr<EigenSelector> selector = make_eigen_selector(*blocks);
  const auto load = [=](std::size_t call) {
    task.frame(call).build(*blocks);
    selector->load(*blocks);
  };
  return {[=](std::size_t /*call*/) { selector->lazy_greedy(task.k); }, {}, load, sim::frame_count};
}

// What an alignment found, beside its time.
void record_alignment(const sim::TrackerFrame& frame, const GoodFeatures& good, Sums& sums) {
  double inliers = 0, wrong = 0;
  for (std::size_t i = 0; i < frame.measured.size(); ++i) {
    inliers += good.is_inlier(i) ? 1 : 0;
    wrong += good.is_inlier(i) && frame.is_wrong[i] != 0 ? 1 : 0;
  }
  sums["inliers"] += inliers;
  sums["wrong_percent"] += 100 * wrong / inliers;
  sums["deviation_mm"] += 1e3 * sim::camera_distance(good.pose(), sim::pose_of(frame.frame.T_cw_prior));
}

// align() of matches that are added already; or all that a tracker calls, with a selection.
Work good_features_work(const Task& task, bool selects) {
  const test::ForcedIsa forced(task.isa.c_str());
  const auto good = std::make_shared<GoodFeatures>(task.n);
  const auto fill = [=](std::size_t call) {
    const sim::TrackerFrame& frame = task.frame(call);
    good->start(Camera(frame.frame.camera), frame.T_predicted);
    for (const FeatureMatch& match : frame.measured) good->add(match);
  };
  const auto record = [=](std::size_t call, Sums& sums) { record_alignment(task.frame(call), *good, sums); };
  if (!selects) return {[good](std::size_t /*call*/) { good->align(); }, record, fill, sim::frame_count};
  const auto run = [=](std::size_t call) {
    fill(call);
    good->select(task.k);
  };
  return {run, record, {}, sim::frame_count};
}

Work eigen_alignment_work(const Task& task) {
  const auto aligner = std::make_shared<EigenAligner>();
  const auto run = [=](std::size_t call) {
    const sim::TrackerFrame& frame = task.frame(call);
    aligner->align(frame.frame.camera, frame.T_predicted, frame.measured);
  };
  return {run, {}, {}, sim::frame_count};
}

template <class MakeWork>
void add(const std::string& method, const Task& task, Caches caches, const MakeWork& make_work) {
  const bool is_eigens = method.rfind("eigen_", 0) == 0;
  if (is_eigens && task.isa != active_isa()) return;  // once suffices
  const std::string name = "tracker/" + method + "/caches:" + to_string(caches) + "/matches:" + task.kind.name +
                           "/n:" + std::to_string(task.n) + "/k:" + std::to_string(task.k) +
                           "/isa:" + (is_eigens ? "native" : task.isa);
  add_case(
      name, [=] { return make_work(task); }, caches);
}

Work whole_frame(const Task& task) { return good_features_work(task, true); }

// The steps of a frame, with the library and with Eigen.
void add_frame(const Task& task, Caches caches) {
  add("align", task, caches, [](const Task& its) { return good_features_work(its, false); });
  add("good_features", task, caches, whole_frame);
  add("append_blocks", task, caches, [](const Task& its) { return library_work(its, true, false); });
  add("lazy_greedy", task, caches, [](const Task& its) { return library_work(its, false, true); });
  add("blocks_and_select", task, caches, [](const Task& its) { return library_work(its, true, true); });
  add("eigen_align", task, caches, eigen_alignment_work);
  add("eigen_lazy_scan", task, caches, eigen_work);
}

}  // namespace

void add_tracker_cases() {
  std::vector<std::string> isas = {active_isa()};
  if (isas.front() != "avx2" && isa_is_supported("avx2")) isas.emplace_back("avx2");
  for (const sim::TrackerKind& kind : sim::tracker_kinds) {
    for (const std::size_t n : {200U, 465U, 1000U, 2000U}) {
      for (const Caches caches : {Caches::hot, Caches::cold}) {
        for (const std::string& isa : isas) add_frame({kind, n, 100, isa}, caches);
      }
    }
    add("good_features", {kind, 465, 200}, Caches::cold, whole_frame);
  }
  add_case(
      "baseline/eigen_lazy_scan",
      [] {
        return eigen_work({sim::stereo_tracker, 465});
      },
      Caches::hot, 80);
}

}  // namespace maxlogdet::bench
