// SPDX-License-Identifier: MIT
#include "cli/evaluation.hpp"

#include "bench/world/draws.hpp"
#include "bench/world/parallel.hpp"
#include "bench/world/text_file.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t resample_count = 1000;
constexpr std::uint64_t resample_seed = 27;
constexpr double within_limits = 0.975;  // E[chi2 | chi2 below its 99.5 % quantile] / E[chi2], of inliers

// What a frame adds to a row. All of it adds up over the frames of a resample.
struct Sums {
  double repetitions = 0, selected = 0, wrong = 0;
  Parts squares = Parts::Zero();    // of deviations, over the variances of the pose of all inliers
  Parts predicted = Parts::Zero();  // the same as predicted
  Parts errors = Parts::Zero();     // squared, of motions against the true ones
  Parts errors_of_all = Parts::Zero();

  void add(double weight, const Sums& other) {
    repetitions += weight * other.repetitions;
    selected += weight * other.selected;
    wrong += weight * other.wrong;
    squares += weight * other.squares;
    predicted += weight * other.predicted;
    errors += weight * other.errors;
    errors_of_all += weight * other.errors_of_all;
  }
  Parts mean() const { return squares / repetitions; }
};

Parts squares_of(const Vector6& xi) { return {xi.head<3>().squaredNorm(), xi.tail<3>().squaredNorm()}; }

// Error of the motion between two poses.
Parts step_error(const std::optional<Pose>& true_before, const std::optional<Pose>& true_after, const Pose& before,
                 const Pose& after) {
  const Pose truth = *true_after * true_before->inverse();
  return squares_of(log_se3(after * before.inverse() * truth.inverse()));
}

class Summarizer {
 public:
  Summarizer(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
             const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options)
      : frames_(frames),
        true_poses_(true_poses),
        options_(options),
        samples_(resample_frames(lengths, resample_count, resample_seed)) {
    samples_.insert(samples_.begin(), FrameCounts(frames.size(), 1));
    std::size_t first = 0;
    for (const std::size_t length : lengths) {
      is_first_.resize(first + length, false);
      if (length > 0) is_first_[first] = true;
      first += length;
    }
  }

  Evaluation run() {
    count();
    add_noise();
    for (std::size_t c = 0; c < options_.contestants.size(); ++c) {
      const std::vector<std::size_t> budgets = budgets_of(options_.contestants[c], options_);
      for (std::size_t b = 0; b < budgets.size(); ++b) add_row(c, b, budgets[b]);
    }
    compare_with_random();
    return std::move(result_);
  }

 private:
  // Of a function of the number of the sample: 0 is all frames, the others are resamples of them.
  template <class Function>
  static Statistic estimate(const Function& function) {
    std::vector<double> values;
    for (std::size_t s = 1; s <= resample_count; ++s) values.push_back(function(s));
    return {function(0), percentile_interval(values)};
  }

  // Of what each frame has, by sample.
  template <class OfFrame>
  std::vector<OfFrame> sums_of(const std::vector<OfFrame>& of_frames) const {
    std::vector<OfFrame> sums(samples_.size());
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      for (std::size_t f = 0; f < frames_.size(); ++f) {
        if (samples_[s][f] > 0) sums[s].add(samples_[s][f], of_frames[f]);
      }
    }
    return sums;
  }

  void count() {
    result_.frames = frames_.size();
    for (const FrameEvaluation& frame : frames_) {
      if (!frame.is_usable) {
        ++result_.unusable;
        continue;
      }
      if (!frame.is_aligned) ++result_.unaligned;
      result_.matches += static_cast<double>(frame.matches);
      result_.inliers += static_cast<double>(frame.inliers);
      result_.sigmas += frame.variances;
      result_.median_chi2 += frame.median_chi2;
    }
    const auto usable = static_cast<double>(frames_.size() - result_.unusable);
    require_input(usable > 0,
                  "no frame has 10 matches that agree with one pose; expected frames as a tracker optimises them");
    result_.matches /= usable;
    result_.inliers /= usable;
    result_.sigmas /= usable;
    result_.median_chi2 /= usable;
  }

  void add_noise() {
    std::vector<FrameNoise> of_frames;
    for (const FrameEvaluation& frame : frames_) of_frames.push_back(frame.noise);
    const std::vector<FrameNoise> sums = sums_of(of_frames);
    const auto ratio = [](double chi2, double freedom) { return chi2 / (within_limits * freedom); };
    const auto sum = [](const auto& values) { return std::accumulate(values.begin(), values.end(), 0.0); };
    for (const FrameNoise& of_sample : sums) chi2_.push_back(ratio(sum(of_sample.chi2), sum(of_sample.freedom)));
    for (std::size_t d = 0; d < leverage_classes; ++d) {
      result_.chi2_by_leverage[d] = estimate([&](std::size_t s) { return ratio(sums[s].chi2[d], sums[s].freedom[d]); });
    }
    result_.cell_correlation = estimate([&](std::size_t s) { return correlation_of(sums[s].pairs); });
    result_.chi2 = chi2_[0];
    result_.sigmas = (result_.chi2 * result_.sigmas).sqrt();
  }

  void add_row(std::size_t contestant, std::size_t b, std::size_t budget) {
    EvaluationRow row;
    row.selector = options_.contestants[contestant].name;
    std::vector<Sums> of_frames(frames_.size());
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (!frames_[f].is_usable || frames_[f].deviations[contestant][b].empty()) continue;
      ++row.frames;
      for (const Deviation& deviation : frames_[f].deviations[contestant][b]) {
        of_frames[f].repetitions += 1;
        of_frames[f].selected += static_cast<double>(deviation.selected);
        of_frames[f].wrong += static_cast<double>(deviation.wrong);
        of_frames[f].squares += squares_of(deviation.xi) / frames_[f].variances;
        of_frames[f].predicted += deviation.predicted / frames_[f].variances;
      }
      if (add_step(f, contestant, b, of_frames[f])) ++row.steps;
    }
    std::vector<Sums> sums = sums_of(of_frames);
    row.has_budget = budget > 0;
    row.budget =
        row.has_budget ? budget : static_cast<std::size_t>(std::lround(sums[0].selected / sums[0].repetitions));
    row.wrong = estimate([&](std::size_t s) { return sums[s].wrong / sums[s].selected; });
    for (int part = 0; part < 2; ++part) {
      Cost& cost = row.costs[static_cast<std::size_t>(part)];
      cost.growth = estimate([&](std::size_t s) { return std::sqrt(1 + sums[s].mean()(part) / chi2_[s]) - 1; });
      cost.predicted = std::sqrt(1 + sums[0].predicted(part) / sums[0].repetitions) - 1;
      if (row.steps == 0) continue;
      cost.true_growth =
          estimate([&](std::size_t s) { return std::sqrt(sums[s].errors(part) / sums[s].errors_of_all(part)) - 1; });
    }
    result_.rows.push_back(std::move(row));
    sums_.push_back(std::move(sums));
  }

  void compare_with_random() {
    for (std::size_t i = 0; i < result_.rows.size(); ++i) {
      EvaluationRow& row = result_.rows[i];
      const EvaluationRow* const random = result_.row("random_gated", row.budget);
      if (random == nullptr || !row.has_budget) continue;
      const std::vector<Sums>& theirs = sums_[static_cast<std::size_t>(random - result_.rows.data())];
      for (int part = 0; part < 2; ++part) {
        row.costs[static_cast<std::size_t>(part)].of_random =
            estimate([&](std::size_t s) { return sums_[i][s].mean()(part) / theirs[s].mean()(part); });
      }
    }
  }

  // Returns whether the motion from the frame before is known.
  bool add_step(std::size_t f, std::size_t contestant, std::size_t b, Sums& sums) const {
    if (is_first_[f] || !frames_[f - 1].is_usable || !true_poses_[f] || !true_poses_[f - 1]) return false;
    const FrameEvaluation &last = frames_[f - 1], &now = frames_[f];
    const Deviations &before = last.deviations[contestant][b], &after = now.deviations[contestant][b];
    if (before.size() != after.size()) return false;
    for (std::size_t r = 0; r < after.size(); ++r) {
      if (!before[r].xi.allFinite() || !after[r].xi.allFinite()) continue;
      sums.errors += step_error(true_poses_[f - 1], true_poses_[f], exp_se3(before[r].xi) * last.all,
                                exp_se3(after[r].xi) * now.all);
      sums.errors_of_all += step_error(true_poses_[f - 1], true_poses_[f], last.all, now.all);
    }
    return true;
  }

  const std::vector<FrameEvaluation>& frames_;
  const std::vector<std::optional<Pose>>& true_poses_;
  const EvaluationOptions& options_;
  std::vector<FrameCounts> samples_;     // all frames once, and resamples
  std::vector<bool> is_first_;           // of its recording
  std::vector<double> chi2_;             // over its expectation, by sample
  std::vector<std::vector<Sums>> sums_;  // by row and sample
  Evaluation result_;
};

// Those that all frames allow. A tracker that selected everything shows nothing.
std::vector<Contestant> contestants_for(const std::vector<const Frame*>& frames) {
  std::vector<Contestant> contestants = {{"md", Choice::md},
                                         {"md_spread", Choice::md_spread},
                                         {"md_ungated", Choice::md, false},
                                         {"random_gated", Choice::random},
                                         {"random", Choice::random, false},
                                         {"bucket_gated", Choice::bucket}};
  const bool has_selections =
      std::all_of(frames.begin(), frames.end(), [](const Frame* frame) { return frame->has_selection; });
  const bool has_all = std::all_of(frames.begin(), frames.end(), [](const Frame* frame) {
    return std::all_of(frame->matches.begin(), frame->matches.end(), [](const Match& m) { return m.is_selected; });
  });
  if (has_selections && !has_all) contestants.push_back({"own", Choice::own, false});
  contestants.push_back({"aligned", Choice::all});
  return contestants;
}

}  // namespace

Evaluation evaluate(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options, int threads) {
  std::vector<const Frame*> frames;
  std::vector<std::size_t> lengths;
  std::vector<std::optional<Pose>> true_poses;
  for (const auto& recording : recordings) {
    lengths.push_back(recording.size());
    for (const Frame& frame : recording) {
      frames.push_back(&frame);
      true_poses.push_back(frame.T_cw_true ? std::optional<Pose>(pose_of(*frame.T_cw_true)) : std::nullopt);
    }
  }
  options.contestants = contestants_for(frames);
  std::vector<FrameEvaluation> evaluated(frames.size());
  for_each_in_parallel("evaluate", "frame", frames.size(), threads,
                       [&](std::size_t i) { evaluated[i] = evaluate_frame(*frames[i], i, options); });
  return summarize(evaluated, lengths, true_poses, options);
}

Evaluation summarize(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
                     const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options) {
  return Summarizer(frames, lengths, true_poses, options).run();
}

const EvaluationRow* Evaluation::row(const std::string& selector, std::size_t budget) const {
  for (const EvaluationRow& each : rows) {
    if (each.selector == selector && (each.budget == budget || !each.has_budget)) return &each;
  }
  return nullptr;
}

// E[r_i . r_j] = s^2 (2 rho - tr(H_i C H_j^T)), E[r_i . r_i] = s^2 (2 - tr(H_i C H_i^T)) where neighbours are
// correlated by rho and noise is s times as large as modelled.
double correlation_of(const PairSums& sums) {
  const double per_variance = 2 * sums.matches - sums.fitted_self;
  if (!(sums.pairs > 0) || !(per_variance > 0)) return nan;
  const double variance = sums.squares / per_variance;
  return (sums.products / variance + sums.fitted) / (2 * sums.pairs);
}

Interval percentile_interval(const std::vector<double>& values) {
  const bool has_nan = std::any_of(values.begin(), values.end(), [](double value) { return std::isnan(value); });
  if (values.empty() || has_nan) return {nan, nan};
  return {quantile_of(values, 0.025), quantile_of(values, 0.975)};
}

std::size_t block_length(std::size_t frames) { return std::clamp<std::size_t>(frames / 5, 1, 10); }

std::vector<FrameCounts> resample_frames(const std::vector<std::size_t>& lengths, std::size_t resamples,
                                         std::uint64_t seed) {
  const std::size_t frames = std::accumulate(lengths.begin(), lengths.end(), std::size_t{0});
  std::vector<FrameCounts> all(resamples, FrameCounts(frames, 0));
  for (std::size_t r = 0; r < resamples; ++r) {
    Draws draws(seed, r);
    std::size_t first = 0;
    for (const std::size_t length : lengths) {
      const std::size_t block = block_length(length);
      for (std::size_t drawn = 0; drawn < length;) {
        const std::size_t start = draws.below(length);
        for (std::size_t i = 0; i < block && drawn < length; ++i, ++drawn) ++all[r][first + (start + i) % length];
      }
      first += length;
    }
  }
  return all;
}

}  // namespace maxlogdet::sim
