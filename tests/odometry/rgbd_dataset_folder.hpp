// SPDX-License-Identifier: MIT
#pragma once

#include "tests/odometry/dataset_folder.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {

/// A folder in the layout of TUM RGB-D: three pairs of random images.
class RgbdFolder : public StereoDatasetFolder {
 protected:
  static constexpr int width = 120;  // px
  static constexpr int height = 90;

  RgbdFolder() {
    Random random;
    write("camera.txt", plain_camera());
    write("associations.txt", associations());
    for (int i = 0; i < 3; ++i) {
      colours_.push_back(random_image(random, width, height));
      depths_.push_back(random_depth(random));
      write(colour(i), colours_.back());
      write(depth(i), depths_.back());
    }
  }

  static Lines plain_camera() {
    return {"# fx fy cx cy k1 k2 p1 p2 k3", "100 101 59.5 44.5 0 0 0 0 0", "# width height units", "120 90 1000"};
  }
  static Lines associations() {
    return {"# pairs", "10.00 rgb/0.png 10.01 depth/0.png", "10.03 rgb/1.png 10.02 depth/1.png",
            "10.07 rgb/2.png 10.06 depth/2.png"};
  }

  static cv::Mat random_depth(Random& random, int columns = width, int rows = height) {
    cv::Mat depth(rows, columns, CV_16UC1);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x)
        depth.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(random.integer(0, 65535));
    }
    return depth;
  }

  static std::string colour(int i) { return "rgb/" + std::to_string(i) + ".png"; }
  static std::string depth(int i) { return "depth/" + std::to_string(i) + ".png"; }

  void write_lists(const std::vector<double>& colour_times, const std::vector<double>& depth_times) const {
    fs::remove(path("associations.txt"));
    for (const auto& [name, times] : {std::make_pair("rgb", colour_times), std::make_pair("depth", depth_times)}) {
      Lines lines = {"# timestamp filename"};
      for (std::size_t i = 0; i < times.size(); ++i) {
        lines.push_back(numbers({times[i]}) + " " + name + "/" + std::to_string(i) + ".png");
      }
      write(name + std::string(".txt"), lines);
    }
  }

  // The index of each pair's depth image among the recorded ones.
  std::vector<std::size_t> depth_indices() const {
    const auto dataset = open_dataset(folder_);
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < dataset->size(); ++i) {
      const cv::Mat loaded = dataset->load(i).depth;
      const auto is_loaded = [&](const cv::Mat& recorded) {
        cv::Mat metres;
        recorded.convertTo(metres, CV_32F, 1e-3);
        return same(metres, loaded);
      };
      indices.push_back(
          static_cast<std::size_t>(std::find_if(depths_.begin(), depths_.end(), is_loaded) - depths_.begin()));
    }
    return indices;
  }

  std::vector<cv::Mat> colours_, depths_;
};

}  // namespace maxlogdet::test
