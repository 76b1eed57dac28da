// SPDX-License-Identifier: MIT
#include "cli/report.hpp"

#include "bench/world/names.hpp"
#include "bench/world/table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t usual_budget = 100;
constexpr std::size_t enough_frames = 10;      // with fewer an interval means nothing
constexpr double most_of_all = 0.8;            // of the inliers: a larger budget leaves nothing to choose
constexpr double least_chi2 = 1e-6;            // a thousandth of the modelled deviation: less is rounding, not noise
constexpr double rising_from = 1.5;            // chi2 of the tenth of highest leverage over that of all
constexpr double limits[] = {0.05, 0.1, 0.2};  // of the growth
constexpr const char* parts[] = {"translation", "rotation"};
constexpr const char* parts_of_both = "translation and rotation";

std::string count(double matches) { return std::to_string(std::lround(matches)); }

// "12 %", or with an interval "12 % (9 to 15)".
std::string percent(double share) { return fixed(100 * share, std::abs(share) < 0.095 ? 1 : 0) + " %"; }
std::string percent(const Statistic& share) {
  const auto bound = [](double value) { return fixed(100 * value, std::abs(value) < 0.095 ? 1 : 0); };
  return percent(share.value) + " (" + bound(share.interval.low) + " to " + bound(share.interval.high) + ")";
}

double growth(const EvaluationRow& row) { return std::max(row.costs[0].growth.value, row.costs[1].growth.value); }

bool is_better(const Cost& cost) { return cost.of_random.interval.high < 1; }
bool is_worse(const Cost& cost) { return cost.of_random.interval.low > 1; }

// Of the parts in which a selection is, or is not, as asked: "translation and rotation".
template <class Predicate>
std::string parts_where(const EvaluationRow& row, const Predicate& predicate) {
  std::vector<std::string> names;
  for (std::size_t part = 0; part < 2; ++part) {
    if (predicate(row.costs[part])) names.emplace_back(parts[part]);
  }
  return joined(names, " and ");
}

class Judge {
 public:
  explicit Judge(const Evaluation& evaluation) : evaluation_(evaluation) {}

  Verdict run() {
    const Statistic& correlation = evaluation_.cell_correlation;
    verdict_.has_noise = evaluation_.median_chi2 >= least_chi2;
    verdict_.shares_errors =
        verdict_.has_noise && correlation.value > shared_from && correlation.interval.low > shared_from / 2;
    selector_ = verdict_.recommended = verdict_.shares_errors ? "md_spread" : "md";
    const EvaluationRow* const row = evaluation_.row(selector_, budget_next_to_usual());
    verdict_.text = why_unknown(row);
    if (verdict_.text.empty()) judge(*row);
    return std::move(verdict_);
  }

 private:
  std::size_t budget_next_to_usual() const {
    std::size_t best = 0;
    const auto distance = [](std::size_t budget) {
      return std::abs(static_cast<double>(budget) - static_cast<double>(usual_budget));
    };
    for (const EvaluationRow& row : evaluation_.rows) {
      if (row.selector == "md" && row.frames > 0 && (best == 0 || distance(row.budget) < distance(best)))
        best = row.budget;
    }
    return best;
  }

  bool is_most(std::size_t budget) const { return static_cast<double>(budget) > most_of_all * evaluation_.inliers; }

  std::string why_unknown(const EvaluationRow* row) const {
    const std::string cannot = "These frames cannot tell: ";
    if (!verdict_.has_noise)
      return cannot + "their residuals are rounding errors; add noise to simulated measurements.";
    if (row == nullptr || row->frames == 0) return cannot + "none has more matches than the smallest budget.";
    const std::string budget = std::to_string(row->budget);
    if (is_most(row->budget)) {
      return cannot + budget + " matches are nearly all of some " + count(evaluation_.inliers) +
             " inliers; choose smaller --budgets.";
    }
    if (row->frames >= enough_frames) return "";
    return cannot + "only " + std::to_string(row->frames) + " have more than " + budget + " matches; record at least " +
           std::to_string(enough_frames) + ", better a hundred.";
  }

  void judge(const EvaluationRow& row) {
    const std::string better = parts_where(row, is_better), worse = parts_where(row, is_worse);
    const std::string open = parts_where(row, [](const Cost& cost) { return !is_better(cost) && !is_worse(cost); });
    const bool pays = !better.empty(), is_affordable = smallest_budget(limits[2]) > 0;
    std::string& text = verdict_.text;
    if (verdict_.shares_errors) {
      text += "Your matches share errors: residuals of neighbours are correlated by " +
              fixed(evaluation_.cell_correlation.value, 2) + ". ";
    }
    if (pays && !is_affordable) {
      text += std::string("Do not select, ") + (is_pose_near() ? "take pose()" : "optimise with all inliers") +
              ": no budget that was tried keeps the growth of the standard deviation within " +
              fixed(100 * limits[2], 0) + " %. ";
    }
    const std::string name = verdict_.shares_errors ? "Max-logDet spread over the image" : "Max-logDet";
    if (pays) {
      text += name + (is_affordable ? " pays" : " is better than random");
      if (better != parts_of_both) text += " in " + better + ", but in ";
      if (!worse.empty()) text += worse + " it is worse than random";
      if (!open.empty()) text += open + " these frames show no difference from random";
    } else if (!worse.empty()) {
      text += name + " does not help here";
      if (!open.empty()) text += ", and is worse than random in " + worse;
    } else {
      text += "These frames cannot tell whether " + name + " helps";
    }
    text += ": " + growth_text(row) + caution(row) + ".";
    if (pays ? !is_affordable : !worse.empty()) verdict_.recommended = is_pose_near() ? "aligned" : "all";
    advise(pays);
  }

  // pose() is not shown to be far: from the true poses, where enough are known, or else from those of all inliers.
  bool is_pose_near() const {
    const EvaluationRow* const aligned = evaluation_.row("aligned", 0);
    return aligned != nullptr && (knows_truth(*aligned) ? has_small_errors(*aligned) : is_near_all(*aligned));
  }
  static bool knows_truth(const EvaluationRow& row) { return row.steps >= enough_frames; }
  static bool is_near_all(const EvaluationRow& row) {
    return row.costs[0].growth.interval.low <= limits[2] && row.costs[1].growth.interval.low <= limits[2];
  }
  static bool has_small_errors(const EvaluationRow& row) {
    return row.costs[0].true_growth.interval.low <= limits[2] && row.costs[1].true_growth.interval.low <= limits[2];
  }

  std::string growth_text(const EvaluationRow& row) const {
    const EvaluationRow* const random = evaluation_.row("random_gated", row.budget);
    std::string text = "with " + std::to_string(row.budget) + " of some " + count(evaluation_.inliers) +
                       " inliers the standard deviation of the pose grows by " + percent(row.costs[0].growth) +
                       " in translation and " + percent(row.costs[1].growth) + " in rotation";
    if (random == nullptr) return text;
    return text + ", with as many random ones by " + percent(random->costs[0].growth.value) + " and " +
           percent(random->costs[1].growth.value);
  }

  // The pose of all inliers is no truth.
  std::string caution(const EvaluationRow& row) const {
    if (knows_truth(row)) return ". " + true_growth_text(row);
    if (!verdict_.shares_errors) return "";
    return ". The pose of all inliers has the shared errors, too: this is not the error to the truth";
  }
  static std::string true_growth_text(const EvaluationRow& row) {
    return "Against the true poses the error grows by " + percent(row.costs[0].true_growth) + " in translation and " +
           percent(row.costs[1].true_growth) + " in rotation";
  }

  // Two estimates from nearly the same matches should agree.
  static std::string caution_of_pose(const EvaluationRow& aligned) {
    if (knows_truth(aligned)) return ". " + true_growth_text(aligned);
    if (is_near_all(aligned)) return "";
    return ". Both poses are of nearly the same matches, so errors are larger than sigmas say. Record the "
           "covariances of map points, where these are uncertain. True poses would tell which pose is better";
  }

  // From which on the growth is within the limit; 0: none.
  std::size_t smallest_budget(double limit) const {
    std::size_t smallest = 0;
    for (const EvaluationRow& row : evaluation_.rows) {
      if (row.selector != selector_ || row.frames < enough_frames || is_most(row.budget)) continue;
      if (!(growth(row) <= limit)) {
        smallest = 0;
      } else if (smallest == 0) {
        smallest = row.budget;
      }
    }
    return smallest;
  }

  void advise(bool pays) {
    if (const EvaluationRow* const aligned = evaluation_.row("aligned", 0)) {
      const std::string grows = "standard deviation grows by " + percent(aligned->costs[0].growth) +
                                " in translation and " + percent(aligned->costs[1].growth) + " in rotation";
      verdict_.advice.push_back((is_pose_near() ? "For the pose alone, do not select, take pose(): its "
                                                : "For the pose alone, optimise with all inliers, not pose(), whose ") +
                                grows + caution_of_pose(*aligned) + ".");
    }
    if (verdict_.recommended != selector_) {
      verdict_.advice.emplace_back("For later steps, use all inliers, or try larger --budgets.");
    } else if (pays) {
      verdict_.advice.push_back(
          "For later steps, take the smallest budget whose growth you can afford: " + budgets_text() + ".");
    } else {
      verdict_.advice.emplace_back("Record more frames.");
    }
    const Statistic& highest = evaluation_.chi2_by_leverage.back();
    if (highest.interval.low > rising_from * evaluation_.chi2) {
      verdict_.advice.push_back("The most informative tenth of the matches is noisier than its sigmas say: its " +
                                ("chi-squared is " + fixed(highest.value, 2)) + ", and that of all " +
                                fixed(evaluation_.chi2, 2) + ". Growth is measured, so it stands. Right sigmas would " +
                                "make it smaller.");
    }
  }

  // "at most 5 %, none of these; at most 10 %, 200; at most 20 %, 100 (no better than random in rotation)"
  std::string budgets_text() const {
    std::vector<std::string> texts;
    for (const double limit : limits) {
      const std::size_t budget = smallest_budget(limit);
      texts.push_back("at most " + fixed(100 * limit, 0) + " %, ");
      texts.back() += budget > 0 ? std::to_string(budget) : "none of these";
      if (budget == 0) continue;
      const std::string worse =
          parts_where(*evaluation_.row(selector_, budget), [](const Cost& cost) { return cost.of_random.value > 1; });
      if (!worse.empty()) texts.back() += " (no better than random in " + worse + ")";
    }
    return joined(texts, "; ");
  }

  const Evaluation& evaluation_;
  std::string selector_;  // of the library, that is judged
  Verdict verdict_;
};

}  // namespace

Verdict verdict_of(const Evaluation& evaluation) { return Judge(evaluation).run(); }

}  // namespace maxlogdet::sim
