// SPDX-License-Identifier: MIT
// Blocks of the C API are those of the C++ one, bit for bit, and so are the weights of matches.
#include "sim/frame.hpp"
#include "tests/api/c_api.hpp"
#include "tests/support/camera_oracle.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

namespace maxlogdet::test {
namespace {

// One of any model, or a rig of two of them.
struct Cameras {
  std::vector<Camera> all;
  std::vector<double> T_cb;  // of a rig, 3 x 4 each
};

Cameras random_cameras(Random& random, const PinholeCamera& pinhole) {
  Cameras cameras;
  const bool is_rig = random.chance(0.5);
  for (int i = is_rig ? 2 : 1; i > 0; --i) {
    cameras.all.push_back(random_camera(random, random.chance(0.3) ? CameraModel::pinhole : random_model(random)));
    cameras.all.back().pinhole = pinhole;
  }
  if (is_rig) cameras.T_cb = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 0.2, 0, 1, 0, 0, 1, 0, 0, -0.1};
  return cameras;
}

BlockReport append_in_cpp(const Cameras& cameras, const double* T, const Matches& matches, const BlockOptions& options,
                          BlockStore& blocks) {
  if (cameras.T_cb.empty())
    return append_blocks(cameras.all[0], RigidTransform::row_major(T), matches, options, blocks);
  const RigCamera of_rig[2] = {{cameras.all[0], RigidTransform::row_major(cameras.T_cb.data())},
                               {cameras.all[1], RigidTransform::row_major(&cameras.T_cb[12])}};
  return append_blocks(Rig{of_rig, 2}, RigidTransform::row_major(T), matches, options, blocks);
}

const maxlogdet_block_report& append_in_c(const Cameras& cameras, const double* T, const maxlogdet_matches& matches,
                                          const maxlogdet_block_options& options, maxlogdet_block_store* blocks) {
  const maxlogdet_camera first = in_c(cameras.all.front());
  const maxlogdet_camera last = in_c(cameras.all.back());
  if (cameras.T_cb.empty()) return *maxlogdet_append_blocks(&first, T, &matches, &options, blocks, nullptr);
  const maxlogdet_camera* const of_rig[2] = {&first, &last};
  return *maxlogdet_append_blocks_of_rig(of_rig, cameras.T_cb.data(), 2, T, &matches, &options, blocks, nullptr);
}

// Of the first camera alone.
void expect_same_weights(const Cameras& cameras, const double* T_cw, const Matches& matches,
                         const BlockOptions& cpp_options, const maxlogdet_block_options& options) {
  const maxlogdet_camera camera = in_c(cameras.all[0]);
  const maxlogdet_matches given = in_c(matches);
  for (std::size_t i = 0; i < matches.size; ++i) {
    double p_w[3];
    for (std::size_t d = 0; d < 3; ++d) {
      const char* const point = static_cast<const char*>(matches.points.data()) + i * matches.points.stride();
      p_w[d] = matches.points.are_float() ? static_cast<double>(reinterpret_cast<const float*>(point)[d])
                                          : reinterpret_cast<const double*>(point)[d];
    }
    const MatchNoise noise = match_noise(matches, i, cpp_options);
    double expected[9] = {}, actual[9] = {};
    ASSERT_EQ(maxlogdet_match_information(&camera, T_cw, &given, i, &options, actual) != 0,
              match_information(cameras.all[0], RigidTransform::row_major(T_cw), p_w, noise, expected));
    EXPECT_TRUE(std::equal(actual, actual + 9, expected)) << i;
    ASSERT_EQ(maxlogdet_match_whitening(&camera, T_cw, &given, i, &options, actual) != 0,
              match_whitening(cameras.all[0], RigidTransform::row_major(T_cw), p_w, noise, expected));
    EXPECT_TRUE(std::equal(actual, actual + 9, expected)) << i;
  }
}

// Whatever matches may have besides their points, in arrays.
struct Arrays {
  Arrays(Random& random, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      sigmas.push_back(random.uniform(-0.01, 3));
      weights.push_back(random.uniform(-0.01, 2));
      has_depth_cue.push_back(random.chance(0.5) ? 1 : 0);
      usable.push_back(random.chance(0.9) ? 1 : 0);
      const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return random.uniform(-0.2, 0.2); });
      const Eigen::Matrix3d covariance = root * root.transpose();
      covariances.insert(covariances.end(), covariance.data(), covariance.data() + 9);
      for (int e = 0; e < 6; ++e) jacobians.push_back(random.chance(0.001) ? nan : random.uniform(-100, 100));
      camera_ids.push_back(static_cast<unsigned char>(random.integer(0, 1)));
      for (int d = 0; d < 4; ++d) points.push_back(static_cast<float>(random.uniform(0, 10)));
    }
  }

  // Some of them are given.
  void give(Random& random, Matches& matches) const {
    matches.sigmas = sigmas.data();
    matches.weights = weights.data();
    matches.has_depth_cue = has_depth_cue.data();
    matches.usable = usable.data();
    if (random.chance(0.5)) matches.map_covariances = covariances.data();
    if (random.chance(0.3)) matches.jacobians = jacobians.data();
    if (random.chance(0.3)) matches.points = Points(points.data(), 4 * sizeof(float));
  }

  std::vector<double> sigmas, weights, covariances, jacobians;
  std::vector<float> points;
  std::vector<unsigned char> has_depth_cue, usable, camera_ids;
};

BlockOptions random_options(Random& random, Weighting weighting, DepthCue depth_cue) {
  BlockOptions options;
  options.min_depth = random.uniform(0, 4);
  options.weighting = weighting;
  options.depth_cue = depth_cue;
  options.map_sigma = random.uniform(0.01, 0.1);
  options.depth_sigma = random.uniform(0.01, 0.1);
  return options;
}

// Stored entries are out of sight in C; what is selected of them, with the bits of its gains, is not.
void expect_same_selection(const maxlogdet_block_store& in_c, const BlockStore& in_cpp) {
  const std::size_t n = in_cpp.size();
  const CSelector selector = c_selector(n);
  Selector cpp_selector(n);
  const maxlogdet_options options = options_in_c(with_budget(n));
  expect_same(*maxlogdet_selector_select(selector.get(), &in_c, &options), cpp_selector.select(in_cpp, with_budget(n)));
}

TEST(CApi, blocks_equal_those_of_cpp) {
  constexpr std::size_t n = 300;
  for (const sim::Scene scene : sim::scenes) {
    for (const Weighting weighting : weightings) {
      for (const DepthCue depth_cue : {DepthCue::none, DepthCue::stereo, DepthCue::depth}) {
        Random random(static_cast<std::uint64_t>(weighting) * 3 + static_cast<std::uint64_t>(depth_cue));
        SCOPED_TRACE(random.name());
        const sim::Frame frame = make_scene(scene, n, random.seed());
        const sim::MatchArrays of_frame(frame);
        const Arrays arrays(random, n);
        Matches matches = of_frame.view();
        arrays.give(random, matches);
        PinholeCamera camera = frame.camera;
        if (depth_cue == DepthCue::stereo) camera.bf = random.chance(0.9) ? 47.9 : 0;
        const Cameras cameras = random_cameras(random, camera);
        if (!cameras.T_cb.empty()) matches.camera_ids = arrays.camera_ids.data();
        const BlockOptions cpp_options = random_options(random, weighting, depth_cue);
        const maxlogdet_block_options options = in_c(cpp_options);

        BlockStore expected(n);
        const CBlocks blocks = c_blocks(n);
        const double* const T_cw = frame.T_cw_prior.data();
        const BlockReport in_cpp = append_in_cpp(cameras, T_cw, matches, cpp_options, expected);
        expect_same(append_in_c(cameras, T_cw, in_c(matches), options, blocks.get()), in_cpp);
        expect_same_weights(cameras, T_cw, matches, cpp_options, options);
        expect_same(*blocks, expected);
        expect_same_selection(*blocks, expected);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
