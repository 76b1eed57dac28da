// SPDX-License-Identifier: MIT
#include "experiments/pnp_experiment.hpp"

#include "experiments/greedy_metric.hpp"
#include "experiments/pose_error_model.hpp"
#include "experiments/runs.hpp"
#include "sim/draws.hpp"
#include "sim/frame_reader.hpp"
#include "sim/pose_optimizer.hpp"
#include "sim/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

namespace maxlogdet::sim {
namespace {

constexpr double degrees = 57.29577951308232;  // of a radian
const char* const no_weighting = "-";

// One draw of everything that a run needs. The noises are multiples of the same draw, so that panels differ in noise
// alone.
struct Scene {
  PinholeCamera camera{458.654, 457.296, 367.215, 248.375, 0};
  Pose true_T_cw = Pose::Identity();
  Pose guess = Pose::Identity();         // where the camera was before it moved
  Pose aligned_T_cw = Pose::Identity();  // what would be right if the map's best rigid alignment were its frame
  Eigen::Matrix3Xd points;               // true
  Eigen::Matrix3Xd mapped;
  Eigen::Matrix2Xd pixels;  // true
  Eigen::Matrix2Xd unit_noise;
  std::vector<std::uint32_t> random_order;
};

double draw_depth(const PnpOptions& options, Draws& draws) {
  const double near = options.nearest, far = options.farthest;
  switch (options.depths) {
    case DepthLaw::volume: return std::cbrt(draws.uniform(near * near * near, far * far * far));
    case DepthLaw::inverse: return 1 / draws.uniform(1 / far, 1 / near);
    default: return draws.uniform(near, far);
  }
}

Scene draw_scene(const PnpOptions& options, std::uint64_t run) {
  Draws draws(options.seed, run);
  Scene scene;
  const auto n = static_cast<Eigen::Index>(options.points);
  scene.points.resize(3, n);
  scene.mapped.resize(3, n);
  scene.pixels.resize(2, n);
  scene.unit_noise.resize(2, n);
  Vector6 xi;
  for (int i = 0; i < 3; ++i) xi[i] = draws.uniform(-options.translation, options.translation);
  for (int i = 3; i < 6; ++i) xi[i] = draws.uniform(-options.rotation_deg, options.rotation_deg) / degrees;
  scene.true_T_cw = exp_se3(xi);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double z = draw_depth(options, draws);
    const double x = draws.uniform(-0.8, 0.8) * z, y = draws.uniform(-0.5, 0.5) * z;
    scene.points.col(i) << x, y, z;
    scene.mapped.col(i) =
        scene.points.col(i) + Eigen::Vector3d::Constant(options.map_bias) + draws.normal3(options.map_deviation);
    const Eigen::Vector3d p_c = scene.true_T_cw * Eigen::Vector3d(scene.points.col(i));
    scene.pixels.col(i) << scene.camera.fx * p_c.x() / p_c.z() + scene.camera.cx,
        scene.camera.fy * p_c.y() / p_c.z() + scene.camera.cy;
    scene.unit_noise(0, i) = draws.normal();
    scene.unit_noise(1, i) = draws.normal();
  }
  scene.random_order.resize(options.points);
  std::iota(scene.random_order.begin(), scene.random_order.end(), 0U);
  draws.shuffle_front(scene.random_order, options.points);

  const Similarity map_shift = align_rigid(scene.points, scene.mapped);
  Pose shift = Pose::Identity();
  shift.linear() = map_shift.R;
  shift.translation() = map_shift.t;
  scene.aligned_T_cw = scene.true_T_cw * shift.inverse();
  return scene;
}

Frame frame_of(const Scene& scene, double noise_px) {
  Frame frame;
  frame.camera = scene.camera;
  frame.width = 752;
  frame.height = 480;
  frame.T_cw_prior = to_rows(scene.guess);
  for (Eigen::Index i = 0; i < scene.points.cols(); ++i) {
    Match match;
    match.keypoint = match.map_point_id = i;
    for (int j = 0; j < 3; ++j) match.point[j] = scene.mapped(j, i);
    match.u = scene.pixels(0, i) + noise_px * scene.unit_noise(0, i);
    match.v = scene.pixels(1, i) + noise_px * scene.unit_noise(1, i);
    match.inv_sigma2 = 1 / (noise_px * noise_px);
    frame.matches.push_back(match);
  }
  return frame;
}

// The parts of eq. 4 come together: |bias|^2 + trace of both covariances. The error of the centre is R^T times that of
// the left perturbation's translation to first order.
void expect(const PnpOptions& options, const Scene& scene, const Frame& frame, double noise_px,
            const std::vector<std::uint32_t>& subset, PnpOutcome& outcome) {
  const PoseErrorModel model(frame.camera, frame.matches, subset, scene.true_T_cw, false);
  const Vector6 bias = model.expected_error(Eigen::Vector3d::Constant(options.map_bias));
  const Matrix6 covariance =
      model.covariance_of_measurement_error(noise_px) + model.covariance_of_map_error(options.map_deviation);
  outcome.expected_translation_m = std::sqrt(bias.head<3>().squaredNorm() + covariance.topLeftCorner<3, 3>().trace());
  outcome.expected_rotation_deg =
      degrees * std::sqrt(bias.tail<3>().squaredNorm() + covariance.bottomRightCorner<3, 3>().trace());
  outcome.bias_amplification = model.bias_amplification()[0];
}

// What a run needs to know about one noise.
class PnpRun {
 public:
  PnpRun(const PnpOptions& options, const Scene& scene, double noise_px)
      : options_(options), scene_(scene), noise_px_(noise_px), frame_(frame_of(scene, noise_px)) {}

  PnpOutcome outcome(const PnpCase& which) {
    const std::vector<std::uint32_t>& order = order_of(which.selector, which.weighting);
    const std::vector<std::uint32_t> subset(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(std::min(which.size, order.size())));
    PoseOptions pose;
    pose.method = PoseMethod::gauss_newton;
    pose.max_iterations = 20;
    std::vector<Whitening> whitenings;
    if (which.selector == "all_weighted") {
      whiten(frame_.camera, scene_.guess, frame_.matches, pose.stereo, nullptr, options_.map_deviation, whitenings);
    }
    const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, subset, scene_.guess, pose, whitenings);
    PnpOutcome outcome;
    if (!estimate.is_usable()) return failed();
    outcome.translation_m = camera_distance(estimate.T_cw, scene_.true_T_cw);
    outcome.rotation_deg = camera_angle_deg(estimate.T_cw, scene_.true_T_cw);
    outcome.aligned_translation_m = camera_distance(estimate.T_cw, scene_.aligned_T_cw);
    outcome.aligned_rotation_deg = camera_angle_deg(estimate.T_cw, scene_.aligned_T_cw);
    expect(options_, scene_, frame_, noise_px_, subset, outcome);
    return outcome;
  }

 private:
  // A pose that could not be computed has no error.
  static PnpOutcome failed() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan, nan, nan, nan, nan, nan};
  }

  const std::vector<std::uint32_t>& order_of(const std::string& selector, const std::string& weighting) {
    if (weighting == no_weighting) return scene_.random_order;
    auto& order = orders_[{selector, weighting}];
    if (!order.empty()) return order;
    for (const GreedyMetric metric : greedy_metrics) {
      if (selector != to_string(metric)) continue;
      order = select_greedily(metric, blocks_of(weighting), options_.points, options_.prior * Matrix6::Identity());
    }
    return order;
  }

  const BlockStore& blocks_of(const std::string& weighting) {
    BlockStore& blocks = blocks_[weighting];
    if (blocks.size() != 0) return blocks;
    BlockOptions options;
    for (const Weighting one : options_.weightings) {
      if (weighting == to_string(one)) options.weighting = one;
    }
    options.map_sigma = options_.map_deviation;
    build_blocks(frame_, options, blocks);
    return blocks;
  }

  const PnpOptions& options_;
  const Scene& scene_;
  double noise_px_;
  Frame frame_;
  std::map<std::string, BlockStore> blocks_;
  std::map<std::pair<std::string, std::string>, std::vector<std::uint32_t>> orders_;
};

template <class Member>
Estimate rms_over(const std::vector<PnpOutcome>& outcomes, Member member) {
  std::vector<double> values;
  for (const PnpOutcome& outcome : outcomes) values.push_back(outcome.*member);
  return rms_of(values);
}

PnpRow row_of(const PnpCase& which, const std::vector<PnpOutcome>& outcomes) {
  PnpRow row;
  row.which = which;
  row.translation_m = rms_over(outcomes, &PnpOutcome::translation_m);
  row.rotation_deg = rms_over(outcomes, &PnpOutcome::rotation_deg);
  row.aligned_translation_m = rms_over(outcomes, &PnpOutcome::aligned_translation_m);
  row.aligned_rotation_deg = rms_over(outcomes, &PnpOutcome::aligned_rotation_deg);
  row.expected_translation_m = rms_over(outcomes, &PnpOutcome::expected_translation_m);
  row.expected_rotation_deg = rms_over(outcomes, &PnpOutcome::expected_rotation_deg);
  for (const PnpOutcome& outcome : outcomes) row.bias_amplification += outcome.bias_amplification;
  row.bias_amplification /= static_cast<double>(outcomes.size());
  row.runs = outcomes.size();
  return row;
}

}  // namespace

const char* to_string(DepthLaw law) {
  switch (law) {
    case DepthLaw::uniform: return "uniform";
    case DepthLaw::volume: return "volume";
    case DepthLaw::inverse: return "inverse";
  }
  return "unknown";
}

nlohmann::ordered_json to_json(const PnpOptions& options) {
  std::vector<std::string> weightings;
  for (const Weighting weighting : options.weightings) weightings.emplace_back(to_string(weighting));
  return {{"experiment", "metrics"},
          {"seed", options.seed},
          {"points", options.points},
          {"noises_px", options.noises},
          {"sizes", options.sizes},
          {"weightings", weightings},
          {"map_bias_m", options.map_bias},
          {"map_deviation_m", options.map_deviation},
          {"prior", options.prior},
          {"depths", to_string(options.depths)},
          {"depth_m", {options.nearest, options.farthest}},
          {"translation_m", options.translation},
          {"rotation_deg", options.rotation_deg}};
}

void check(const PnpOptions& options) {
  const auto require = [](bool holds, const char* expected) {
    if (!holds) throw InputError(expected);
  };
  require(options.points >= 6 && options.points <= 2000, "--points: expected 6 to 2000");
  require(!options.sizes.empty() && !options.noises.empty() && !options.weightings.empty(),
          "--sizes, --noise, --weightings: expected at least one of each");
  for (const std::size_t size : options.sizes) {
    require(size >= 6 && size <= options.points, "--sizes: expected numbers from 6 to that of the points");
  }
  for (const double noise : options.noises)
    require(noise > 0 && noise <= 100, "--noise: expected numbers above 0 px, at most 100 px");
  require(std::abs(options.map_bias) <= 1, "--map-bias: expected at most 1 m");
  require(options.map_deviation > 0 && options.map_deviation <= 1,
          "--map-deviation: expected a number above 0 m, at most 1 m");
  require(options.nearest > 0.5 && options.farthest > options.nearest && options.farthest <= 1e4,
          "--nearest, --farthest: expected 0.5 m < nearest < farthest <= 10 km");
  require(options.translation >= 0 && options.translation <= 1, "a translation of 0 to 1 m along each axis");
  require(options.rotation_deg >= 0 && options.rotation_deg <= 20, "a rotation of 0 to 20 degrees about each axis");
  require(options.nearest + options.map_bias > 5 * options.map_deviation,
          "--map-bias, --map-deviation, --nearest: expected a map that stays in front of the camera");
  require(options.prior >= 1e-20 && options.prior <= 1e6, "--prior: expected a number from 1e-20 to 1e6");
}

std::vector<PnpCase> pnp_cases(const PnpOptions& options) {
  std::vector<PnpCase> cases;
  for (const double noise : options.noises) {
    for (const std::size_t size : options.sizes) {
      for (const Weighting weighting : options.weightings) {
        for (const GreedyMetric metric : greedy_metrics) {
          cases.push_back({noise, size, to_string(weighting), to_string(metric)});
        }
      }
      cases.push_back({noise, size, no_weighting, "random"});
    }
    cases.push_back({noise, options.points, no_weighting, "all"});
    cases.push_back({noise, options.points, no_weighting, "all_weighted"});
  }
  return cases;
}

std::vector<PnpOutcome> run_pnp(const PnpOptions& options, std::uint64_t run) {
  const Scene scene = draw_scene(options, run);
  std::map<double, PnpRun> by_noise;
  for (const double noise : options.noises) by_noise.emplace(noise, PnpRun(options, scene, noise));
  std::vector<PnpOutcome> outcomes;
  for (const PnpCase& which : pnp_cases(options)) outcomes.push_back(by_noise.at(which.noise_px).outcome(which));
  return outcomes;
}

Frame pnp_frame(const PnpOptions& options, std::uint64_t run) {
  Frame frame = frame_of(draw_scene(options, run), options.noises.front());
  frame.name = "run " + std::to_string(run);
  return frame;
}

std::vector<PnpRow> summarize(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs) {
  if (runs.empty()) return {};
  const std::vector<PnpCase> cases = pnp_cases(options);
  std::map<std::tuple<double, std::size_t, std::string, std::string>, PnpRow> rows;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    std::vector<PnpOutcome> outcomes;
    for (const auto& run : runs) outcomes.push_back(run.at(c));
    const PnpCase& which = cases[c];
    rows[{which.noise_px, which.size, which.weighting, which.selector}] = row_of(which, outcomes);
  }
  std::vector<PnpRow> table;
  const auto add = [&](double noise, std::size_t size, std::size_t size_of_case, const std::string& weighting,
                       const std::string& weighting_of_case, const std::string& selector) {
    table.push_back(rows.at({noise, size_of_case, weighting_of_case, selector}));
    table.back().which = {noise, size, weighting, selector};
  };
  for (const double noise : options.noises) {
    for (const Weighting weighting : options.weightings) {
      const std::string name = to_string(weighting);
      for (const std::size_t size : options.sizes) {
        for (const GreedyMetric metric : greedy_metrics) add(noise, size, size, name, name, to_string(metric));
        add(noise, size, size, name, no_weighting, "random");
        for (const char* const every : {"all", "all_weighted"}) {
          add(noise, size, options.points, name, no_weighting, every);
        }
      }
    }
  }
  return table;
}

nlohmann::json to_json(const std::vector<PnpOutcome>& outcomes) {
  nlohmann::json result = nlohmann::json::array();
  for (const PnpOutcome& o : outcomes) {
    result.push_back({o.translation_m, o.rotation_deg, o.aligned_translation_m, o.aligned_rotation_deg,
                      o.bias_amplification, o.expected_translation_m, o.expected_rotation_deg});
  }
  return result;
}

std::vector<PnpOutcome> pnp_outcomes_of(const nlohmann::json& result) {
  std::vector<PnpOutcome> outcomes;
  for (const nlohmann::json& o : result) {
    outcomes.push_back({number_of(o.at(0)), number_of(o.at(1)), number_of(o.at(2)), number_of(o.at(3)),
                        number_of(o.at(4)), number_of(o.at(5)), number_of(o.at(6))});
  }
  return outcomes;
}

}  // namespace maxlogdet::sim
