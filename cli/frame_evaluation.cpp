// SPDX-License-Identifier: MIT
#include "cli/frame_evaluation.hpp"

#include "bench/world/feature_selector.hpp"
#include "bench/world/hash.hpp"
#include "bench/world/projection.hpp"

#include <maxlogdet/eigen.hpp>

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
constexpr double much_less = 0.5;     // of the noise: another consensus, and not the same by other roundings
constexpr std::size_t min_inliers = 10;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double spread = 1.5;  // as docs/guide.md recommends

using Indices = std::vector<std::uint32_t>;

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
    whitenings_ = whitenings_of(frame, start_, pose_.stereo, options.map_sigma);
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
  // As a tracker does it.
  void add_matches(GoodFeatures& good) const {
    good.block_options.map_sigma = options_.map_sigma;
    if (frame_.camera.depth_sigma > 0) good.block_options.depth_sigma = frame_.camera.depth_sigma;
    const RigidTransform T_cw = RigidTransform::row_major(frame_.T_cw_prior.data());
    const std::vector<Camera>& rig = frame_.camera.rig;
    rig.empty() ? good.start(Camera(frame_.camera), T_cw) : good.start(rig.data(), rig.size(), T_cw);
    for (const FeatureMatch& match : feature_matches(frame_, frame_.camera.depth_cue())) good.add(match);
  }

  bool find_pose_of_all() {
    Indices matches(frame_.matches.size());
    std::iota(matches.begin(), matches.end(), 0U);
    Consensus found = consensus_of(matches, start_);
    // A few wrong points next to the camera can lead the first round to a pose that fits few others.
    if (gated_.alignment().is_aligned()) {
      Consensus aligned = consensus_of(candidates_of({"", Choice::all, true}), gated_.pose());
      if (aligned.noise < much_less * found.noise) found = std::move(aligned);
    }
    if (!(found.noise < infinity)) return false;
    inliers_ = std::move(found.inliers);
    noise_ = found.noise;
    pose_.huber_monocular = std::sqrt(of_two.huber * noise_);
    pose_.huber_stereo = std::sqrt(of_three.huber * noise_);
    all_ = optimize_pose(frame_.camera, frame_.matches, inliers_, found.start, pose_, whitenings_);
    covariance_ = all_.covariance();
    return all_.is_usable() && covariance_.allFinite();
  }

  // Matches that fit one pose, and the robust variance of the residuals over the modelled one: infinite without a pose.
  struct Consensus {
    Pose start;
    Indices inliers = {};
    double noise = infinity;
  };

  Consensus consensus_of(const Indices& matches, const Pose& start) const {
    Consensus found{start};
    double noise = first_noise;
    for (int pass = 0; pass < 3; ++pass) {
      RejectionOptions rejection;
      rejection.chi2_monocular = of_two.limit * noise;
      rejection.chi2_stereo = of_three.limit * noise;
      rejection.stereo = pose_.stereo;
      const Rejection rejected = reject_outliers(frame_.camera, frame_.matches, matches, start, rejection, whitenings_);
      found.inliers = rejected.inliers;
      if (!rejected.estimate.is_usable() || found.inliers.size() < min_inliers) return found;
      noise = std::max(noise_at(rejected.estimate.T_cw), least_noise);
    }
    found.noise = noise;
    return found;
  }

  // The median of chi2 over its expectation: of all matches, most of which are no outliers.
  double noise_at(const Pose& T_cw) const {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < frame_.matches.size(); ++i) {
      const Match& match = frame_.matches[i];
      const Chi2& of = pose_.stereo && match.has_depth_cue() ? of_three : of_two;
      ratios.push_back(chi2(frame_.camera, T_cw, match, pose_.stereo, &whitenings_[i]) / of.median);
    }
    return quantile_of(std::move(ratios), 0.5);
  }

  Indices candidates_of(const Contestant& contestant) const {
    const GoodFeatures& good = contestant.is_gated ? gated_ : ungated_;
    Indices candidates;
    for (std::uint32_t i = 0; i < frame_.matches.size(); ++i) {
      if (contestant.choice == Choice::own ? frame_.matches[i].is_selected : good.is_inlier(i)) candidates.push_back(i);
    }
    return candidates;
  }

  // In the order of selection, if the contestant has one.
  Indices select(const Contestant& contestant, const Indices& candidates, std::size_t budget, std::size_t repetition) {
    if (!contestant.has_budget()) return candidates;
    if (contestant.is_random()) {
      SelectorSettings settings;
      settings.kind = contestant.choice == Choice::random ? SelectorKind::random : SelectorKind::bucket;
      settings.budget = budget;
      Hash seed;
      for (const std::uint64_t word : {options_.seed, std::uint64_t{number_}, std::uint64_t{repetition}})
        seed.add(word);
      settings.seed = seed.value();
      return FeatureSelector(settings).select(frame_, candidates);
    }
    GoodFeatures& good = contestant.is_gated ? gated_ : ungated_;
    good.spread = contestant.choice == Choice::md_spread ? spread : 0;
    const Selection selection = good.select(budget);
    return {selection.begin(), selection.end()};
  }

  // A budget that takes all inliers leaves nothing to choose, and is left out.
  void add_repetition(const Contestant& contestant, const std::vector<std::size_t>& budgets, std::size_t repetition,
                      std::vector<Deviations>& deviations) {
    const Indices candidates = candidates_of(contestant);
    Indices nested;
    if (contestant.is_nested() && !candidates.empty()) {
      nested = select(contestant, candidates, std::min(budgets.back(), candidates.size() - 1), repetition);
    }
    for (std::size_t b = 0; b < budgets.size() && budgets[b] < inliers_.size(); ++b) {
      const bool is_begun = contestant.is_nested() && budgets[b] <= nested.size();
      const auto end = nested.begin() + static_cast<std::ptrdiff_t>(is_begun ? budgets[b] : 0);
      deviations[b].push_back(deviation_of(contestant, is_begun
                                                           ? Indices(nested.begin(), end)
                                                           : select(contestant, candidates, budgets[b], repetition)));
    }
  }

  Deviation deviation_of(const Contestant& contestant, const Indices& selected) const {
    Deviation deviation;
    deviation.selected = selected.size();
    for (const std::uint32_t i : selected) {
      deviation.wrong += std::binary_search(inliers_.begin(), inliers_.end(), i) ? 0 : 1;
    }
    const Pose start = contestant.is_gated ? Pose(gated_.pose()) : start_;
    if (contestant.choice == Choice::all) {  // the aligned pose itself
      deviation.xi = log_se3(start * all_.T_cw.inverse());
      return deviation;
    }
    const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, selected, start, pose_, whitenings_);
    deviation.predicted = traces_of(estimate.covariance() - covariance_);
    deviation.xi = log_se3(estimate.T_cw * all_.T_cw.inverse());
    if (!estimate.is_usable() || !deviation.predicted.allFinite()) {
      deviation.predicted.setConstant(infinity);
      deviation.xi.setConstant(infinity);
    }
    return deviation;
  }

  const Frame& frame_;
  std::size_t number_;
  const EvaluationOptions& options_;
  Pose start_;
  GoodFeatures gated_, ungated_;
  PoseOptions pose_;
  std::vector<Whitening> whitenings_;  // of all matches
  Indices inliers_;                    // ascending
  double noise_ = 1;                   // of the consensus
  PoseEstimate all_;
  Matrix6 covariance_;  // of the pose of all
};

// A match at the pose of all inliers.
struct WhitenedResidual {
  std::uint32_t cell;
  int rows;
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> H;
  double leverage;
};

PairSums pair_sums(std::vector<WhitenedResidual> residuals, const Matrix6& covariance) {
  std::stable_sort(residuals.begin(), residuals.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
  PairSums sums;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Vector2d r = residuals[i].r.head<2>();
    const Eigen::Matrix<double, 2, 6> HC = residuals[i].H.topRows<2>() * covariance;
    sums.squares += r.squaredNorm();
    sums.fitted_self += HC.cwiseProduct(residuals[i].H.topRows<2>()).sum();
    ++sums.matches;
    for (std::size_t j = i + 1; j < residuals.size() && residuals[j].cell == residuals[i].cell; ++j) {
      sums.products += r.dot(residuals[j].r.head<2>());
      sums.fitted += HC.cwiseProduct(residuals[j].H.topRows<2>()).sum();
      ++sums.pairs;
    }
  }
  return sums;
}

}  // namespace

std::vector<std::size_t> budgets_of(const Contestant& contestant, const EvaluationOptions& options) {
  if (!contestant.has_budget()) return {0};
  std::vector<std::size_t> budgets = options.budgets;
  std::sort(budgets.begin(), budgets.end());
  budgets.erase(std::unique(budgets.begin(), budgets.end()), budgets.end());
  return budgets;
}

void FrameNoise::add(double weight, const FrameNoise& other) {
  for (std::size_t d = 0; d < leverage_classes; ++d) {
    chi2[d] += weight * other.chi2[d];
    freedom[d] += weight * other.freedom[d];
  }
  for (double PairSums::*const sum : {&PairSums::products, &PairSums::fitted, &PairSums::pairs, &PairSums::squares,
                                      &PairSums::fitted_self, &PairSums::matches}) {
    pairs.*sum += weight * other.pairs.*sum;
  }
}

FrameNoise noise_of(const Frame& frame, const PoseEstimate& all, const Indices& inliers,
                    const std::vector<Whitening>& whitenings) {
  const Matrix6 covariance = all.covariance();
  std::vector<WhitenedResidual> residuals;
  for (const std::uint32_t i : inliers) {
    const Match& match = frame.matches[i];
    LinearizedMatch at;
    if (!linearize(frame.camera, all.T_cw, match, frame.camera.depth_cue() != DepthCue::none, at)) continue;
    const auto cell =
        noise_grid.cell_of(frame, match) + static_cast<std::uint32_t>(noise_grid.cells()) * match.camera_id;
    WhitenedResidual one{cell, at.rows, whitenings[i] * at.residual, whitenings[i] * at.H_x(), 0};
    one.leverage = (one.H * covariance * one.H.transpose()).trace();
    if (one.r.allFinite() && one.H.allFinite()) residuals.push_back(one);
  }
  FrameNoise noise;
  noise.pairs = pair_sums(residuals, covariance);
  std::stable_sort(residuals.begin(), residuals.end(),
                   [](const auto& a, const auto& b) { return a.leverage < b.leverage; });
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const std::size_t decile = leverage_classes * i / residuals.size();
    noise.chi2[decile] += residuals[i].r.squaredNorm();
    noise.freedom[decile] += residuals[i].rows - residuals[i].leverage;
  }
  return noise;
}

FrameEvaluation evaluate_frame(const Frame& frame, std::size_t number, const EvaluationOptions& options) {
  return FrameEvaluator(frame, number, options).run();
}

double quantile_of(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double share = at - static_cast<double>(below);
  if (share == 0 || values[below] == values[above]) return values[below];  // also of infinite ones
  return values[below] + share * (values[above] - values[below]);
}

}  // namespace maxlogdet::sim
