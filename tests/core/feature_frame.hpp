// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/good_features.hpp>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <vector>

namespace maxlogdet {

inline void PrintTo(AlignmentStatus status, std::ostream* out) { *out << to_string(status); }
inline void PrintTo(Warning warning, std::ostream* out) { *out << to_string(warning); }

}  // namespace maxlogdet

namespace maxlogdet::test {

using Isometry = Eigen::Isometry3d;

inline RigidTransform rows_of(const Isometry& T) { return RigidTransform(T.matrix()); }

constexpr double bf_of_typical = 50, shift_of_typical = 32;  // its baseline times fx, and its shift_of_right

/// A camera of that model with parameters that are common.
inline Camera typical_camera(CameraModel model) {
  const PinholeCamera pinhole = {458, 457, 367, 248, bf_of_typical, 367 + shift_of_typical};
  switch (model) {
    case CameraModel::radial_tangential: return Camera::radial_tangential(pinhole, -0.05, 0.01, 2e-4, -1e-4, 1e-3);
    case CameraModel::kannala_brandt: return Camera::kannala_brandt(pinhole, -0.01, 0.02, -0.003, 0.0004);
    case CameraModel::pinhole: break;
  }
  return pinhole;
}

/// What the matches of a frame have.
struct FeatureKind {
  CameraModel model = CameraModel::pinhole;
  DepthCue depth_cue = DepthCue::none;
  bool has_rig = false;
  enum class Covariances { none, some, all } covariances = Covariances::none;
};

inline FeatureKind random_kind(Random& random) {
  FeatureKind kind;
  kind.model = random_model(random);
  kind.depth_cue = kind.model == CameraModel::pinhole ? DepthCue(random.integer(0, 2)) : DepthCue::none;
  kind.has_rig = random.chance(0.3);
  kind.covariances = FeatureKind::Covariances(random.integer(0, 2));
  return kind;
}

/// The same matches as GoodFeatures and as append_blocks take them. Some points are behind the camera, some have no
/// third measurement. Measurements are what the camera sees, off by up to five deviations.
struct FeatureFrame {
  FeatureFrame(Random& random, std::size_t n, const FeatureKind& what = FeatureKind())
      : kind(what), T_cw(random_isometry(random, 2, 1)) {
    options.map_sigma = 0.11;
    options.depth_sigma = 0.07;
    const bool is_stereo = kind.depth_cue == DepthCue::stereo;
    cameras[0] = typical_camera(kind.model);
    cameras[1] = typical_camera(is_stereo ? kind.model : CameraModel::kannala_brandt);
    for (Isometry& T : T_cb) T = random_isometry(random, 0.2, 0.2);
    for (std::size_t c = 0; c < 2 && kind.has_rig; ++c) cameras[c].T_cb = rows_of(T_cb[c]);
    for (std::size_t i = 0; i < n; ++i) add(random, i);
  }

  std::size_t camera_of_match(std::size_t i) const { return kind.has_rig ? i % 2 : 0; }
  Eigen::Vector3d point(std::size_t i) const { return Eigen::Vector3d(&points[3 * i]); }
  template <class AnyIsometry>
  WideVector3 in_camera(std::size_t i, const AnyIsometry& pose) const {
    const WideVector3 p = pose.template cast<long double>() * point(i).cast<long double>();
    return kind.has_rig ? WideVector3(T_cb[camera_of_match(i)].cast<long double>() * p) : p;
  }

  /// start() alone, and start() and add() of every match.
  void start(GoodFeatures& good) const {
    good.rejects_outliers = rejects_outliers;
    good.block_options = options;
    if (kind.has_rig) {
      good.start(cameras, 2, rows_of(T_cw));
    } else {
      good.start(cameras[0], rows_of(T_cw));
    }
  }
  void gather(GoodFeatures& good) const {
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

  /// Makes a share of the matches odd: numbers of no use, unknown cameras, measurements or cues that are missing; and
  /// some required.
  void make_odd(Random& random, double share) {
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (random.chance(share)) make_one_odd(random, i);
    }
  }

  /// The matches as append_blocks takes them, and the blocks that it makes. Those that are not usable have no point,
  /// and set nothing for the others.
  std::vector<FeatureMatch> records() const {
    std::vector<FeatureMatch> all = matches;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (usable[i] == 0) all[i].point[0] = nan;
      if (knows_covariance[i] != 0) all[i].covariance = &covariances[9 * i];
    }
    return all;
  }
  BlockReport append(const std::vector<FeatureMatch>& given, BlockStore& store) const {
    return append_blocks(cameras, kind.has_rig ? 2 : 1, rows_of(T_cw), given.data(), given.size(), options, store);
  }
  BlockStore blocks() const {
    BlockStore store(matches.size());
    EXPECT_TRUE(append(records(), store).error == Error::none);
    return store;
  }

  /// Residuals of match i at `pose`: u, v and the third measurement; and their squares in units of their deviations,
  /// infinite behind the camera. In long double.
  template <class AnyIsometry>
  WideVector3 residuals(std::size_t i, const AnyIsometry& pose) const {
    const WideVector3 p = in_camera(i, pose);
    const WideVector2 uv = image_of(cameras[camera_of_match(i)], p);
    const bool is_depth = kind.depth_cue == DepthCue::depth;
    const long double depth_cue = is_depth ? p.z() : uv.x() - bf_of_typical / p.z() + shift_of_typical;
    const FeatureMatch& match = matches[i];
    return {match.measured[0] - uv.x(), match.measured[1] - uv.y(),
            (is_depth ? match.depth : match.u_right) - depth_cue};
  }
  /// Whether a match that sets what the frame has knows the covariance of its point: then all count.
  bool has_covariances() const {
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (usable[i] != 0 && knows_covariance[i] != 0) return true;
    }
    return false;
  }
  /// Sigma of the residuals of match i at `pose`.
  WideMatrix noise(std::size_t i, const WideIsometry& pose) const {
    const double of_third = kind.depth_cue == DepthCue::depth ? options.depth_sigma : sigmas[i];
    const WideMatrix measured = WideVector3(sigmas[i], sigmas[i], of_third).cwiseAbs2().asDiagonal();
    if (!has_covariances()) return measured;
    const WideMatrix J = differentiate(3, [&](const WideVector& by) -> WideVector {
      WideIsometry shifted = pose;
      shifted.translate(WideVector3(by));
      return residuals(i, shifted);
    });
    const Eigen::Map<const Eigen::Matrix3d> of_map(&covariances[9 * i]);
    return measured + wide_product(wide_product(J, of_map.cast<long double>()), J.transpose());
  }
  /// e^T Sigma^-1 e; infinite behind the camera.
  long double chi2(std::size_t i, const Isometry& at) const {
    const WideIsometry pose = at.cast<long double>();
    if (!(in_camera(i, pose).z() > 0)) return infinity;
    const int rows = has_depth_cue[i] == 0 ? 2 : 3;
    const WideMatrix e = residuals(i, pose).head(rows), S = noise(i, pose).topLeftCorner(rows, rows);
    return wide_product(e.transpose(), wide_product(wide_inverse(S), e))(0, 0);
  }

  FeatureKind kind;
  bool rejects_outliers = false;  // of GoodFeatures
  Isometry T_cw;
  Isometry T_cb[2];
  Camera cameras[2];
  BlockOptions options;
  std::vector<FeatureMatch> matches;
  std::vector<double> points, sigmas, covariances;
  std::vector<unsigned char> has_depth_cue, knows_covariance;
  std::vector<unsigned char> usable;  // by the rules of GoodFeatures::select

 private:
  void add(Random& random, std::size_t i) {
    const std::size_t c = camera_of_match(i);
    const double z = random.chance(0.05) ? -3 : random.uniform(1, 20);
    const Eigen::Vector3d p_c(random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z);
    const Eigen::Vector3d p_b = kind.has_rig ? Eigen::Vector3d(T_cb[c].inverse() * p_c) : p_c;
    const Eigen::Vector3d p_w = T_cw.inverse() * p_b;
    points.insert(points.end(), p_w.data(), p_w.data() + 3);
    sigmas.push_back(random.uniform(0.5, 3));
    has_depth_cue.push_back(kind.depth_cue != DepthCue::none && random.chance(0.6) ? 1 : 0);
    add_covariance(random);

    FeatureMatch match;
    match.id = static_cast<std::uint32_t>(1000 + i);
    for (int d = 0; d < 3; ++d) match.point[d] = p_w(d);
    match.sigma = sigmas.back();
    match.camera_id = static_cast<std::uint8_t>(c);
    measure(random, p_c, match);
    if (!(match.u_right >= 0 || match.depth > 0)) has_depth_cue.back() = 0;  // as outside of the right image
    matches.push_back(match);
    usable.push_back(1);
  }

  // A match without a covariance gets that of the options' map_sigma.
  void add_covariance(Random& random) {
    const bool is_known = kind.covariances == FeatureKind::Covariances::all ||
                          (kind.covariances == FeatureKind::Covariances::some && random.chance(0.5));
    Eigen::Vector3d deviations = Eigen::Vector3d::Constant(0.05) + 0.1 * random_vector(random, 1);
    if (!is_known) deviations = Eigen::Vector3d::Constant(options.map_sigma);
    const Eigen::Matrix3d covariance = deviations.cwiseAbs2().asDiagonal();
    covariances.insert(covariances.end(), covariance.data(), covariance.data() + 9);
    knows_covariance.push_back(is_known ? 1 : 0);
  }

  void measure(Random& random, const Eigen::Vector3d& p_c, FeatureMatch& match) const {
    const WideVector2 uv = image_of(cameras[match.camera_id], p_c.cast<long double>());
    for (int axis = 0; axis < 2; ++axis) {
      match.measured[axis] = static_cast<double>(uv(axis)) + random.uniform(-5, 5) * match.sigma;
    }
    if (has_depth_cue.back() == 0) return;
    if (kind.depth_cue == DepthCue::depth) {
      match.depth = p_c.z() + random.uniform(-5, 5) * options.depth_sigma;
    } else {
      const double right = static_cast<double>(uv.x()) - bf_of_typical / p_c.z() + shift_of_typical;
      match.u_right = right + random.uniform(-5, 5) * match.sigma;
    }
  }

  void make_one_odd(Random& random, std::size_t i) {
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
};

/// A frame, and what has gathered its matches.
struct Gathered {
  explicit Gathered(std::size_t n) : frame(random, n), good(n) { frame.gather(good); }

  TracedRandom random;
  FeatureFrame frame;
  GoodFeatures good;
};

/// Calls test(random, frame) with `count` frames of n matches, of all kinds.
template <class Test>
void for_frames_of_all_kinds(std::size_t count, std::size_t n, const Test& test) {
  for (std::uint64_t variation = 0; variation < count && !::testing::Test::HasFatalFailure(); ++variation) {
    TracedRandom random(variation);
    const FeatureKind kind = random_kind(random);
    test(random, FeatureFrame(random, n, kind));
  }
}

/// The numbers of the selected matches in ascending order.
inline std::vector<std::uint32_t> selected_of(const GoodFeatures& good) {
  std::vector<std::uint32_t> selected;
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (good.is_selected(i)) selected.push_back(static_cast<std::uint32_t>(i));
  }
  return selected;
}

/// Normal errors of `noise` deviations of pixels and points, a predicted pose that is off, and the pose that the
/// measurements are of.
struct Scene {
  Scene(Random& random, std::size_t n, const FeatureKind& kind = FeatureKind(), double noise = 1, double metres = 0.05,
        double radians = 0.01)
      : frame(random, n, kind), T_true(frame.T_cw), is_wrong(n) {
    frame.rejects_outliers = true;
    for (std::size_t i = 0; i < n; ++i) {
      measure(random, i, noise);
      for (std::size_t d = 0; d < 3 && kind.covariances != FeatureKind::Covariances::none; ++d) {
        const double deviation = std::sqrt(frame.covariances[9 * i + 4 * d]);  // the covariances are diagonal
        frame.points[3 * i + d] += noise * deviation * normal(random);
        frame.matches[i].point[d] = frame.points[3 * i + d];
      }
    }
    frame.T_cw = random_isometry(random, metres, radians) * T_true;
  }

  void measure(Random& random, std::size_t i, double noise) {
    FeatureMatch& match = frame.matches[i];
    const Eigen::Vector3d e = frame.residuals(i, T_true).cast<double>();  // z <- z - e: exact
    for (int d = 0; d < 2; ++d) match.measured[d] += noise * match.sigma * normal(random) - e(d);
    if (match.u_right >= 0) match.u_right += noise * match.sigma * normal(random) - e.z();
    if (match.depth > 0) match.depth += noise * frame.options.depth_sigma * normal(random) - e.z();
  }

  /// Moves measurements of a share of the matches by 8 to 60 sigmas.
  void spoil(Random& random, double share) {
    for (std::size_t i = 0; i < is_wrong.size(); ++i) {
      if (!random.chance(share)) continue;
      const double angle = random.uniform(-3.14, 3.14);
      const double length = random.uniform(8, 60) * frame.sigmas[i];
      frame.matches[i].measured[0] += length * std::cos(angle);
      frame.matches[i].measured[1] += length * std::sin(angle);
      is_wrong[i] = true;
    }
  }

  bool is_in_front(std::size_t i) const { return frame.in_camera(i, T_true).z() > 0.5L; }

  FeatureFrame frame;
  Isometry T_true;
  std::vector<bool> is_wrong;
};

inline Isometry pose_of(const GoodFeatures& good) { return good.pose(); }

inline Matrix6 information_of(const GoodFeatures& good) { return Eigen::Map<const Matrix6>(good.pose_information()); }

}  // namespace maxlogdet::test
