// SPDX-License-Identifier: MIT
#include "bench/does_it_help/frame_evaluation.hpp"

#include "bench/world/hash.hpp"
#include "bench/world/outlier_rejection.hpp"
#include "bench/world/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Of chi-squared with two and with three degrees of freedom.
struct Chi2 {
  double median;
  double huber;  // (1.5)^2 of two, which 68 % do not exceed: Huber's loss is linear above
  double limit;  // the 99.5 % quantile: inliers are below
};
constexpr Chi2 of_two = {1.386, 2.25, 10.597}, of_three = {2.366, 3.470, 12.838};
constexpr double first_noise = 2.25;  // over the modelled variance: the first limits are wide
constexpr double least_noise = 1e-8;  // residuals are rounding errors
constexpr std::size_t min_inliers = 10;
constexpr double spread = 1.5;  // as docs/guide.md recommends

Pose to_pose(const RigidTransform& T) {
  std::array<double, 12> rows{};
  std::copy_n(T.data(), rows.size(), rows.begin());
  return pose_of(rows);
}

Parts traces_of(const Matrix6& covariance) {
  return {covariance.topLeftCorner<3, 3>().trace(), covariance.bottomRightCorner<3, 3>().trace()};
}

class FrameEvaluator {
 public:
  FrameEvaluator(const Frame& frame, std::size_t number, const EvaluationOptions& options)
      : frame_(frame),
        number_(number),
        options_(options),
        start_(pose_of(frame.T_cw_prior)),
        gated_(frame.matches.size()),
        ungated_(frame.matches.size()) {
    pose_.max_iterations = 20;
    pose_.stereo = frame.camera.depth_cue() != DepthCue::none;
    whiten_matches();
    for (GoodFeatures* const good : {&gated_, &ungated_}) add_matches(*good);
    ungated_.rejects_outliers = false;
    gated_.align();
  }

  FrameEvaluation run() {
    FrameEvaluation result;
    result.matches = frame_.matches.size();
    result.deviations.resize(options_.contestants.size());
    if (!find_pose_of_all()) return result;
    result.is_usable = true;
    result.is_aligned = gated_.alignment().is_aligned();
    result.inliers = inliers_.size();
    result.all = all_.T_cw;
    result.variances = traces_of(covariance_);
    result.median_chi2 = noise_;
    for (std::size_t c = 0; c < options_.contestants.size(); ++c) {
      const Contestant& contestant = options_.contestants[c];
      const std::vector<std::size_t> budgets = budgets_of(contestant, options_);
      result.deviations[c].resize(budgets.size());
      const std::size_t repeats = contestant.is_random() ? options_.repeats : 1;
      for (std::size_t r = 0; r < repeats; ++r) add_repetition(contestant, budgets, r, result.deviations[c]);
    }
    result.noise = noise_of(frame_, all_, inliers_, whitenings_);
    return result;
  }

 private:
  bool weighs_map() const { return options_.weighting == Weighting::measurement_and_map; }

  void whiten_matches() {
    if (weighs_map()) {
      const double* const covariances = frame_.map_covariances.empty() ? nullptr : frame_.map_covariances[0].data();
      whiten(frame_.camera, start_, frame_.matches, true, covariances, options_.map_sigma, whitenings_);
      of_optimizer_ = whitenings_;
    } else {  // the optimiser is faster without
      for (const Match& match : frame_.matches) whitenings_.push_back(measurement_whitening(frame_.camera, match));
    }
  }

  // As a tracker does it.
  void add_matches(GoodFeatures& good) const {
    good.block_options.weighting = options_.weighting;
    good.block_options.map_sigma = options_.map_sigma;
    if (frame_.camera.depth_sigma > 0) good.block_options.depth_sigma = frame_.camera.depth_sigma;
    good.is_weighted = weighs_map();
    const RigidTransform T_cw = RigidTransform::row_major(frame_.T_cw_prior.data());
    const std::vector<Camera>& rig = frame_.camera.rig;
    rig.empty() ? good.start(Camera(frame_.camera), T_cw) : good.start(rig.data(), rig.size(), T_cw);
    for (std::size_t i = 0; i < frame_.matches.size(); ++i) {
      FeatureMatch match = feature_match(frame_.matches[i], frame_.camera.depth_cue());
      if (weighs_map() && !frame_.map_covariances.empty()) match.covariance = frame_.map_covariances[i].data();
      good.add(match);
    }
  }

  bool find_pose_of_all() {
    inliers_.resize(frame_.matches.size());
    std::iota(inliers_.begin(), inliers_.end(), 0U);
    const std::vector<std::uint32_t> matches = inliers_;
    noise_ = first_noise;
    for (int pass = 0; pass < 3; ++pass) {
      RejectionOptions rejection;
      rejection.chi2_monocular = of_two.limit * noise_;
      rejection.chi2_stereo = of_three.limit * noise_;
      rejection.stereo = pose_.stereo;
      const Rejection rejected =
          reject_outliers(frame_.camera, frame_.matches, matches, start_, rejection, of_optimizer_);
      inliers_ = rejected.inliers;
      if (!rejected.estimate.is_usable() || inliers_.size() < min_inliers) return false;
      noise_ = std::max(noise_at(rejected.estimate.T_cw), least_noise);
    }
    pose_.huber_monocular = std::sqrt(of_two.huber * noise_);
    pose_.huber_stereo = std::sqrt(of_three.huber * noise_);
    all_ = optimize_pose(frame_.camera, frame_.matches, inliers_, start_, pose_, of_optimizer_);
    covariance_ = all_.covariance();
    return all_.is_usable() && covariance_.allFinite();
  }

  // The median of chi2 over its expectation: of all matches, most of which are no outliers.
  double noise_at(const Pose& T_cw) const {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < frame_.matches.size(); ++i) {
      const Match& match = frame_.matches[i];
      const Whitening* const whitening = of_optimizer_.empty() ? nullptr : &of_optimizer_[i];
      const Chi2& of = pose_.stereo && match.has_depth_cue() ? of_three : of_two;
      ratios.push_back(chi2(frame_.camera, T_cw, match, pose_.stereo, whitening) / of.median);
    }
    return quantile_of(std::move(ratios), 0.5);
  }

  std::vector<std::uint32_t> candidates_of(const Contestant& contestant) const {
    const GoodFeatures& good = contestant.is_gated ? gated_ : ungated_;
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t i = 0; i < frame_.matches.size(); ++i) {
      if (contestant.is_own ? frame_.matches[i].is_selected : good.is_inlier(i)) candidates.push_back(i);
    }
    return candidates;
  }

  // In the order of selection, if the contestant has one.
  std::vector<std::uint32_t> select(const Contestant& contestant, const std::vector<std::uint32_t>& candidates,
                                    std::size_t budget, std::size_t repetition) {
    if (!contestant.has_budget()) return candidates;
    if (contestant.kind == SelectorKind::md || contestant.kind == SelectorKind::md_spread) {
      GoodFeatures& good = contestant.is_gated ? gated_ : ungated_;
      good.spread = contestant.kind == SelectorKind::md_spread ? spread : 0;
      const Selection selection = good.select(budget);
      return {selection.begin(), selection.end()};
    }
    SelectorSettings settings;
    settings.kind = contestant.kind;
    settings.budget = budget;
    Hash seed;
    for (const std::uint64_t word : {options_.seed, std::uint64_t{number_}, std::uint64_t{repetition}}) seed.add(word);
    settings.seed = seed.value();
    return FeatureSelector(settings).select(frame_, candidates);
  }

  // A budget that takes all inliers leaves nothing to choose, and is left out.
  void add_repetition(const Contestant& contestant, const std::vector<std::size_t>& budgets, std::size_t repetition,
                      std::vector<Deviations>& deviations) {
    const std::vector<std::uint32_t> candidates = candidates_of(contestant);
    std::vector<std::uint32_t> nested;
    if (contestant.is_nested() && !candidates.empty()) {
      nested = select(contestant, candidates, std::min(budgets.back(), candidates.size() - 1), repetition);
    }
    for (std::size_t b = 0; b < budgets.size() && budgets[b] < inliers_.size(); ++b) {
      const bool is_begun = contestant.is_nested() && budgets[b] <= nested.size();
      deviations[b].push_back(deviation_of(
          contestant, is_begun ? std::vector<std::uint32_t>(nested.begin(),
                                                            nested.begin() + static_cast<std::ptrdiff_t>(budgets[b]))
                               : select(contestant, candidates, budgets[b], repetition)));
    }
  }

  Deviation deviation_of(const Contestant& contestant, const std::vector<std::uint32_t>& selected) const {
    Deviation deviation;
    deviation.selected = selected.size();
    for (const std::uint32_t i : selected) {
      deviation.wrong += std::binary_search(inliers_.begin(), inliers_.end(), i) ? 0 : 1;
    }
    const Pose start = contestant.is_gated && !contestant.is_own ? to_pose(gated_.pose()) : start_;
    if (contestant.kind == SelectorKind::all && !contestant.is_own) {  // the aligned pose itself
      deviation.xi = log_se3(start * all_.T_cw.inverse());
      return deviation;
    }
    const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, selected, start, pose_, of_optimizer_);
    deviation.predicted = traces_of(estimate.covariance() - covariance_);
    deviation.xi = log_se3(estimate.T_cw * all_.T_cw.inverse());
    if (!estimate.is_usable() || !deviation.predicted.allFinite()) {
      deviation.predicted.setConstant(std::numeric_limits<double>::infinity());
      deviation.xi.setConstant(std::numeric_limits<double>::infinity());
    }
    return deviation;
  }

  const Frame& frame_;
  std::size_t number_;
  const EvaluationOptions& options_;
  Pose start_;
  GoodFeatures gated_, ungated_;
  PoseOptions pose_;
  std::vector<Whitening> whitenings_;    // of all matches
  std::vector<Whitening> of_optimizer_;  // the same, or none: by the measurements' noise
  std::vector<std::uint32_t> inliers_;   // ascending
  double noise_ = 1;                     // robust variance of the residuals over the modelled one
  PoseEstimate all_;
  Matrix6 covariance_;  // of the pose of all
};

}  // namespace

std::vector<std::size_t> budgets_of(const Contestant& contestant, const EvaluationOptions& options) {
  if (!contestant.has_budget()) return {0};
  std::vector<std::size_t> budgets = options.budgets;
  std::sort(budgets.begin(), budgets.end());
  budgets.erase(std::unique(budgets.begin(), budgets.end()), budgets.end());
  return budgets;
}

FrameEvaluation evaluate_frame(const Frame& frame, std::size_t number, const EvaluationOptions& options) {
  return FrameEvaluator(frame, number, options).run();
}

}  // namespace maxlogdet::sim
