// SPDX-License-Identifier: MIT
// What holds of every adapter, in a tracker with the lines of docs/trackers.md; then the adapter of VINS-Fusion: body
// poses, depths in the first frame of a track, places in para_Feature.
#include "tests/api/integration/adapter_world.hpp"
#include "tests/api/integration/guide.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/text_folder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// Runs a frame, of which all matches are candidates.
std::set<std::size_t> continued_with(AdapterWorld& world, const char* status) {
  const std::set<std::size_t> kept = world.run();
  EXPECT_STREQ(world.hook().features.reason(), status);
  return kept;
}

TEST_P(AnyAdapter, the_tracker_continues_with_what_a_selector_selects_by_derivatives_under_a_left_perturbation) {
  const auto world = world_of(300, 100);
  const std::vector<SeenPoint> seen = world->seen();
  const std::set<std::size_t> kept = continued_with(*world, "ok");
  const BlockStore& blocks = world->hook().features.blocks();
  ASSERT_EQ(blocks.size(), 300U);
  EXPECT_LT(largest_difference(blocks, seen), GetParam().tolerance);
  const std::vector<std::uint32_t> expected = select_indices(blocks, world->hook().options);
  EXPECT_EQ(kept, std::set<std::size_t>(expected.begin(), expected.end()));
  EXPECT_EQ(kept.size(), 100U);
  for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(world->hook().features.is_selected(i), kept.count(i) > 0) << i;
}

// What is beyond the capacity continues as well.
TEST_P(AnyAdapter, few_candidates_and_after_an_error_all_of_them_continue_and_at_a_deadline_a_full_budget) {
  EXPECT_EQ(continued_with(*world_of(90, 100), "all_selected").size(), 90U);
  EXPECT_EQ(continued_with(*world_of(100, 100), "all_selected").size(), 100U);
  auto world = world_of(300, 100);
  world->hook().options.time_limit = 1e-9;
  EXPECT_EQ(continued_with(*world, "deadline_reached").size(), 100U);
  world->hook().options.time_limit = -1;
  EXPECT_EQ(continued_with(*world, "invalid_time_limit").size(), 300U);
  world = world_of(300, 100);
  world->lose_pose();
  EXPECT_EQ(continued_with(*world, "invalid_pose").size(), 300U);
  const std::set<std::size_t> kept = continued_with(*world_of(300, 100, 250), "capacity_exceeded");
  EXPECT_EQ(kept.size(), 150U);
  for (std::size_t i = 250; i < 300; ++i) EXPECT_EQ(kept.count(i), 1U) << i;
}

// An outlier that never enters the optimiser, or what the tracker has to judge itself.
TEST_P(AnyAdapter, what_is_not_finite_or_behind_the_camera_takes_no_place_of_the_budget) {
  for (const bool has_error : {false, true}) {
    for (const std::size_t budget : {100U, 500U}) {
      const auto world = world_of(300, budget);
      world->hook().options.time_limit = has_error ? -1 : 0;
      std::vector<std::size_t> unusable = {7, 8};
      for (const std::size_t i : unusable) world->make_not_finite(i);
      if (!has_error && budget < 300) {  // otherwise the tracker continues with it
        unusable.push_back(9);
        world->put_behind_camera(9);
      }
      const std::set<std::size_t> kept = world->run();
      for (const std::size_t i : unusable) {
        EXPECT_EQ(kept.count(i), world->has_outliers() ? 0U : 1U) << i;
        EXPECT_EQ(world->is_outlier(i), world->has_outliers()) << i;
      }
      const std::size_t usable = 300 - unusable.size();
      EXPECT_EQ(kept.size() - unusable.size() * kept.count(7), has_error ? usable : std::min(budget, usable));
    }
  }
}

TEST_P(AnyAdapter, a_frame_is_recorded_with_all_candidates_as_they_were_before) {
  const auto world = world_of(300, 100);
  TrackerHook& hook = world->hook();
  const TemporaryFolder folder;
  ASSERT_TRUE(hook.record(folder.path().c_str()));
  for (int frame = 0; frame < 2; ++frame) {
    hook.options.budget = frame == 0 ? 100 : 400;
    const std::set<std::size_t> kept = continued_with(*world, frame == 0 ? "ok" : "all_selected");
    EXPECT_EQ(kept.size(), frame == 0 ? 100U : 300U);
    const RecordedFrame recorded(folder / ("frame_00000" + std::to_string(frame) + ".csv"));
    ASSERT_EQ(recorded.rows.size(), 300U);
    for (std::size_t row = 0; row < 300; ++row) {
      EXPECT_EQ(recorded.at(row, "selected"), kept.count(row)) << row;
      for (const auto& [column, value] : world->recorded(row)) {
        EXPECT_DOUBLE_EQ(recorded.at(row, column), value) << row << ' ' << column;
      }
    }
  }
}

// A full window of n features that the newest frame sees in at least four frames; between them as many whose track is
// too short, or has ended.
class VinsFusionWorld : public AdapterWorld {
 public:
  VinsFusionWorld(Random& random, std::size_t n, std::size_t budget, std::size_t capacity) {
    estimator.good_features = VinsFusion(budget, capacity);
    estimator.good_features.features.rejects_outliers = false;  // its tracks fit no pose
    const sim::Pose T_bc = random_pose(random, 2, 0.9);
    estimator.frame_count = WINDOW_SIZE;
    for (int camera = 0; camera < 2; ++camera) {
      estimator.ric[camera] = T_bc.linear();
      estimator.tic[camera] = 0.1 * T_bc.translation();
    }
    for (int i = 0; i <= WINDOW_SIZE; ++i) {
      const sim::Pose T_wb = random_pose(random, 2, 0.9);
      estimator.Rs[i] = T_wb.linear();
      estimator.Ps[i] = T_wb.translation();
    }
    for (int id = 0; candidates.size() < n; ++id) {
      const bool is_short = id % 4 == 1, has_ended = id % 4 == 3;
      add_track(random, id, WINDOW_SIZE - 7 + (is_short ? 5 : random.integer(0, 4)),
                has_ended ? WINDOW_SIZE - 1 : WINDOW_SIZE);
      // In no order that anything may rely on.
      if (!is_short && !has_ended) candidates.insert(candidates.begin(), &estimator.f_manager.feature.front());
    }
  }

  TrackerHook& hook() override { return estimator.good_features; }

  // What is not left out of the problem.
  std::set<std::size_t> run() override {
    estimator.added.clear();
    estimator.optimization();
    std::set<std::size_t> kept;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!leaves_out(*candidates[i])) kept.insert(i);
    }
    EXPECT_EQ(estimator.good_features.left_out_count(), candidates.size() - kept.size());
    return kept;
  }
  bool leaves_out(const FeaturePerId& feature) const {
    return estimator.good_features.leaves_out(static_cast<std::uint64_t>(feature.feature_id));
  }

  std::vector<SeenPoint> seen() const override {
    const auto measured = [](const Eigen::Vector3d& p) { return seen_by_pinhole(p, 1, 1, 0); };
    std::vector<SeenPoint> all;
    for (const FeaturePerId* const feature : candidates) {
      const Eigen::Vector3d in_first = feature->feature_per_frame[0].point * feature->estimated_depth;
      all.push_back({measured, T_wc(WINDOW_SIZE).inverse() * (T_wc(feature->start_frame) * in_first), 1.5 / 460});
    }
    return all;
  }

  void lose_pose() override { estimator.Rs[WINDOW_SIZE] *= 2; }  // no rotation
  void make_not_finite(std::size_t i) override { candidates[i]->feature_per_frame[0].point.x() = nan; }
  void put_behind_camera(std::size_t i) override {
    const sim::Pose T_first = T_wc(candidates[i]->start_frame).inverse() * T_wc(WINDOW_SIZE);
    candidates[i]->feature_per_frame[0].point = T_first * Eigen::Vector3d(0.1, 0, -5);
    candidates[i]->estimated_depth = 1;
  }

  // As the newest image measures them, in normalised coordinates.
  std::map<std::string, double> recorded(std::size_t i) const override {
    const double id = candidates[i]->feature_id;
    return {{"mp_id", id}, {"u", id}, {"v", 0.5 * id}, {"inv_sigma2", std::pow(460 / 1.5, 2)}};
  }

  // VINS-Fusion's own chain: camera to body by ric, tic; body to world by Rs, Ps.
  sim::Pose T_wc(int frame) const {
    sim::Pose T_wb = sim::Pose::Identity(), T_bc = sim::Pose::Identity();
    T_wb.linear() = estimator.Rs[frame];
    T_wb.translation() = estimator.Ps[frame];
    T_bc.linear() = estimator.ric[0];
    T_bc.translation() = estimator.tic[0];
    return T_wb * T_bc;
  }

  Estimator estimator;
  std::vector<FeaturePerId*> candidates;

 private:
  void add_track(Random& random, int id, int first, int last) {
    FeaturePerId feature(id, first);
    for (int frame = first; frame <= last; ++frame) feature.feature_per_frame.emplace_back();
    // In front of the newest frame, perhaps behind the first one of the track: only the former counts.
    const Eigen::Vector3d p_c = T_wc(first).inverse() * (T_wc(WINDOW_SIZE) * random_point_in_camera(random));
    feature.estimated_depth = std::abs(p_c.z());
    feature.solve_flag = 1;
    feature.feature_per_frame[0].point = p_c / feature.estimated_depth;
    feature.feature_per_frame.back().point = Eigen::Vector3d(id, 0.5 * id, 1);
    estimator.f_manager.feature.push_front(feature);
  }
};

std::unique_ptr<AdapterWorld> make_world(Random& random, std::size_t n, std::size_t budget, std::size_t capacity) {
  return std::make_unique<VinsFusionWorld>(random, n, budget, capacity);
}
INSTANTIATE_TEST_SUITE_P(VinsFusion, AnyAdapter, ::testing::Values(AdapterCase{"VinsFusion", make_world, 1e-5}),
                         name_of);

TEST(VinsFusionAdapter, features_stay_in_whose_depth_is_new_or_not_known_and_the_latter_are_no_candidates) {
  TracedRandom random;
  VinsFusionWorld world(random, 200, 100, 200);
  const std::set<std::size_t> before = world.run();
  std::set<std::size_t> fresh;
  for (std::size_t i = 0; i < 200 && fresh.size() < 30; ++i) {
    if (before.count(i) == 0) fresh.insert(i);
  }
  for (const std::size_t i : fresh) world.candidates[i]->solve_flag = 0;
  const std::set<std::size_t> after = world.run();
  EXPECT_EQ(after.size(), 100U) << "they count as budget";
  for (const std::size_t i : fresh) EXPECT_EQ(after.count(i), 1U) << i;
  for (std::size_t i = 0; i < 200; i += 10) world.candidates[i]->estimated_depth = -1;
  const std::set<std::size_t> kept = world.run();
  for (std::size_t i = 0; i < 200; i += 10) EXPECT_EQ(kept.count(i), 1U) << i;
  EXPECT_EQ(kept.size(), 120U);
  EXPECT_EQ(world.hook().features.size(), 180U);
}

TEST(VinsFusionAdapter, what_is_left_out_keeps_its_place_in_para_feature_and_is_not_removed_for_its_error) {
  TracedRandom random;
  VinsFusionWorld world(random, 200, 100, 200);
  EXPECT_EQ(world.run().size(), 100U);
  std::vector<std::pair<int, int>> expected;
  std::set<int> optimised;
  int place = -1;
  for (const FeaturePerId& feature : world.estimator.f_manager.feature) {
    if (feature.feature_per_frame.size() < 4) continue;
    ++place;
    if (world.leaves_out(feature)) continue;
    expected.emplace_back(feature.feature_id, place);
    optimised.insert(feature.feature_id);
  }
  EXPECT_EQ(world.estimator.added, expected);
  std::set<int> removed;
  world.estimator.outliersRejection(removed);
  EXPECT_EQ(removed, optimised);
}

}  // namespace
}  // namespace maxlogdet::test
