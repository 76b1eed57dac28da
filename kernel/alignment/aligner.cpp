// SPDX-License-Identifier: MIT
#include "kernel/alignment/aligner.hpp"

#include "kernel/base/memory.hpp"
#include "kernel/information/factor.hpp"

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
constexpr double largest_expected_scale = 3;  // in recordings of trackers it is at most 1.1

// At a good prediction the scale is smaller than at the aligned pose by chance, but not by so much.
constexpr double tolerated_growth = 1.25;

// Of the Cholesky factor of normal equations; below it a step would have next to no digits.
constexpr double smallest_relative_pivot = 1e-12;

// Third rows are off if they are so by half a deviation; 31 % of normal ones are by chance, on either side.
constexpr double limit_of_third = 0.5;
constexpr double most_on_one_side = 0.45;
constexpr double most_off = 0.75;
constexpr double gate_of_third = 2.576;  // 1 % of normal ones

constexpr std::size_t error_lanes = 16;  // medians read whole packs of float32

constexpr std::size_t padded(std::size_t count, std::size_t to) { return (count + to - 1) / to * to; }
constexpr std::size_t most_lanes(std::size_t capacity) {
  return padded(capacity + (alignment_lanes - 1) * std::min(capacity, max_cameras), alignment_lanes);
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

// Solves H x = b of a symmetric H, of which the lower triangle is read. False where it is not positive definite, or so
// nearly singular, whatever the units of its rows, that x has next to no digits.
bool solve(const double (&H)[6][6], const double (&b)[6], double (&x)[6]) noexcept {
  double L[6][6];
  if (!cholesky(&H[0][0], smallest_relative_pivot, L)) return false;
  for (int i = 0; i < 6; ++i) {
    x[i] = b[i];
    for (int k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
  return std::all_of(x, x + 6, [](double entry) { return std::isfinite(entry); });
}

// Of `count`, by more than chance: twice the deviation of a share.
bool is_above(double share, std::size_t found, std::size_t count) noexcept {
  const auto all = static_cast<double>(count);
  return static_cast<double>(found) > share * all + std::sqrt(all);
}

}  // namespace

Aligner::Aligner(std::size_t capacity)
    : kernel_(simd::active()),
      stride_(most_lanes(checked_capacity(capacity)) | alignment_lanes),
      planes_(planes::count * stride_),
      errors_(most_lanes(capacity) + error_lanes),
      match_of_lane_(most_lanes(capacity)),
      fits_with_third_(capacity) {
  parts_.reserve(std::min(capacity, max_cameras));
}

void Aligner::forget(const RigidTransform& T_bw, Error why) noexcept {
  found_ = Found();
  found_.error = why;
  found_.pose = T_bw;
}

void Aligner::align(const MatchedFrame& frame, const double* prior, unsigned char* is_inlier) noexcept {
  align_once(frame, prior, is_inlier);
  if (!doubts_third(frame.depth_cue)) return;
  const Found with_third = found_;
  std::copy_n(is_inlier, frame.size, fits_with_third_.begin());

  MatchedFrame without = frame;
  without.depth_cue = DepthCue::none;
  align_once(without, nullptr, is_inlier);  // the prior may be what does not fit
  if (found_.is_aligned() && (!with_third.is_aligned() || third_misfits(frame))) {
    if (prior != nullptr) align_once(without, prior, is_inlier);
    const bool is_stereo = frame.depth_cue == DepthCue::stereo;
    found_.warning = is_stereo ? Warning::misfitting_right_columns : Warning::misfitting_depths;
    return;
  }
  found_ = with_third;
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
    found_.pose = RigidTransform::row_major(motion_.pose());
    found_.scale = std::sqrt(scale_squared_);
    found_.warning = found_.scale > largest_expected_scale ? Warning::large_errors : Warning::none;
  } else {
    found_.inliers = 0;
    std::fill_n(found_.information, 36, 0.0);
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
  for (const simd::AlignmentInput& part : parts_) kernel_->alignment.measure_errors(part);
  const double* const errors = plane(planes::error);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    if (match_of_lane_[lane] != no_match) chi2[match_of_lane_[lane]] = errors[lane] * limits_of(lane).median;
  }
}

// Sorts the matches by camera, and copies what is known of them to planes. Returns how many there are.
std::size_t Aligner::read(const MatchedFrame& frame) noexcept {
  const auto is_aligned = [&frame](std::size_t i) { return frame.usable[i] != 0 && is_measured(frame.matches[i]); };
  std::size_t next[max_cameras] = {};  // how many a camera sees, then where its next match goes
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (is_aligned(i)) ++next[frame.matches[i].camera_id];
  }
  lanes_ = 0;
  parts_.clear();
  std::size_t measured = 0;
  for (std::size_t c = 0; c < frame.camera_count; ++c) {
    const std::size_t begin = lanes_;
    measured += next[c];
    lanes_ += padded(next[c], alignment_lanes);
    if (next[c] > 0) parts_.push_back(part_of(frame, frame.cameras[c], begin));
    for (std::size_t lane = begin + next[c]; lane < lanes_; ++lane) clear_lane(lane);
    next[c] = begin;
  }
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (is_aligned(i)) read_match(frame, i, next[frame.matches[i].camera_id]++);
  }
  std::fill_n(errors_ + lanes_, error_lanes, float_infinity);
  return measured;
}

simd::AlignmentInput Aligner::part_of(const MatchedFrame& frame, const Camera& camera,
                                      std::size_t begin) const noexcept {
  return {camera_input(camera),
          motion_.pose(),
          frame.depth_cue,
          frame.options.depth_sigma,
          frame.has_covariances,
          planes_,
          stride_,
          errors_,
          begin,
          lanes_};
}

void Aligner::read_match(const MatchedFrame& frame, std::size_t i, std::size_t lane) noexcept {
  const FeatureMatch& match = frame.matches[i];
  const DepthCue third = frame.depth_cue;
  match_of_lane_[lane] = static_cast<std::uint32_t>(i);
  for (std::size_t d = 0; d < 3; ++d) plane(planes::point + d)[lane] = match.point[d];
  for (std::size_t d = 0; d < 2; ++d) plane(planes::measured + d)[lane] = match.measured[d];
  plane(planes::sigma)[lane] = match.sigma;
  plane(planes::weight)[lane] = 1 / match.sigma;
  const PinholeCamera& pinhole = frame.cameras[match.camera_id].pinhole;
  plane(planes::measured + 2)[lane] = third == DepthCue::stereo ? match.u_right - pinhole.shift_of_right : match.depth;
  plane(planes::has_third)[lane] = third != DepthCue::none && measured_cue(match) != DepthCue::none ? 1 : 0;
  for (std::size_t e = 0; frame.has_covariances && e < 6; ++e)
    plane(planes::map_covariance + e)[lane] = simd::map_covariance_of(match, frame.options.map_sigma, e);
}

// A lane without a match has no error.
void Aligner::clear_lane(std::size_t lane) noexcept {
  match_of_lane_[lane] = no_match;
  for (std::size_t v = 0; v < planes::given; ++v) plane(v)[lane] = 0;
  plane(planes::point)[lane] = not_a_number;
}

AlignmentStatus Aligner::find_pose() noexcept {
  if (found_.measured == 0) return AlignmentStatus::few_matches;
  measure_radian();
  whiten();
  limit_leverage();
  measure_errors();
  if (found_.finite < fewest_matches) return AlignmentStatus::few_matches;
  const double scale_at_start = scale_squared_;
  const std::size_t finite_at_start = found_.finite;
  const auto failed = [this] {  // at the predicted pose, or later
    return found_.iterations == 0 ? AlignmentStatus::singular : AlignmentStatus::not_converged;
  };
  if (!settle(RobustWeight::huber, is_settled_by_huber)) return failed();
  if (!settle(RobustWeight::tukey, is_settled_by_tukey)) return failed();
  if (parts_[0].by_map) {  // the noise of the map at the pose found
    whiten();
    measure_errors();
  }
  find_inliers();
  if (2 * found_.inliers < std::max(found_.finite, finite_at_start) ||
      scale_squared_ > coarsest_scale * coarsest_scale * radian_squared_ || is_far_off())
    return AlignmentStatus::no_consensus;
  if (!settle(RobustWeight::inliers, is_converged)) return failed();
  const bool fits = scale_squared_ <= tolerated_growth * tolerated_growth * scale_at_start;
  return fits && length_ < is_converged ? AlignmentStatus::aligned : AlignmentStatus::not_converged;
}

// The squared whitened error that an angle of one radian makes, of a match of median sigma over focal length.
void Aligner::measure_radian() noexcept {
  const double* const sigmas = plane(planes::sigma);
  for (const simd::AlignmentInput& part : parts_) {
    for (std::size_t lane = part.begin; lane < part.end; ++lane) {
      const bool is_match = match_of_lane_[lane] != no_match;
      errors_[lane] = is_match ? static_cast<float>(sigmas[lane] / part.camera.fx) : float_infinity;
    }
  }
  const double angle = median_error();
  radian_squared_ = 1 / (angle * angle * simd::robust_limits[0].median);
}

// Mallows' weights, at the predicted pose.
void Aligner::limit_leverage() noexcept {
  for (const simd::AlignmentInput& part : parts_) kernel_->alignment.measure_leverage(part);
  const double median = median_error();
  double* const leverage = plane(planes::leverage);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    const bool is_large = leverage[lane] > most_leverage * median;
    leverage[lane] = is_large ? most_leverage * median / leverage[lane] : 1;
  }
}

// Steps with one kind of weights until a step is short; once there are inliers, with the scale that they have.
bool Aligner::settle(RobustWeight weight, double short_step) noexcept {
  length_ = infinity;
  for (int i = 0; i < most_steps && length_ >= short_step; ++i) {
    if (!step(weight)) return false;
    if (weight != RobustWeight::inliers) measure_errors();
  }
  return true;
}

void Aligner::find_inliers() noexcept {
  const double* const errors = plane(planes::error);
  double* const is_inlier = plane(planes::is_inlier);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    const simd::RobustLimits& limits = limits_of(lane);
    const bool fits = errors[lane] <= limits.gate / limits.median * scale_squared_;
    is_inlier[lane] = fits ? 1 : 0;
    found_.inliers += fits ? 1 : 0;
  }
}

// The median distance of some of the points from the body at a pose.
double Aligner::median_distance(const RigidTransform& T_bw) const noexcept {
  constexpr std::size_t most = 64;
  double squares[most + 1];
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < lanes_; lane += lanes_ / most + 1) {
    double p_w[3], p_b[3];
    for (std::size_t d = 0; d < 3; ++d) p_w[d] = plane(planes::point + d)[lane];
    T_bw.transform(p_w, p_b);
    const double square = p_b[0] * p_b[0] + p_b[1] * p_b[1] + p_b[2] * p_b[2];
    if (std::isfinite(square)) squares[count++] = square;
  }
  if (count == 0) return 0;
  std::nth_element(squares, squares + count / 2, squares + count);
  return std::sqrt(squares[count / 2]);
}

bool Aligner::is_far_off() const noexcept {
  const double predicted = median_distance(RigidTransform::row_major(motion_.start_pose()));
  const double found = median_distance(RigidTransform::row_major(motion_.pose()));
  return found > most_growth * predicted || predicted > most_growth * found;
}

simd::ThirdRows Aligner::count_third(double deviations) const noexcept {
  const double limit = deviations * std::fmax(found_.scale, 1);
  simd::ThirdRows all{};
  for (const simd::AlignmentInput& part : parts_) {
    const simd::ThirdRows rows = kernel_->alignment.count_third(part, limit);
    all.count += rows.count;
    all.below += rows.below;
    all.above += rows.above;
  }
  return all;
}

// Whether the frame may fit better without third rows.
bool Aligner::doubts_third(DepthCue third) const noexcept {
  if (third == DepthCue::none || found_.measured < fewest_matches) return false;
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
  for (const simd::AlignmentInput& part : parts_) {
    if (part.by_map) kernel_->alignment.whiten(part);
  }
}

// Of those that are finite.
double Aligner::median_error() noexcept {
  return static_cast<double>(kernel_->arrays.median(errors_, padded(lanes_, error_lanes), found_.finite));
}

// Errors and their scale at the pose.
void Aligner::measure_errors() noexcept {
  for (const simd::AlignmentInput& part : parts_) kernel_->alignment.measure_errors(part);
  scale_squared_ = std::max(median_error(), finest_scale * finest_scale * radian_squared_);
}

// One step of Gauss and Newton: (sum w H^T H / scale^2 + prior) x = sum w H^T e / scale^2 - prior xi.
bool Aligner::step(RobustWeight weight) noexcept {
  double H[6][6] = {}, b[6] = {}, x[6];
  for (const simd::AlignmentInput& part : parts_)
    add(kernel_->alignment.normal_equations(part, weight, scale_squared_), 1 / scale_squared_, H, b);
  if (prior_ != nullptr) motion_.add_prior(prior_, H, b);
  if (!solve(H, b, x)) return false;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) found_.information[6 * i + j] = H[std::max(i, j)][std::min(i, j)];
  }
  motion_.move(x);
  ++found_.iterations;
  double squared = 0;  // x^T H x
  for (int i = 0; i < 6; ++i) squared += x[i] * b[i];
  length_ = std::sqrt(std::max(squared, 0.0));
  return true;
}

}  // namespace maxlogdet
