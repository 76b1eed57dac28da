// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pnp_experiment.hpp"

#include "bench/does_the_paper_hold/greedy_metric.hpp"
#include "bench/does_the_paper_hold/pose_error.hpp"
#include "bench/does_the_paper_hold/pose_error_model.hpp"
#include "bench/world/angles.hpp"
#include "bench/world/names.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace maxlogdet::sim {
namespace {

// The expected square by eq. 4: |bias|^2 + trace of both covariances. To first order the error of the centre is R^T
// times the translation of the left perturbation.
void expect(const PnpOptions& options, const PnpScene& scene, const Frame& frame, double noise_px,
            const std::vector<std::uint32_t>& subset, PnpOutcome& outcome) {
  const PoseErrorModel model(frame.camera, frame.matches, subset, scene.true_T_cw, false);
  const Vector6 bias = model.expected_error(Eigen::Vector3d::Constant(options.map_bias));
  const Matrix6 covariance =
      model.covariance_of_measurement_error(noise_px) + model.covariance_of_map_error(options.map_deviation);
  outcome.expected_translation_m = std::sqrt(bias.head<3>().squaredNorm() + covariance.topLeftCorner<3, 3>().trace());
  outcome.expected_rotation_deg =
      degrees * std::sqrt(bias.tail<3>().squaredNorm() + covariance.bottomRightCorner<3, 3>().trace());
  outcome.bias_amplification = model.bias_amplification()[0];
}

// The part of a run with one noise.
class PnpRun {
 public:
  PnpRun(const PnpOptions& options, const PnpScene& scene, double noise_px)
      : options_(options), scene_(scene), noise_px_(noise_px), frame_(frame_of(scene, noise_px)) {}

  PnpOutcome outcome(const PnpCase& which) {
    const std::vector<std::uint32_t>& order = order_of(which.selector, which.weighting);
    const std::vector<std::uint32_t> subset(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(std::min(which.size, order.size())));
    PoseOptions pose;
    pose.method = PoseMethod::gauss_newton;
    pose.max_iterations = 20;
    std::vector<Whitening> whitenings;
    if (which.selector == "all_weighted") {
      whiten(frame_.camera, scene_.guess, frame_.matches, pose.stereo, nullptr, options_.map_deviation, whitenings);
    }
    const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, subset, scene_.guess, pose, whitenings);
    const PoseError error = pose_error(estimate, scene_.true_T_cw);
    const PoseError aligned = pose_error(estimate, scene_.aligned_T_cw);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    PnpOutcome outcome{
        error.translation_m, error.rotation_deg, aligned.translation_m, aligned.rotation_deg, nan, nan, nan};
    if (estimate.is_usable()) expect(options_, scene_, frame_, noise_px_, subset, outcome);
    return outcome;
  }

 private:
  const std::vector<std::uint32_t>& order_of(const std::string& selector, const std::string& weighting) {
    if (weighting == no_weighting) return scene_.random_order;
    auto& order = orders_[{selector, weighting}];
    if (!order.empty()) return order;
    const GreedyMetric metric = find_named(greedy_metrics, selector).value();
    order = select_greedily(metric, blocks_of(weighting), options_.points, options_.prior * Matrix6::Identity());
    return order;
  }

  const BlockStore& blocks_of(const std::string& weighting) {
    BlockStore& blocks = blocks_[weighting];
    if (blocks.size() != 0) return blocks;
    BlockOptions options;
    options.weighting = find_named(weightings, weighting).value();
    options.map_sigma = options_.map_deviation;
    build_blocks(frame_, options, blocks);
    return blocks;
  }

  const PnpOptions& options_;
  const PnpScene& scene_;
  double noise_px_;
  Frame frame_;
  std::map<std::string, BlockStore> blocks_;
  std::map<std::pair<std::string, std::string>, std::vector<std::uint32_t>> orders_;
};

}  // namespace

std::vector<PnpCase> pnp_cases(const PnpOptions& options) {
  std::vector<PnpCase> cases;
  for (const double noise : options.noises) {
    for (const std::size_t size : options.sizes) {
      for (const Weighting weighting : options.weightings) {
        for (const GreedyMetric metric : greedy_metrics) {
          cases.push_back({noise, size, to_string(weighting), to_string(metric)});
        }
      }
      cases.push_back({noise, size, no_weighting, "random"});
    }
    cases.push_back({noise, options.points, no_weighting, "all"});
    cases.push_back({noise, options.points, no_weighting, "all_weighted"});
  }
  return cases;
}

std::vector<PnpOutcome> run_pnp(const PnpOptions& options, std::uint64_t run) {
  const PnpScene scene = draw_scene(options, run);
  std::map<double, PnpRun> by_noise;
  for (const double noise : options.noises) by_noise.emplace(noise, PnpRun(options, scene, noise));
  std::vector<PnpOutcome> outcomes;
  for (const PnpCase& which : pnp_cases(options)) outcomes.push_back(by_noise.at(which.noise_px).outcome(which));
  return outcomes;
}

Frame pnp_frame(const PnpOptions& options, std::uint64_t run) {
  Frame frame = frame_of(draw_scene(options, run), options.noises.front());
  frame.name = "run " + std::to_string(run);
  return frame;
}

}  // namespace maxlogdet::sim
