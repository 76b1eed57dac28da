// SPDX-License-Identifier: MIT
#include <maxlogdet/good_features.hpp>

#include "kernel/alignment/aligner.hpp"
#include "kernel/base/deadline.hpp"
#include "kernel/base/memory.hpp"
#include "kernel/blocks/matched_frame.hpp"
#include "kernel/frame_recorder.hpp"
#include "kernel/image_cells.hpp"
#include "kernel/information/prior.hpp"

#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace maxlogdet {
namespace {

// Those without a block are named if they are a twentieth of the usable ones, and not a few by chance.
constexpr double sizeable_share = 0.05;
constexpr std::size_t sizeable_count = 5;

constexpr double quantile_of_two = 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
constexpr double quantile_of_three = 7.815;

}  // namespace

/// A frame: its matches, their blocks, which of them are selected, and how the others fit; in memory that is allocated
/// once.
struct GoodFeatures::State {
  State(std::size_t capacity, Executor* executor);

  void align(const double* of_pose) noexcept;
  void forget_alignment() noexcept;
  Error make_blocks() noexcept;
  bool has_image(std::size_t i) const noexcept;
  void explain_rejected() noexcept;
  Warning warning() const noexcept;

  void clear_answer() noexcept;
  void take(std::size_t i, double gain) noexcept;
  Error settle(double cells_per_match, Options& options) noexcept;
  void spread_over_image(double cell_count, Options& options) noexcept;
  void select_candidates(const Options& options) noexcept;
  void fill_up(const Options& asked, double cells_per_match) noexcept;
  void select_inliers(Error why) noexcept;
  void record() noexcept;

  // The frame, with the first frame.size of the matches added. Only usable ones set what the frame has.
  Camera alone;  // of a frame with one camera
  MatchedFrame frame;
  std::size_t added = 0;
  std::vector<FeatureMatch> matches;
  std::vector<double> covariances;  // to which the matches point
  std::vector<unsigned char> is_usable;
  std::vector<unsigned char> is_inlier;  // usable, and not rejected
  Aligner aligner;
  BlockStore blocks;  // candidate i is match i
  BlockReport report;

  // The answer.
  Selector selector;
  ImageCells cells;
  std::vector<unsigned char> is_required, is_spread;
  Selection summary;  // without its arrays
  std::vector<std::uint32_t> indices;
  std::vector<double> gains;
  std::vector<unsigned char> is_selected;
  bool is_answered = false;  // by select(), in this frame
  bool has_prior = false;
  double prior[state_dimension * state_dimension];

  std::size_t judged = 0;  // the first matches
  bool are_cues_judged = false;
  std::vector<double> chi2;
  std::vector<std::uint32_t> outliers;

  FrameRecorder recorder;
  bool is_record_due = false;
};

GoodFeatures::State::State(std::size_t capacity, Executor* executor)
    : matches(checked_capacity(capacity)),
      covariances(9 * capacity),
      is_usable(capacity),
      is_inlier(capacity),
      aligner(capacity),
      blocks(capacity),
      selector(capacity, executor),
      cells(capacity),
      is_required(capacity),
      is_spread(capacity),
      indices(capacity),
      gains(capacity),
      is_selected(capacity),
      chi2(capacity) {
  outliers.reserve(capacity);
  clear_answer();
}

GoodFeatures::GoodFeatures(std::size_t capacity, Executor* executor) : state_(new State(capacity, executor)) {}
void GoodFeatures::Destroy::operator()(State* state) const noexcept { delete state; }

// Matches

void GoodFeatures::start(const Camera& camera, const RigidTransform& T_cw) noexcept {
  state_->alone = camera;
  start(&state_->alone, 1, T_cw);
}

void GoodFeatures::start(const Camera* cameras, std::size_t count, const RigidTransform& T_bw) noexcept {
  State& s = *state_;
  s.frame = MatchedFrame{cameras, cameras == nullptr ? 0 : count, T_bw, s.matches.data(), 0, s.is_usable.data()};
  s.added = 0;
  s.blocks.clear();
  s.report = BlockReport();
  s.forget_alignment();
  s.clear_answer();
  s.is_record_due = s.recorder.is_open();
}

void GoodFeatures::add(const FeatureMatch& match) noexcept {
  State& s = *state_;
  ++s.added;
  if (s.frame.size == s.matches.size()) return;
  const std::size_t i = s.frame.size++;
  s.matches[i] = match;
  if (match.covariance != nullptr) {
    double* const copy = &s.covariances[9 * i];
    std::copy_n(match.covariance, 9, copy);
    s.matches[i].covariance = copy;
  }
  const bool is_usable = is_sound(match) && s.frame.has_camera_of(match);
  s.is_usable[i] = s.is_inlier[i] = is_usable ? 1 : 0;
  if (is_usable) s.frame.note(match);
}

std::size_t GoodFeatures::size() const noexcept { return state_->added; }
std::uint32_t GoodFeatures::id(std::size_t i) const noexcept {
  return i < state_->frame.size ? state_->matches[i].id : no_id;
}

// Alignment

void GoodFeatures::State::forget_alignment() noexcept {
  aligner.forget(frame.T_bw, Error::none);
  std::copy_n(is_usable.begin(), frame.size, is_inlier.begin());
}

// Nothing is rejected in a frame with an error.
void GoodFeatures::State::align(const double* of_pose) noexcept {
  forget_alignment();
  Error error = check(frame);
  Prior of_start;
  if (error == Error::none && of_pose != nullptr && !(of_start.read(of_pose) && of_start.is_semidefinite()))
    error = Error::invalid_prior;
  if (error != Error::none) return aligner.forget(frame.T_bw, error);
  aligner.align(frame, of_pose != nullptr ? of_start.entries : nullptr, is_inlier.data());
}

Alignment GoodFeatures::align(const double* prior) noexcept {
  state_->frame.options = block_options;
  state_->align(prior);
  return alignment();
}
Alignment GoodFeatures::alignment() const noexcept { return state_->aligner.found(); }
const RigidTransform& GoodFeatures::pose() const noexcept { return state_->aligner.pose(); }
const double* GoodFeatures::pose_information() const noexcept { return state_->aligner.information(); }
bool GoodFeatures::is_inlier(std::size_t i) const noexcept {
  return i < state_->frame.size && state_->is_inlier[i] != 0;
}

// Blocks

// Of inliers, at the aligned pose.
Error GoodFeatures::State::make_blocks() noexcept {
  MatchedFrame of_inliers = frame;
  of_inliers.T_bw = aligner.pose();
  of_inliers.usable = is_inlier.data();
  if (aligner.leaves_out_third()) of_inliers.depth_cue = DepthCue::none;
  blocks.clear();
  report = append_blocks(of_inliers, blocks);
  return report.error;
}

const BlockReport& GoodFeatures::block_report() const noexcept { return state_->report; }
const BlockStore& GoodFeatures::blocks() const noexcept { return state_->blocks; }

bool GoodFeatures::State::has_image(std::size_t i) const noexcept {
  const Camera& camera = frame.cameras[matches[i].camera_id];
  double p_b[3], p_c[3], uv[2];
  aligner.pose().transform(matches[i].point, p_b);
  camera.T_cb.transform(p_b, p_c);
  return project(camera, p_c, uv);
}

// Of what was rejected without an error the report says why there is none, as of candidates.
void GoodFeatures::State::explain_rejected() noexcept {
  aligner.for_each_without_error([this](std::size_t i) {
    const bool is_seen = has_image(i);
    // Its error was beyond all numbers, it has an image at the final pose, or fits in another attempt.
    if (is_inlier[i] != 0 || (is_seen && !frame.has_covariances)) return;
    --report.unusable;
    ++(is_seen ? report.invalid_covariances : report.behind_camera);
  });
}

// What is missing of a sizeable share of the usable matches, by its most frequent cause.
Warning GoodFeatures::State::warning() const noexcept {
  const Alignment& found = aligner.found();
  const auto usable = std::count(is_usable.begin(), is_usable.begin() + static_cast<std::ptrdiff_t>(frame.size), 1);
  if (frame.size >= sizeable_count && 2 * static_cast<std::size_t>(usable) <= frame.size)
    return Warning::unusable_matches;
  if (found.warning != Warning::none) return found.warning;
  const std::size_t missing = report.invalid - report.unusable;
  if (missing < sizeable_count || static_cast<double>(missing) < sizeable_share * static_cast<double>(usable)) {
    const bool has_failed =
        found.status != AlignmentStatus::none && !found.is_aligned() && found.measured >= Aligner::fewest_matches;
    return has_failed ? Warning::not_aligned : Warning::none;
  }
  const std::size_t unbounded = missing - report.behind_camera - report.invalid_covariances;
  if (report.behind_camera >= std::max(report.invalid_covariances, unbounded)) return Warning::behind_camera;
  return report.invalid_covariances >= unbounded ? Warning::invalid_covariances : Warning::unbounded_blocks;
}

// The answer

void GoodFeatures::State::clear_answer() noexcept {
  for (std::size_t j = 0; j < summary.size; ++j) is_selected[indices[j]] = 0;
  summary = Selection();
  summary.status = Status::all_selected;
  is_answered = has_prior = false;
  judged = 0;
}

// Whatever is taken already is ignored: no match can fill the arrays twice.
void GoodFeatures::State::take(std::size_t i, double gain) noexcept {
  if (is_selected[i] != 0) return;
  indices[summary.size] = static_cast<std::uint32_t>(i);
  gains[summary.size++] = gain;
  is_selected[i] = 1;
}

// What the matches require, and where they are, becomes part of the options for the candidates. Required matches count
// towards the budget, with a block or without one, which is taken here.
Error GoodFeatures::State::settle(double cells_per_match, Options& options) noexcept {
  if (!(cells_per_match >= 0) || cells_per_match == infinity) return Error::invalid_groups;
  if (options.required != nullptr) return Error::misplaced_required;
  std::size_t required = 0;
  for (std::size_t i = 0; i < frame.size; ++i) {
    const bool is_needed = matches[i].is_required && is_usable[i] != 0;
    is_required[i] = is_needed && blocks.is_valid(i) ? 1 : 0;
    required += is_required[i];
    if (is_needed && is_required[i] == 0) take(i, not_a_number);
  }
  if (required + summary.size > options.budget) return Error::infeasible;
  if (cells_per_match > 0 && options.groups.ids == nullptr && frame.size > 0)
    spread_over_image(cells_per_match * static_cast<double>(options.budget), options);
  options.budget -= summary.size;
  if (required > 0) options.required = is_required.data();
  return Error::none;
}

// Required matches may be neighbours; the others share the cells.
void GoodFeatures::State::spread_over_image(double cell_count, Options& options) noexcept {
  for (std::size_t i = 0; i < frame.size; ++i) {
    is_spread[i] = blocks.is_valid(i) && is_measured(matches[i]) && is_required[i] == 0 ? 1 : 0;
  }
  const double wanted = std::fmax(std::round(cell_count), 1);
  const auto count = static_cast<std::size_t>(std::fmin(wanted, static_cast<double>(frame.size)));
  cells.limit(matches.data(), frame.size, is_spread.data(), count, options);
}

void GoodFeatures::State::select_candidates(const Options& options) noexcept {
  const Selection selection = selector.select(blocks, options);
  if (!selection.has_answer()) return select_inliers(selection.error);
  const std::size_t before = summary.size;
  for (std::size_t j = 0; j < selection.size; ++j) take(selection.indices[j], selection.gains[j]);
  summary = selection;
  summary.size += before;
  summary.searched += before;
}

// Inliers without a block fill what the candidates have left of the budget, but no group, nor beyond a target. From a
// spread of 1 on, cells are as many as the budget, so that only the lack of candidates leaves it short.
void GoodFeatures::State::fill_up(const Options& asked, double cells_per_match) noexcept {
  const Status status = summary.status;
  if (status == Status::error || status == Status::target_reached) return;
  const bool has_groups = asked.groups.ids != nullptr || (cells_per_match > 0 && cells_per_match < 1);
  const std::size_t candidates = summary.size;
  for (std::size_t i = 0; i < frame.size && summary.size < asked.budget && !has_groups; ++i) {
    if (is_inlier[i] != 0) take(i, not_a_number);
  }
  if (status == Status::deadline_reached) return;
  bool are_all_in = true;
  for (std::size_t i = 0; i < frame.size; ++i) are_all_in = are_all_in && (is_inlier[i] == 0 || is_selected[i] != 0);
  if (are_all_in) {
    const Alignment& found = aligner.found();
    const bool are_rejected = found.is_aligned() && found.inliers < found.measured;
    summary.status = are_rejected && summary.size < asked.budget ? Status::few_inliers : Status::all_selected;
  } else if (summary.size > candidates) {
    summary.status = Status::few_candidates;
  } else if (!has_groups || summary.size == asked.budget) {
    summary.status = Status::ok;
  }
}

// The answer after an error: all that can be optimised with, and what is required.
void GoodFeatures::State::select_inliers(Error why) noexcept {
  clear_answer();
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (is_inlier[i] != 0 || (is_usable[i] != 0 && matches[i].is_required)) take(i, not_a_number);
  }
  summary.status = Status::error;
  summary.error = why;
}

Selection GoodFeatures::select(const Options& options) noexcept {
  const Deadline time(options.time_limit);
  State& s = *state_;
  s.clear_answer();
  s.has_prior = options.prior != nullptr;
  if (s.has_prior) std::copy_n(options.prior, state_dimension * state_dimension, s.prior);
  s.frame.options = block_options;
  rejects_outliers ? s.align(options.prior) : s.forget_alignment();
  Error error = s.make_blocks();
  Options settled = options;
  if (error == Error::none) error = s.settle(spread, settled);
  settled.time_limit = time.left();
  error == Error::none ? s.select_candidates(settled) : s.select_inliers(error);
  s.fill_up(options, spread);
  s.explain_rejected();
  s.summary.warning = s.summary.status == Status::error ? Warning::none : s.warning();
  s.is_answered = true;
  if (s.is_record_due) s.record();
  return selection();
}

Selection GoodFeatures::selection() const noexcept {
  Selection selection = state_->summary;
  selection.indices = state_->indices.data();
  selection.gains = state_->gains.data();
  return selection;
}
const char* GoodFeatures::reason() const noexcept {
  const Alignment found = alignment();
  const bool is_aligned_alone = !state_->is_answered && found.status != AlignmentStatus::none;
  if (found.error != Error::none && !state_->is_answered) return found.reason();
  if (!selection().has_answer()) return selection().reason();
  if (state_->added > state_->frame.size) return to_string(Error::capacity_exceeded);
  return is_aligned_alone ? found.reason() : selection().reason();
}
bool GoodFeatures::is_selected(std::size_t i) const noexcept {
  return i < state_->frame.size && state_->is_selected[i] != 0;
}

// The selected ones alone, as required ones, against the target of all.
double GoodFeatures::efficiency() noexcept {
  State& s = *state_;
  if (s.summary.status == Status::error || s.blocks.stored() == 0) return not_a_number;
  Options options(0);
  for (std::size_t i = 0; i < s.frame.size; ++i) {
    s.is_required[i] = s.is_selected[i] != 0 && s.blocks.is_valid(i) ? 1 : 0;
    options.budget += s.is_required[i];
  }
  options.required = s.is_required.data();
  options.target_efficiency = 1;
  if (s.has_prior) options.prior = s.prior;
  return std::min(s.selector.select(s.blocks, options).efficiency, 1.0);
}

// How the matches fit the optimised pose

IndexRange GoodFeatures::outliers(const RigidTransform& T_cw) noexcept {
  State& s = *state_;
  s.outliers.clear();
  s.judged = 0;
  MatchedFrame at = s.frame;
  at.T_bw = T_cw;
  at.options = block_options;
  if (at.has_mixed_cues || s.aligner.leaves_out_third()) at.depth_cue = DepthCue::none;
  at.has_mixed_cues = false;
  if (!is_rigid(T_cw)) return {};
  s.judged = at.size;
  s.are_cues_judged = at.depth_cue != DepthCue::none;
  for (std::size_t i = 0; i < at.size; ++i) s.chi2[i] = s.is_usable[i] != 0 ? not_a_number : infinity;
  if (check(at) == Error::none) s.aligner.judge(at, s.chi2.data());
  for (std::size_t i = 0; i < at.size; ++i) {
    if (s.is_selected[i] != 0) s.chi2[i] = not_a_number;
    if (is_outlier(i)) s.outliers.push_back(static_cast<std::uint32_t>(i));
  }
  IndexRange found;
  found.indices = s.outliers.data();
  found.size = s.outliers.size();
  return found;
}

double GoodFeatures::chi2(std::size_t i) const noexcept { return i < state_->judged ? state_->chi2[i] : not_a_number; }

bool GoodFeatures::is_outlier(std::size_t i) const noexcept {
  if (i >= state_->judged) return false;
  const bool has_cue = state_->are_cues_judged && measured_cue(state_->matches[i]) != DepthCue::none;
  return chi2(i) > (has_cue ? quantile_of_three : quantile_of_two);
}

// Recording

// Reads the frame as select() has left it, and hands it to the recorder.
void GoodFeatures::State::record() noexcept {
  is_record_due = false;
  if (added > frame.size) {
    recorder.skip("it has more matches than the capacity");
  } else if (report.error != Error::none) {
    recorder.skip(explain(report.error));
  } else {
    recorder.write(frame, is_selected.data());
  }
}

bool GoodFeatures::record(const char* folder) noexcept { return state_->recorder.open(folder); }

}  // namespace maxlogdet
