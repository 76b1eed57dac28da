// SPDX-License-Identifier: MIT
#include "tests/fuzz/c_api_matches.hpp"

#include "tests/support/numbers.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace maxlogdet::fuzz {
namespace {

constexpr double T_cb[36] = {1, 0, 0,  0, 0, 1, 0, 0, 0, 0,   1, 0,  0, 0, 1, 0, 0,  1,
                             0, 0, -1, 0, 0, 0, 1, 0, 0, 0.1, 0, -1, 0, 0, 0, 0, -1, 0};

Points points_in_cpp(const maxlogdet_matches& matches) {
  const std::size_t stride = matches.point_stride;
  if (matches.point_type == MAXLOGDET_POINT_TYPE_FLOAT32) {
    return {static_cast<const float*>(matches.points), stride == 0 ? 3 * sizeof(float) : stride};
  }
  return {static_cast<const double*>(matches.points), stride == 0 ? 3 * sizeof(double) : stride};
}

Matches in_cpp(const maxlogdet_matches& matches) {
  Matches made;
  made.size = matches.size;
  made.points = points_in_cpp(matches);
  made.sigmas = matches.sigmas;
  made.has_depth_cue = matches.has_depth_cue;
  made.usable = matches.usable;
  made.weights = matches.weights;
  made.map_covariances = matches.map_covariances;
  made.jacobians = matches.jacobians;
  made.camera_ids = matches.camera_ids;
  return made;
}

std::vector<double> point_of(const Points& points, std::size_t i) {
  const char* const from = static_cast<const char*>(points.data()) + i * points.stride();
  double xyz[3];
  float xyz_of_float[3];
  std::memcpy(points.are_float() ? static_cast<void*>(xyz_of_float) : xyz, from,
              points.are_float() ? sizeof xyz_of_float : sizeof xyz);
  return points.are_float() ? std::vector<double>(xyz_of_float, xyz_of_float + 3) : std::vector<double>(xyz, xyz + 3);
}

}  // namespace

BlockOptions in_cpp(const maxlogdet_block_options& options) {
  BlockOptions made;
  made.weighting = static_cast<Weighting>(options.weighting);
  made.depth_cue = static_cast<DepthCue>(options.depth_cue);
  made.map_sigma = options.map_sigma;
  made.depth_sigma = options.depth_sigma;
  made.min_depth = options.min_depth;
  made.threads = options.threads;
  return made;
}

Camera in_cpp(const maxlogdet_camera& camera) {
  Camera made(camera.fx, camera.fy, camera.cx, camera.cy, camera.bf);
  made.model = static_cast<CameraModel>(camera.model);
  std::copy(std::begin(camera.parameters), std::end(camera.parameters), made.parameters);
  return made;
}

AnyMatches::AnyMatches(Bytes& bytes, bool is_full)
    : camera_(any_camera(bytes)),
      T_cw_(any_pose(bytes)),
      count_(is_full ? 0 : bytes.below(40)),
      points_(numbers(bytes, 3 * count_, 1)),
      sigmas_(numbers(bytes, count_, 1)),
      weights_(numbers(bytes, count_, 0.5)),
      covariances_(numbers(bytes, 9 * count_, 0)),
      jacobians_(numbers(bytes, 6 * count_, 3)),
      has_depth_cue_(flags(bytes, count_)),
      usable_(flags(bytes, count_)),
      matches_(any_matches(bytes)),
      options_(any_block_options(bytes)),
      given_camera_(bytes, camera_, defaults_of(maxlogdet_camera_init)),
      given_matches_(bytes, matches_, defaults_of(maxlogdet_matches_init)),
      given_options_(bytes, options_, defaults_of(maxlogdet_block_options_init)),
      pose_(bytes.chance(8) ? nullptr : T_cw_.data()),
      is_rig_(bytes.chance(64)) {}

maxlogdet_camera any_camera(Bytes& bytes) {
  auto camera = defaults_of(maxlogdet_camera_init);
  camera.fx = bytes.chance(16) ? bytes.number() : 400 + bytes.byte();
  camera.fy = bytes.chance(16) ? bytes.number() : 400 + bytes.byte();
  camera.cx = bytes.chance(16) ? bytes.number() : 320;
  camera.bf = bytes.chance(64) ? bytes.number() : 40;
  camera.model = bytes.chance(8) ? bytes.raw<std::int32_t>() : static_cast<int>(bytes.below(4));
  for (double& parameter : camera.parameters) parameter = bytes.chance(16) ? bytes.number() : 0.01;
  return camera;
}

std::vector<double> any_pose(Bytes& bytes) {
  std::vector<double> T_cw = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  if (bytes.chance(64)) T_cw[bytes.below(12)] = bytes.number();
  return T_cw;
}

std::vector<double> AnyMatches::numbers(Bytes& bytes, std::size_t size, double usual) {
  std::vector<double> list(size, usual);
  for (double& value : list) value = bytes.chance(16) ? bytes.number() : usual + bytes.byte() / 64.0;
  return list;
}

std::vector<std::uint8_t> AnyMatches::flags(Bytes& bytes, std::size_t size) {
  std::vector<std::uint8_t> list(size);
  for (std::uint8_t& value : list) value = bytes.byte() & 2;
  return list;
}

maxlogdet_matches AnyMatches::any_matches(Bytes& bytes) {
  auto matches = defaults_of(maxlogdet_matches_init);
  matches.size = count_;
  if (!bytes.chance(8)) matches.points = points_.data();
  if (bytes.chance(64)) matches.sigmas = sigmas_.data();
  if (bytes.chance(64)) matches.weights = weights_.data();
  if (bytes.chance(64)) matches.has_depth_cue = has_depth_cue_.data();
  if (bytes.chance(64)) matches.usable = usable_.data();
  if (bytes.chance(64)) matches.map_covariances = covariances_.data();
  if (bytes.chance(64)) matches.jacobians = jacobians_.data();
  camera_ids_ = flags(bytes, count_);
  if (bytes.chance(64)) matches.camera_ids = camera_ids_.data();
  if (bytes.chance(64)) {
    matches.point_type = MAXLOGDET_POINT_TYPE_FLOAT32;  // what the same bytes are then
    matches.point_stride = 3 * sizeof(double);
  }
  if (bytes.chance(8)) matches.point_stride = bytes.below(24);
  return matches;
}

maxlogdet_block_options any_block_options(Bytes& bytes) {
  auto options = defaults_of(maxlogdet_block_options_init);
  options.weighting = bytes.chance(8) ? bytes.raw<std::int32_t>() : static_cast<int>(bytes.below(4));
  options.depth_cue = bytes.chance(8) ? bytes.raw<std::int32_t>() : static_cast<int>(bytes.below(3));
  options.map_sigma = bytes.chance(16) ? bytes.number() : 0.1;
  options.depth_sigma = bytes.chance(16) ? bytes.number() : 0.1;
  options.min_depth = bytes.chance(16) ? bytes.number() : 0.1;
  options.threads = bytes.raw<std::int8_t>();
  if (!bytes.chance(16)) options.threads = std::max(0, options.threads);
  if (bytes.chance(8)) options.reserved = bytes.byte();
  return options;
}

bool AnyMatches::is_understood() const {
  return given_camera_.is_good() && given_matches_.is_good() && given_options_.is_good() &&
         given_options_.seen().reserved == 0 && given_camera_.seen().reserved == 0 &&
         given_matches_.seen().reserved == 0;
}

const maxlogdet_block_report* AnyMatches::append_in_c(maxlogdet_block_store* store) const {
  const maxlogdet_camera* const cameras[3] = {given_camera_.get(), given_camera_.get(), given_camera_.get()};
  return is_rig_ ? maxlogdet_append_blocks_of_rig(cameras, T_cb, 3, pose_, given_matches_.get(), given_options_.get(),
                                                  store, nullptr)
                 : maxlogdet_append_blocks(given_camera_.get(), pose_, given_matches_.get(), given_options_.get(),
                                           store, nullptr);
}

BlockReport AnyMatches::append_in_cpp(BlockStore& store) const {
  const Camera camera = in_cpp(given_camera_.seen());
  const Matches matches = in_cpp(given_matches_.seen());
  const BlockOptions options = in_cpp(given_options_.seen());
  const RigidTransform pose = RigidTransform::row_major(pose_);
  if (!is_rig_) return append_blocks(camera, pose, matches, options, store);
  const RigCamera cameras[3] = {{camera, RigidTransform::row_major(T_cb)},
                                {camera, RigidTransform::row_major(T_cb + 12)},
                                {camera, RigidTransform::row_major(T_cb + 24)}};
  return append_blocks(Rig{cameras, 3}, pose, matches, options, store);
}

void AnyMatches::check_weights() const {
  const Camera camera = in_cpp(given_camera_.seen());
  const Matches matches = in_cpp(given_matches_.seen());
  const RigidTransform pose = RigidTransform::row_major(pose_);
  for (std::size_t i = 0; i < matches.size; ++i) {
    const std::vector<double> p_w = point_of(matches.points, i);
    const MatchNoise noise = match_noise(matches, i, in_cpp(given_options_.seen()));
    double in_c[9] = {}, expected[9] = {};
    require((maxlogdet_match_information(given_camera_.get(), pose_, given_matches_.get(), i, given_options_.get(),
                                         in_c) != 0) == match_information(camera, pose, p_w.data(), noise, expected) &&
                std::equal(in_c, in_c + 9, expected, test::same_value),
            "weights are those of C++", i);
    require((maxlogdet_match_whitening(given_camera_.get(), pose_, given_matches_.get(), i, given_options_.get(),
                                       in_c) != 0) == match_whitening(camera, pose, p_w.data(), noise, expected) &&
                std::equal(in_c, in_c + 9, expected, test::same_value),
            "and their roots", i);
  }
}

}  // namespace maxlogdet::fuzz
