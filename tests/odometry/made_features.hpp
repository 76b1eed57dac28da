// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/features.hpp"
#include "bench/world/frame.hpp"
#include "tests/support/support.hpp"

#include <opencv2/core.hpp>
#include <vector>

// Features without images, and their matches.
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

inline void expect_same_matches(const std::vector<sim::Match>& a, const std::vector<sim::Match>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].map_point_id, b[i].map_point_id);
    EXPECT_EQ(a[i].keypoint, b[i].keypoint);
    EXPECT_EQ(a[i].u, b[i].u);
    EXPECT_EQ(a[i].v, b[i].v);
    EXPECT_EQ(a[i].u_right, b[i].u_right);
  }
}

}  // namespace maxlogdet::test
