// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/features.hpp"
#include "tests/support/support.hpp"

#include <opencv2/core.hpp>

// Features without images.
namespace maxlogdet::test {

inline stereo_odometry::Descriptor random_descriptor(Random& random) {
  stereo_odometry::Descriptor descriptor;
  for (unsigned char& byte : descriptor) byte = static_cast<unsigned char>(random.integer(0, 255));
  return descriptor;
}

/// Adds a keypoint; u_right -1: it has no stereo match.
inline void add_keypoint(stereo_odometry::StereoFeatures& features, double u, double v, int octave,
                         stereo_odometry::Descriptor descriptor, double u_right = -1) {
  features.keypoints.emplace_back(static_cast<float>(u), static_cast<float>(v), 31.0F, -1.0F, 0.0F, octave);
  features.u_right.push_back(u_right);
  features.descriptors.push_back(cv::Mat(1, 32, CV_8UC1, descriptor.data()));
}

}  // namespace maxlogdet::test
