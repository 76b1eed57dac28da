// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pnp_scene.hpp"

#include "bench/does_the_paper_hold/trajectory_error.hpp"
#include "bench/world/angles.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/names.hpp"

#include <cmath>
#include <numeric>

namespace maxlogdet::sim {
namespace {

double draw_depth(const PnpOptions& options, Draws& draws) {
  const double near = options.nearest, far = options.farthest;
  switch (options.depths) {
    case DepthLaw::volume: return std::cbrt(draws.uniform(near * near * near, far * far * far));
    case DepthLaw::inverse: return 1 / draws.uniform(1 / far, 1 / near);
    default: return draws.uniform(near, far);
  }
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
  return {{"experiment", "metrics"},
          {"seed", options.seed},
          {"points", options.points},
          {"noises_px", options.noises},
          {"sizes", options.sizes},
          {"weightings", names_of(options.weightings)},
          {"map_bias_m", options.map_bias},
          {"map_deviation_m", options.map_deviation},
          {"prior", options.prior},
          {"depths", to_string(options.depths)},
          {"depth_m", {options.nearest, options.farthest}},
          {"translation_m", options.translation},
          {"rotation_deg", options.rotation_deg}};
}

void check(const PnpOptions& options) {
  require_input(options.points >= 6 && options.points <= 2000, "--points: expected 6 to 2000");
  require_input(!options.sizes.empty() && !options.noises.empty() && !options.weightings.empty(),
                "--sizes, --noise, --weightings: expected at least one of each");
  for (const std::size_t size : options.sizes) {
    require_input(size >= 6 && size <= options.points, "--sizes: expected numbers from 6 to that of the points");
  }
  for (const double noise : options.noises)
    require_input(noise > 0 && noise <= 100, "--noise: expected numbers above 0 px, at most 100 px");
  require_input(std::abs(options.map_bias) <= 1, "--map-bias: expected -1 to 1 m");
  require_input(options.map_deviation > 0 && options.map_deviation <= 1,
                "--map-deviation: expected a number above 0 m, at most 1 m");
  require_input(options.nearest > 0.5 && options.farthest > options.nearest && options.farthest <= 1e4,
                "--nearest, --farthest: expected 0.5 m < nearest < farthest <= 10 km");
  require_input(options.translation >= 0 && options.translation <= 1, "a translation of 0 to 1 m along each axis");
  require_input(options.rotation_deg >= 0 && options.rotation_deg <= 20,
                "a rotation of 0 to 20 degrees about each axis");
  require_input(options.nearest + options.map_bias > 5 * options.map_deviation,
                "--map-bias, --map-deviation, --nearest: expected a map that stays in front of the camera");
  require_input(options.prior >= 1e-20 && options.prior <= 1e6, "--prior: expected a number from 1e-20 to 1e6");
}

PnpScene draw_scene(const PnpOptions& options, std::uint64_t run) {
  Draws draws(options.seed, run);
  PnpScene scene;
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

Frame frame_of(const PnpScene& scene, double noise_px) {
  Frame frame;
  frame.camera = scene.camera;
  frame.width = euroc_width;
  frame.height = euroc_height;
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

}  // namespace maxlogdet::sim
