// SPDX-License-Identifier: MIT
#include "bench/does_it_help/evaluation.hpp"
#include "bench/world/input_error.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

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

struct NoiseSums {
  std::array<double, leverage_classes> chi2{}, freedom{};
  PairSums pairs;
};

Parts squares_of(const Vector6& xi) { return {xi.head<3>().squaredNorm(), xi.tail<3>().squaredNorm()}; }

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
  template <class Statistic>
  static Estimate estimate(const Statistic& statistic) {
    std::vector<double> values;
    for (std::size_t s = 1; s <= resample_count; ++s) values.push_back(statistic(s));
    return {statistic(0), percentile_interval(std::move(values))};
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
    if (usable == 0) {
      throw InputError("no frame has 10 matches that agree with one pose; expected frames as a tracker optimises them");
    }
    result_.matches /= usable;
    result_.inliers /= usable;
    result_.sigmas /= usable;
    result_.median_chi2 /= usable;
  }

  void add_noise() {
    std::vector<NoiseSums> sums(samples_.size());
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      for (std::size_t f = 0; f < frames_.size(); ++f) {
        if (!frames_[f].is_usable || samples_[s][f] == 0) continue;
        const double weight = samples_[s][f];
        for (std::size_t d = 0; d < leverage_classes; ++d) {
          sums[s].chi2[d] += weight * frames_[f].noise.chi2[d];
          sums[s].freedom[d] += weight * within_limits * frames_[f].noise.freedom[d];
        }
        sums[s].pairs = sums[s].pairs + weight * frames_[f].noise.pairs;
      }
      const auto sum = [](const auto& values) { return std::accumulate(values.begin(), values.end(), 0.0); };
      chi2_.push_back(sum(sums[s].chi2) / sum(sums[s].freedom));
    }
    for (std::size_t d = 0; d < leverage_classes; ++d) {
      result_.chi2_by_leverage[d] = estimate([&](std::size_t s) { return sums[s].chi2[d] / sums[s].freedom[d]; });
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
      if (has_step(f) && add_step(f, contestant, b, of_frames[f])) ++row.steps;
    }
    std::vector<Sums> sums(samples_.size());
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      for (std::size_t f = 0; f < frames_.size(); ++f) {
        if (samples_[s][f] > 0) sums[s].add(samples_[s][f], of_frames[f]);
      }
    }
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

  // Error of the motion from frame f - 1 to f.
  Parts step_error(std::size_t f, const Pose& before, const Pose& after) const {
    const Pose truth = *true_poses_[f] * true_poses_[f - 1]->inverse();
    return squares_of(log_se3(after * before.inverse() * truth.inverse()));
  }

  bool has_step(std::size_t f) const {
    return !is_first_[f] && frames_[f].is_usable && frames_[f - 1].is_usable && true_poses_[f] && true_poses_[f - 1];
  }

  bool add_step(std::size_t f, std::size_t contestant, std::size_t b, Sums& sums) const {
    const Deviations& before = frames_[f - 1].deviations[contestant][b];
    const Deviations& after = frames_[f].deviations[contestant][b];
    if (before.size() != after.size()) return false;
    for (std::size_t r = 0; r < after.size(); ++r) {
      if (!before[r].xi.allFinite() || !after[r].xi.allFinite()) continue;
      sums.errors += step_error(f, exp_se3(before[r].xi) * frames_[f - 1].all, exp_se3(after[r].xi) * frames_[f].all);
      sums.errors_of_all += step_error(f, frames_[f - 1].all, frames_[f].all);
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

}  // namespace

Evaluation summarize(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
                     const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options) {
  return Summarizer(frames, lengths, true_poses, options).run();
}

}  // namespace maxlogdet::sim
