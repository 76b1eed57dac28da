// SPDX-License-Identifier: MIT
#include <maxlogdet/good_features.hpp>

#include "kernel/base/limits.hpp"
#include "kernel/blocks/block_planes.hpp"
#include "kernel/frame_matches.hpp"

#include <maxlogdet/active_selection.hpp>
#include <maxlogdet/frame_recorder.hpp>
#include <maxlogdet/image_cells.hpp>
#include <maxlogdet/match_information.hpp>
#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <vector>

namespace maxlogdet {
namespace {

constexpr double quantile_of_two = 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
constexpr double quantile_of_three = 7.815;

bool is_set(const unsigned char* mask, std::size_t i) noexcept { return mask != nullptr && mask[i] != 0; }

Selection nothing_selected() noexcept {
  Selection none{};
  none.status = Status::all_selected;
  none.threads = 1;
  none.log_det = none.upper_bound = none.efficiency = none.translation_sigma = none.rotation_sigma = not_a_number;
  return none;
}

}  // namespace

struct GoodFeatures::State {
  State(std::size_t capacity, Executor* helpers)
      : matches(capacity),
        store(capacity),
        selector(capacity, helpers),
        cells(capacity),
        executor(helpers),
        max_kept(capacity) {
    for (auto* array : {&required, &excluded, &is_selected, &is_spread}) array->resize(capacity);
    indices.resize(capacity);
    gains.resize(capacity);
    flagged.reserve(capacity);
    chi2.resize(capacity);
  }

  void start() noexcept {
    store.clear();
    flagged.clear();
    answer = nothing_selected();
    is_recorded = recorder.is_open();
    report = BlockReport();
    has_prior = false;
    std::fill_n(is_selected.begin(), is_selected.size(), static_cast<unsigned char>(0));
    std::fill_n(chi2.begin(), chi2.size(), not_a_number);
  }

  bool build(const BlockOptions& options) noexcept {
    store.clear();
    report = matches.append_blocks_to(store, options, executor);
    return report.error == Error::none;
  }

  void begin_answer() noexcept {
    answer = nothing_selected();
    std::fill_n(is_selected.begin(), matches.size(), static_cast<unsigned char>(0));
  }

  // Appends a match to the answer.
  void take(std::size_t i, double gain) noexcept {
    indices[answer.size] = static_cast<std::uint32_t>(i);
    gains[answer.size++] = gain;
    is_selected[i] = 1;
  }

  void keep_prior(const Options& options) noexcept {
    has_prior = options.prior != nullptr;
    if (has_prior) std::copy_n(options.prior, state_dimension * state_dimension, prior);
  }

  void select_usable(Error why, const unsigned char* left_out) noexcept;
  void select_as_asked(const Options& asked, double cells_per_match) noexcept;
  void spread_over_image(double cells_per_match, Options& options) noexcept;
  void fill_up(const Options& asked, std::size_t usable) noexcept;
  void take_candidates(const Selection& selection) noexcept;
  void match_as_asked(const Options& asked, const BlockOptions& blocks, MatchFunction function, void* context);
  void match_required(const Options& asked, MatchFunction function, void* context);
  void match_by_gain(const BlockOptions& blocks, MatchFunction function, void* context);
  void match_in_order(std::size_t budget, MatchFunction function, void* context);
  bool try_to_match(std::size_t i, MatchFunction function, void* context);
  bool start_recording(const char* folder) noexcept;
  void record(const BlockOptions& options) noexcept;

  FrameMatches matches;
  BlockStore store;
  Selector selector;
  ImageCells cells;
  std::unique_ptr<ActiveSelection> active;  // from the first match() on
  BlockStore one;                           // a block as measured
  Executor* executor;
  std::size_t max_kept;
  FrameRecorder recorder;
  bool is_recorded = false;
  BlockReport report;
  Selection answer = nothing_selected();
  std::vector<std::uint32_t> indices, flagged;
  std::vector<double> gains, chi2;
  std::vector<unsigned char> required, excluded, is_selected, is_spread;
  bool has_prior = false;
  double prior[state_dimension * state_dimension] = {};
};

// After an error: all that can be optimised with.
void GoodFeatures::State::select_usable(Error why, const unsigned char* left_out) noexcept {
  begin_answer();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches.is_usable(i) && !is_set(left_out, i)) take(i, not_a_number);
  }
  answer.status = Status::error;
  answer.error = why;
}

// Required matches count towards the budget, but may be neighbours; the others share the cells.
void GoodFeatures::State::spread_over_image(double cells_per_match, Options& options) noexcept {
  const unsigned char* const has_block = planes_of(store).validity();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_free = !is_set(options.required, i) && !is_set(options.excluded, i);
    is_spread[i] = is_set(has_block, i) && matches.is_measured(i) && is_free ? 1 : 0;
  }
  const double wanted = std::fmax(cells_per_match, 1) * static_cast<double>(options.budget);
  const auto count = static_cast<std::size_t>(std::fmin(std::round(wanted), static_cast<double>(matches.size())));
  cells.assign(matches.measured.data(), 3, matches.size(), count, is_spread.data(),
               matches.has_rig ? matches.camera_ids.data() : nullptr);
  cells.limit(options);
}

void GoodFeatures::State::take_candidates(const Selection& selection) noexcept {
  const std::size_t before = answer.size;
  for (std::size_t j = 0; j < selection.size; ++j) take(selection.indices[j], selection.gains[j]);
  const std::size_t size = answer.size;
  answer = selection;
  answer.size = size;
  answer.searched += before;
}

void GoodFeatures::State::select_as_asked(const Options& asked, double cells_per_match) noexcept {
  if (!(cells_per_match >= 0) || cells_per_match == infinity) {
    return select_usable(Error::invalid_groups, asked.excluded);
  }
  Options options = asked;
  begin_answer();
  std::size_t usable = 0;
  bool is_any_required = false;
  const unsigned char* const has_block = planes_of(store).validity();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_allowed = matches.is_usable(i) && (!is_set(asked.excluded, i) || is_set(asked.required, i));
    const bool is_needed = is_allowed && (matches.is_required[i] != 0 || is_set(asked.required, i));
    usable += is_allowed ? 1 : 0;
    required[i] = is_needed && is_set(has_block, i) ? 1 : 0;
    is_any_required = is_any_required || required[i] != 0;
    if (is_needed && !is_set(has_block, i)) take(i, not_a_number);  // no candidate, but wanted in any case
  }
  options.required = is_any_required ? required.data() : nullptr;
  keep_prior(options);
  if (cells_per_match > 0 && options.groups.ids == nullptr) spread_over_image(cells_per_match, options);
  const Selection selection = selector.select(store, options);
  if (!selection.has_answer()) return select_usable(selection.error, asked.excluded);
  take_candidates(selection);
  fill_up(asked, usable);
}

// Usable matches without a block fill what the candidates have left of the budget.
void GoodFeatures::State::fill_up(const Options& asked, std::size_t usable) noexcept {
  if (answer.status == Status::target_reached) return;
  const std::size_t candidates = answer.size;
  for (std::size_t i = 0; i < matches.size() && answer.size < asked.budget && asked.groups.ids == nullptr; ++i) {
    if (matches.is_usable(i) && is_selected[i] == 0 && !is_set(asked.excluded, i)) take(i, not_a_number);
  }
  if (answer.status == Status::deadline_reached) return;
  if (answer.size == usable) {
    answer.status = Status::all_selected;
  } else if (answer.size > candidates) {
    answer.status = Status::few_candidates;
  } else if (asked.groups.ids == nullptr || answer.size == asked.budget) {
    answer.status = Status::ok;
  }
}

bool GoodFeatures::State::try_to_match(std::size_t i, MatchFunction function, void* context) {
  FeatureMatch match = matches.get(i);
  const bool is_found = function(context, i, match);
  if (is_found) matches.set(i, match);
  if (is_found && matches.is_usable(i)) return true;
  matches.leave_unmatched(i);
  return false;
}

// Required points are tried first: only what is found may be required of the selection.
void GoodFeatures::State::match_required(const Options& asked, MatchFunction function, void* context) {
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_needed = matches.is_required[i] != 0 || is_set(asked.required, i);
    required[i] = is_needed && matches.is_usable(i) && try_to_match(i, function, context) ? 1 : 0;
    excluded[i] = !matches.is_usable(i) || (is_set(asked.excluded, i) && required[i] == 0) ? 1 : 0;
  }
}

void GoodFeatures::State::match_by_gain(const BlockOptions& blocks, MatchFunction function, void* context) {
  for (std::uint32_t i; (i = active->next()) != ActiveSelection::none;) {
    if (!try_to_match(i, function, context)) {
      active->reject();
      continue;
    }
    double rows[max_block_rows][state_dimension];
    const int count = matches.block_of(i, one, blocks, rows);
    count > 0 ? active->accept(&rows[0][0], count) : active->accept();
  }
  take_candidates(active->selection());
}

// After an error: there are no gains.
void GoodFeatures::State::match_in_order(std::size_t budget, MatchFunction function, void* context) {
  for (std::size_t i = 0; i < matches.size() && answer.size < budget; ++i) {
    if (required[i] != 0 || (excluded[i] == 0 && try_to_match(i, function, context))) take(i, not_a_number);
  }
}

void GoodFeatures::State::match_as_asked(const Options& asked, const BlockOptions& blocks, MatchFunction function,
                                         void* context) {
  if (!active) active = std::make_unique<ActiveSelection>(max_kept);
  if (one.capacity() == 0) one.reserve(1);
  begin_answer();
  match_required(asked, function, context);
  Error error = build(blocks) ? Error::none : report.error;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (error != Error::none || required[i] == 0 || store.is_valid(i)) continue;
    required[i] = 0;  // found, but no candidate
    take(i, not_a_number);
  }
  Options options = asked;
  options.required = required.data();
  options.excluded = excluded.data();
  keep_prior(options);
  if (error == Error::none) error = active->start(store, options);
  if (error == Error::none) {
    match_by_gain(blocks, function, context);
  } else {
    match_in_order(asked.budget, function, context);
    answer.status = Status::error;
    answer.error = error;
  }
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches.is_usable(i) && is_selected[i] == 0) matches.leave_unmatched(i);
  }
}

bool GoodFeatures::State::start_recording(const char* folder) noexcept try {
  matches.reserve_numbers();
  return recorder.open(folder);
} catch (const std::bad_alloc&) {
  return recorder.open(nullptr);
}

// The frame, as select() or match() has left it; once.
void GoodFeatures::State::record(const BlockOptions& options) noexcept {
  const bool is_due = is_recorded && report.error == Error::none && matches.added() == matches.size();
  is_recorded = false;
  if (!is_due) return;
  FrameDetails details;
  details.depth_cue = matches.depth_cue;
  details.depth_sigma = options.depth_sigma;
  details.has_covariances = matches.has_covariances;
  details.has_keyframes = matches.has_keyframes();
  matches.has_rig ? recorder.start(matches.rig, matches.T, details)
                  : recorder.start(matches.only.camera, matches.T, details);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches.is_usable(i)) recorder.add(matches.get(i), is_selected[i] != 0);
  }
  recorder.finish();
}

GoodFeatures::GoodFeatures(std::size_t capacity, Executor* executor) : state_(new State(capacity, executor)) {}
GoodFeatures::~GoodFeatures() = default;
GoodFeatures::GoodFeatures(GoodFeatures&&) noexcept = default;
GoodFeatures& GoodFeatures::operator=(GoodFeatures&&) noexcept = default;

void GoodFeatures::start(const Camera& camera, const RigidTransform& T_cw) noexcept {
  state_->start();
  state_->matches.start(camera, T_cw, state_->is_recorded);
}

void GoodFeatures::start(const Rig& rig, const RigidTransform& T_bw) noexcept {
  state_->start();
  state_->matches.start(rig, T_bw, state_->is_recorded);
}

void GoodFeatures::add(const FeatureMatch& match) noexcept { state_->matches.add(match); }
void GoodFeatures::add(const WorldPoint& p_w, const Pixel& measured, double sigma) noexcept {
  add(FeatureMatch(p_w, measured, sigma));
}
void GoodFeatures::add(const WorldPoint& p_w, double sigma) noexcept { add(FeatureMatch(p_w, sigma)); }
std::size_t GoodFeatures::size() const noexcept { return state_->matches.added(); }
// Weak: a C++17 translation unit that takes its address has a definition of its own.
[[gnu::weak]] constexpr std::uint32_t GoodFeatures::no_id;

std::uint32_t GoodFeatures::id(std::size_t i) const noexcept {
  return state_->matches.is_kept(i) ? state_->matches.ids[i] : no_id;
}

Selection GoodFeatures::select(const Options& options) noexcept {
  using Clock = std::chrono::steady_clock;
  State& s = *state_;
  const bool has_limit = options.time_limit > 0;
  const Clock::time_point start = has_limit ? Clock::now() : Clock::time_point();
  if (s.build(block_options)) {
    Options asked = options;
    if (has_limit) {
      const double spent = std::chrono::duration<double>(Clock::now() - start).count();
      asked.time_limit = std::fmax(options.time_limit - spent, std::numeric_limits<double>::min());
    }
    s.select_as_asked(asked, spread);
  } else {
    s.select_usable(s.report.error, options.excluded);
  }
  s.record(block_options);
  return selection();
}

Selection GoodFeatures::match_by(const Options& options, MatchFunction function, void* context) {
  state_->match_as_asked(options, block_options, function, context);
  state_->record(block_options);
  return selection();
}

Selection GoodFeatures::selection() const noexcept {
  Selection selection = state_->answer;
  selection.indices = state_->indices.data();
  selection.gains = state_->gains.data();
  return selection;
}

const char* GoodFeatures::reason() const noexcept {
  const bool are_all_kept = state_->matches.added() == state_->matches.size();
  return are_all_kept || !state_->answer.has_answer() ? state_->answer.reason() : to_string(Error::capacity_exceeded);
}
const BlockReport& GoodFeatures::block_report() const noexcept { return state_->report; }
const BlockStore& GoodFeatures::blocks() const noexcept { return state_->store; }
bool GoodFeatures::is_selected(std::size_t i) const noexcept {
  return state_->matches.is_kept(i) && state_->is_selected[i] != 0;
}

bool GoodFeatures::information(std::size_t i, double* omega) const noexcept {
  return state_->matches.weigh(i, block_options, false, omega);
}
bool GoodFeatures::whitening(std::size_t i, double* W) const noexcept {
  return state_->matches.weigh(i, block_options, true, W);
}

IndexRange GoodFeatures::outliers(const RigidTransform& T_cw) noexcept {
  State& s = *state_;
  s.flagged.clear();
  for (std::size_t i = 0; i < s.matches.size(); ++i) {
    s.chi2[i] = not_a_number;
    if (s.is_selected[i] == 0) s.chi2[i] = s.matches.chi2_of(T_cw, i, is_weighted ? &block_options : nullptr);
    if (is_outlier(i)) s.flagged.push_back(static_cast<std::uint32_t>(i));
  }
  return {s.flagged.data(), s.flagged.size()};
}
double GoodFeatures::chi2(std::size_t i) const noexcept {
  return state_->matches.is_kept(i) ? state_->chi2[i] : not_a_number;
}
bool GoodFeatures::is_outlier(std::size_t i) const noexcept {
  return state_->matches.is_kept(i) &&
         state_->chi2[i] > (state_->matches.has_depth_cue[i] != 0 ? quantile_of_three : quantile_of_two);
}

double GoodFeatures::efficiency() noexcept {
  State& s = *state_;
  if (!s.answer.has_answer() || s.store.invalid_count() == s.store.size()) return not_a_number;
  Options all(s.max_kept);
  if (s.has_prior) all.prior = s.prior;
  all.strategy = Strategy::backward_greedy;  // starts from all of them and removes none
  const Selection selection = s.selector.select(s.store, all);
  return std::min(std::exp((s.answer.log_det - selection.log_det) / state_dimension), 1.0);
}

bool GoodFeatures::record(const char* folder) noexcept { return state_->start_recording(folder); }

}  // namespace maxlogdet
