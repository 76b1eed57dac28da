// SPDX-License-Identifier: MIT
#include "kernel/alignment/aligner.hpp"

#include "kernel/base/memory.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

namespace planes = simd::plane;
using simd::alignment_lanes;
using simd::RobustWeight;

// Lengths of steps, in standard deviations of the pose, below which it has settled with Huber's and with Tukey's
// weights, and has converged with the inliers.
constexpr double is_settled_by_huber = 3;
constexpr double is_settled_by_tukey = 2;
constexpr double is_converged = 1e-3;
constexpr int most_steps = 10;
// The robust scale as an angle, rad: below the first it is the rounding of pixels in float32, above the second no
// tracker's noise.
constexpr double finest_scale = 1e-6;
constexpr double coarsest_scale = 1.0 / 32;
// Of the distance of the points, over that at the predicted pose: where pixels are in another unit than the camera, the
// pose that fits best is far away, and the points are next to each other.
constexpr double most_growth = 4;
// Of |W J|^2 over its median: ten times as near as half of the matches.
constexpr double most_leverage = 100;
// At a good prediction the scale is smaller than at the aligned pose by chance, but not by so much.
constexpr double tolerated_growth = 1.25;

// Third rows are off if they are so by half a deviation; 31 % of normal ones are by chance, on either side.
constexpr double limit_of_third = 0.5;
constexpr double most_on_one_side = 0.45;
constexpr double most_off = 0.75;
constexpr double gate_of_third = 2.576;  // 1 % of normal ones

constexpr std::size_t error_lanes = 16;  // medians read whole packs of float32

constexpr std::size_t most_parts(std::size_t capacity) { return capacity < max_cameras ? capacity : max_cameras; }
constexpr std::size_t most_lanes(std::size_t capacity) {
  return capacity + (alignment_lanes - 1) * most_parts(capacity) + alignment_lanes;
}
// Adds sums over matches, times `factor`, to the normal equations; H is symmetric, and gets its lower triangle.
void add(const simd::NormalSums& sums, double factor, double (&H)[6][6], double (&b)[6]) noexcept {
  for (int i = 0, upper = 0; i < 3; ++i) {
    b[i] += factor * sums.g[i];
    b[3 + i] += factor * sums.moment[i];
    for (int j = 0; j < 3; ++j) H[3 + j][i] += factor * sums.cross[3 * i + j];
    for (int j = i; j < 3; ++j, ++upper) {
      H[j][i] += factor * sums.G[upper];
      H[3 + j][3 + i] += factor * sums.turned[upper];
    }
  }
}

// Of `count`, by more than chance: twice the deviation of a share.
bool is_above(double share, std::size_t found, std::size_t count) noexcept {
  const auto all = static_cast<double>(count);
  return static_cast<double>(found) > share * all + std::sqrt(all);
}

constexpr std::size_t padded(std::size_t count, std::size_t to) { return (count + to - 1) / to * to; }

}  // namespace

Aligner::Aligner(std::size_t capacity)
    : kernel_(simd::active()),
      planes_(planes::count * most_lanes(checked_capacity(capacity))),
      errors_(most_lanes(capacity) + error_lanes),
      match_of_lane_(most_lanes(capacity)),
      fits_with_third_(capacity),
      parts_(most_parts(capacity)) {}

void Aligner::forget(const RigidTransform& T_bw, Error why) noexcept {
  found_ = Alignment();
  found_.error = why;
  pose_ = T_bw;
  std::fill_n(information_, 36, 0.0);
}

void Aligner::align(const MatchedFrame& frame, const double* prior, unsigned char* is_inlier) noexcept {
  align_once(frame, prior, is_inlier);
  if (!doubts_third()) return;
  const Alignment found = found_;
  const RigidTransform pose = pose_;
  const std::size_t finite = finite_;
  double information[36];
  std::copy_n(information_, 36, information);
  std::copy_n(is_inlier, frame.size, fits_with_third_.begin());

  MatchedFrame without = frame;
  without.depth_cue = DepthCue::none;
  align_once(without, nullptr, is_inlier);  // the prior may be what does not fit
  if (found_.is_aligned() && (!found.is_aligned() || third_misfits(frame))) {
    if (prior != nullptr) align_once(without, prior, is_inlier);
    const bool is_stereo = frame.depth_cue == DepthCue::stereo;
    found_.warning = is_stereo ? Warning::misfitting_right_columns : Warning::misfitting_depths;
    return;
  }
  found_ = found;
  pose_ = pose;
  finite_ = finite;
  std::copy_n(information, 36, information_);
  std::copy_n(fits_with_third_.begin(), frame.size, is_inlier);
}

void Aligner::align_once(const MatchedFrame& frame, const double* prior, unsigned char* is_inlier) noexcept {
  forget(frame.T_bw, kernel_ == nullptr ? Error::unsupported_isa : Error::none);
  if (kernel_ == nullptr) return;
  motion_.start(frame.T_bw);
  prior_ = prior;
  found_.measured = read(frame);
  found_.status = find_pose();
  const bool is_aligned = found_.is_aligned();
  if (is_aligned) {
    pose_ = RigidTransform::row_major(motion_.pose());
    found_.scale = std::sqrt(scale_squared_);
  } else {
    found_.inliers = 0;
    std::fill_n(information_, 36, 0.0);
  }
  const double* const fits = plane(planes::is_inlier);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    if (match_of_lane_[lane] != no_match) is_inlier[match_of_lane_[lane]] = is_aligned && fits[lane] == 0 ? 0 : 1;
  }
}

void Aligner::judge(const MatchedFrame& frame, double* chi2) noexcept {
  if (kernel_ == nullptr) return;
  motion_.start(frame.T_bw);
  read(frame);
  whiten();
  for (std::size_t p = 0; p < part_count_; ++p) kernel_->alignment.measure_errors(parts_[p]);
  const double* const errors = plane(planes::error);
  const double* const has_third = plane(planes::has_third);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    const double median = simd::robust_limits[has_third[lane] == 0 ? 0 : 1].median;
    if (match_of_lane_[lane] != no_match) chi2[match_of_lane_[lane]] = errors[lane] * median;
  }
}

// Sorts the matches by camera, and copies what is known of them to planes. Returns how many there are.
std::size_t Aligner::read(const MatchedFrame& frame) noexcept {
  const auto is_aligned = [&frame](std::size_t i) {
    return (frame.usable == nullptr || frame.usable[i] != 0) && is_measured(frame.matches[i]);
  };
  std::size_t next[max_cameras] = {};  // how many a camera sees, then where its next match goes
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (is_aligned(i)) ++next[frame.matches[i].camera_id];
  }
  by_map_ = frame.has_covariances;
  third_ = frame.depth_cue;
  lanes_ = part_count_ = 0;
  std::size_t measured = 0;
  for (std::size_t c = 0; c < frame.camera_count; ++c) {
    measured += next[c];
    const std::size_t begin = lanes_;
    lanes_ += padded(next[c], alignment_lanes);
    if (next[c] > 0) parts_[part_count_++] = part_of(frame, frame.cameras[c], begin);
    next[c] = begin;
  }
  stride_ = lanes_ | alignment_lanes;  // an odd number of cache lines
  for (std::size_t p = 0; p < part_count_; ++p) parts_[p].stride = stride_;
  std::fill_n(match_of_lane_.begin(), lanes_, no_match);
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (is_aligned(i)) read_match(frame, i, next[frame.matches[i].camera_id]++);
  }
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    if (match_of_lane_[lane] == no_match) clear_lane(lane);
  }
  std::fill_n(errors_ + lanes_, error_lanes, float_infinity);
  return measured;
}

simd::AlignmentInput Aligner::part_of(const MatchedFrame& frame, const Camera& camera, std::size_t begin) noexcept {
  return {camera_input(camera),
          motion_.pose(),
          third_,
          frame.options.depth_sigma,
          by_map_,
          planes_,
          0,
          errors_,
          begin,
          lanes_};
}

void Aligner::read_match(const MatchedFrame& frame, std::size_t i, std::size_t lane) noexcept {
  const FeatureMatch& match = frame.matches[i];
  match_of_lane_[lane] = static_cast<std::uint32_t>(i);
  for (std::size_t d = 0; d < 3; ++d) plane(planes::point + d)[lane] = match.point[d];
  for (std::size_t d = 0; d < 2; ++d) plane(planes::measured + d)[lane] = match.measured[d];
  plane(planes::sigma)[lane] = match.sigma;
  plane(planes::weight)[lane] = 1 / match.sigma;
  const PinholeCamera& pinhole = frame.cameras[match.camera_id].pinhole;
  plane(planes::measured + 2)[lane] = third_ == DepthCue::stereo ? match.u_right - pinhole.shift_of_right : match.depth;
  plane(planes::has_third)[lane] = third_ != DepthCue::none && measured_cue(match) != DepthCue::none ? 1 : 0;
  for (std::size_t e = 0; by_map_ && e < 6; ++e)
    plane(planes::map_covariance + e)[lane] = simd::map_covariance_of(match, frame.options.map_sigma, e);
}

// A lane without a match has no error.
void Aligner::clear_lane(std::size_t lane) noexcept {
  for (std::size_t v = 0; v < planes::given; ++v) plane(v)[lane] = 0;
  plane(planes::point)[lane] = not_a_number;
}

AlignmentStatus Aligner::find_pose() noexcept {
  if (found_.measured == 0) return AlignmentStatus::few_matches;
  measure_radian();
  whiten();
  limit_leverage();
  measure_errors();
  if (finite_ < fewest_matches) return AlignmentStatus::few_matches;
  const double scale_at_start = scale_squared_;
  const std::size_t finite_at_start = finite_;
  const auto failed = [this] {  // at the predicted pose, or later
    return found_.iterations == 0 ? AlignmentStatus::singular : AlignmentStatus::not_converged;
  };
  if (!settle(RobustWeight::huber, is_settled_by_huber)) return failed();
  if (!settle(RobustWeight::tukey, is_settled_by_tukey)) return failed();
  if (by_map_) {  // the noise of the map at the pose found
    whiten();
    measure_errors();
  }
  find_inliers();
  if (2 * found_.inliers < std::max(finite_, finite_at_start) ||
      scale_squared_ > coarsest_scale * coarsest_scale * radian_squared_ || is_far_off())
    return AlignmentStatus::no_consensus;
  for (int i = 0; i < most_steps; ++i) {
    if (!step(RobustWeight::inliers)) return failed();
    if (length_ < is_converged) {
      const bool fits = scale_squared_ <= tolerated_growth * tolerated_growth * scale_at_start;
      return fits ? AlignmentStatus::aligned : AlignmentStatus::not_converged;
    }
  }
  return AlignmentStatus::not_converged;
}

// The squared whitened error that an angle of one radian makes, of a match of median sigma over focal length.
void Aligner::measure_radian() noexcept {
  const double* const sigmas = plane(planes::sigma);
  for (std::size_t p = 0; p < part_count_; ++p) {
    const double focal_length = parts_[p].camera.fx;
    for (std::size_t lane = parts_[p].begin; lane < parts_[p].end; ++lane) {
      const bool is_match = match_of_lane_[lane] != no_match;
      errors_[lane] = is_match ? static_cast<float>(sigmas[lane] / focal_length) : float_infinity;
    }
  }
  std::size_t finite;
  const double angle = median_error(finite);
  radian_squared_ = 1 / (angle * angle * simd::robust_limits[0].median);
}

// Mallows' weights, at the predicted pose.
void Aligner::limit_leverage() noexcept {
  for (std::size_t p = 0; p < part_count_; ++p) kernel_->alignment.measure_leverage(parts_[p]);
  std::size_t finite;
  const double median = median_error(finite);
  double* const leverage = plane(planes::leverage);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    const bool is_large = leverage[lane] > most_leverage * median;
    leverage[lane] = is_large ? most_leverage * median / leverage[lane] : 1;
  }
}

// Steps with one kind of weights until a step is short.
bool Aligner::settle(RobustWeight weight, double short_step) noexcept {
  length_ = infinity;
  for (int i = 0; i < most_steps && length_ >= short_step; ++i) {
    if (!step(weight)) return false;
    measure_errors();
  }
  return true;
}

void Aligner::find_inliers() noexcept {
  const double* const errors = plane(planes::error);
  const double* const has_third = plane(planes::has_third);
  double* const is_inlier = plane(planes::is_inlier);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    const simd::RobustLimits& limits = simd::robust_limits[has_third[lane] == 0 ? 0 : 1];
    const bool fits = errors[lane] <= limits.gate / limits.median * scale_squared_;
    is_inlier[lane] = fits ? 1 : 0;
    found_.inliers += fits ? 1 : 0;
  }
}

// The median distance of some of the points from the body at a pose.
double Aligner::median_distance(const double* T_bw) const noexcept {
  constexpr std::size_t most = 64;
  double squares[most + 1];
  std::size_t count = 0;
  const double* const p = planes_ + planes::point * stride_;
  for (std::size_t lane = 0; lane < lanes_; lane += lanes_ / most + 1) {
    if (match_of_lane_[lane] == no_match) continue;
    double square = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      const double* const r = T_bw + 4 * row;
      const double coordinate = r[0] * p[lane] + r[1] * p[stride_ + lane] + r[2] * p[2 * stride_ + lane] + r[3];
      square += coordinate * coordinate;
    }
    if (std::isfinite(square)) squares[count++] = square;
  }
  if (count == 0) return 0;
  std::nth_element(squares, squares + count / 2, squares + count);
  return std::sqrt(squares[count / 2]);
}

bool Aligner::is_far_off() const noexcept {
  const double predicted = median_distance(motion_.start_pose());
  const double found = median_distance(motion_.pose());
  return found > most_growth * predicted || predicted > most_growth * found;
}

simd::ThirdRows Aligner::count_third(double deviations) const noexcept {
  const double limit = deviations * std::fmax(found_.scale, 1);
  simd::ThirdRows all{};
  for (std::size_t p = 0; p < part_count_; ++p) {
    const simd::ThirdRows rows = kernel_->alignment.count_third(parts_[p], limit);
    all.count += rows.count;
    all.below += rows.below;
    all.above += rows.above;
  }
  return all;
}

// Whether the frame may fit better without third rows.
bool Aligner::doubts_third() const noexcept {
  if (third_ == DepthCue::none || found_.measured < fewest_matches) return false;
  if (!found_.is_aligned()) return true;
  const simd::ThirdRows rows = count_third(limit_of_third);
  return rows.count >= fewest_matches && (is_above(most_on_one_side, std::max(rows.below, rows.above), rows.count) ||
                                          is_above(most_off, rows.below + rows.above, rows.count));
}

// Whether most third rows are off at the pose that u and v alone have found.
bool Aligner::third_misfits(const MatchedFrame& frame) noexcept {
  read(frame);
  whiten();
  const simd::ThirdRows by_half = count_third(limit_of_third);
  const simd::ThirdRows by_all = count_third(gate_of_third);
  return is_above(0.5, std::max(by_half.below, by_half.above), by_half.count) ||
         is_above(0.5, by_all.below + by_all.above, by_all.count);
}

void Aligner::whiten() noexcept {
  for (std::size_t p = 0; by_map_ && p < part_count_; ++p) kernel_->alignment.whiten(parts_[p]);
}

// Of those that are finite.
double Aligner::median_error(std::size_t& finite) noexcept {
  return static_cast<double>(kernel_->arrays.median(errors_, padded(lanes_, error_lanes), finite));
}

// Errors and their scale at the pose.
void Aligner::measure_errors() noexcept {
  for (std::size_t p = 0; p < part_count_; ++p) kernel_->alignment.measure_errors(parts_[p]);
  const double median = median_error(finite_);
  scale_squared_ = std::max(median, finest_scale * finest_scale * radian_squared_);
}

// One step of Gauss and Newton: (sum w H^T H / scale^2 + prior) x = sum w H^T e / scale^2 - prior xi.
bool Aligner::step(RobustWeight weight) noexcept {
  double H[6][6] = {}, b[6] = {}, x[6];
  for (std::size_t p = 0; p < part_count_; ++p)
    add(kernel_->alignment.normal_equations(parts_[p], weight, scale_squared_), 1 / scale_squared_, H, b);
  if (prior_ != nullptr) motion_.add_prior(prior_, H, b);
  if (!solve(H, b, x)) return false;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) information_[6 * i + j] = H[std::max(i, j)][std::min(i, j)];
  }
  motion_.move(x);
  ++found_.iterations;
  double squared = 0;  // x^T H x
  for (int i = 0; i < 6; ++i) squared += x[i] * b[i];
  length_ = std::sqrt(std::max(squared, 0.0));
  return true;
}

}  // namespace maxlogdet
