// SPDX-License-Identifier: MIT
#include "bench/world/scene.hpp"

#include "bench/world/draws.hpp"

#include <cmath>

namespace maxlogdet::sim {
namespace {

// Arithmetic here is limited to what IEEE 754 rounds exactly (no sin, log, ...), so that every machine makes the same
// frame to the last bit.

struct Camera {
  PinholeCamera pinhole;
  int width;
  int height;
};

constexpr Camera euroc_stereo{
    {euroc_camera.fx, euroc_camera.fy, euroc_camera.cx, euroc_camera.cy, euroc_camera.fx * 0.11},
    euroc_width,
    euroc_height};
constexpr Camera kitti_stereo{{707.0912, 707.0912, 601.8873, 183.1104, 379.8145}, 1226, 370};

// The image region and the depths of the matches of a scene.
struct Region {
  Camera camera;
  double u_min, u_max, v_min, v_max;  // px
  double near, far;                   // m; inverse depth is uniform between them
  int clusters;                       // 0: none
};

Region region_of(Scene scene) {
  constexpr double border = 16;  // px, where ORB finds no corners
  const Camera& c = scene == Scene::kitti_like ? kitti_stereo : euroc_stereo;
  Region region{c, border, c.width - border, border, c.height - border, 2, 20, 0};
  if (scene == Scene::kitti_like) {
    region.near = 5;
    region.far = 100;
  } else if (scene == Scene::far_narrow) {
    region = {c, c.pinhole.cx - 48, c.pinhole.cx + 48, c.pinhole.cy - 48, c.pinhole.cy + 48, 50, 500, 0};
  } else if (scene == Scene::clustered) {
    region.clusters = 20;
  }
  return region;
}

struct Place {
  double u, v, inverse_depth;
};

Place draw_place(const Region& region, Draws& random) {
  const double u = random.uniform(region.u_min, region.u_max);
  const double v = random.uniform(region.v_min, region.v_max);
  return {u, v, random.uniform(1 / region.far, 1 / region.near)};
}

Place draw_place(const Region& region, const std::vector<Place>& clusters, Draws& random) {
  if (clusters.empty()) return draw_place(region, random);
  Place place = clusters[random.below(clusters.size())];
  place.u += random.uniform(-2, 2);
  place.v += random.uniform(-2, 2);
  return place;
}

// Returns a camera pose: looking along the horizontal of a z-up world, turned by up to about 30 degrees about any axis.
std::array<double, 12> random_pose(Draws& random) {
  double q[4] = {1, 0, 0, 0};
  for (int i = 1; i < 4; ++i) q[i] = random.uniform(-0.15, 0.15);
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& entry : q) entry /= norm;
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  // World x forward, y left, z up, seen by a camera with x right, y down, z forward.
  constexpr int axis[3] = {1, 2, 0};
  constexpr double sign[3] = {-1, -1, 1};
  std::array<double, 12> T_cw{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) T_cw[4 * i + static_cast<std::size_t>(axis[j])] = turn[i][j] * sign[j];
    T_cw[4 * i + 3] = random.uniform(-2, 2);
  }
  return T_cw;
}

// ORB spreads its features over the levels in proportion to their scale: 1.2^-octave.
int random_octave(Draws& random) {
  double left = random.uniform(0, 1);
  double share = (1 - 1 / 1.2) / (1 - 1 / (1.2 * 1.2 * 1.2 * 1.2 * 1.2 * 1.2 * 1.2 * 1.2));
  int octave = 0;
  while (octave < 7 && left >= share) {
    left -= share;
    share /= 1.2;
    ++octave;
  }
  return octave;
}

// p_w = R^T (p_c - t)
void set_point(const Frame& frame, const Place& at, Match& match) {
  const PinholeCamera& camera = frame.camera;
  const double z = 1 / at.inverse_depth;
  const double p_c[3] = {(at.u - camera.cx) / camera.fx * z, (at.v - camera.cy) / camera.fy * z, z};
  const auto& t = frame.T_cw_prior;
  for (std::size_t j = 0; j < 3; ++j) {
    match.point[j] = 0;
    for (std::size_t d = 0; d < 3; ++d) match.point[j] += t[4 * d + j] * (p_c[d] - t[4 * d + 3]);
  }
}

Match match_at(const Frame& frame, const Place& at, std::size_t number, Draws& random) {
  Match match;
  match.keypoint = match.map_point_id = static_cast<std::int64_t>(number);
  set_point(frame, at, match);
  match.u = at.u;
  match.v = at.v;
  match.octave = random_octave(random);
  for (int level = 0; level < match.octave; ++level) match.inv_sigma2 /= 1.2 * 1.2;
  match.desc_dist = random.below(100);
  const double disparity = frame.camera.bf * at.inverse_depth;
  if (disparity >= 2 && at.u >= disparity) match.u_right = at.u - disparity;
  return match;
}

}  // namespace

std::string to_string(Scene scene) {
  switch (scene) {
    case Scene::euroc_like: return "euroc_like";
    case Scene::kitti_like: return "kitti_like";
    case Scene::far_narrow: return "far_narrow";
    case Scene::clustered: return "clustered";
  }
  return "unknown";
}

Frame make_scene(Scene scene, std::size_t n, std::uint64_t seed) {
  Draws random(seed);
  const Region region = region_of(scene);
  Frame frame;
  frame.name = to_string(scene) + "_" + std::to_string(seed);
  frame.camera = region.camera.pinhole;
  frame.width = region.camera.width;
  frame.height = region.camera.height;
  frame.T_cw_prior = random_pose(random);
  std::vector<Place> clusters;
  for (int i = 0; i < region.clusters; ++i) clusters.push_back(draw_place(region, random));
  frame.matches.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Place at = draw_place(region, clusters, random);
    frame.matches.push_back(match_at(frame, at, i, random));
  }
  return frame;
}

}  // namespace maxlogdet::sim
