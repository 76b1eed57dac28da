// SPDX-License-Identifier: MIT
#include <maxlogdet/jacobian.hpp>

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

constexpr double rotation_tolerance = 1e-3;   // of R R^T - I: poses kept in float32 pass
constexpr double singular_ray_cosine = 1e-6;  // below it H_p^n has lost more digits than float32 has

bool is_positive(double value) noexcept { return value > 0 && std::isfinite(value); }

struct Vector3 {
  double x, y, z;
};

struct Pose {
  double r[3][3];
  double t[3];

  Vector3 transform(const double* p) const noexcept {
    return {r[0][0] * p[0] + r[0][1] * p[1] + r[0][2] * p[2] + t[0],
            r[1][0] * p[0] + r[1][1] * p[1] + r[1][2] * p[2] + t[1],
            r[2][0] * p[0] + r[2][1] * p[1] + r[2][2] * p[2] + t[2]};
  }
};

bool read_pose(const double* T_cw, Pose& pose) noexcept {
  if (T_cw == nullptr) return false;
  for (int i = 0; i < 12; ++i) {
    if (!std::isfinite(T_cw[i])) return false;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) pose.r[i][j] = T_cw[4 * i + j];
    pose.t[i] = T_cw[4 * i + 3];
  }
  const auto& r = pose.r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double dot = r[i][0] * r[j][0] + r[i][1] * r[j][1] + r[i][2] * r[j][2];
      if (std::abs(dot - (i == j ? 1 : 0)) > rotation_tolerance) return false;
    }
  }
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  return determinant > 0;
}

// J = d z / d p_c, `rows` x 3.
struct ProjectionJacobian {
  double j[max_block_rows][3];
  int rows;
};

ProjectionJacobian projection_jacobian(const PinholeCamera& camera, const Vector3& p, ThirdMeasurement third) noexcept {
  const double inverse_z = 1 / p.z;
  const double x = p.x * inverse_z;
  const double y = p.y * inverse_z;
  const double fx = camera.fx * inverse_z;
  const double fy = camera.fy * inverse_z;
  ProjectionJacobian result{{{fx, 0, -fx * x}, {0, fy, -fy * y}, {0, 0, 0}}, 2};
  if (third == ThirdMeasurement::stereo) {  // u_right = u - bf / Z
    result = {{{fx, 0, -fx * x}, {0, fy, -fy * y}, {fx, 0, -fx * x + camera.bf * inverse_z * inverse_z}}, 3};
  } else if (third == ThirdMeasurement::depth) {
    result = {{{fx, 0, -fx * x}, {0, fy, -fy * y}, {0, 0, 1}}, 3};
  }
  return result;
}

// block = factor (rows x 3) [ I | -[p]x ].
void times_point_jacobian(const double (*factor)[3], int rows, const Vector3& p, double (*block)[6]) noexcept {
  for (int row = 0; row < rows; ++row) {
    const double a = factor[row][0];
    const double b = factor[row][1];
    const double c = factor[row][2];
    block[row][0] = a;
    block[row][1] = b;
    block[row][2] = c;
    block[row][3] = c * p.y - b * p.z;
    block[row][4] = a * p.z - c * p.x;
    block[row][5] = b * p.x - a * p.y;
  }
}

struct Block {
  double h[max_block_rows][6];
  int rows;  // 0: none
};

constexpr Block no_block{{}, 0};

// H_c in the camera frame: H_p^n^-1 = [J; 0 0 1]^-1, and the row of zeros that the paper appends to H_x leaves
// [1 0 -X/Z; 0 1 -Y/Z; 0 0 0] of it. fx and fy cancel. With a third measurement J^-1 J = I is left.
Block map_bias_block(const Vector3& p, int rows) noexcept {
  Block block{{}, rows};
  const double x = p.x / p.z;
  const double y = p.y / p.z;
  const double monocular[2][3] = {{1, 0, -x}, {0, 1, -y}};
  const double identity[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  times_point_jacobian(rows == 2 ? monocular : identity, rows, p, block.h);
  return block;
}

// H_c in the world frame. H_c = B [I | -[p]x] where the columns of B solve [J R; e_3^T] B = [J; 0]: J (R B - I) = 0, so
// R B = I - p g^T, since p spans the null space of J; and e_3^T B = 0 gives g = R e_3 / (e_3^T R^T p), the world's z
// axis seen from the camera over the ray's share of it. So B = R^T (I - p g^T); singular where that share is zero.
Block map_bias_world_block(const Pose& pose, const Vector3& p, int rows, bool& is_singular) noexcept {
  const auto& r = pose.r;
  double g[3] = {0, 0, 0};
  if (rows == 2) {
    const double share = r[0][2] * p.x + r[1][2] * p.y + r[2][2] * p.z;
    is_singular = std::abs(share) < singular_ray_cosine * std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    if (is_singular) return no_block;
    for (int i = 0; i < 3; ++i) g[i] = r[i][2] / share;
  }
  const double point[3] = {p.x, p.y, p.z};
  double b[3][3];
  for (int i = 0; i < 3; ++i) {
    const double projected = r[0][i] * point[0] + r[1][i] * point[1] + r[2][i] * point[2];  // (R^T p)_i
    for (int j = 0; j < 3; ++j) b[i][j] = r[j][i] - projected * g[j];
  }
  Block block{{}, 3};
  times_point_jacobian(b, 3, p, block.h);
  return block;
}

// Solves C block = H_x by forward substitution, C C^T = covariance; no block if that is not positive definite.
Block whitened(const double (&covariance)[3][3], const Block& h_x) noexcept {
  Block block = h_x;
  double c[3][3] = {};
  for (int i = 0; i < h_x.rows; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = covariance[i][j];
      for (int d = 0; d < j; ++d) sum -= c[i][d] * c[j][d];
      if (i == j && !(sum > 0)) return no_block;
      c[i][j] = i == j ? std::sqrt(sum) : sum / c[j][j];
    }
    for (int column = 0; column < 6; ++column) {
      double sum = h_x.h[i][column];
      for (int d = 0; d < i; ++d) sum -= c[i][d] * block.h[d][column];
      block.h[i][column] = sum / c[i][i];
    }
  }
  return block;
}

// H_p Sigma_p H_p^T with H_p = J R and Sigma_p in the world frame; sigma^2 J J^T where no covariance is given.
void add_map_covariance(const Pose& pose, const ProjectionJacobian& j, const double* sigma_p, double map_sigma,
                        double (&covariance)[3][3]) noexcept {
  double h_p[3][3];
  for (int a = 0; a < j.rows; ++a) {
    for (int c = 0; c < 3; ++c) {
      h_p[a][c] = j.j[a][0] * pose.r[0][c] + j.j[a][1] * pose.r[1][c] + j.j[a][2] * pose.r[2][c];
    }
  }
  for (int a = 0; a < j.rows; ++a) {
    for (int b = 0; b < j.rows; ++b) {
      for (int c = 0; c < 3; ++c) {
        if (sigma_p == nullptr) {
          covariance[a][b] += map_sigma * map_sigma * h_p[a][c] * h_p[b][c];
        } else {
          for (int d = 0; d < 3; ++d) covariance[a][b] += h_p[a][c] * sigma_p[3 * c + d] * h_p[b][d];
        }
      }
    }
  }
}

BlockStatus check(const PinholeCamera& camera, const Matches& matches, const BlockOptions& options) noexcept {
  if (matches.size > 0 && matches.points == nullptr) return BlockStatus::missing_points;
  if (!is_positive(camera.fx) || !is_positive(camera.fy)) return BlockStatus::invalid_camera;
  if (options.third == ThirdMeasurement::stereo && !is_positive(camera.bf)) return BlockStatus::invalid_camera;
  if (!is_positive(options.depth_sigma) || !(options.map_sigma >= 0) || !std::isfinite(options.map_sigma)) {
    return BlockStatus::invalid_options;
  }
  if (options.weighting < Weighting::map_bias || options.weighting > Weighting::measurement_and_map ||
      options.third < ThirdMeasurement::none || options.third > ThirdMeasurement::depth) {
    return BlockStatus::invalid_options;
  }
  return BlockStatus::ok;
}

}  // namespace

BlockReport append_blocks(const PinholeCamera& camera, const double* T_cw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks) {
  BlockReport report;
  Pose pose;
  report.status = check(camera, matches, options);
  if (report.status == BlockStatus::ok && !read_pose(T_cw, pose)) report.status = BlockStatus::invalid_pose;
  if (report.status != BlockStatus::ok) return report;

  const std::size_t needed = blocks.size() + matches.size;
  if (needed > blocks.capacity()) blocks.reserve(std::max(needed, 2 * blocks.capacity()));
  const std::size_t invalid_before = blocks.invalid_count();
  for (std::size_t i = 0; i < matches.size; ++i) {
    if (matches.usable != nullptr && matches.usable[i] == 0) {
      blocks.push_back_invalid();
      continue;
    }
    const Vector3 p = pose.transform(matches.points + 3 * i);
    const double sigma = matches.sigmas == nullptr ? 1 : matches.sigmas[i];
    const double weight = matches.weights == nullptr ? 1 : matches.weights[i];
    if (p.z <= 0) ++report.behind_camera;
    const bool is_in_view = is_positive(p.z) && std::isfinite(p.x) && std::isfinite(p.y);
    if (!is_in_view || !is_positive(sigma) || !(weight >= 0)) {
      blocks.push_back_invalid();
      continue;
    }
    const bool has_third = matches.has_third == nullptr || matches.has_third[i] != 0;
    const ProjectionJacobian j = projection_jacobian(camera, p, has_third ? options.third : ThirdMeasurement::none);
    const double third_sigma = options.third == ThirdMeasurement::depth ? options.depth_sigma : sigma;
    const double sigmas[3] = {sigma, sigma, third_sigma};

    Block block{{}, j.rows};
    bool is_singular = false;
    switch (options.weighting) {
      case Weighting::map_bias: block = map_bias_block(p, j.rows); break;
      case Weighting::map_bias_world: block = map_bias_world_block(pose, p, j.rows, is_singular); break;
      case Weighting::measurement:
      case Weighting::measurement_and_map: {
        double covariance[3][3] = {};
        for (int row = 0; row < j.rows; ++row) covariance[row][row] = sigmas[row] * sigmas[row];
        if (options.weighting == Weighting::measurement_and_map) {
          const double* const sigma_p = matches.map_covariances == nullptr ? nullptr : matches.map_covariances + 9 * i;
          add_map_covariance(pose, j, sigma_p, options.map_sigma, covariance);
        }
        times_point_jacobian(j.j, j.rows, p, block.h);
        block = whitened(covariance, block);
        break;
      }
    }
    if (is_singular) ++report.singular_rays;
    const double root_weight = std::sqrt(weight);
    for (int row = 0; row < block.rows; ++row) {
      for (double& entry : block.h[row]) entry *= root_weight;
    }
    blocks.push_back(&block.h[0][0], block.rows);
  }
  report.appended = matches.size;
  report.invalid = blocks.invalid_count() - invalid_before;
  if (report.singular_rays > 0) report.status = BlockStatus::singular_rays;
  return report;
}

const char* to_string(Weighting weighting) noexcept {
  switch (weighting) {
    case Weighting::map_bias: return "map_bias";
    case Weighting::map_bias_world: return "map_bias_world";
    case Weighting::measurement: return "measurement";
    case Weighting::measurement_and_map: return "measurement_and_map";
  }
  return "unknown";
}

const char* to_string(BlockStatus status) noexcept {
  switch (status) {
    case BlockStatus::ok: return "ok";
    case BlockStatus::singular_rays: return "singular_rays";
    case BlockStatus::invalid_camera: return "invalid_camera";
    case BlockStatus::invalid_pose: return "invalid_pose";
    case BlockStatus::invalid_options: return "invalid_options";
    case BlockStatus::missing_points: return "missing_points";
  }
  return "unknown";
}

}  // namespace maxlogdet
