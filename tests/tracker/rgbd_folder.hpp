// SPDX-License-Identifier: MIT
#pragma once

#include "tests/tracker/rendered_world.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace maxlogdet::test {

/// Writes the first frames of the rendered world in the layout of TUM RGB-D, 30 Hz, with ground truth that begins
/// before them; 1000 depth units per metre.
inline void write_rendered_rgbd(const std::string& folder, std::size_t frames) {
  const RenderedWorld world;
  for (const char* const kind : {"rgb", "depth"}) std::filesystem::create_directories(folder + "/" + kind);
  std::ofstream(folder + "/camera.txt") << "300 300 239.5 159.5 0 0 0 0\n480 320 1000\n";
  std::ofstream associations(folder + "/associations.txt"), truth(folder + "/groundtruth.txt");
  associations.precision(17);
  truth.precision(17);
  for (std::size_t i = 0; i < frames; ++i) {
    const std::string file = std::to_string(i) + ".png";
    const double time = 100 + static_cast<double>(i) / 30;
    const stereo_odometry::StereoImages images = world.depth_images(RenderedWorld::T_wc(i));
    cv::Mat depth;
    images.depth.convertTo(depth, CV_16U, 1000);
    ASSERT_TRUE(cv::imwrite(folder + "/rgb/" + file, images.left));
    ASSERT_TRUE(cv::imwrite(folder + "/depth/" + file, depth));
    associations << time << " rgb/" << file << ' ' << time + 0.004 << " depth/" << file << '\n';
    // Exact at the times of the frames.
    const sim::Pose T_wc = RenderedWorld::T_wc(i);
    const Eigen::Quaterniond q(T_wc.linear());
    const Eigen::Vector3d p = T_wc.translation();
    for (const double t : {time - 0.005, time, time + 0.005}) {
      truth << t << ' ' << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
            << q.w() << '\n';
    }
  }
}

}  // namespace maxlogdet::test
