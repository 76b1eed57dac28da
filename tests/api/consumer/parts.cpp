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
#include <fstream>
#include <string>
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

const maxlogdet::Camera camera = maxlogdet::Camera::kannala_brandt({458, 457, 367, 248}, -0.2, 0.6, 0, 0);
const maxlogdet::RigidTransform T_cw = maxlogdet::RigidTransform::identity();

// Matches become blocks; blocks are selected from, with options.
void select(const std::vector<Eigen::Vector3d>& points) {
  maxlogdet::BlockStore blocks(n);
  std::vector<maxlogdet::FeatureMatch> matches;
  for (const Eigen::Vector3d& point : points) matches.emplace_back(point, 1.5);
  const maxlogdet::BlockReport report =
      append_blocks(&camera, 1, T_cw, matches.data(), n, maxlogdet::BlockOptions(), blocks);
  if (report.error != maxlogdet::Error::none) std::puts(explain(report.error));
  expect(report.appended == n && report.invalid == 0 && blocks.size() == n && blocks.is_valid(0), "a store");

  maxlogdet::Selector selector(n);
  maxlogdet::Options options(100);
  const Eigen::Matrix<double, 6, 6> prior = 10 * Eigen::Matrix<double, 6, 6>::Identity();
  options.prior = prior.data();
  const maxlogdet::Selection selection = selector.select(blocks, options);
  expect(selection.status == maxlogdet::Status::ok && selection.size == 100, "a selection");
}

void record(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& uv, const std::string& folder) {
  maxlogdet::GoodFeatures good(n);
  expect(good.record(folder.c_str()), "a folder");
  good.start(camera, T_cw);
  for (std::size_t i = 0; i < n; ++i) good.add(points[i], &uv[2 * i]);
  good.select(100);
  expect(std::ifstream(folder + "/frame_000000.csv").good(), "a recording");
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<Eigen::Vector3d> points;  // in front of the camera
  std::vector<double> uv(2 * n);        // where it sees them
  for (int i = 0; i < static_cast<int>(n); ++i) {
    const double z = 2 + i % 17;
    points.emplace_back((7 * i % 752 - 367.0) / 458 * z, (11 * i % 480 - 248.0) / 457 * z, z);
    expect(project(camera, points.back().data(), &uv[2 * points.size() - 2]), "a projection");
  }
  select(points);
  record(points, uv, count > 1 ? arguments[1] : "");
  expect(tracks(points), "the tracker");
  expect(std::strcmp(maxlogdet::version(), MAXLOGDET_VERSION) == 0, "the version");
  std::printf("instruction sets:");
  for (int i = 0; const char* const isa = maxlogdet::built_in_isa(i); ++i) {
    std::printf(" %s%s", isa, maxlogdet::isa_is_supported(isa) ? "" : " (not here)");
  }
  std::printf("; %s is used. The parts are %s\n", maxlogdet::active_isa(), failures == 0 ? "right" : "WRONG");
  return failures == 0 ? 0 : 1;
}
