// SPDX-License-Identifier: MIT
// Any matches of any cameras: what GoodFeatures promises of its alignment and of a selection after it, and the same
// bits on every instruction set.
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/processor.hpp"
#include "tests/support/request.hpp"

#include <maxlogdet/good_features.hpp>

#include <cmath>
#include <vector>

namespace maxlogdet::fuzz {
namespace {

struct Match {
  FeatureMatch match;
  bool has_covariance;
  double covariance[9];
};

struct Frame {
  std::vector<Camera> cameras;
  RigidTransform T_bw = RigidTransform::identity();
  BlockOptions options;
  std::vector<Match> matches;
  std::vector<double> prior;  // or empty
};

Camera camera_of(Bytes& bytes) {
  PinholeCamera pinhole(400, 410, 320, bytes.chance(16) ? bytes.number() : 240, bytes.chance(128) ? 50 : 0);
  if (bytes.chance(16)) pinhole.shift_of_right = bytes.number();
  const auto parameter = [&] { return bytes.raw<std::int8_t>() / 512.0; };
  switch (bytes.below(6)) {
    case 0: return Camera::radial_tangential(pinhole, parameter(), parameter(), parameter() / 64, parameter() / 64);
    case 1: return Camera::kannala_brandt(pinhole, parameter(), parameter(), parameter(), parameter());
    default: return pinhole;
  }
}

// Mostly what the first camera, a pinhole at the identity, would see, so that many frames have a pose.
Match match_of(Bytes& bytes, std::size_t cameras) {
  Match made{};
  FeatureMatch& match = made.match;
  const double z = bytes.chance(16) ? bytes.number() : 2 + bytes.byte() / 16.0;
  const double x = bytes.raw<std::int8_t>() / 160.0, y = bytes.raw<std::int8_t>() / 200.0;
  const double point[3] = {x * z, y * z, z};
  const double pixel[2] = {320 + 400 * x + bytes.raw<std::int8_t>() / 64.0, 240 + 410 * y};
  match = FeatureMatch(point, pixel, bytes.chance(16) ? bytes.number() : 1);
  if (bytes.chance(24)) match.measured[bytes.below(2)] = bytes.number();
  if (bytes.chance(8)) match.point[bytes.below(3)] = bytes.number();
  if (bytes.chance(64)) match.u_right = pixel[0] - 50 / z;
  if (bytes.chance(8)) match.depth = bytes.number();
  match.camera_id = static_cast<std::uint8_t>(bytes.chance(64) ? bytes.below(cameras + 1) : 0);
  match.is_required = bytes.chance(8);
  made.has_covariance = bytes.chance(48);
  for (double& entry : made.covariance) entry = bytes.chance(16) ? bytes.number() : 0;
  for (int d = 0; d < 3; ++d) made.covariance[4 * d] += 0.01;
  return made;
}

Frame frame_of(Bytes& bytes) {
  Frame frame;
  for (std::size_t c = bytes.chance(32) ? 3 : 1; c > 0; --c) frame.cameras.push_back(camera_of(bytes));
  double pose[12];
  std::copy_n(frame.T_bw.data(), 12, pose);
  for (int axis = 0; axis < 3; ++axis) pose[4 * axis + 3] = bytes.raw<std::int8_t>() / 256.0;
  if (bytes.chance(8)) pose[bytes.below(12)] = bytes.number();
  frame.T_bw = RigidTransform::row_major(pose);
  if (bytes.chance(8)) frame.options.depth_sigma = bytes.number();
  if (bytes.chance(32)) frame.options.map_sigma = static_cast<double>(bytes.below(4));
  if (bytes.chance(48)) {
    frame.prior.assign(36, 0);
    for (std::size_t d = 0; d < 6; ++d) frame.prior[7 * d] = bytes.number();
  }
  const double off = bytes.chance(48) ? bytes.raw<std::int8_t>() : 0;  // of every right column
  while (!bytes.is_empty() && frame.matches.size() < 80) {
    frame.matches.push_back(match_of(bytes, frame.cameras.size()));
    if (frame.matches.back().match.u_right >= 0) frame.matches.back().match.u_right += off;
  }
  return frame;
}

void gather(const Frame& frame, GoodFeatures& good) {
  good.block_options = frame.options;
  good.start(frame.cameras.data(), frame.cameras.size(), frame.T_bw);
  for (const Match& made : frame.matches) {
    FeatureMatch match = made.match;
    if (made.has_covariance) match.covariance = made.covariance;
    good.add(match);
  }
}

// All that the alignment says, bit for bit.
std::vector<std::uint64_t> bits_of_alignment(const GoodFeatures& good) {
  const Alignment found = good.alignment();
  std::vector<std::uint64_t> bits = {static_cast<std::uint64_t>(found.status), found.measured, found.inliers,
                                     static_cast<std::uint64_t>(found.iterations), test::bits_of(found.scale)};
  for (int e = 0; e < 12; ++e) bits.push_back(test::bits_of(good.pose().data()[e]));
  for (int e = 0; e < 36; ++e) bits.push_back(test::bits_of(good.pose_information()[e]));
  for (std::size_t i = 0; i < good.size(); ++i) bits.push_back(good.is_inlier(i) ? 1 : 0);
  return bits;
}

void check_alignment(const Frame& frame, const GoodFeatures& good) {
  const Alignment found = good.alignment();
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < good.size(); ++i) inliers += good.is_inlier(i) ? 1 : 0;
  for (int e = 0; e < 36; ++e) {
    const double entry = good.pose_information()[e];
    require(found.is_aligned() ? std::isfinite(entry) : entry == 0, "information is finite, or zero", entry);
  }
  if (found.is_aligned()) {
    require(found.inliers >= 5 && found.measured >= 10, "there is a consensus", found.inliers);
    require(inliers >= found.inliers, "inliers are counted", inliers, found.inliers);
    require(found.scale > 0, "the scale is positive", found.scale);
    for (int e = 0; e < 12; ++e) require(std::isfinite(good.pose().data()[e]), "the pose is finite");
  } else {
    require(found.inliers == 0, "without an alignment there are no inliers", found.inliers);
    for (int e = 0; e < 12; ++e) {
      require(test::bits_of(good.pose().data()[e]) == test::bits_of(frame.T_bw.data()[e]),
              "the pose is that of start()");
    }
  }
}

void check_all(Bytes bytes) {
  const Frame frame = frame_of(bytes);
  const double* const prior = frame.prior.empty() ? nullptr : frame.prior.data();
  GoodFeatures good(80);
  gather(frame, good);
  good.align(prior);
  check_alignment(frame, good);
  const std::vector<std::uint64_t> expected = bits_of_alignment(good);
  Options options(20);
  options.prior = prior;
  const Selection selection = good.select(options);
  if (selection.has_answer()) require(bits_of_alignment(good) == expected, "select() aligns in the same way");
  for (const std::uint32_t i : selection) {
    require(good.is_inlier(i) || frame.matches[i].match.is_required, "what is selected fits, or is required", i);
  }
  for (int isa = 0; built_in_isa(isa) != nullptr; ++isa) {
    if (!isa_is_supported(built_in_isa(isa))) continue;
    const test::ForcedIsa forced(built_in_isa(isa));
    GoodFeatures other(80);
    gather(frame, other);
    other.align(prior);
    require(bits_of_alignment(other) == expected, "an alignment has the same bits on", built_in_isa(isa));
  }
}

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::check_all(maxlogdet::fuzz::Bytes(data, size));
  return 0;
}
