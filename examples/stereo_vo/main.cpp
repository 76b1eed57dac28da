// SPDX-License-Identifier: MIT
// A visual odometry on recorded images: reads a folder, and writes the path of the camera, and a picture.
#include "odometry.hpp"
#include "picture.hpp"
#include "sequence.hpp"

#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iomanip>
#include <opencv2/core/quaternion.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace {

using namespace stereo_vo;

struct Arguments {
  std::string folder;
  std::string output = "trajectory.txt";
  std::string picture;
  Settings settings;
};

void add_to(CLI::App& program, Arguments& arguments) {
  program.add_option("FOLDER", arguments.folder, "Images in the layout of KITTI odometry or of TUM RGB-D")->required();
  program
      .add_option("--output", arguments.output,
                  "File for the trajectory, camera to world, the first camera being the world. KITTI: 3 x 4 "
                  "row-major; TUM: timestamp tx ty tz qx qy qz qw")
      ->capture_default_str();
  program.add_option("--picture", arguments.picture,
                     "File for a picture: the last image with its matches, and the path from above");
  program
      .add_option("--select", arguments.settings.select,
                  "Matches of each frame to select, and to compute the pose from; without it the aligned pose, "
                  "which all inliers determine, is taken")
      ->check(CLI::Range(6, 10000));
  program
      .add_option("--spread", arguments.settings.spread,
                  "At most one selected match in each of SPREAD times --select cells of the image; 0: off")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  program.add_option("--record", arguments.settings.record, "Folder for the frames that `maxlogdet evaluate` reads");
  program.add_option("--corners", arguments.settings.corners, "Corners of a keyframe")
      ->check(CLI::Range(20, 10000))
      ->capture_default_str();
}

void write_pose(std::ostream& file, const std::string& time, const cv::Affine3d& T_wc) {
  std::vector<double> numbers(T_wc.matrix.val, T_wc.matrix.val + 12);
  if (!time.empty()) {
    const cv::Quatd q = cv::Quatd::createFromRvec(T_wc.rvec());
    const cv::Vec3d t = T_wc.translation();
    numbers = {t[0], t[1], t[2], q.x, q.y, q.z, q.w};
    file << time << ' ';
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) file << (i > 0 ? " " : "") << numbers[i];
  file << '\n';
}

void write_picture(const std::string& file, const cv::Mat& image, const Odometry& odometry,
                   const std::vector<cv::Affine3d>& poses) {
  cv::Mat picture;
  cv::vconcat(draw_matches(image, odometry.matches()), draw_path(poses, image.cols, image.rows), picture);
  bool is_written = false;
  try {
    is_written = cv::imwrite(file, picture);
  } catch (const cv::Exception&) {  // thrown for unknown formats
  }
  if (!is_written) throw InputError(file + ": cannot be written; expected a file NAME.png in a folder that exists");
}

// Returns the exit code.
int run(const Arguments& arguments) {
  using Clock = std::chrono::steady_clock;
  Sequence sequence(arguments.folder);
  std::ofstream file(arguments.output);
  if (!file) throw InputError(arguments.output + ": cannot be written; expected a file in a folder that exists");
  file << std::setprecision(9);
  Odometry odometry(sequence.calibration(), arguments.settings);
  if (!arguments.settings.record.empty() && !odometry.is_recording()) return 2;  // the library has said why

  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const bool is_terminal = isatty(STDERR_FILENO) == 1;
  std::vector<cv::Affine3d> poses;
  cv::Mat image;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const Frame frame = sequence.read(i);
    odometry.track(frame);
    if (odometry.failure() != nullptr) {
      std::fprintf(stderr, "frame %zu: no pose fits the matches (%s); the predicted one is taken\n", i,
                   odometry.failure());
    }
    poses.push_back(odometry.T_cw().inv());
    write_pose(file, frame.time, poses.back());
    image = frame.left;
    if (is_terminal && seconds() > 2) std::fprintf(stderr, "\r%zu of %zu images\033[K\r", i + 1, sequence.size());
  }
  if (is_terminal) std::fputs("\033[K", stderr);
  if (!file.flush()) throw InputError(arguments.output + ": cannot be written; expected a disk that is not full");
  if (!arguments.picture.empty()) write_picture(arguments.picture, image, odometry, poses);
  std::printf("%zu images, %d keyframes, %.1f ms an image; the trajectory is in %s\n", poses.size(),
              odometry.keyframes(), 1000 * seconds() / static_cast<double>(poses.size()), arguments.output.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are one line, ours
  CLI::App program("A small visual odometry that takes inliers and poses from maxlogdet.");
  Arguments arguments;
  add_to(program, arguments);
  try {
    program.parse(argc, argv);
    return run(arguments);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const std::exception& error) {  // of arguments, files and images
    std::fprintf(stderr, "stereo_vo: %s\n", error.what());
    return 2;
  }
}
