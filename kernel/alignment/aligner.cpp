// SPDX-License-Identifier: MIT
#include "kernel/alignment/aligner.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/camera_checks.hpp"
#include "simd/whitening.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet {
namespace {

namespace planes = simd::plane;
using simd::alignment_lanes;
using simd::RobustWeight;

constexpr std::size_t fewest_matches = 10;
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
// The robust scale over the spread of the inliers in the image: where pixels are in another unit than the camera, the
// best pose is so far away that all points share a pixel.
constexpr double coarsest_share = 1.0 / 8;
// Of |W J|^2 over its median: ten times as near as half of the matches.
constexpr double most_leverage = 100;
// At a good prediction the scale is smaller than at the aligned pose by chance, but not by so much.
constexpr double tolerated_growth = 1.25;

// Of the median squared error of third rows, over that expected of the scale.
constexpr double suspicious_ratio = 2;
constexpr double median_of_one = 0.4549364231195725;  // of chi-squared

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

constexpr std::size_t padded(std::size_t count, std::size_t to) { return (count + to - 1) / to * to; }

}  // namespace

Aligner::Aligner(std::size_t capacity)
    : kernel_(simd::active()),
      planes_(planes::count * most_lanes(checked_capacity(capacity))),
      errors_(most_lanes(capacity) + error_lanes),
      match_of_lane_(most_lanes(capacity)),
      parts_(most_parts(capacity)) {}

void Aligner::forget(const RigidTransform& T_bw, Error why) noexcept {
  found_ = Alignment();
  found_.error = why;
  pose_ = T_bw;
  std::fill_n(information_, 36, 0.0);
}

void Aligner::align(const FrameToAlign& frame, unsigned char* is_inlier) noexcept {
  forget(frame.T_bw, kernel_ == nullptr ? Error::unsupported_isa : Error::none);
  if (kernel_ == nullptr) return;
  motion_.start(frame.T_bw);
  prior_ = frame.prior;
  read(frame);
  found_.status = find_pose();
  if (!found_.is_aligned()) {
    found_.inliers = 0;
    std::fill_n(information_, 36, 0.0);
    return;
  }
  pose_ = RigidTransform::row_major(motion_.pose());
  found_.scale = std::sqrt(scale_squared_);
  const double* const fits = plane(planes::is_inlier);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    if (match_of_lane_[lane] != no_match && fits[lane] == 0) is_inlier[match_of_lane_[lane]] = 0;
  }
}

// Sorts the matches by camera, and copies what is known of them to planes.
void Aligner::read(const FrameToAlign& frame) noexcept {
  std::size_t next[max_cameras] = {};  // how many a camera sees, then where its next match goes
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (frame.is_aligned[i] != 0) ++next[frame.matches[i].camera_id];
  }
  by_map_ = frame.options.weighting == Weighting::measurement_and_map;
  third_ = frame.options.depth_cue;
  lanes_ = part_count_ = 0;
  for (std::size_t c = 0; c < frame.camera_count; ++c) {
    found_.measured += next[c];
    const std::size_t begin = lanes_;
    lanes_ += padded(next[c], alignment_lanes);
    if (next[c] > 0) parts_[part_count_++] = part_of(frame, frame.cameras[c], begin);
    next[c] = begin;
  }
  stride_ = lanes_ | alignment_lanes;  // an odd number of cache lines
  for (std::size_t p = 0; p < part_count_; ++p) parts_[p].stride = stride_;
  std::fill_n(match_of_lane_.begin(), lanes_, no_match);
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (frame.is_aligned[i] != 0) read_match(frame, i, next[frame.matches[i].camera_id]++);
  }
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    if (match_of_lane_[lane] == no_match) clear_lane(lane);
  }
  std::fill_n(errors_ + lanes_, error_lanes, float_infinity);
}

simd::AlignmentInput Aligner::part_of(const FrameToAlign& frame, const Camera& camera, std::size_t begin) noexcept {
  simd::AlignmentInput part{};
  part.by_map = by_map_;
  part.frame.third = frame.options.depth_cue;
  part.frame.camera = camera_input(camera);
  part.frame.T_bw = motion_.pose();
  part.frame.map_sigma = frame.options.map_sigma;
  part.frame.depth_sigma = frame.options.depth_sigma;
  part.frame.map_covariances = frame.covariances;
  part.planes = planes_;
  part.errors = errors_;
  part.begin = begin;
  part.end = lanes_;
  return part;
}

void Aligner::read_match(const FrameToAlign& frame, std::size_t i, std::size_t lane) noexcept {
  const FeatureMatch& match = frame.matches[i];
  match_of_lane_[lane] = static_cast<std::uint32_t>(i);
  for (std::size_t d = 0; d < 3; ++d) plane(planes::point + d)[lane] = match.point[d];
  for (std::size_t d = 0; d < 2; ++d) plane(planes::measured + d)[lane] = match.measured[d];
  plane(planes::sigma)[lane] = match.sigma;
  plane(planes::weight)[lane] = 1 / match.sigma;
  const PinholeCamera& pinhole = frame.cameras[match.camera_id].pinhole;
  plane(planes::measured + 2)[lane] =
      frame.options.depth_cue == DepthCue::stereo ? match.u_right - pinhole.shift_of_right : match.depth;
  plane(planes::has_third)[lane] = third_ != DepthCue::none && frame.has_third[i] != 0 ? 1 : 0;
  for (std::size_t e = 0; by_map_ && frame.covariances != nullptr && e < 6; ++e) {
    plane(planes::map_covariance + e)[lane] = frame.covariances[9 * i + simd::upper_triangle[e]];
  }
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
      scale_squared_ > coarsest_scale * coarsest_scale * radian_squared_ ||
      scale_squared_ > coarsest_share * coarsest_share * image_spread())
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
    const double focal_length = parts_[p].frame.camera.fx;
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

// The variance of the inliers' u and v about their means over the cameras, in units of sigma.
double Aligner::image_spread() noexcept {
  const double *const u = plane(planes::measured), *const v = plane(planes::measured + 1);
  const double *const weights = plane(planes::weight), *const is_inlier = plane(planes::is_inlier);
  double sum = 0;
  for (std::size_t p = 0; p < part_count_; ++p) {
    double totals[4][alignment_lanes] = {};  // of w, w u, w v, w (u^2 + v^2), w = 1 / sigma^2
    for (std::size_t begin = parts_[p].begin; begin < parts_[p].end; begin += alignment_lanes) {
      for (std::size_t lane = 0; lane < alignment_lanes; ++lane) {
        const std::size_t i = begin + lane;
        const double w = is_inlier[i] * weights[i] * weights[i];
        totals[0][lane] += w;
        totals[1][lane] += w * u[i];
        totals[2][lane] += w * v[i];
        totals[3][lane] += w * (u[i] * u[i] + v[i] * v[i]);
      }
    }
    double total[4];
    for (int t = 0; t < 4; ++t) total[t] = std::accumulate(totals[t], totals[t] + alignment_lanes, 0.0);
    if (total[0] > 0) sum += total[3] - (total[1] * total[1] + total[2] * total[2]) / total[0];
  }
  return sum / (2 * static_cast<double>(found_.inliers));
}

bool Aligner::doubts_third() noexcept {
  if (third_ == DepthCue::none || found_.status == AlignmentStatus::few_matches) return false;
  if (!found_.is_aligned()) return true;
  for (std::size_t p = 0; p < part_count_; ++p) kernel_->alignment.measure_third(parts_[p]);
  std::size_t finite;
  const double median = median_error(finite);
  return finite >= fewest_matches && median > suspicious_ratio * median_of_one * std::max(scale_squared_, 1.0);
}

void Aligner::whiten() noexcept {
  for (std::size_t p = 0; by_map_ && p < part_count_; ++p) kernel_->alignment.whiten(parts_[p]);
}

// Of those that are finite, with 23 - 11 bits after the first: 2^-12 is far below the error of a median.
double Aligner::median_error(std::size_t& finite) noexcept {
  return static_cast<double>(kernel_->arrays.median(errors_, padded(lanes_, error_lanes), 11, finite));
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
