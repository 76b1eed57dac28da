// SPDX-License-Identifier: MIT
#include <maxlogdet/good_features.hpp>

#include "kernel/alignment/aligner.hpp"
#include "kernel/base/deadline.hpp"
#include "kernel/base/limits.hpp"
#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/block_planes.hpp"
#include "kernel/empty_selection.hpp"
#include "kernel/information/prior.hpp"

#include <maxlogdet/frame_recorder.hpp>
#include <maxlogdet/image_cells.hpp>
#include <maxlogdet/match_information.hpp>
#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

namespace maxlogdet {
namespace {

// Those without a block are named if they are a twentieth of the usable ones, and not a few by chance.
constexpr double sizeable_share = 0.05;
constexpr std::size_t sizeable_count = 5;

constexpr double quantile_of_two = 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
constexpr double quantile_of_three = 7.815;

bool has_right(const FeatureMatch& match) noexcept { return match.u_right >= 0 && match.u_right < infinity; }
bool has_depth(const FeatureMatch& match) noexcept { return is_positive(match.depth); }

DepthCue measured_cue(const FeatureMatch& match) noexcept {
  if (has_right(match)) return DepthCue::stereo;
  return has_depth(match) ? DepthCue::depth : DepthCue::none;
}

bool is_measured(const FeatureMatch& match) noexcept { return match.measured[0] != unmeasured; }
// What can be computed with: squares of numbers far beyond these would overflow.
bool is_sound(const FeatureMatch& match) noexcept {
  const bool is_moderate = std::abs(match.measured[0]) < 1e15 && std::abs(match.measured[1]) < 1e15;
  return all_finite(match.point, 3) && (is_moderate || !is_measured(match)) && match.sigma > 1e-15 &&
         match.sigma < 1e15;
}

}  // namespace

/// A frame: its matches, their blocks, which of them are selected, and how the others fit; in memory that is allocated
/// once.
struct GoodFeatures::State {
  State(std::size_t capacity, Executor* executor);

  void start(const Camera* seen_by, std::size_t count, const RigidTransform& pose) noexcept;
  void add(const FeatureMatch& match) noexcept;
  DepthCue cue_of(std::size_t i) const noexcept {
    return aligner.leaves_out_third() ? DepthCue::none : measured_cue(matches[i]);
  }
  MatchNoise noise_of(std::size_t i, const BlockOptions& options) const noexcept;
  BlockOptions options_of_frame(BlockOptions options) noexcept;
  void align(BlockOptions& options, const double* of_pose) noexcept;
  void forget_alignment() noexcept;
  Error make_blocks(const BlockOptions& options) noexcept;
  void explain_rejected() noexcept;
  bool is_sizeable(std::size_t count) const noexcept;
  Warning warning() const noexcept;

  void clear_answer() noexcept;
  void take(std::size_t i, double gain) noexcept;
  Error settle(const Options& asked, double cells_per_match, Options& options) noexcept;
  void spread_over_image(double cell_count, Options& options) noexcept;
  void select_candidates(const Options& options) noexcept;
  void fill_up(const Options& asked, double cells_per_match) noexcept;
  void select_usable(Error why) noexcept;

  bool residual_of(std::size_t i, const RigidTransform& pose, double (&e)[3]) const noexcept;
  double chi2_of(std::size_t i, const RigidTransform& pose, const BlockOptions& options,
                 bool is_whitened) const noexcept;
  void record(double depth_sigma) noexcept;

  // The frame.
  Camera alone;  // of a frame with one camera
  const Camera* cameras = &alone;
  std::size_t camera_count = 1;
  RigidTransform T_bw = nullptr;
  // The matches; the first `size` of `added` are kept. Only usable ones set what the frame has.
  std::size_t added = 0, size = 0;
  std::vector<FeatureMatch> matches;
  DepthCue depth_cue = DepthCue::none;
  bool are_mixed = false;  // some matches with a right column, and some with a depth
  bool has_covariances = false;
  // What append_blocks and a Selector read as arrays.
  std::vector<double> sigmas, covariances;
  std::vector<unsigned char> camera_ids, has_depth_cue, is_usable, is_required, is_spread;
  BlockStore blocks;
  BlockReport report;

  Aligner aligner;
  std::vector<unsigned char> is_aligned;  // usable, with a measurement
  std::vector<unsigned char> is_inlier;   // usable, and not rejected

  // The answer.
  Selector selector;
  ImageCells cells;
  Selection summary;  // without its arrays
  std::vector<std::uint32_t> indices;
  std::vector<double> gains;
  std::vector<unsigned char> is_selected;
  bool has_prior = false;
  double prior[state_dimension * state_dimension];

  std::size_t judged = 0;  // the first matches
  std::vector<double> chi2;
  std::vector<std::uint32_t> outliers;

  FrameRecorder recorder;
  bool is_record_due = false;
};

GoodFeatures::State::State(std::size_t capacity, Executor* executor)
    : matches(checked_capacity(capacity)),
      sigmas(capacity),
      covariances(9 * capacity),
      camera_ids(capacity),
      has_depth_cue(capacity),
      is_usable(capacity),
      is_required(capacity),
      is_spread(capacity),
      blocks(capacity),
      aligner(capacity),
      is_aligned(capacity),
      is_inlier(capacity),
      selector(capacity, executor),
      cells(capacity),
      summary(empty_selection(Error::none)),
      indices(capacity),
      gains(capacity),
      is_selected(capacity),
      chi2(capacity) {
  outliers.reserve(capacity);
  clear_answer();
}

// Matches

void GoodFeatures::State::start(const Camera* seen_by, std::size_t count, const RigidTransform& pose) noexcept {
  cameras = seen_by;
  camera_count = seen_by == nullptr ? 0 : count;
  T_bw = pose;
  added = size = judged = 0;
  depth_cue = DepthCue::none;
  are_mixed = has_covariances = false;
  blocks.clear();
  report = BlockReport();
  forget_alignment();
  clear_answer();
  is_record_due = recorder.is_open();
}

void GoodFeatures::State::add(const FeatureMatch& match) noexcept {
  ++added;
  if (size == matches.size()) return;
  const std::size_t i = size++;
  matches[i] = match;
  sigmas[i] = match.sigma;
  camera_ids[i] = match.camera_id;
  const bool has_camera = match.camera_id < camera_count || camera_count == 0;  // none: an error of the frame
  is_usable[i] = is_inlier[i] = is_sound(match) && has_camera ? 1 : 0;
  is_aligned[i] = is_usable[i] != 0 && is_measured(match) ? 1 : 0;
  has_depth_cue[i] = 0;
  if (match.covariance != nullptr) {
    double* const copy = &covariances[9 * i];
    std::copy_n(match.covariance, 9, copy);
    matches[i].covariance = copy;
  }
  if (is_usable[i] == 0) return;
  has_covariances = has_covariances || match.covariance != nullptr;
  const DepthCue cue = measured_cue(match);
  if (cue == DepthCue::none) return;
  has_depth_cue[i] = 1;
  const bool has_both = has_right(match) && has_depth(match);
  are_mixed = are_mixed || has_both || (depth_cue != DepthCue::none && depth_cue != cue);
  depth_cue = cue;
}

// The noise that the block of match i is whitened by.
MatchNoise GoodFeatures::State::noise_of(std::size_t i, const BlockOptions& options) const noexcept {
  MatchNoise noise;
  noise.sigma = matches[i].sigma;
  noise.depth_cue = cue_of(i);
  noise.depth_sigma = options.depth_sigma;
  const Weighting weighting = has_covariances ? with_covariances(options.weighting) : options.weighting;
  if (weighting != Weighting::measurement_and_map) return noise;
  noise.map_sigma = options.map_sigma;
  noise.covariance = matches[i].covariance;
  return noise;
}

// A match whose covariance is unknown has map_sigma^2 I in a frame where others have one.
BlockOptions GoodFeatures::State::options_of_frame(BlockOptions options) noexcept {
  for (std::size_t i = 0; i < size && has_covariances; ++i) {
    for (std::size_t e = 0; e < 9 && matches[i].covariance == nullptr; ++e) {
      covariances[9 * i + e] = e % 4 == 0 ? options.map_sigma * options.map_sigma : 0;
    }
  }
  if (has_covariances) options.weighting = with_covariances(options.weighting);
  options.depth_cue = depth_cue;
  return options;
}

void GoodFeatures::State::forget_alignment() noexcept {
  aligner.forget(T_bw, Error::none);
  std::copy_n(is_usable.begin(), size, is_inlier.begin());
}

// Nothing is rejected in a frame with an error.
void GoodFeatures::State::align(BlockOptions& options, const double* of_pose) noexcept {
  forget_alignment();
  Error error = are_mixed ? Error::mixed_depth_cues : check(cameras, camera_count, options, T_bw);
  Prior of_start;
  if (error == Error::none && of_pose != nullptr && !(of_start.read(of_pose) && of_start.is_semidefinite()))
    error = Error::invalid_prior;
  if (error != Error::none) return aligner.forget(T_bw, error);
  FrameToAlign frame;
  frame.cameras = cameras;
  frame.camera_count = camera_count;
  frame.T_bw = T_bw;
  frame.matches = matches.data();
  frame.size = size;
  frame.is_aligned = is_aligned.data();
  frame.has_third = has_depth_cue.data();
  frame.covariances = has_covariances ? covariances.data() : nullptr;
  frame.options = options;
  frame.prior = of_pose != nullptr ? of_start.entries : nullptr;
  aligner.align(frame, is_inlier.data());
  if (aligner.leaves_out_third()) options.depth_cue = DepthCue::none;
}

// Candidate i is match i.
Error GoodFeatures::State::make_blocks(const BlockOptions& options) noexcept {
  blocks.clear();
  report = BlockReport();
  if (are_mixed) return report.error = Error::mixed_depth_cues;
  Matches arrays;
  arrays.size = size;
  if (size > 0) arrays.points = Points(matches[0].point, sizeof(FeatureMatch));
  arrays.sigmas = sigmas.data();
  arrays.has_depth_cue = has_depth_cue.data();
  if (std::count(is_inlier.data(), is_inlier.data() + size, 0) > 0) arrays.usable = is_inlier.data();
  if (camera_count > 1) arrays.camera_ids = camera_ids.data();
  if (has_covariances) arrays.map_covariances = covariances.data();
  report = append_blocks(cameras, camera_count, aligner.pose(), arrays, options, blocks);
  return report.error;
}

bool GoodFeatures::State::is_sizeable(std::size_t count) const noexcept {
  const auto usable = std::count(is_usable.begin(), is_usable.begin() + static_cast<std::ptrdiff_t>(size), 1);
  return count >= sizeable_count && static_cast<double>(count) >= sizeable_share * static_cast<double>(usable);
}

// Of what was rejected without an error the report says why there is none, as of candidates.
void GoodFeatures::State::explain_rejected() noexcept {
  aligner.for_each_without_error([this](std::size_t i) {
    double e[3];
    const bool has_image = residual_of(i, aligner.pose(), e);
    if (has_image && !has_covariances) return;  // the error is beyond all numbers
    --report.unusable;
    ++(has_image ? report.invalid_covariances : report.behind_camera);
  });
}

// What is missing of a sizeable share of the usable matches, by its most frequent cause.
Warning GoodFeatures::State::warning() const noexcept {
  const Alignment& found = aligner.found();
  if (found.warning != Warning::none) return found.warning;
  const std::size_t missing = report.invalid - report.unusable;
  const bool has_failed =
      found.status != AlignmentStatus::none && !found.is_aligned() && found.measured >= Aligner::fewest_matches;
  if (!is_sizeable(missing)) return has_failed ? Warning::not_aligned : Warning::none;
  const std::size_t counted =
      report.behind_camera + report.too_near + report.singular_rays + report.invalid_covariances;
  const std::pair<std::size_t, Warning> causes[] = {{report.behind_camera, Warning::behind_camera},
                                                    {report.too_near, Warning::too_near},
                                                    {report.singular_rays, Warning::singular_rays},
                                                    {report.invalid_covariances, Warning::invalid_covariances},
                                                    {missing - counted, Warning::unbounded_blocks}};
  return std::max_element(std::begin(causes), std::end(causes),
                          [](const auto& a, const auto& b) { return a.first < b.first; })
      ->second;
}

// The answer

void GoodFeatures::State::clear_answer() noexcept {
  for (std::size_t j = 0; j < summary.size; ++j) is_selected[indices[j]] = 0;
  summary = empty_selection(Error::none);
  summary.status = Status::all_selected;
  has_prior = false;
  judged = 0;
}

// Whatever is taken already is ignored: no match can fill the arrays twice.
void GoodFeatures::State::take(std::size_t i, double gain) noexcept {
  if (is_selected[i] != 0) return;
  indices[summary.size] = static_cast<std::uint32_t>(i);
  gains[summary.size++] = gain;
  is_selected[i] = 1;
}

// What the matches require, and where they are, becomes `options` for the candidates. Required matches count towards
// the budget, with a block or without one, which is taken here.
Error GoodFeatures::State::settle(const Options& asked, double cells_per_match, Options& options) noexcept {
  if (!(cells_per_match >= 0) || cells_per_match == infinity) return Error::invalid_groups;
  if (asked.required != nullptr) return Error::misplaced_required;
  const unsigned char* const has_block = planes_of(blocks).validity();
  std::size_t required = 0, with_block = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const bool is_needed = matches[i].is_required && is_usable[i] != 0;
    is_required[i] = is_needed && has_block[i] != 0 ? 1 : 0;
    with_block += is_required[i];
    required += is_needed ? 1 : 0;
  }
  if (required > asked.budget) return Error::infeasible;
  for (std::size_t i = 0; i < size && with_block < required; ++i) {
    if (matches[i].is_required && is_usable[i] != 0 && has_block[i] == 0) take(i, not_a_number);
  }
  options.budget = asked.budget - summary.size;
  if (with_block > 0) options.required = is_required.data();
  if (cells_per_match > 0 && asked.groups.ids == nullptr && size > 0)
    spread_over_image(cells_per_match * static_cast<double>(asked.budget), options);
  return Error::none;
}

// Required matches may be neighbours; the others share the cells.
void GoodFeatures::State::spread_over_image(double cell_count, Options& options) noexcept {
  const unsigned char* const has_block = planes_of(blocks).validity();
  for (std::size_t i = 0; i < size; ++i) {
    is_spread[i] = has_block[i] != 0 && is_measured(matches[i]) && is_required[i] == 0 ? 1 : 0;
  }
  const double wanted = std::fmax(std::round(cell_count), 1);
  const auto count = static_cast<std::size_t>(std::fmin(wanted, static_cast<double>(size)));
  cells.assign(matches[0].measured, sizeof(FeatureMatch) / sizeof(double), size, count, is_spread.data(),
               camera_count > 1 ? camera_ids.data() : nullptr);
  cells.limit(options);
}

void GoodFeatures::State::select_candidates(const Options& options) noexcept {
  const Selection selection = selector.select(blocks, options);
  if (!selection.has_answer()) return select_usable(selection.error);
  const std::size_t before = summary.size;
  for (std::size_t j = 0; j < selection.size; ++j) take(selection.indices[j], selection.gains[j]);
  summary = selection;
  summary.size += before;
  summary.searched += before;
}

// Inliers without a block fill what the candidates have left of the budget, but no group, nor beyond a target.
void GoodFeatures::State::fill_up(const Options& asked, double cells_per_match) noexcept {
  const Status status = summary.status;
  if (status == Status::error || status == Status::target_reached) return;
  const bool has_groups = asked.groups.ids != nullptr || (cells_per_match > 0 && cells_per_match < 1);
  const std::size_t candidates = summary.size;
  for (std::size_t i = 0; i < size && summary.size < asked.budget && !has_groups; ++i) {
    if (is_inlier[i] != 0) take(i, not_a_number);
  }
  if (status == Status::deadline_reached) return;
  bool are_all_in = true;
  for (std::size_t i = 0; i < size; ++i) are_all_in = are_all_in && (is_inlier[i] == 0 || is_selected[i] != 0);
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
void GoodFeatures::State::select_usable(Error why) noexcept {
  clear_answer();
  for (std::size_t i = 0; i < size; ++i) {
    if (is_inlier[i] != 0 || (is_usable[i] != 0 && matches[i].is_required)) take(i, not_a_number);
  }
  summary.status = Status::error;
  summary.error = why;
}

// How the matches fit the optimised pose

// z - h(T_bw, p_w); false where the point has no image.
bool GoodFeatures::State::residual_of(std::size_t i, const RigidTransform& pose, double (&e)[3]) const noexcept {
  const FeatureMatch& match = matches[i];
  if (match.camera_id >= camera_count) return false;
  const Camera& camera = cameras[match.camera_id];
  const PinholeCamera& pinhole = camera.pinhole;
  double p_b[3], p_c[3], uv[2];
  pose.transform(match.point, p_b);
  camera.T_cb.transform(p_b, p_c);
  if (!project(camera, p_c, uv)) return false;
  for (int d = 0; d < 2; ++d) e[d] = match.measured[d] - uv[d];
  switch (cue_of(i)) {
    case DepthCue::none: e[2] = 0; break;
    case DepthCue::stereo: e[2] = match.u_right - (uv[0] - pinhole.bf / p_c[2] + pinhole.shift_of_right); break;
    case DepthCue::depth: e[2] = match.depth - p_c[2]; break;
  }
  return true;
}

// Residuals are divided by their deviations before they are squared, which may underflow.
double GoodFeatures::State::chi2_of(std::size_t i, const RigidTransform& pose, const BlockOptions& options,
                                    bool is_whitened) const noexcept {
  if (is_usable[i] == 0) return infinity;
  if (!is_measured(matches[i])) return not_a_number;
  double e[3];
  if (!residual_of(i, pose, e)) return infinity;
  const MatchNoise noise = noise_of(i, options);
  const std::size_t rows = residual_rows(noise.depth_cue);
  double W[9];
  if (!is_whitened || !match_whitening(cameras[matches[i].camera_id], aligner.pose(), matches[i].point, noise, W)) {
    const double of_cue = noise.depth_cue == DepthCue::depth ? noise.depth_sigma : noise.sigma;
    const double whitened[3] = {e[0] / noise.sigma, e[1] / noise.sigma, e[2] / of_cue};
    return whitened[0] * whitened[0] + whitened[1] * whitened[1] + whitened[2] * whitened[2];
  }
  double sum = 0;
  for (std::size_t a = 0; a < rows; ++a) {
    double whitened = 0;
    for (std::size_t b = 0; b <= a; ++b) whitened += W[rows * a + b] * e[b];
    sum += whitened * whitened;
  }
  return sum;
}

// Reads the frame as select() has left it, and hands it to the recorder.
void GoodFeatures::State::record(double depth_sigma) noexcept {
  is_record_due = false;
  if (added > size) return recorder.skip("it has more matches than the capacity");
  if (report.error != Error::none) return recorder.skip(explain(report.error));
  FrameDetails details;
  details.depth_cue = depth_cue;
  details.depth_sigma = depth_sigma;
  details.has_covariances = has_covariances;
  for (std::size_t i = 0; i < size; ++i) details.has_keyframes |= matches[i].keyframe >= 0;
  recorder.start(cameras, camera_count, T_bw, details);
  for (std::size_t i = 0; i < size; ++i) {
    if (is_usable[i] != 0) recorder.add(matches[i], is_selected[i] != 0);
  }
  recorder.finish();
}

// The class

GoodFeatures::GoodFeatures(std::size_t capacity, Executor* executor) : state_(new State(capacity, executor)) {}
void GoodFeatures::Destroy::operator()(State* state) const noexcept { delete state; }

void GoodFeatures::start(const Camera& camera, const RigidTransform& T_cw) noexcept {
  state_->alone = camera;
  state_->start(&state_->alone, 1, T_cw);
}
void GoodFeatures::start(const Camera* cameras, std::size_t count, const RigidTransform& T_bw) noexcept {
  state_->start(cameras, count, T_bw);
}
void GoodFeatures::add(const FeatureMatch& match) noexcept { state_->add(match); }
std::size_t GoodFeatures::size() const noexcept { return state_->added; }
std::uint32_t GoodFeatures::id(std::size_t i) const noexcept {
  return i < state_->size ? state_->matches[i].id : no_id;
}

Selection GoodFeatures::select(const Options& options) noexcept {
  const Deadline time(options.time_limit);
  State& s = *state_;
  s.clear_answer();
  s.has_prior = options.prior != nullptr;
  if (s.has_prior) std::copy_n(options.prior, state_dimension * state_dimension, s.prior);
  Options settled = options;
  BlockOptions of_frame = s.options_of_frame(block_options);
  rejects_outliers ? s.align(of_frame, options.prior) : s.forget_alignment();
  Error error = s.make_blocks(of_frame);
  if (error == Error::none) error = s.settle(options, spread, settled);
  settled.time_limit = time.left();
  error == Error::none ? s.select_candidates(settled) : s.select_usable(error);
  s.fill_up(options, spread);
  s.explain_rejected();
  s.summary.warning = s.summary.status == Status::error ? Warning::none : s.warning();
  if (s.is_record_due) s.record(block_options.depth_sigma);
  return selection();
}

Alignment GoodFeatures::align(const double* prior) noexcept {
  BlockOptions of_frame = state_->options_of_frame(block_options);
  state_->align(of_frame, prior);
  return alignment();
}
Alignment GoodFeatures::alignment() const noexcept { return state_->aligner.found(); }
const RigidTransform& GoodFeatures::pose() const noexcept { return state_->aligner.pose(); }
const double* GoodFeatures::pose_information() const noexcept { return state_->aligner.information(); }
bool GoodFeatures::is_inlier(std::size_t i) const noexcept { return i < state_->size && state_->is_inlier[i] != 0; }

Selection GoodFeatures::selection() const noexcept {
  Selection selection = state_->summary;
  selection.indices = state_->indices.data();
  selection.gains = state_->gains.data();
  return selection;
}
const char* GoodFeatures::reason() const noexcept {
  const bool are_all_kept = state_->added == state_->size;
  return are_all_kept || !selection().has_answer() ? selection().reason() : to_string(Error::capacity_exceeded);
}
const BlockReport& GoodFeatures::block_report() const noexcept { return state_->report; }
const BlockStore& GoodFeatures::blocks() const noexcept { return state_->blocks; }
bool GoodFeatures::is_selected(std::size_t i) const noexcept { return i < state_->size && state_->is_selected[i] != 0; }

IndexRange GoodFeatures::outliers(const RigidTransform& T_cw) noexcept {
  State& s = *state_;
  s.outliers.clear();
  s.judged = is_rigid(T_cw) ? s.size : 0;
  for (std::size_t i = 0; i < s.judged; ++i) {
    s.chi2[i] = s.is_selected[i] != 0 ? not_a_number : s.chi2_of(i, T_cw, block_options, is_weighted);
    if (is_outlier(i)) s.outliers.push_back(static_cast<std::uint32_t>(i));
  }
  return {s.outliers.data(), s.outliers.size()};
}
double GoodFeatures::chi2(std::size_t i) const noexcept { return i < state_->judged ? state_->chi2[i] : not_a_number; }
bool GoodFeatures::is_outlier(std::size_t i) const noexcept {
  if (i >= state_->judged) return false;
  return chi2(i) > (state_->cue_of(i) == DepthCue::none ? quantile_of_two : quantile_of_three);
}

bool GoodFeatures::record(const char* folder) noexcept { return state_->recorder.open(folder); }

// The selected ones alone, as required ones, against the target of all.
double efficiency(GoodFeatures& good) noexcept {
  GoodFeatures::State& s = *good.state_;
  if (s.summary.status == Status::error || s.blocks.stored() == 0) return not_a_number;
  Options options(0);
  for (std::size_t i = 0; i < s.size; ++i) {
    s.is_required[i] = s.is_selected[i] != 0 && s.blocks.is_valid(i) ? 1 : 0;
    options.budget += s.is_required[i];
  }
  options.required = s.is_required.data();
  options.target.efficiency = 1;
  if (s.has_prior) options.prior = s.prior;
  return std::min(s.selector.select(s.blocks, options).efficiency, 1.0);
}

bool match_information(const GoodFeatures& good, std::size_t i, double* omega) noexcept {
  const GoodFeatures::State& s = *good.state_;
  return i < s.size && s.matches[i].camera_id < s.camera_count &&
         match_information(s.cameras[s.matches[i].camera_id], s.aligner.pose(), s.matches[i].point,
                           s.noise_of(i, good.block_options), omega);
}
bool match_whitening(const GoodFeatures& good, std::size_t i, double* W) noexcept {
  const GoodFeatures::State& s = *good.state_;
  return i < s.size && s.matches[i].camera_id < s.camera_count &&
         match_whitening(s.cameras[s.matches[i].camera_id], s.aligner.pose(), s.matches[i].point,
                         s.noise_of(i, good.block_options), W);
}

}  // namespace maxlogdet
