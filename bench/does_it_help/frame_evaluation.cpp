// SPDX-License-Identifier: MIT
#include "bench/does_it_help/frame_evaluation.hpp"

#include "bench/world/hash.hpp"
#include "bench/world/outlier_rejection.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double gate = 4;  // times the 95 % quantiles of chi2
constexpr std::size_t min_inliers = 10;

Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& covariance) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues();
}

class FrameEvaluator {
 public:
  FrameEvaluator(const Frame& frame, std::size_t number, const EvaluationOptions& options)
      : frame_(frame), number_(number), options_(options), start_(pose_of(frame.T_cw_prior)) {
    const RejectionOptions usual;
    pose_.huber_monocular = std::sqrt(usual.chi2_monocular);
    pose_.huber_stereo = std::sqrt(usual.chi2_stereo);
    pose_.max_iterations = 20;
    pose_.stereo = frame.camera.depth_cue() != DepthCue::none;
    whiten_matches();
  }

  FrameEvaluation run() {
    FrameEvaluation result;
    result.matches = frame_.matches.size();
    result.deviations.resize(options_.contestants.size());
    if (!find_pose_of_all()) return result;
    result.is_usable = true;
    result.inliers = inliers_.size();
    result.all = all_.T_cw;
    result.own = own_selection().size();
    for (std::size_t c = 0; c < options_.contestants.size(); ++c) {
      const Contestant& contestant = options_.contestants[c];
      const std::vector<std::size_t> budgets = budgets_of(contestant, options_);
      result.deviations[c].resize(budgets.size());
      const std::size_t repeats = contestant.is_random() ? options_.repeats : 1;
      for (std::size_t r = 0; r < repeats; ++r) add_repetition(contestant, budgets, r, result.deviations[c]);
    }
    result.noise = noise_of(frame_, all_, inliers_, whitenings_, selected_for_noise());
    return result;
  }

 private:
  void whiten_matches() {
    if (options_.weighting == Weighting::measurement_and_map) {
      const double* const covariances = frame_.map_covariances.empty() ? nullptr : frame_.map_covariances[0].data();
      whiten(frame_.camera, start_, frame_.matches, true, covariances, options_.map_sigma, whitenings_);
      of_optimizer_ = whitenings_;
    } else {  // the optimiser is faster without
      for (const Match& match : frame_.matches) whitenings_.push_back(measurement_whitening(frame_.camera, match));
    }
  }

  bool find_pose_of_all() {
    RejectionOptions rejection;
    rejection.chi2_monocular *= gate;
    rejection.chi2_stereo *= gate;
    rejection.stereo = pose_.stereo;
    std::vector<std::uint32_t> matches(frame_.matches.size());
    std::iota(matches.begin(), matches.end(), 0U);
    const Rejection rejected =
        reject_outliers(frame_.camera, frame_.matches, matches, start_, rejection, of_optimizer_);
    inliers_ = rejected.inliers;
    if (!rejected.estimate.is_usable() || inliers_.size() < min_inliers) return false;
    all_ = optimize_pose(frame_.camera, frame_.matches, inliers_, start_, pose_, of_optimizer_);
    covariance_ = all_.covariance();
    return all_.is_usable() && covariance_.allFinite();
  }

  // In the order of selection, if the contestant has one.
  std::vector<std::uint32_t> select(const Contestant& contestant, std::size_t budget, std::size_t repetition) const {
    if (contestant.is_own) return own_selection();
    SelectorSettings settings;
    settings.kind = contestant.kind;
    settings.budget = budget;
    Hash seed;
    for (const std::uint64_t word : {options_.seed, std::uint64_t{number_}, std::uint64_t{repetition}}) seed.add(word);
    settings.seed = seed.value();
    settings.blocks.weighting = options_.weighting;
    settings.blocks.map_sigma = options_.map_sigma;
    settings.blocks.depth_cue = frame_.camera.depth_cue();
    if (frame_.camera.depth_sigma > 0) settings.blocks.depth_sigma = frame_.camera.depth_sigma;
    return FeatureSelector(settings).select(frame_, inliers_);
  }

  std::vector<std::uint32_t> own_selection() const {
    std::vector<std::uint32_t> own;
    for (const std::uint32_t i : inliers_) {
      if (frame_.matches[i].is_selected) own.push_back(i);
    }
    return own;
  }

  // A selection that takes all inliers deviates by nothing, and is left out.
  void add_repetition(const Contestant& contestant, const std::vector<std::size_t>& budgets, std::size_t repetition,
                      std::vector<Deviations>& deviations) const {
    std::vector<std::uint32_t> nested;
    if (contestant.is_nested()) nested = select(contestant, std::min(budgets.back(), inliers_.size() - 1), repetition);
    for (std::size_t b = 0; b < budgets.size(); ++b) {
      if (budgets[b] >= inliers_.size()) break;
      std::vector<std::uint32_t> selected;
      if (contestant.is_nested()) {
        selected.assign(nested.begin(),
                        nested.begin() + static_cast<std::ptrdiff_t>(std::min(budgets[b], nested.size())));
      } else {
        selected = select(contestant, budgets[b], repetition);
      }
      if (selected.size() < inliers_.size()) deviations[b].push_back(deviation_of(selected));
    }
  }

  Deviation deviation_of(const std::vector<std::uint32_t>& selected) const {
    Deviation deviation;
    const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, selected, start_, pose_, of_optimizer_);
    const Matrix6 difference = estimate.covariance() - covariance_;
    if (!estimate.is_usable() || !difference.allFinite()) {
      deviation.xi.setConstant(std::numeric_limits<double>::infinity());
      return deviation;
    }
    deviation.xi = log_se3(estimate.T_cw * all_.T_cw.inverse());
    deviation.translation_variances = eigenvalues(difference.topLeftCorner<3, 3>());
    deviation.rotation_variances = eigenvalues(difference.bottomRightCorner<3, 3>());
    return deviation;
  }

  std::vector<std::uint32_t> selected_for_noise() const {
    return select({"md", SelectorKind::md, false}, std::min(options_.noise_budget, inliers_.size()), 0);
  }

  const Frame& frame_;
  std::size_t number_;
  const EvaluationOptions& options_;
  Pose start_;
  PoseOptions pose_;
  std::vector<Whitening> whitenings_;    // of all matches
  std::vector<Whitening> of_optimizer_;  // the same, or none: by the measurements' noise
  std::vector<std::uint32_t> inliers_;
  PoseEstimate all_;
  Matrix6 covariance_;  // of the pose of all
};

}  // namespace

bool Contestant::is_nested() const {
  switch (kind) {
    case SelectorKind::md:
    case SelectorKind::bucket:
    case SelectorKind::random:
    case SelectorKind::quality: return !is_own;
    default: return false;
  }
}

bool Contestant::is_random() const { return !is_own && (kind == SelectorKind::random || kind == SelectorKind::bucket); }

std::vector<std::size_t> budgets_of(const Contestant& contestant, const EvaluationOptions& options) {
  if (contestant.is_own) return {0};
  std::vector<std::size_t> budgets = options.budgets;
  if (contestant.is_random()) budgets.insert(budgets.end(), options.curve.begin(), options.curve.end());
  std::sort(budgets.begin(), budgets.end());
  budgets.erase(std::unique(budgets.begin(), budgets.end()), budgets.end());
  return budgets;
}

FrameEvaluation evaluate_frame(const Frame& frame, std::size_t number, const EvaluationOptions& options) {
  return FrameEvaluator(frame, number, options).run();
}

}  // namespace maxlogdet::sim
