// SPDX-License-Identifier: MIT
#include <maxlogdet/good_features.hpp>

#include "kernel/base/limits.hpp"

#include <maxlogdet/frame_recorder.hpp>
#include <maxlogdet/image_cells.hpp>
#include <maxlogdet/match_information.hpp>
#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <vector>

namespace maxlogdet {
namespace {

constexpr double quantile_of_two = 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
constexpr double quantile_of_three = 7.815;

// e^T Omega e.
double square_of(const double* e, const double* omega, std::size_t count) noexcept {
  double sum = 0;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b) sum += e[a] * omega[count * a + b] * e[b];
  }
  return sum;
}

}  // namespace

struct GoodFeatures::State {
  State(std::size_t capacity, Executor* helpers)
      : store(capacity), selector(capacity, helpers), cells(capacity), executor(helpers), max_kept(capacity) {
    ids.reserve(capacity);
    points.reserve(3 * capacity);
    measured.reserve(3 * capacity);
    sigmas.reserve(capacity);
    covariances.reserve(9 * capacity);
    jacobians.reserve(6 * capacity);
    chi2.reserve(capacity);
    for (auto* array : bytes()) array->reserve(capacity);
  }

  std::array<std::vector<unsigned char>*, 7> bytes() noexcept {
    return {{&camera_ids, &has_third, &has_covariance, &is_required, &is_required_candidate, &is_selected, &is_spread}};
  }

  void start(const RigidTransform& pose, ThirdMeasurement measurement) noexcept {
    T = pose;
    third = measurement;
    for (auto* array : {&points, &measured, &sigmas, &covariances, &jacobians, &chi2}) array->clear();
    for (auto* array : bytes()) array->clear();
    ids.clear();
    point_ids.clear();
    keyframes.clear();
    is_recorded = recorder.is_open();
    store.clear();
    has_covariances = has_jacobians = false;
    added = 0;
    status = Status::all_selected;
    is_target_reached = false;
    report = BlockReport();
  }

  void add(const FeatureMatch& match) noexcept {
    ++added;
    if (ids.size() == max_kept) return;
    ids.push_back(match.id);
    points.insert(points.end(), match.point, match.point + 3);
    measured.insert(measured.end(), match.measured, match.measured + 2);
    measured.push_back(match.third);
    sigmas.push_back(match.sigma);
    camera_ids.push_back(match.camera_id);
    has_third.push_back(third != ThirdMeasurement::none && !std::isnan(match.third) ? 1 : 0);
    has_covariance.push_back(match.covariance != nullptr ? 1 : 0);
    is_required.push_back(match.is_required ? 1 : 0);
    is_required_candidate.push_back(0);
    is_selected.push_back(1);
    is_spread.push_back(1);
    chi2.push_back(not_a_number);
    if (is_recorded) {
      point_ids.push_back(match.point_id);
      keyframes.push_back(match.keyframe);
    }
    append(match.covariance, 9, covariances, has_covariances);
    append(match.jacobian, 6, jacobians, has_jacobians);
  }

  // Appends an array that only some matches have; nothing is written before the first of them.
  void append(const double* entries, std::size_t count, std::vector<double>& all, bool& is_any) const noexcept {
    if (entries == nullptr && !is_any) return;
    if (!is_any) all.assign(count * (ids.size() - 1), not_a_number);
    is_any = true;
    if (entries == nullptr) {
      all.insert(all.end(), count, not_a_number);
    } else {
      all.insert(all.end(), entries, entries + count);
    }
  }

  void select_all(Status why) noexcept {
    status = why;
    std::fill(is_selected.begin(), is_selected.end(), static_cast<unsigned char>(1));
  }

  bool build(BlockOptions options) noexcept;
  Status select(Options options, double cells_per_match) noexcept;
  void spread_over_image(double cells_per_match, Options& options) noexcept;
  bool start_recording(const char* folder) noexcept;
  void record(const BlockOptions& options) noexcept;
  void judge(const RigidTransform& pose, const BlockOptions* options) noexcept;
  bool residual_of(const RigidTransform& T_cw, std::size_t i, double (&e)[3]) const noexcept;
  double chi2_of(const RigidTransform& T_cw, std::size_t i, const BlockOptions* options) const noexcept;
  const RigCamera& seen_by(std::size_t i) const noexcept { return has_rig ? rig.cameras[camera_ids[i]] : only; }
  bool has_camera(std::size_t i) const noexcept { return is_kept(i) && (!has_rig || camera_ids[i] < rig.size); }
  MatchNoise noise_of(std::size_t i, const BlockOptions& options) const noexcept;
  bool is_overfull() const noexcept { return added > ids.size(); }
  bool is_kept(std::size_t i) const noexcept { return i < ids.size(); }

  BlockStore store;
  Selector selector;
  ImageCells cells;
  Executor* executor;
  std::size_t max_kept;
  RigCamera only;  // the single camera, as its own body
  Rig rig;         // instead of it, if has_rig
  bool has_rig = false;
  RigidTransform T = RigidTransform::identity();
  ThirdMeasurement third = ThirdMeasurement::none;
  double depth_sigma = 1;
  std::vector<std::uint32_t> ids;
  std::vector<double> points, measured, sigmas, covariances, jacobians, chi2;
  FrameRecorder recorder;
  std::vector<std::int64_t> point_ids, keyframes;  // only if is_recorded
  std::vector<unsigned char> camera_ids, has_third, has_covariance, is_required, is_required_candidate, is_selected;
  std::vector<unsigned char> is_spread;
  bool has_covariances = false, has_jacobians = false, is_recorded = false;
  std::size_t added = 0;  // including those beyond the capacity, which are not kept
  BlockReport report;
  Status status = Status::all_selected;
  double log_det = not_a_number;
  bool is_target_reached = false;
  bool has_prior = false;
  double prior[state_dimension * state_dimension] = {};
};

bool GoodFeatures::State::build(BlockOptions options) noexcept {
  Matches matches;
  matches.size = ids.size();
  matches.points = points.data();
  matches.sigmas = sigmas.data();
  matches.has_third = has_third.data();
  if (has_jacobians) matches.jacobians = jacobians.data();
  if (has_rig) matches.camera_ids = camera_ids.data();
  if (has_covariances) {
    for (std::size_t i = 0; i < ids.size(); ++i) {
      for (std::size_t e = 0; e < 9 && has_covariance[i] == 0; ++e) {
        covariances[9 * i + e] = e % 4 == 0 ? options.map_sigma * options.map_sigma : 0;
      }
    }
    matches.map_covariances = covariances.data();
    options.weighting = with_covariances(options.weighting);
  }
  options.third = third;
  depth_sigma = options.depth_sigma;
  store.clear();
  report = has_rig ? append_blocks(rig, T, matches, options, store, executor)
                   : append_blocks(only.camera, T, matches, options, store, executor);
  return report.is_done();
}

// Required matches count towards the budget, but may be neighbours; the others share the cells.
void GoodFeatures::State::spread_over_image(double cells_per_match, Options& options) noexcept {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool is_excluded = options.excluded != nullptr && options.excluded[i] != 0;
    is_spread[i] = store.is_valid(i) && is_required_candidate[i] == 0 && !is_excluded ? 1 : 0;
  }
  const double wanted = std::fmax(cells_per_match, 1) * static_cast<double>(options.budget);
  const auto count = static_cast<std::size_t>(std::fmin(std::round(wanted), static_cast<double>(ids.size())));
  cells.assign(measured.data(), 3, ids.size(), count, is_spread.data(), has_rig ? camera_ids.data() : nullptr);
  cells.limit(options);
}

Status GoodFeatures::State::select(Options options, double cells_per_match) noexcept {
  log_det = not_a_number;
  if (!(cells_per_match >= 0) || cells_per_match == infinity) return Status::invalid_groups;
  bool is_any_required = false;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool is_required_match = is_required[i] != 0 || (options.required != nullptr && options.required[i] != 0);
    is_selected[i] = is_required_match ? 1 : 0;  // also without a block, in which case it is no candidate
    is_required_candidate[i] = is_required_match && store.is_valid(i) ? 1 : 0;
    is_any_required = is_any_required || is_required_match;
  }
  options.required = is_any_required ? is_required_candidate.data() : nullptr;
  has_prior = options.prior != nullptr;
  if (has_prior) std::copy_n(options.prior, state_dimension * state_dimension, prior);
  if (cells_per_match > 0 && options.groups == nullptr) spread_over_image(cells_per_match, options);
  const Selection selection = selector.select(store, options);
  const bool are_all_allowed =
      selection.status == Status::all_selected && (options.groups != nullptr || options.excluded != nullptr);
  is_target_reached = selection.status == Status::target_reached;
  const bool is_free = options.groups == nullptr && options.excluded == nullptr;
  if (is_target_reached && is_free && selection.size == store.stored())
    return Status::all_selected;  // as without a target
  if (selection.status != Status::ok && !is_target_reached && !are_all_allowed) return selection.status;
  for (const std::uint32_t i : selection) is_selected[i] = 1;
  log_det = selection.log_det;
  const bool are_all = std::find(is_selected.begin(), is_selected.end(), 0) == is_selected.end();
  return are_all ? Status::all_selected : Status::ok;
}

bool GoodFeatures::State::start_recording(const char* folder) noexcept try {
  point_ids.reserve(max_kept);
  keyframes.reserve(max_kept);
  return recorder.open(folder);
} catch (const std::bad_alloc&) {
  return recorder.open(nullptr);
}

// The frame, as select() has left it.
void GoodFeatures::State::record(const BlockOptions& options) noexcept {
  if (is_overfull() || !report.is_done()) return;
  FrameDetails details;
  details.third = third;
  details.depth_sigma = options.depth_sigma;
  details.has_covariances = has_covariances;
  details.has_keyframes =
      std::any_of(keyframes.begin(), keyframes.end(), [](std::int64_t keyframe) { return keyframe >= 0; });
  has_rig ? recorder.start(rig, T, details) : recorder.start(only.camera, T, details);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    FeatureMatch match;
    match.id = ids[i];
    match.point_id = point_ids[i];
    match.keyframe = keyframes[i];
    std::copy_n(&points[3 * i], 3, match.point);
    std::copy_n(&measured[3 * i], 2, match.measured);
    if (has_third[i] != 0) match.third = measured[3 * i + 2];
    match.sigma = sigmas[i];
    match.camera_id = camera_ids[i];
    if (has_covariance[i] != 0) match.covariance = &covariances[9 * i];
    if (has_jacobians) match.jacobian = &jacobians[6 * i];
    recorder.add(match, is_selected[i] != 0);
  }
  recorder.finish();
}

// z - h(T_cw, p_w), on a rig with T_bw for T_cw; false where the point has no image.
bool GoodFeatures::State::residual_of(const RigidTransform& T_cw, std::size_t i, double (&e)[3]) const noexcept {
  double p_b[3], p_c[3], uv[2];
  T_cw.transform(&points[3 * i], p_b);
  const RigCamera& camera = seen_by(i);
  camera.T_cb.transform(p_b, p_c);
  if (!project(camera.camera, p_c, uv)) return false;
  const double* const z = &measured[3 * i];
  e[0] = z[0] - uv[0];
  e[1] = z[1] - uv[1];
  const bool is_depth = third == ThirdMeasurement::depth;
  e[2] = has_third[i] == 0 ? 0 : z[2] - (is_depth ? p_c[2] : uv[0] - camera.camera.pinhole.bf / p_c[2]);
  return true;
}

// Squared error of match i in standard deviations; `options`: nullptr for those of the measurement only.
double GoodFeatures::State::chi2_of(const RigidTransform& T_cw, std::size_t i,
                                    const BlockOptions* options) const noexcept {
  if (has_jacobians) return not_a_number;
  double e[3], omega[9];
  if (!residual_of(T_cw, i, e)) return infinity;
  if (options != nullptr && match_information(seen_by(i), T, &points[3 * i], noise_of(i, *options), omega)) {
    return square_of(e, omega, has_third[i] != 0 ? 3 : 2);
  }
  const double of_third = e[2] / (third == ThirdMeasurement::depth ? depth_sigma : sigmas[i]);
  return (e[0] * e[0] + e[1] * e[1]) / (sigmas[i] * sigmas[i]) + of_third * of_third;
}

// The noise that the block of match i is whitened by.
MatchNoise GoodFeatures::State::noise_of(std::size_t i, const BlockOptions& options) const noexcept {
  MatchNoise noise;
  noise.sigma = sigmas[i];
  noise.depth_sigma = options.depth_sigma;
  if (has_third[i] != 0) noise.third = third;
  if (has_jacobians) noise.jacobian = &jacobians[6 * i];
  const Weighting weighting = has_covariances ? with_covariances(options.weighting) : options.weighting;
  if (weighting != Weighting::measurement_and_map) return noise;
  noise.map_sigma = options.map_sigma;
  if (has_covariance[i] != 0) noise.covariance = &covariances[9 * i];
  return noise;
}

void GoodFeatures::State::judge(const RigidTransform& pose, const BlockOptions* options) noexcept {
  for (std::size_t i = 0; i < ids.size(); ++i) chi2[i] = is_selected[i] != 0 ? not_a_number : chi2_of(pose, i, options);
}

GoodFeatures::GoodFeatures(std::size_t capacity, Executor* executor) : state_(new State(capacity, executor)) {}
GoodFeatures::~GoodFeatures() = default;
GoodFeatures::GoodFeatures(GoodFeatures&&) noexcept = default;
GoodFeatures& GoodFeatures::operator=(GoodFeatures&&) noexcept = default;

void GoodFeatures::start(const Camera& camera, const RigidTransform& T_cw, ThirdMeasurement third) noexcept {
  state_->only.camera = camera;
  state_->has_rig = false;
  state_->start(T_cw, third);
}

void GoodFeatures::start(const Rig& rig, const RigidTransform& T_bw, ThirdMeasurement third) noexcept {
  state_->rig = rig;
  state_->has_rig = true;
  state_->start(T_bw, third);
}

void GoodFeatures::add(const FeatureMatch& match) noexcept { state_->add(match); }
std::size_t GoodFeatures::size() const noexcept { return state_->added; }
// Weak: a C++17 translation unit that takes its address has a definition of its own.
[[gnu::weak]] constexpr std::uint32_t GoodFeatures::no_id;

std::uint32_t GoodFeatures::id(std::size_t i) const noexcept { return state_->is_kept(i) ? state_->ids[i] : no_id; }

bool GoodFeatures::build() noexcept { return !state_->is_overfull() && state_->build(block_options); }

Status GoodFeatures::select(const Options& options) noexcept {
  State& s = *state_;
  s.is_target_reached = false;
  Status status = s.is_overfull() ? Status::capacity_exceeded : Status::invalid_block;
  if (build()) status = s.select(options, spread);
  s.status = status;
  if (status != Status::ok) s.select_all(status);
  if (s.is_recorded) s.record(block_options);
  return status;
}

Status GoodFeatures::status() const noexcept { return state_->status; }
const char* GoodFeatures::reason() const noexcept {
  return state_->status == Status::invalid_block ? to_string(state_->report.status) : to_string(state_->status);
}
bool GoodFeatures::is_target_reached() const noexcept { return state_->is_target_reached; }
const BlockReport& GoodFeatures::block_report() const noexcept { return state_->report; }
bool GoodFeatures::is_selected(std::size_t i) const noexcept {
  return !state_->is_kept(i) || state_->is_selected[i] != 0;
}
std::size_t GoodFeatures::selected_count() const noexcept {
  const std::vector<unsigned char>& is_selected = state_->is_selected;
  const auto left_out = std::count(is_selected.begin(), is_selected.end(), 0);
  return state_->added - static_cast<std::size_t>(left_out);
}

bool GoodFeatures::information(std::size_t i, double* omega) const noexcept {
  const State& s = *state_;
  return s.has_camera(i) && match_information(s.seen_by(i), s.T, &s.points[3 * i], s.noise_of(i, block_options), omega);
}
bool GoodFeatures::whitening(std::size_t i, double* W) const noexcept {
  const State& s = *state_;
  return s.has_camera(i) && match_whitening(s.seen_by(i), s.T, &s.points[3 * i], s.noise_of(i, block_options), W);
}

void GoodFeatures::judge(const RigidTransform& T_cw) noexcept {
  state_->judge(T_cw, is_weighted ? &block_options : nullptr);
}
double GoodFeatures::chi2(std::size_t i) const noexcept { return state_->is_kept(i) ? state_->chi2[i] : not_a_number; }
bool GoodFeatures::is_outlier(std::size_t i) const noexcept {
  return chi2(i) > (state_->is_kept(i) && state_->has_third[i] != 0 ? quantile_of_three : quantile_of_two);
}

double GoodFeatures::share_of_all() noexcept {
  State& s = *state_;
  if (s.status == Status::all_selected) return 1;
  if (s.status != Status::ok) return not_a_number;
  Options all;
  all.budget = s.selector.capacity();
  if (s.has_prior) all.prior = s.prior;
  all.strategy = Strategy::backward_greedy;  // starts from all of them and removes none
  const Selection selection = s.selector.select(s.store, all);
  return std::min(std::exp((s.log_det - selection.log_det) / state_dimension), 1.0);
}

const BlockStore& GoodFeatures::blocks() const noexcept { return state_->store; }

bool GoodFeatures::record(const char* folder) noexcept { return state_->start_recording(folder); }

}  // namespace maxlogdet
