// SPDX-License-Identifier: MIT
#include "tests/core/feature_frame.hpp"

#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

constexpr double bf = 50;
constexpr double shift_of_right = 32;

}  // namespace

RigidTransform rows_of(const Isometry& T) { return RigidTransform(T.matrix()); }

Camera typical_camera(CameraModel model) {
  const PinholeCamera pinhole = {458, 457, 367, 248, bf, 367 + shift_of_right};
  switch (model) {
    case CameraModel::radial_tangential: return Camera::radial_tangential(pinhole, -0.05, 0.01, 2e-4, -1e-4, 1e-3);
    case CameraModel::kannala_brandt: return Camera::kannala_brandt(pinhole, -0.01, 0.02, -0.003, 0.0004);
    case CameraModel::double_sphere: return Camera::double_sphere(pinhole, -0.2, 0.6);
    case CameraModel::pinhole: break;
  }
  return pinhole;
}

FeatureKind random_kind(Random& random) {
  FeatureKind kind;
  kind.model = random_model(random);
  kind.depth_cue = kind.model == CameraModel::pinhole ? DepthCue(random.integer(0, 2)) : DepthCue::none;
  kind.has_rig = random.chance(0.3);
  kind.covariances = FeatureKind::Covariances(random.integer(0, 2));
  return kind;
}

FeatureFrame::FeatureFrame(Random& random, std::size_t n, const FeatureKind& what)
    : kind(what), T_cw(random_isometry(random, 2, 1)) {
  options.depth_cue = kind.depth_cue;
  options.map_sigma = 0.11;
  options.depth_sigma = 0.07;
  const bool is_stereo = kind.depth_cue == DepthCue::stereo;
  cameras[0] = typical_camera(kind.model);
  cameras[1] = typical_camera(is_stereo ? kind.model : CameraModel::double_sphere);
  for (Isometry& T : T_cb) T = random_isometry(random, 0.2, 0.2);
  for (std::size_t c = 0; c < 2 && kind.has_rig; ++c) cameras[c].T_cb = rows_of(T_cb[c]);
  for (std::size_t i = 0; i < n; ++i) add(random, i);
}

void FeatureFrame::add(Random& random, std::size_t i) {
  const std::size_t c = camera_of_match(i);
  const double z = random.chance(0.05) ? -3 : random.uniform(1, 20);
  const Eigen::Vector3d p_c(random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z);
  const Eigen::Vector3d p_b = kind.has_rig ? Eigen::Vector3d(T_cb[c].inverse() * p_c) : p_c;
  const Eigen::Vector3d p_w = T_cw.inverse() * p_b;
  points.insert(points.end(), p_w.data(), p_w.data() + 3);
  sigmas.push_back(random.uniform(0.5, 3));
  camera_ids.push_back(static_cast<unsigned char>(c));
  has_depth_cue.push_back(kind.depth_cue != DepthCue::none && random.chance(0.6) ? 1 : 0);
  add_covariance(random);

  FeatureMatch match;
  match.id = static_cast<std::uint32_t>(1000 + i);
  for (int d = 0; d < 3; ++d) match.point[d] = p_w(d);
  match.sigma = sigmas.back();
  match.camera_id = camera_ids.back();
  measure(random, p_c, match);
  if (!(match.u_right >= 0 || match.depth > 0)) has_depth_cue.back() = 0;  // as outside of the right image
  matches.push_back(match);
  usable.push_back(1);
}

// A match without a covariance gets that of the options' map_sigma.
void FeatureFrame::add_covariance(Random& random) {
  const bool is_known = kind.covariances == FeatureKind::Covariances::all ||
                        (kind.covariances == FeatureKind::Covariances::some && random.chance(0.5));
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d root = identity * 0.05 + 0.1 * Eigen::Matrix3d(random_vector(random, 1).asDiagonal());
  const Eigen::Matrix3d covariance = is_known ? Eigen::Matrix3d(root * root.transpose())
                                              : Eigen::Matrix3d(options.map_sigma * options.map_sigma * identity);
  covariances.insert(covariances.end(), covariance.data(), covariance.data() + 9);
  knows_covariance.push_back(is_known ? 1 : 0);
}

void FeatureFrame::measure(Random& random, const Eigen::Vector3d& p_c, FeatureMatch& match) const {
  const WideVector2 uv = image_of(cameras[match.camera_id], p_c.cast<long double>());
  for (int axis = 0; axis < 2; ++axis) {
    match.measured[axis] = static_cast<double>(uv(axis)) + random.uniform(-5, 5) * match.sigma;
  }
  if (has_depth_cue.back() == 0) return;
  const bool is_depth = kind.depth_cue == DepthCue::depth;
  if (is_depth) {
    match.depth = p_c.z() + random.uniform(-5, 5) * options.depth_sigma;
  } else {
    const double right = static_cast<double>(uv.x()) - bf / p_c.z() + shift_of_right;
    match.u_right = right + random.uniform(-5, 5) * match.sigma;
  }
}

void FeatureFrame::make_odd(Random& random, std::size_t i) {
  FeatureMatch& match = matches[i];
  const double broken[] = {nan, infinity, -infinity};
  const double sigmas_of_no_use[] = {0, -1, nan, infinity, 1e-16, 1e16};
  const int kind_of_odd = random.integer(0, 6);
  switch (kind_of_odd) {
    case 0: {
      const std::size_t d = random.index(3);
      match.point[d] = points[3 * i + d] = broken[random.integer(0, 2)];
      break;
    }
    case 1: match.measured[random.integer(0, 1)] = broken[random.integer(0, 2)]; break;
    case 2: match.sigma = sigmas[i] = sigmas_of_no_use[random.integer(0, 5)]; break;
    case 3: match.camera_id = static_cast<std::uint8_t>(random.chance(0.5) ? 255 : (kind.has_rig ? 2 : 1)); break;
    case 4: match.measured[0] = match.measured[1] = unmeasured; break;
    case 5:
      match.u_right = random.chance(0.5) ? -1 : broken[random.integer(0, 2)];
      match.depth = random.chance(0.5) ? 0 : broken[random.integer(0, 2)];
      has_depth_cue[i] = 0;
      break;
    default: match.is_required = true;
  }
  if (kind_of_odd > 3) return;
  usable[i] = 0;
  if (random.chance(0.5)) match.u_right = match.depth = 3;  // which then sets nothing for the others
  if (random.chance(0.5)) knows_covariance[i] = 1;
}

void FeatureFrame::make_odd(Random& random, double share) {
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (random.chance(share)) make_odd(random, i);
  }
}

Eigen::Vector3d FeatureFrame::point(std::size_t i) const {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

WideVector3 FeatureFrame::in_camera(std::size_t i, const Isometry& pose) const {
  Eigen::Vector3d p = pose * point(i);
  if (kind.has_rig) p = T_cb[camera_of_match(i)] * p;
  return p.cast<long double>();
}

void FeatureFrame::start(GoodFeatures& good) const {
  good.rejects_outliers = rejects_outliers;
  good.block_options = options;
  good.block_options.depth_cue = DepthCue::none;  // the matches say which
  if (kind.has_rig) {
    good.start(cameras, 2, rows_of(T_cw));
  } else {
    good.start(cameras[0], rows_of(T_cw));
  }
}

void FeatureFrame::gather(GoodFeatures& good) const {
  start(good);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    FeatureMatch match = matches[i];
    double covariance[9];  // copied by add()
    std::copy_n(&covariances[9 * i], 9, covariance);
    if (knows_covariance[i] != 0) match.covariance = covariance;
    good.add(match);
    std::fill_n(covariance, 9, nan);
  }
}

Matches FeatureFrame::arrays() const {
  Matches arrays;
  arrays.size = matches.size();
  arrays.points = points.data();
  arrays.sigmas = sigmas.data();
  arrays.has_depth_cue = has_depth_cue.data();
  arrays.usable = usable.data();
  if (kind.has_rig) arrays.camera_ids = camera_ids.data();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (usable[i] != 0 && knows_covariance[i] != 0) arrays.map_covariances = covariances.data();
  }
  return arrays;
}

BlockOptions FeatureFrame::options_of_blocks() const {
  BlockOptions of_blocks = options;
  if (arrays().map_covariances != nullptr) of_blocks.weighting = with_covariances(options.weighting);
  return of_blocks;
}

BlockStore FeatureFrame::blocks() const {
  const Matches given = arrays();
  const BlockOptions block_options = options_of_blocks();
  BlockStore store(matches.size());
  const BlockReport report = kind.has_rig ? append_blocks(cameras, 2, rows_of(T_cw), given, block_options, store)
                                          : append_blocks(cameras[0], rows_of(T_cw), given, block_options, store);
  EXPECT_TRUE(report.error == Error::none);
  return store;
}

WideVector3 FeatureFrame::residuals(std::size_t i, const Isometry& pose) const {
  return residuals_of(i, in_camera(i, pose));
}

WideVector3 FeatureFrame::residuals_of(std::size_t i, const WideVector3& p) const {
  const WideVector2 uv = image_of(cameras[camera_of_match(i)], p);
  const long double depth_cue = kind.depth_cue == DepthCue::depth ? p.z() : uv.x() - bf / p.z() + shift_of_right;
  const FeatureMatch& match = matches[i];
  const long double measured = kind.depth_cue == DepthCue::depth ? match.depth : match.u_right;
  return {match.measured[0] - uv.x(), match.measured[1] - uv.y(), measured - depth_cue};
}

long double FeatureFrame::chi2(std::size_t i, const Isometry& pose) const {
  if (!(in_camera(i, pose).z() > 0)) return infinity;
  const double sigma_of_third = kind.depth_cue == DepthCue::depth ? options.depth_sigma : sigmas[i];
  const WideVector3 e = residuals(i, pose);
  const long double of_image = std::pow(e.x() / sigmas[i], 2) + std::pow(e.y() / sigmas[i], 2);
  return has_depth_cue[i] == 0 ? of_image : of_image + std::pow(e.z() / sigma_of_third, 2);
}

std::vector<std::uint32_t> selected_of(const GoodFeatures& good) {
  std::vector<std::uint32_t> selected;
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (good.is_selected(i)) selected.push_back(static_cast<std::uint32_t>(i));
  }
  return selected;
}

}  // namespace maxlogdet::test
