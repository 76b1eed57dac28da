// SPDX-License-Identifier: MIT
#include "tests/api/integration/orb_slam2_world.hpp"

#include "sim/outlier_rejection.hpp"
#include "tests/support/linear_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ORB_SLAM2 {

float Frame::fx = 458;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::fy = 457;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cx = 367;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cy = 248;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

// With every match that is not null, whatever its flag; sets flags and the pose.
int Optimizer::PoseOptimization(Frame* pFrame) {
  using namespace maxlogdet::sim;
  maxlogdet::test::calls.optimised.clear();
  ++maxlogdet::test::calls.optimiser_calls;
  std::vector<Match> matches;
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr) continue;
    pFrame->mvbOutlier[i] = false;
    maxlogdet::test::calls.optimised.push_back(i);
    matches.push_back(maxlogdet::test::match_of(*pFrame, i));
  }
  if (matches.size() < 3 || pFrame->mTcw.empty()) return 0;
  std::vector<std::uint32_t> all(matches.size());
  std::iota(all.begin(), all.end(), 0U);
  const Rejection rejection = reject_outliers(maxlogdet::test::camera_in_double(*pFrame), matches, all,
                                              maxlogdet::test::pose_in_double(*pFrame), RejectionOptions());
  for (const std::size_t i : maxlogdet::test::calls.optimised) pFrame->mvbOutlier[i] = true;
  for (const std::uint32_t i : rejection.inliers) pFrame->mvbOutlier[maxlogdet::test::calls.optimised[i]] = false;
  pFrame->SetPose(maxlogdet::test::to_mat(rejection.estimate.T_cw));
  return static_cast<int>(rejection.inliers.size());
}

// Asks what each stereo match weighs, and optimises nothing.
int weighted::Optimizer::PoseOptimization(Frame* pFrame, const maxlogdet::OrbSlam2* good) {
  maxlogdet::test::calls.weights.clear();
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr || pFrame->mvuRight[i] < 0) continue;
    maxlogdet::test::calls.weights[i] = information_of_edge(pFrame, i, good);
  }
  return 0;
}

}  // namespace ORB_SLAM2

namespace maxlogdet::test {

Calls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

PinholeCamera camera_in_double(const ORB_SLAM2::Frame& frame) {
  return {ORB_SLAM2::Frame::fx, ORB_SLAM2::Frame::fy, ORB_SLAM2::Frame::cx, ORB_SLAM2::Frame::cy, frame.mbf};
}

sim::Pose pose_in_double(const ORB_SLAM2::Frame& frame) {
  sim::Pose T_cw = sim::Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) T_cw.matrix()(row, column) = frame.mTcw.at<float>(row, column);
  }
  return T_cw;
}

sim::Match match_of(const ORB_SLAM2::Frame& frame, std::size_t i) {
  sim::Match match;
  const cv::Mat p = frame.mvpMapPoints[i]->GetWorldPos();
  for (int row = 0; row < 3; ++row) match.point[row] = p.at<float>(row);
  match.u = frame.mvKeysUn[i].pt.x;
  match.v = frame.mvKeysUn[i].pt.y;
  match.octave = frame.mvKeysUn[i].octave;
  match.u_right = frame.mvuRight[i];
  match.inv_sigma2 = std::pow(frame.mvScaleFactors[static_cast<std::size_t>(match.octave)], -2.0);
  return match;
}

cv::Mat to_mat(const sim::Pose& T_cw) {
  cv::Mat mat(4, 4, CV_32F);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      mat.at<float>(row, column) = static_cast<float>(T_cw.matrix()(row, column));
    }
  }
  return mat;
}

World::World(Random& random, std::size_t n, bool stereo) : T_cw(random_pose(random)) {
  calls = Calls();
  frame.mbf = stereo ? 50 : 0;
  for (int level = 0; level < 8; ++level) frame.mvScaleFactors.push_back(static_cast<float>(std::pow(1.2, level)));
  for (int k = 0; k < 3; ++k) {
    keyframes.push_back(std::make_unique<ORB_SLAM2::KeyFrame>());
    keyframes.back()->Tcw = to_mat(near(random, 0.4, 0.05));
    keyframes.back()->mbf = 50;
    keyframes.back()->mvScaleFactors = frame.mvScaleFactors;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 3 == 0) add_slot(nullptr, cv::KeyPoint(), -1);
    add_match(random, i % 8 == 5, stereo && i % 2 == 0);
  }
  frame.N = static_cast<int>(frame.mvpMapPoints.size());
  frame.SetPose(to_mat(near(random, 0.1, 0.02)));
}

sim::Pose World::near(Random& random, double metres, double radians) const {
  sim::Vector6 xi;
  xi << random_vector(random, metres), random_vector(random, radians);
  return sim::exp_se3(xi) * T_cw;
}

MapPoint* World::new_point(Random& random, const Eigen::Vector3d& in_camera) {
  const Eigen::Vector3d p = T_cw.inverse() * in_camera;
  points.push_back(std::make_unique<MapPoint>());
  MapPoint& point = *points.back();
  point.mnId = points.size();
  point.mnFirstKFid = static_cast<long int>(points.size() / 50) - 1;
  point.mWorldPos = cv::Mat(3, 1, CV_32F);
  for (int row = 0; row < 3; ++row) point.mWorldPos.at<float>(row) = static_cast<float>(p(row));
  for (const auto& keyframe : keyframes) observe(random, point, *keyframe, keyframe == keyframes[0]);
  return &point;
}

void World::observe(Random& random, MapPoint& point, ORB_SLAM2::KeyFrame& keyframe, bool stereo) {
  point.mObservations[&keyframe] = keyframe.mvKeysUn.size();
  keyframe.mvKeysUn.emplace_back();
  keyframe.mvKeysUn.back().octave = random.integer(0, 7);
  keyframe.mvuRight.push_back(stereo ? 100 : -1);
  point.nObs += stereo ? 2 : 1;
}

void World::add_slot(MapPoint* point, const cv::KeyPoint& key, float u_right) {
  frame.mvpMapPoints.push_back(point);
  frame.mvKeysUn.push_back(key);
  frame.mvuRight.push_back(u_right);
  frame.mvbOutlier.push_back(false);
}

void World::add_match(Random& random, bool outlier, bool stereo) {
  const Eigen::Vector3d p = random_point_in_camera(random);
  cv::KeyPoint key;
  key.octave = random.integer(0, 7);
  const double sigma = std::pow(1.2, key.octave);
  const double offset = outlier ? random.uniform(2, random.chance(0.5) ? 3.5 : 20) * sigma : 0;
  const double u = Frame::fx * p.x() / p.z() + Frame::cx;
  const double v = Frame::fy * p.y() / p.z() + Frame::cy;
  key.pt.x = static_cast<float>(u + random.uniform(-1, 1) * sigma + offset);
  key.pt.y = static_cast<float>(v + random.uniform(-1, 1) * sigma);
  const double right = u - frame.mbf / p.z() + random.uniform(-1, 1) * sigma;
  add_slot(new_point(random, p), key, stereo ? static_cast<float>(right) : -1);
}

std::size_t World::match_count() const {
  return frame.mvpMapPoints.size() -
         static_cast<std::size_t>(std::count(frame.mvpMapPoints.begin(), frame.mvpMapPoints.end(), nullptr));
}

Eigen::Vector3d position_of(MapPoint& point) {
  const cv::Mat p = point.GetWorldPos();
  return {p.at<float>(0), p.at<float>(1), p.at<float>(2)};
}

Eigen::Matrix3d covariance_of(MapPoint& point) {
  const Eigen::Vector3d p_w = position_of(point);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const auto& observation : point.GetObservations()) {
    ORB_SLAM2::KeyFrame& keyframe = *observation.first;
    if (keyframe.isBad()) continue;
    sim::Pose T_cw = sim::Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) T_cw.matrix()(row, column) = keyframe.Tcw.at<float>(row, column);
    }
    const bool stereo = keyframe.mvuRight[observation.second] >= 0;
    const Derivatives derivatives({T_cw * p_w, stereo ? keyframe.mbf : 0.0, keyframe.fx, keyframe.fy});
    const Eigen::MatrixXd H_p = derivatives.H_p.topRows(stereo ? 3 : 2) * T_cw.linear();
    information += std::pow(1.2, -2 * keyframe.mvKeysUn[observation.second].octave) * gram(H_p);
  }
  return inverse(information + 1e-8 * information.trace() * Eigen::Matrix3d::Identity());
}

SeenPoint seen_point(const Frame& frame, const Eigen::Vector3d& p, double bf, double sigma,
                     const Eigen::Matrix3d& covariance) {
  const sim::Pose T_cw = pose_in_double(frame);
  return {T_cw * p, bf, Frame::fx, Frame::fy, sigma, T_cw.linear() * covariance * T_cw.linear().transpose()};
}

SeenPoint seen_match(const Frame& frame, std::size_t slot, bool with_covariance) {
  const sim::Match match = match_of(frame, slot);
  MapPoint& point = *frame.mvpMapPoints[slot];
  return seen_point(frame, position_of(point), match.is_stereo() ? frame.mbf : 0.0, 1 / std::sqrt(match.inv_sigma2),
                    with_covariance ? covariance_of(point) : Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
}

std::vector<SeenPoint> seen_matches(const Frame& frame, bool with_covariance) {
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < frame.mvpMapPoints.size(); ++i) {
    if (frame.mvpMapPoints[i] != nullptr) points.push_back(seen_match(frame, i, with_covariance));
  }
  return points;
}

}  // namespace maxlogdet::test
