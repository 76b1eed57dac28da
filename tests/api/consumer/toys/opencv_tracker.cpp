// SPDX-License-Identifier: MIT
// A toy tracker with OpenCV's types, and a pose as ORB-SLAM2 has it: CV_32F 4 x 4.
#include <maxlogdet/good_features.hpp>
#include <maxlogdet/opencv.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <opencv2/core/core.hpp>
#include <vector>

#include "world.hpp"

namespace {

cv::Mat mat_of(const Eigen::Isometry3d& T) {
  cv::Mat mat(4, 4, CV_32F);
  for (int i = 0; i < 16; ++i) mat.at<float>(i / 4, i % 4) = static_cast<float>(T.matrix()(i / 4, i % 4));
  return mat;
}

Eigen::Isometry3d isometry_of(const cv::Mat& mat) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = static_cast<double>(mat.at<float>(i / 4, i % 4));
  return T;
}

cv::Point3f point_of(const toy::Seen& seen) {
  cv::Point3f point;
  point.x = static_cast<float>(seen.point.x());
  point.y = static_cast<float>(seen.point.y());
  point.z = static_cast<float>(seen.point.z());
  return point;
}

cv::KeyPoint keypoint_of(const toy::Seen& seen) {
  cv::KeyPoint keypoint;
  keypoint.pt.x = static_cast<float>(seen.u);
  keypoint.pt.y = static_cast<float>(seen.v);
  keypoint.octave = seen.octave;
  return keypoint;
}

toy::Observation observation_of(const cv::Point3f& point, const cv::KeyPoint& keypoint, double sigma) {
  return {Eigen::Vector3f(point.x, point.y, point.z).cast<double>(), double{keypoint.pt.x}, double{keypoint.pt.y}, -1,
          sigma};
}

class Tracker {
 public:
  Eigen::Isometry3d track(const std::vector<toy::Seen>& frame, std::vector<bool>& is_used,
                          std::vector<bool>& is_outlier) {
    std::vector<cv::Point3f> points;
    std::vector<cv::KeyPoint> keypoints;
    for (const toy::Seen& seen : frame) {
      points.push_back(point_of(seen));
      keypoints.push_back(keypoint_of(seen));
    }
    std::vector<toy::Observation> observations;
    good_.start(camera_, T_cw_);
    for (std::size_t i = 0; i < points.size(); ++i) good_.add(points[i], keypoints[i].pt, sigma(keypoints[i]));
    for (const std::size_t i : good_.select(100)) {
      observations.push_back(observation_of(points[i], keypoints[i], sigma(keypoints[i])));
      is_used[i] = true;
    }
    T_cw_ = mat_of(toy::optimize(isometry_of(T_cw_), observations));
    for (const std::size_t i : good_.outliers(T_cw_)) is_outlier[i] = true;
    return isometry_of(T_cw_);
  }

 private:
  static double sigma(const cv::KeyPoint& keypoint) { return std::pow(1.2, keypoint.octave); }

  cv::Mat T_cw_ = mat_of(Eigen::Isometry3d::Identity());
  const maxlogdet::Camera camera_{toy::fx, toy::fy, toy::cx, toy::cy};
  maxlogdet::GoodFeatures good_{2000};
};

}  // namespace

int main() { return toy::run<Tracker>("a tracker with OpenCV"); }
