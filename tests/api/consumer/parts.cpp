// SPDX-License-Identifier: MIT
// The parts below GoodFeatures, for trackers with Jacobians of their own, benchmarks and research: each once. Then a
// tracker in a library of its own.
// Usage: parts FOLDER   (where a frame is recorded)
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

bool tracks(const std::vector<Eigen::Vector3d>& points);  // of tracker.cpp

namespace {

constexpr std::size_t n = 500;
int failures = 0;

void expect(bool is_so, const char* what) {
  if (is_so) return;
  ++failures;
  std::printf("%s is NOT as it should be\n", what);
}

// Points in front of the camera, and where it sees them.
struct Frame {
  Frame() {
    for (int i = 0; i < static_cast<int>(n); ++i) {
      const double z = 2 + i % 17;
      points.emplace_back((7 * i % 752 - 367.0) / 458 * z, (11 * i % 480 - 248.0) / 457 * z, z);
      double of_point[2];
      expect(project(camera, points.back().data(), of_point), "a projection");
      uv.insert(uv.end(), of_point, of_point + 2);
    }
  }
  maxlogdet::Camera camera = maxlogdet::Camera::double_sphere({458, 457, 367, 248}, -0.2, 0.6);
  maxlogdet::RigidTransform T_cw = maxlogdet::RigidTransform::identity();
  std::vector<Eigen::Vector3d> points;
  std::vector<double> uv;
};

// Arrays of matches become blocks; blocks are selected from, with options.
void select(const Frame& frame, maxlogdet::BlockStore& blocks) {
  maxlogdet::Matches matches;  // arrays of the caller's; more of them have deviations, weights, covariances, ...
  const std::vector<double> sigmas(n, 1.5);
  matches.sigmas = sigmas.data();
  const maxlogdet::BlockReport report =
      append_blocks(frame.camera, frame.T_cw, frame.points, matches, maxlogdet::BlockOptions(), blocks);
  if (report.error != maxlogdet::Error::none) std::puts(explain(report.error));
  expect(report.appended == n && report.invalid == 0 && blocks.size() == n && blocks.is_valid(0), "a store");

  maxlogdet::Selector selector(n);
  maxlogdet::Options options(100);
  const Eigen::Matrix<double, 6, 6> information = 10 * Eigen::Matrix<double, 6, 6>::Identity();
  const maxlogdet::EigenPrior prior(information);
  options.prior = prior.data();
  maxlogdet::ImageCells cells(n);
  expect(cells.assign(frame.uv.data(), 2, n, 150), "cells");
  cells.limit(options);  // at most one of each
  const maxlogdet::Selection selection = selector.select(blocks, options);
  expect(selection.status == maxlogdet::Status::ok && selection.size == 100, "a selection");
}

// The weight of a residual, as the blocks have it.
void weigh(const Frame& frame) {
  maxlogdet::MatchNoise noise;
  noise.sigma = 2;
  noise.map_sigma = 0.1;
  Eigen::Matrix<double, 2, 2, Eigen::RowMajor> omega, W;
  expect(match_information(frame.camera, frame.T_cw, frame.points[0].data(), noise, omega.data()), "a weight");
  expect(match_whitening(frame.camera, frame.T_cw, frame.points[0].data(), noise, W.data()), "its root");
  expect((W.transpose() * W - omega).norm() < 1e-12 && omega(0, 0) < 0.25, "weights");
}

void record(const Frame& frame, const char* folder) {
  maxlogdet::FrameRecorder recorder;
  if (folder == nullptr || !recorder.open(folder)) return expect(false, "a folder");
  maxlogdet::FrameDetails details;
  details.T_cw_true = frame.T_cw;
  recorder.start(frame.camera, frame.T_cw, details);
  for (std::size_t i = 0; i < n; ++i) {
    recorder.add(maxlogdet::FeatureMatch(frame.points[i], &frame.uv[2 * i]), i % 5 == 0);
  }
  expect(recorder.finish(), "a recording");
}

}  // namespace

int main(int count, char** arguments) {
  const Frame frame;
  maxlogdet::BlockStore blocks(n);
  select(frame, blocks);
  weigh(frame);
  record(frame, count > 1 ? arguments[1] : nullptr);
  expect(tracks(frame.points), "the tracker");
  expect(std::strcmp(maxlogdet::version(), MAXLOGDET_VERSION) == 0, "the version");
  std::printf("instruction sets:");
  for (int i = 0; const char* const isa = maxlogdet::built_in_isa(i); ++i) {
    std::printf(" %s%s", isa, maxlogdet::isa_is_supported(isa) ? "" : " (not here)");
  }
  std::printf("; %s is used. The parts are %s\n", maxlogdet::active_isa(), failures == 0 ? "right" : "WRONG");
  return failures == 0 ? 0 : 1;
}
