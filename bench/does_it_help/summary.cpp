// SPDX-License-Identifier: MIT
#include "bench/does_it_help/evaluation.hpp"
#include "bench/does_it_help/gaussian_norm.hpp"
#include "bench/world/input_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t resample_count = 1000;
constexpr std::uint64_t resample_seed = 27;

// A selector's deviations with one budget, in both parts.
struct Lengths {
  SortedValues translation, rotation;

  void add(const Deviation& deviation, std::uint32_t frame) {
    translation.add(deviation.translation(), frame);
    rotation.add(deviation.rotation(), frame);
  }
  void sort() {
    translation.sort();
    rotation.sort();
  }
};

// Medians of translation times rotation, of all frames and of each resample.
struct Product {
  double value;
  std::vector<double> resampled;
};

// What random or bucket give with any number of matches.
struct Reference {
  std::vector<std::size_t> counts;
  std::vector<Product> products;  // one for each count

  Worth worth(const Product& of) const {
    Worth result;
    result.matches = matches_worth(counts, values([](const Product& product) { return product.value; }), of.value);
    std::vector<double> resampled;
    for (std::size_t r = 0; r < resample_count; ++r) {
      resampled.push_back(
          matches_worth(counts, values([r](const Product& product) { return product.resampled[r]; }), of.resampled[r]));
    }
    result.interval = percentile_interval(std::move(resampled));
    return result;
  }

  template <class Value>
  std::vector<double> values(const Value& value) const {
    std::vector<double> all;
    for (const Product& product : products) all.push_back(value(product));
    return all;
  }
};

class Summarizer {
 public:
  Summarizer(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
             const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options)
      : frames_(frames),
        true_poses_(true_poses),
        options_(options),
        resamples_(resample_frames(lengths, resample_count, resample_seed)) {
    std::size_t first = 0;
    for (const std::size_t length : lengths) {
      is_first_.resize(first + length, false);
      if (length > 0) is_first_[first] = true;
      first += length;
    }
  }

  Evaluation run() {
    count();
    for (const char* name : {"random", "bucket"}) references_[name] = reference(name);
    for (std::size_t c = 0; c < options_.contestants.size(); ++c) {
      const std::vector<std::size_t> budgets = budgets_of(options_.contestants[c], options_);
      for (std::size_t b = 0; b < budgets.size(); ++b) add_row(c, b, budgets[b]);
    }
    add_noise();
    return std::move(result_);
  }

 private:
  void count() {
    result_.frames = frames_.size();
    for (const FrameEvaluation& frame : frames_) {
      if (!frame.is_usable) {
        ++result_.unusable;
        continue;
      }
      result_.matches += static_cast<double>(frame.matches);
      result_.inliers += static_cast<double>(frame.inliers);
    }
    const std::size_t usable = frames_.size() - result_.unusable;
    if (usable == 0) {
      throw InputError("no frame has 10 matches that agree with one pose; expected frames as a tracker optimises them");
    }
    result_.matches /= static_cast<double>(usable);
    result_.inliers /= static_cast<double>(usable);
  }

  bool is_reported(std::size_t budget) const {
    return budget == 0 || std::find(options_.budgets.begin(), options_.budgets.end(), budget) != options_.budgets.end();
  }

  // With 0 where the budget takes all inliers, so that the frames are the same with every budget.
  Product product_of(std::size_t contestant, std::size_t budget) const {
    Lengths lengths;
    for (std::uint32_t f = 0; f < frames_.size(); ++f) {
      if (!frames_[f].is_usable) continue;
      const Deviations& deviations = frames_[f].deviations[contestant][budget];
      for (const Deviation& deviation : deviations) lengths.add(deviation, f);
      const std::size_t repeats = options_.contestants[contestant].is_random() ? options_.repeats : 1;
      for (std::size_t r = deviations.size(); r < repeats; ++r) lengths.add(Deviation(), f);
    }
    lengths.sort();
    Product product{lengths.translation.quantile(0.5) * lengths.rotation.quantile(0.5), {}};
    const auto translations = lengths.translation.quantiles(0.5, resamples_);
    const auto rotations = lengths.rotation.quantiles(0.5, resamples_);
    for (std::size_t r = 0; r < resamples_.size(); ++r) product.resampled.push_back(translations[r] * rotations[r]);
    return product;
  }

  Reference reference(const std::string& name) const {
    Reference reference;
    for (std::size_t c = 0; c < options_.contestants.size(); ++c) {
      if (options_.contestants[c].name != name) continue;
      reference.counts = budgets_of(options_.contestants[c], options_);
      for (std::size_t b = 0; b < reference.counts.size(); ++b) reference.products.push_back(product_of(c, b));
    }
    return reference;
  }

  void add_row(std::size_t contestant, std::size_t b, std::size_t budget) {
    if (!is_reported(budget)) return;
    const Contestant& of = options_.contestants[contestant];
    EvaluationRow row;
    row.selector = of.name;
    row.budget = budget == 0 ? own_count() : budget;
    Lengths lengths;
    std::vector<Eigen::Vector3d> translation_variances, rotation_variances;
    for (std::uint32_t f = 0; f < frames_.size(); ++f) {
      if (!frames_[f].is_usable || frames_[f].deviations[contestant][b].empty()) continue;
      ++row.frames;
      for (const Deviation& deviation : frames_[f].deviations[contestant][b]) {
        lengths.add(deviation, f);
        if (!deviation.xi.allFinite()) continue;  // a pose that could not be optimised has no prediction
        translation_variances.push_back(deviation.translation_variances);
        rotation_variances.push_back(deviation.rotation_variances);
      }
    }
    lengths.sort();
    row.translation = summary_of(lengths.translation, translation_variances);
    row.rotation = summary_of(lengths.rotation, rotation_variances);
    if (!of.is_random()) {
      const Product product = product_of(contestant, b);
      row.worth_random = references_["random"].worth(product);
      row.worth_bucket = references_["bucket"].worth(product);
    }
    row.truth = truth_of(contestant, b);
    result_.rows.push_back(std::move(row));
  }

  DeviationSummary summary_of(const SortedValues& lengths, const std::vector<Eigen::Vector3d>& variances) const {
    if (variances.empty()) return {nan, {nan, nan}, nan, nan, nan};
    return {lengths.quantile(0.5), percentile_interval(lengths.quantiles(0.5, resamples_)), lengths.quantile(0.9),
            predicted_quantile(variances, 0.5), predicted_quantile(variances, 0.9)};
  }

  std::size_t own_count() const {
    SortedValues counts;
    for (std::uint32_t f = 0; f < frames_.size(); ++f) {
      if (frames_[f].is_usable) counts.add(static_cast<double>(frames_[f].own), f);
    }
    counts.sort();
    return static_cast<std::size_t>(counts.quantile(0.5));
  }

  // Error of the motion from frame f - 1 to f.
  Vector6 step_error(std::size_t f, const Pose& before, const Pose& after) const {
    const Pose truth = *true_poses_[f] * true_poses_[f - 1]->inverse();
    return log_se3(after * before.inverse() * truth.inverse());
  }

  bool has_step(std::size_t f) const {
    return f > 0 && !is_first_[f] && frames_[f].is_usable && frames_[f - 1].is_usable && true_poses_[f] &&
           true_poses_[f - 1];
  }

  std::optional<TruthSummary> truth_of(std::size_t contestant, std::size_t b) const {
    Lengths own, all;
    TruthSummary truth;
    for (std::uint32_t f = 0; f < frames_.size(); ++f) {
      if (!has_step(f)) continue;
      const Deviations& before = frames_[f - 1].deviations[contestant][b];
      const Deviations& after = frames_[f].deviations[contestant][b];
      if (before.empty() || before.size() != after.size()) continue;
      ++truth.steps;
      for (std::size_t r = 0; r < after.size(); ++r) {
        if (!before[r].xi.allFinite() || !after[r].xi.allFinite()) continue;
        Deviation error;
        error.xi = step_error(f, exp_se3(before[r].xi) * frames_[f - 1].all, exp_se3(after[r].xi) * frames_[f].all);
        own.add(error, f);
        error.xi = step_error(f, frames_[f - 1].all, frames_[f].all);
        all.add(error, f);
      }
    }
    if (truth.steps == 0) return std::nullopt;
    own.sort();
    all.sort();
    truth.median_m = own.translation.quantile(0.5);
    truth.median_rad = own.rotation.quantile(0.5);
    truth.translation_ratio = truth.median_m / all.translation.quantile(0.5);
    truth.rotation_ratio = truth.median_rad / all.rotation.quantile(0.5);
    truth.of_translation_ratio = interval_of_ratio(own.translation, all.translation, resamples_);
    truth.of_rotation_ratio = interval_of_ratio(own.rotation, all.rotation, resamples_);
    return truth;
  }

  void add_noise() {
    const FrameCounts once(frames_.size(), 1);
    const NoiseSummary noise = noise_summary(once);
    std::array<std::vector<double>, leverage_classes> chi2;
    std::vector<double> all, selected;
    for (const FrameCounts& counts : resamples_) {
      const NoiseSummary resampled = noise_summary(counts);
      for (std::size_t d = 0; d < leverage_classes; ++d) chi2[d].push_back(resampled.chi2[d]);
      all.push_back(resampled.all);
      selected.push_back(resampled.selected);
    }
    result_.chi2_by_leverage = noise.chi2;
    for (std::size_t d = 0; d < leverage_classes; ++d) result_.of_chi2[d] = percentile_interval(std::move(chi2[d]));
    result_.cell_correlation = {noise.all, percentile_interval(std::move(all))};
    result_.cell_correlation_selected = {noise.selected, percentile_interval(std::move(selected))};
    result_.static_correlation = static_correlation();
  }

  struct NoiseSummary {
    std::array<double, leverage_classes> chi2{};
    double all = 0;
    double selected = 0;
  };

  NoiseSummary noise_summary(const FrameCounts& counts) const {
    NoiseSummary summary;
    std::array<double, leverage_classes> freedom{};
    PairSums all, selected;
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (!frames_[f].is_usable || counts[f] == 0) continue;
      const double weight = counts[f];
      const FrameNoise& noise = frames_[f].noise;
      for (std::size_t d = 0; d < leverage_classes; ++d) {
        summary.chi2[d] += weight * noise.chi2[d];
        freedom[d] += weight * noise.freedom[d];
      }
      all = all + weight * noise.all;
      selected = selected + weight * noise.selected;
    }
    for (std::size_t d = 0; d < leverage_classes; ++d) summary.chi2[d] /= freedom[d];
    summary.all = correlation_of(all);
    summary.selected = correlation_of(selected);
    return summary;
  }

  // Products of residuals of the same cell in frames of a recording that are at least ten apart, which have few points
  // in common: of sums over ten frames, all products less those of a sum with itself and with its neighbours.
  double static_correlation() const {
    CellSums distant;
    double squares = 0, matches = 0;
    for (std::size_t first = 0, end = 0; first < frames_.size(); first = end) {
      for (end = first + 1; end < frames_.size() && !is_first_[end];) ++end;
      if (end - first < enough_frames) continue;
      for (std::size_t cell = 0; cell < noise_grid.cells(); ++cell) add_distant_pairs(first, end, cell, distant);
      for (std::size_t f = first; f < end; ++f) {
        squares += frames_[f].noise.all.squares;
        matches += frames_[f].noise.all.matches;
      }
    }
    return distant.pairs > 0 ? distant.products / distant.pairs / (squares / matches) : nan;
  }

  static constexpr std::size_t frames_together = 10;
  static constexpr std::size_t enough_frames = 40;

  struct CellSums {
    double products = 0;
    double pairs = 0;
  };

  // Of one cell, in the frames of a recording.
  void add_distant_pairs(std::size_t first, std::size_t end, std::size_t cell, CellSums& distant) const {
    struct Sum {
      Eigen::Vector2d r = Eigen::Vector2d::Zero();
      double matches = 0;
    };
    std::vector<Sum> sums((end - first) / frames_together + 2);  // the last one stays empty
    Sum all;
    for (std::size_t f = first; f < end; ++f) {
      const FrameNoise& noise = frames_[f].noise;
      if (!frames_[f].is_usable || noise.cell_sums.empty()) continue;
      for (Sum* const to : {&sums[(f - first) / frames_together], &all}) {
        to->r += noise.cell_sums[cell];
        to->matches += noise.cell_matches[cell];
      }
    }
    distant.products += all.r.squaredNorm();
    distant.pairs += all.matches * all.matches;
    for (std::size_t s = 0; s + 1 < sums.size(); ++s) {
      distant.products -= sums[s].r.squaredNorm() + 2 * sums[s].r.dot(sums[s + 1].r);
      distant.pairs -= sums[s].matches * (sums[s].matches + 2 * sums[s + 1].matches);
    }
  }

  const std::vector<FrameEvaluation>& frames_;
  const std::vector<std::optional<Pose>>& true_poses_;
  const EvaluationOptions& options_;
  std::vector<FrameCounts> resamples_;
  std::vector<bool> is_first_;  // of its recording
  std::map<std::string, Reference> references_;
  Evaluation result_;
};

}  // namespace

Evaluation summarize(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
                     const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options) {
  return Summarizer(frames, lengths, true_poses, options).run();
}

}  // namespace maxlogdet::sim
