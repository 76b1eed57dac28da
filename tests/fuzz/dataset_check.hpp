// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/dataset.hpp"
#include "tests/fuzz/input_folder.hpp"
#include "tests/fuzz/require.hpp"

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace maxlogdet::fuzz {

/// A grey image of 16 x 12 px as a file.
inline void write_image(const InputFolder& folder, const std::string& name) {
  cv::Mat image(12, 16, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.ptr(y)[x] = static_cast<unsigned char>(40 + 11 * x + 5 * y);
  }
  require(cv::imwrite(folder.path(name), image), "an image can be written:", folder.path(name));
}

/// What StereoDataset promises; and the images can be loaded.
inline void check_dataset(const stereo_odometry::StereoDataset& dataset) {
  const PinholeCamera& camera = dataset.camera();
  for (const double value : {camera.fx, camera.fy, camera.bf}) {
    require(value > 0 && std::isfinite(value), "the camera is a stereo camera", camera.fx, camera.fy, camera.bf);
  }
  require(std::isfinite(camera.cx) && std::isfinite(camera.cy), "the principal point is finite", camera.cx, camera.cy);
  require(dataset.width() > 0 && dataset.height() > 0, "images have a size", dataset.width(), dataset.height());
  require(dataset.size() > 0, "there is a pair of images");
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    require(std::isfinite(dataset.time(i)), "times are finite", dataset.time(i));
    require(i == 0 || dataset.time(i) > dataset.time(i - 1), "times increase", dataset.time(i), "of image", i);
    if (!dataset.truth(i)) continue;
    const sim::Pose& truth = *dataset.truth(i);
    require(truth.matrix().allFinite(), "true poses are finite, image", i);
    require(truth.linear().isUnitary(1e-6) && truth.linear().determinant() > 0, "true poses are rigid, image", i);
  }
  const stereo_odometry::StereoImages images = dataset.load(0);
  for (const cv::Mat& image : {images.left, images.right}) {
    require(image.cols == dataset.width() && image.rows == dataset.height() && image.type() == CV_8UC1,
            "images are grey, and of the reported size", image.cols, image.rows);
  }
}

/// Opens a folder: expects a valid dataset, or an InputError that names a file in it.
inline void check_folder(const InputFolder& folder, const std::string& name) {
  std::unique_ptr<stereo_odometry::StereoDataset> dataset;
  if (reads([&] { dataset = stereo_odometry::open_dataset(folder.path(name)); }, folder.path(name))) {
    check_dataset(*dataset);
  }
}

}  // namespace maxlogdet::fuzz
