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

class Tracker {
 public:
  void track(const std::vector<cv::Point3f>& points, const std::vector<cv::KeyPoint>& keypoints) {
    std::vector<toy::Observation> observations;
    is_used.assign(points.size(), false);
    is_outlier.assign(points.size(), false);
    good_.start(camera_, T_cw);
    for (std::size_t i = 0; i < points.size(); ++i) good_.add(points[i], keypoints[i].pt, sigma(keypoints[i]));
    for (const std::size_t i : good_.select(100)) {
      const Eigen::Vector3f point(points[i].x, points[i].y, points[i].z);
      observations.push_back(
          {point.cast<double>(), double{keypoints[i].pt.x}, double{keypoints[i].pt.y}, -1, sigma(keypoints[i])});
      is_used[i] = true;
    }
    T_cw = mat_of(toy::optimize(isometry_of(T_cw), observations));
    for (const std::size_t i : good_.outliers(T_cw)) is_outlier[i] = true;
  }

  cv::Mat T_cw = mat_of(Eigen::Isometry3d::Identity());
  std::vector<bool> is_used, is_outlier;

 private:
  static double sigma(const cv::KeyPoint& keypoint) { return std::pow(1.2, keypoint.octave); }

  const maxlogdet::Camera camera_{toy::fx, toy::fy, toy::cx, toy::cy};
  maxlogdet::GoodFeatures good_{2000};
};

}  // namespace

int main() {
  toy::Judge judge;
  Tracker tracker;
  for (int number = 0; number < 20; ++number) {
    const std::vector<toy::Seen> frame = toy::see(number);
    std::vector<cv::Point3f> points(frame.size());
    std::vector<cv::KeyPoint> keypoints(frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      points[i].x = static_cast<float>(frame[i].point.x());
      points[i].y = static_cast<float>(frame[i].point.y());
      points[i].z = static_cast<float>(frame[i].point.z());
      keypoints[i].pt.x = static_cast<float>(frame[i].u);
      keypoints[i].pt.y = static_cast<float>(frame[i].v);
      keypoints[i].octave = frame[i].octave;
    }
    tracker.track(points, keypoints);
    judge.pose(isometry_of(tracker.T_cw), number);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      judge.outlier(frame[i], tracker.is_used[i], tracker.is_outlier[i], i);
    }
  }
  return judge.end("a tracker with OpenCV");
}
