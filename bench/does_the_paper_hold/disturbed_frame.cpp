// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/disturbed_frame.hpp"

#include "bench/world/angles.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/match_noise.hpp"
#include "bench/world/names.hpp"
#include "bench/world/outlier_rejection.hpp"
#include "bench/world/projection.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double keyframe_distance = 0.3;   // m, between successive keyframes
constexpr double prior_translation = 0.05;  // m, each axis
constexpr double prior_rotation_deg = 0.5;  // each axis
constexpr double strayed_share = 1.0 / 3;   // of the points: mapped by a random keyframe
constexpr double bad_sigma = 2;             // sigma_uneven: times the noise
constexpr double wrong_shares[] = {0.05, 0.1, 0.2};

Vector6 uniform_step(Draws& draws, double translation, double rotation_deg) {
  Vector6 xi;
  for (int i = 0; i < 3; ++i) xi[i] = draws.uniform(-translation, translation);
  for (int i = 3; i < 6; ++i) xi[i] = draws.uniform(-rotation_deg, rotation_deg) * radians;
  return xi;
}

// All draws of a run, the same for every disturbance.
struct Run {
  Run(const RobustnessOptions& options, std::uint64_t number);

  Frame frame;  // without any error
  Pose true_T_cw;
  Pose prior_T_cw;
  std::vector<Pose> keyframes;                // T_cw, the last one first
  std::vector<Vector6> batch_errors;          // of deviation 1
  std::vector<std::size_t> keyframe_of;       // of a match
  std::vector<Eigen::Vector3d> noise;         // of a match, deviation 1: u, v, u_right
  std::vector<Eigen::Vector3d> map_noise;     // the same of the keyframe's pixels
  std::vector<Eigen::Vector3d> strays;        // of a match that is wrong: a direction, not normalised
  std::vector<double> stray_quantiles;        // of the distance in that direction
  std::vector<Eigen::Vector2d> patch_errors;  // of a cell, deviation 1
  std::vector<std::uint32_t> wrong_order;     // wrong matches come first
};

Run::Run(const RobustnessOptions& options, std::uint64_t number) {
  Draws draws(options.seed, number);
  frame = make_scene(options.scene, options.matches, draws.bits());
  true_T_cw = pose_of(frame.T_cw_prior);
  prior_T_cw = exp_se3(uniform_step(draws, prior_translation, prior_rotation_deg)) * true_T_cw;
  for (std::size_t k = 0; k < options.keyframes; ++k) {
    Vector6 step = uniform_step(draws, 0.2, 3);
    step[2] += keyframe_distance * static_cast<double>(k + 1);  // points are farther from there
    keyframes.push_back(exp_se3(step) * true_T_cw);
    batch_errors.emplace_back();
    batch_errors.back() << draws.normal3(1), draws.normal3(1);
  }
  std::vector<std::uint32_t> by_depth(options.matches);
  std::iota(by_depth.begin(), by_depth.end(), 0U);
  wrong_order = by_depth;
  std::sort(by_depth.begin(), by_depth.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(in_camera(frame, frame.matches[a])[2], a) <
           std::make_pair(in_camera(frame, frame.matches[b])[2], b);
  });
  keyframe_of.resize(options.matches);
  for (std::size_t rank = 0; rank < by_depth.size(); ++rank) {
    const bool is_strayed = draws.chance(strayed_share);
    const std::size_t any = draws.below(options.keyframes);
    keyframe_of[by_depth[rank]] = is_strayed ? any : rank * options.keyframes / options.matches;
  }
  for (std::size_t i = 0; i < options.matches; ++i) {
    noise.push_back(draws.normal3(1));
    map_noise.push_back(draws.normal3(1));
    strays.push_back(draws.normal3(1));
    stray_quantiles.push_back(draws.uniform(0, 1));
  }
  for (std::size_t cell = 0; cell < error_patches.cells(); ++cell) {
    const double u = draws.normal(), v = draws.normal();
    patch_errors.emplace_back(u, v);
  }
  draws.shuffle_front(wrong_order, wrong_order.size());
}

// Adds the error e of a point that a keyframe triangulates from noisy pixels, J e = noise, and sets its covariance.
void triangulate(const Frame& frame, const Pose& keyframe, const Eigen::Vector3d& noise, double sigma, Match& match,
                 std::array<double, 9>& covariance) {
  Match seen = match;
  seen.u_right = 0;
  LinearizedMatch at;
  linearize(frame.camera, keyframe, seen, true, at);
  const Eigen::Matrix3d J_inverse = at.H_p.inverse();
  const Eigen::Vector3d error = sigma * J_inverse * noise;
  for (int i = 0; i < 3; ++i) match.point[i] += error[i];
  Eigen::Map<Eigen::Matrix3d>(covariance.data()) = sigma * sigma * J_inverse * J_inverse.transpose();
}

// Moves a point with the erroneous pose of its keyframe, in whose camera frame it stays.
void shift(const RobustnessOptions& options, const Pose& keyframe, const Vector6& unit_error, Match& match) {
  Vector6 xi = unit_error;
  xi.head<3>() *= options.batch_translation;
  xi.tail<3>() *= options.batch_rotation_deg * radians;
  const Eigen::Vector3d p(match.point[0], match.point[1], match.point[2]);
  const Eigen::Vector3d shifted = keyframe.inverse() * (exp_se3(xi) * (keyframe * p));
  for (int i = 0; i < 3; ++i) match.point[i] = shifted[i];
}

void add_to_pixels(Match& match, const Eigen::Vector3d& error) {
  match.u += error[0];
  match.v += error[1];
  if (match.is_stereo()) match.u_right = std::max(0.0, match.u_right + error[2]);  // still a stereo match
}

// Makes a match wrong: its whitened residual at the truth is uniform in the ball that passes the chi2 test.
void lead_astray(Frame& at_truth, const Run& run, double gate, std::uint32_t i) {
  Match& match = at_truth.matches[i];
  LinearizedMatch at;
  if (!linearize(at_truth.camera, run.true_T_cw, match, true, at)) return;
  const RejectionOptions limits;
  const bool is_stereo = at.rows == 3;
  const double radius = is_stereo ? std::sqrt(gate * limits.chi2_stereo) * std::cbrt(run.stray_quantiles[i])
                                  : std::sqrt(gate * limits.chi2_monocular * run.stray_quantiles[i]);
  Eigen::Vector3d direction = run.strays[i];
  if (!is_stereo) direction[2] = 0;
  const Eigen::Map<const Eigen::Matrix3d> map_covariance(at_truth.map_covariances[i].data());
  Eigen::Matrix3d L_inverse = whitening_of(at_truth.camera, run.true_T_cw, match, true, map_covariance).matrix();
  if (!is_stereo) L_inverse(2, 2) = 1;  // a missing row
  const Eigen::Vector3d residual =
      L_inverse.triangularView<Eigen::Lower>().solve(Eigen::Vector3d(radius * direction.normalized()));
  add_to_pixels(match, residual - at.residual);
}

double wrong_share_of(Disturbance disturbance) {
  switch (disturbance) {
    case Disturbance::wrong_5: return wrong_shares[0];
    case Disturbance::wrong_10: return wrong_shares[1];
    case Disturbance::wrong_20: return wrong_shares[2];
    default: return 0;
  }
}

double believed_sigma_factor(Disturbance disturbance) {
  if (disturbance == Disturbance::sigma_half) return 0.5;
  return disturbance == Disturbance::sigma_double ? 2 : 1;
}

DisturbedFrame disturb(const RobustnessOptions& options, Disturbance disturbance, const Run& run) {
  DisturbedFrame result;
  Frame& frame = result.frame;
  frame = run.frame;
  frame.map_covariances.resize(options.matches);
  result.true_T_cw = run.true_T_cw;
  result.is_wrong.assign(options.matches, 0);
  const double believed = believed_sigma_factor(disturbance);
  for (std::size_t i = 0; i < options.matches; ++i) {
    Match& match = frame.matches[i];
    const std::size_t keyframe = run.keyframe_of[i];
    match.keyframe = static_cast<std::int64_t>(options.keyframes - 1 - keyframe);
    triangulate(frame, run.keyframes[keyframe], run.map_noise[i], options.map_sigma, match, frame.map_covariances[i]);
    if (disturbance == Disturbance::batches) {
      shift(options, run.keyframes[keyframe], run.batch_errors[keyframe], match);
    }
    double sigma = options.pixel_sigma / std::sqrt(match.inv_sigma2);
    match.inv_sigma2 = 1 / (sigma * sigma * believed * believed);
    if (disturbance == Disturbance::sigma_uneven && match.u < frame.width / 2.0) sigma *= bad_sigma;
    const std::uint32_t patch = error_patches.cell_of(frame, match);
    add_to_pixels(match, sigma * run.noise[i]);
    if (disturbance == Disturbance::patches) {
      const Eigen::Vector2d shared = options.patch_sigma * run.patch_errors[patch];
      add_to_pixels(match, {shared[0], shared[1], shared[0]});
    }
  }
  const auto wrong = std::lround(wrong_share_of(disturbance) * static_cast<double>(options.matches));
  for (std::size_t w = 0; w < static_cast<std::size_t>(wrong); ++w) {
    lead_astray(frame, run, options.gate, run.wrong_order[w]);
    result.is_wrong[run.wrong_order[w]] = 1;
  }
  frame.T_cw_prior = to_rows(run.prior_T_cw);
  if (disturbance == Disturbance::focal) {
    const double factor = 1 + options.focal_error_percent / 100;
    frame.camera.fx *= factor;
    frame.camera.fy *= factor;
    frame.camera.bf *= factor;
  }
  return result;
}

}  // namespace

const char* to_string(Disturbance disturbance) {
  switch (disturbance) {
    case Disturbance::none: return "none";
    case Disturbance::batches: return "batches";
    case Disturbance::patches: return "patches";
    case Disturbance::sigma_half: return "sigma_half";
    case Disturbance::sigma_double: return "sigma_double";
    case Disturbance::sigma_uneven: return "sigma_uneven";
    case Disturbance::wrong_5: return "wrong_5";
    case Disturbance::wrong_10: return "wrong_10";
    case Disturbance::wrong_20: return "wrong_20";
    case Disturbance::focal: return "focal";
  }
  return "unknown";
}

nlohmann::ordered_json to_json(const RobustnessOptions& options) {
  return {{"experiment", "robustness"},
          {"seed", options.seed},
          {"scene", to_string(options.scene)},
          {"matches", options.matches},
          {"budgets", options.budgets},
          {"disturbances", names_of(options.disturbances)},
          {"pixel_sigma_px", options.pixel_sigma},
          {"map_sigma_px", options.map_sigma},
          {"keyframes", options.keyframes},
          {"batch_translation_m", options.batch_translation},
          {"batch_rotation_deg", options.batch_rotation_deg},
          {"patch_sigma_px", options.patch_sigma},
          {"gate", options.gate},
          {"focal_error_percent", options.focal_error_percent},
          {"tau_px", options.tau}};
}

void check(const RobustnessOptions& options) {
  const auto is_within = [](double value, double low, double high) { return value >= low && value <= high; };
  require_input(options.matches >= 20 && options.matches <= 5000, "--matches: expected 20 to 5000");
  require_input(!options.budgets.empty() && !options.disturbances.empty(),
                "--budgets, --disturbances: expected at least one of each");
  for (const std::size_t budget : options.budgets) {
    require_input(budget >= 10 && budget <= options.matches,
                  "--budgets: expected numbers from 10 to that of the matches");
  }
  require_input(is_within(options.pixel_sigma, 1e-6, 10), "--pixel-sigma: expected 1e-6 to 10 px");
  require_input(is_within(options.map_sigma, 1e-6, 1), "--map-sigma: expected 1e-6 to 1 px");
  require_input(options.keyframes >= 1 && options.keyframes <= 20, "--keyframes: expected 1 to 20");
  require_input(is_within(options.batch_translation, 0, 0.5), "--batch-translation: expected 0 to 0.5 m");
  require_input(is_within(options.batch_rotation_deg, 0, 5), "--batch-rotation: expected 0 to 5 degrees");
  require_input(is_within(options.patch_sigma, 0, 10), "--patch-sigma: expected 0 to 10 px");
  require_input(is_within(options.gate, 0, 100), "--gate: expected 0 to 100");
  require_input(is_within(options.focal_error_percent, -10, 10), "--focal-error: expected -10 to 10 percent");
  require_input(is_within(options.tau, 0, 100), "--tau: expected 0 to 100 px");
}

DisturbedFrame disturbed_frame(const RobustnessOptions& options, Disturbance disturbance, std::uint64_t run) {
  return disturb(options, disturbance, Run(options, run));
}

}  // namespace maxlogdet::sim
