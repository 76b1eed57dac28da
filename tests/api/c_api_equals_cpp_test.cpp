// SPDX-License-Identifier: MIT
// The C API is the C++ one in other words: every answer is the same, bit for bit, errors included.
#include "sim/frame.hpp"
#include "tests/api/c_api.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using CBlocks = Owned<maxlogdet_block_store>;
using CSelector = Owned<maxlogdet_selector>;
using CActive = Owned<maxlogdet_active_selection>;

CBlocks c_blocks(std::size_t capacity) {
  maxlogdet_block_store* made = nullptr;
  EXPECT_EQ(maxlogdet_block_store_create(capacity, &made), MAXLOGDET_STATUS_OK);
  return CBlocks(made);
}

CSelector c_selector(std::size_t capacity) {
  maxlogdet_selector* made = nullptr;
  EXPECT_EQ(maxlogdet_selector_create(capacity, nullptr, &made), MAXLOGDET_STATUS_OK);
  return CSelector(made);
}

CActive c_active(std::size_t capacity) {
  maxlogdet_active_selection* made = nullptr;
  EXPECT_EQ(maxlogdet_active_selection_create(capacity, &made), MAXLOGDET_STATUS_OK);
  return CActive(made);
}

CBlocks copied(const BlockStore& blocks) {
  CBlocks copy = c_blocks(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = stored_block(blocks, i);
    const maxlogdet_status status = blocks.is_valid(i)
                                        ? maxlogdet_block_store_push_back(copy.get(), block.data(), blocks.rows())
                                        : maxlogdet_block_store_push_back_invalid(copy.get());
    EXPECT_EQ(status, MAXLOGDET_STATUS_OK);
  }
  return copy;
}

void expect_same(const maxlogdet_block_store& in_c, const BlockStore& in_cpp) {
  EXPECT_EQ(maxlogdet_block_store_size(&in_c), in_cpp.size());
  EXPECT_EQ(maxlogdet_block_store_rows(&in_c), in_cpp.rows());
  EXPECT_EQ(maxlogdet_block_store_invalid_count(&in_c), in_cpp.invalid_count());
  for (std::size_t i = 0; i < in_cpp.size(); ++i) {
    EXPECT_EQ(maxlogdet_block_store_is_valid(&in_c, i) != 0, in_cpp.is_valid(i)) << i;
  }
}

bool same_value(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void expect_same(const maxlogdet_selection& in_c, const Selection& in_cpp) {
  ASSERT_EQ(in_c.status, static_cast<int>(in_cpp.status)) << maxlogdet_status_name(in_c.status);
  ASSERT_EQ(in_c.size, in_cpp.size);
  EXPECT_EQ(std::vector<std::uint32_t>(in_c.indices, in_c.indices + in_c.size), indices_of(in_cpp));
  for (std::size_t i = 0; i < in_c.size; ++i) EXPECT_TRUE(same_value(in_c.gains[i], in_cpp.gains[i])) << i;
  EXPECT_TRUE(same_value(in_c.log_det, in_cpp.log_det));
  EXPECT_TRUE(same_value(in_c.upper_bound, in_cpp.upper_bound));
  EXPECT_TRUE(same_value(maxlogdet_selection_efficiency(&in_c), in_cpp.efficiency()));
  EXPECT_TRUE(same_value(in_c.efficiency_of_all, in_cpp.efficiency_of_all));
  EXPECT_TRUE(same_value(in_c.translation_sigma, in_cpp.translation_sigma));
  EXPECT_TRUE(same_value(in_c.rotation_sigma, in_cpp.rotation_sigma));
  EXPECT_EQ(in_c.evaluations, in_cpp.evaluations);
  EXPECT_EQ(in_c.float64_decisions, in_cpp.float64_decisions);
  EXPECT_EQ(in_c.invalid_candidates, in_cpp.invalid_candidates);
  EXPECT_EQ(in_c.strategy, static_cast<int>(in_cpp.strategy));
  EXPECT_EQ(in_c.threads, in_cpp.threads);
  EXPECT_EQ(maxlogdet_selection_has_answer(&in_c) != 0, in_cpp.has_answer());
}

// Candidates, and options that use every field; some are errors.
struct Instance {
  BlockStore blocks;
  std::size_t capacity = 0;
  Options options;
  Matrix6 prior;
  std::vector<unsigned char> required;
  std::vector<unsigned char> excluded;
  std::vector<std::uint32_t> groups;
  std::vector<std::uint32_t> maxima;

  explicit Instance(Random& random) : blocks(awkward_blocks(random, static_cast<std::size_t>(random.integer(0, 150)))) {
    for (int i = random.integer(0, 3); i > 0; --i) blocks.push_back_invalid();
    const std::size_t n = blocks.size();
    capacity = n + static_cast<std::size_t>(random.integer(0, 30));
    const int known = static_cast<int>(std::size(strategies));
    const int strategy = random.chance(0.03) ? random.integer(-1, known) : random.integer(0, known - 1);
    options.strategy = static_cast<Strategy>(strategy);
    options.budget = static_cast<std::size_t>(random.integer(0, static_cast<int>(n)));
    options.epsilon = random.uniform(0.01, 0.9);
    options.seed = static_cast<std::uint64_t>(random.integer(0, 1000));
    options.threads = random.integer(0, 4);
    options.certify = random.chance(0.5);
    options.certificate_passes = static_cast<std::size_t>(random.integer(0, 3));
    options.exchange_sweeps = static_cast<std::size_t>(random.integer(0, 2));
    options.time_limit = random.chance(0.2) ? 1e-9 : random.chance(0.5) ? 1000 : 0;
    if (random.chance(0.5)) {
      prior = random_prior(random);
      options.prior = prior.data();
    }
    if (random.chance(0.3)) {
      required.resize(n);
      for (unsigned char& flag : required) flag = random.chance(0.03) ? 1 : 0;
      options.required = required.data();
    }
    if (random.chance(0.3)) {
      excluded.resize(n);
      for (unsigned char& flag : excluded) flag = random.chance(0.2) ? 3 : 0;
      options.excluded = excluded.data();
    }
    if (random.chance(0.3)) {
      const int count = random.integer(1, 10);
      groups.resize(n);
      for (std::uint32_t& group : groups) group = static_cast<std::uint32_t>(random.integer(0, count - 1));
      options.groups = groups.data();
      options.group_count = static_cast<std::size_t>(count);
      options.max_per_group = static_cast<std::size_t>(random.integer(1, 20));
      if (random.chance(0.5)) {
        for (int g = 0; g < count; ++g) maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 20)));
        options.group_maxima = maxima.data();
      }
    }
    if (random.chance(0.3)) aim(random);
    spoil(random);
  }
  Instance(const Instance&) = delete;  // the options point into it
  Instance& operator=(const Instance&) = delete;

 private:
  // At what strategies and sweeps mostly allow.
  void aim(Random& random) {
    if (random.chance(0.9)) options.exchange_sweeps = 0;
    if (random.chance(0.9)) options.strategy = strategies[random.integer(0, 2)];
    if (random.chance(0.5)) options.target_efficiency = random.uniform(0, 1);
    if (random.chance(0.5)) options.target_translation_sigma = random.uniform(0, 1);
    if (random.chance(0.5)) options.target_rotation_sigma = random.uniform(0, 1);
    if (random.chance(0.03)) options.target_efficiency = random.uniform(1, 2);
  }

  void spoil(Random& random) {
    const int kind = random.integer(0, 80);
    if (kind == 0) options.budget = capacity + 1;
    if (kind == 1) options.epsilon = 0;
    if (kind == 2) options.threads = -1;
    if (kind == 3) options.time_limit = -1;
    if (kind == 4) capacity = blocks.size() / 2;
    if (kind == 5) options.group_count = 0;
    if (kind == 6) prior.setZero();
  }
};

// The header is read as text: nothing in C could loop over its enumerators, and one that is missing has no name to
// test.
template <class Enum, std::size_t count>
void expect_enumerators(const Enum (&all)[count], const std::string& type, const char* (*name_in_c)(std::int32_t)) {
  std::ifstream file(MAXLOGDET_C_HEADER);
  const std::string header((std::istreambuf_iterator<char>(file)), {});
  const auto upper = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
    return text;
  };
  ASSERT_NE(header.find("typedef int32_t " + type + ";"), std::string::npos) << MAXLOGDET_C_HEADER;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(static_cast<std::size_t>(all[i]), i) << "the list of C++ is in the order of the enumerators";
    const std::string line = upper(type + "_" + to_string(all[i])) + " = " + std::to_string(i);
    const std::size_t at = header.find("  " + line);
    const bool is_there = at != std::string::npos && std::isdigit(header[at + 2 + line.size()]) == 0;
    EXPECT_TRUE(is_there) << "enumerators.h lacks " << line;
    EXPECT_STREQ(name_in_c(static_cast<std::int32_t>(i)), to_string(all[i]));
  }
}

TEST(CApi, every_strategy_has_its_enumerator) {
  expect_enumerators(strategies, "maxlogdet_strategy", maxlogdet_strategy_name);
}

TEST(CApi, every_camera_model_has_its_enumerator) {
  expect_enumerators(camera_models, "maxlogdet_camera_model", maxlogdet_camera_model_name);
}

TEST(CApi, selections_equal_those_of_cpp) {
  std::size_t answers = 0;
  std::size_t errors = 0;
  const std::size_t count = trials(2000);
  for (std::uint64_t variation = 0; variation < count; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Instance instance(random);
    const CBlocks blocks = copied(instance.blocks);
    expect_same(*blocks, instance.blocks);
    const CSelector selector = c_selector(instance.capacity);
    EXPECT_EQ(maxlogdet_selector_capacity(selector.get()), instance.capacity);
    Selector expected(instance.capacity);
    const maxlogdet_options options = options_in_c(instance.options);
    const maxlogdet_selection* const selection = maxlogdet_selector_select(selector.get(), blocks.get(), &options);
    expect_same(*selection, expected.select(instance.blocks, instance.options));
    if (HasFatalFailure()) return;
    ++(maxlogdet_selection_has_answer(selection) != 0 ? answers : errors);
  }
  EXPECT_GE(answers, count / 2);
  EXPECT_GE(errors, count / 50);
}

TEST(CApi, active_selections_equal_those_of_cpp) {
  std::size_t accepted = 0;
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const CActive active = c_active(200);
    ActiveSelection expected(200);
    for (int round = 0; round < 2; ++round) {  // a handle is used again
      const Instance instance(random);
      const CBlocks blocks = copied(instance.blocks);
      Options cpp_options = instance.options;
      if (random.chance(0.9)) cpp_options.strategy = Strategy::lazy_greedy;
      const maxlogdet_options options = options_in_c(cpp_options);
      ASSERT_EQ(maxlogdet_active_selection_start(active.get(), blocks.get(), &options),
                static_cast<int>(expected.start(instance.blocks, cpp_options)));
      for (;;) {
        const std::uint32_t proposed = expected.next();
        ASSERT_EQ(maxlogdet_active_selection_next(active.get()), proposed);
        if (proposed == MAXLOGDET_NONE || random.chance(0.01)) break;
        const int answer = random.integer(0, 3);
        const Block measured = random_block(random, random.integer(1, 3));
        const auto rows = static_cast<int>(measured.rows()) + (answer == 3 ? 3 : 0);  // 3: of too many rows
        Status status = Status::ok;
        maxlogdet_status in_c = MAXLOGDET_STATUS_OK;
        if (answer == 0) {
          status = expected.reject();
          in_c = maxlogdet_active_selection_reject(active.get());
        } else if (answer == 1) {
          status = expected.accept();
          in_c = maxlogdet_active_selection_accept(active.get());
        } else {
          status = expected.accept(measured.data(), rows);
          in_c = maxlogdet_active_selection_accept_block(active.get(), measured.data(), rows);
        }
        ASSERT_EQ(in_c, static_cast<int>(status));
        expect_same(*maxlogdet_active_selection_selection(active.get()), expected.selection());
        if (HasFailure()) return;
      }
      const Selection selection = expected.selection();
      accepted += selection.size;
      expect_same(*maxlogdet_active_selection_selection(active.get()), selection);
    }
  }
  EXPECT_GT(accepted, 1000U * trials(500) / 500);
}

// One answer of any kind to both, about any of the proposals or none of them.
void expect_same_answer(Random& random, const std::vector<std::uint32_t>& proposed, maxlogdet_active_selection* active,
                        ActiveSelection& expected) {
  const auto any = static_cast<std::uint32_t>(random.integer(0, 201));
  const auto place = static_cast<std::size_t>(random.integer(0, static_cast<int>(proposed.size()) - 1));
  const std::uint32_t index = random.chance(0.9) ? proposed[place] : any;
  const Block measured = random_block(random, random.integer(1, 3));
  const auto rows = static_cast<int>(measured.rows()) + (random.chance(0.1) ? 3 : 0);
  std::vector<unsigned char> matched(proposed.size() + (random.chance(0.1) ? 1 : 0));
  for (unsigned char& flag : matched) flag = random.chance(0.5) ? 9 : 0;
  Status status = Status::ok;
  maxlogdet_status in_c = MAXLOGDET_STATUS_OK;
  switch (random.integer(0, 4)) {
    case 0:
      status = expected.reject(index);
      in_c = maxlogdet_active_selection_reject_index(active, index);
      break;
    case 1:
      status = expected.accept(index, measured.data(), rows);
      in_c = maxlogdet_active_selection_accept_block_index(active, index, measured.data(), rows);
      break;
    case 2:
      status = expected.answer(matched.data(), matched.size());
      in_c = maxlogdet_active_selection_answer(active, matched.data(), matched.size());
      break;
    case 3:
      status = expected.reject();
      in_c = maxlogdet_active_selection_reject(active);
      break;
    default: status = expected.accept(index); in_c = maxlogdet_active_selection_accept_index(active, index);
  }
  ASSERT_EQ(in_c, static_cast<int>(status));
}

TEST(CApi, batches_equal_those_of_cpp) {
  const std::size_t instances = std::max<std::size_t>(20, trials(500));
  std::size_t accepted = 0;
  for (std::uint64_t variation = 0; variation < instances; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const CActive active = c_active(200);
    ActiveSelection expected(200);
    const Instance instance(random);
    const CBlocks blocks = copied(instance.blocks);
    Options cpp_options = instance.options;
    cpp_options.strategy = Strategy::lazy_greedy;
    const maxlogdet_options options = options_in_c(cpp_options);
    ASSERT_EQ(maxlogdet_active_selection_start(active.get(), blocks.get(), &options),
              static_cast<int>(expected.start(instance.blocks, cpp_options)));
    for (;;) {
      const auto wanted = static_cast<std::size_t>(random.integer(1, 20));
      std::vector<std::uint32_t> proposed(wanted), in_c(wanted);
      proposed.resize(expected.next(proposed.data(), wanted));
      in_c.resize(maxlogdet_active_selection_next_batch(active.get(), in_c.data(), wanted));
      ASSERT_EQ(in_c, proposed);
      if (proposed.empty()) break;
      expect_same_answer(random, proposed, active.get(), expected);
      if (HasFailure()) return;
    }
    accepted += expected.selection().size;
    expect_same(*maxlogdet_active_selection_selection(active.get()), expected.selection());
  }
  EXPECT_GT(accepted, 2 * instances);
}

maxlogdet_matches in_c(const Matches& matches) {
  maxlogdet_matches made;
  EXPECT_EQ(maxlogdet_matches_init(&made, sizeof made), MAXLOGDET_STATUS_OK);
  made.size = matches.size;
  made.points = matches.points.data();
  made.point_stride = matches.points.stride();
  made.point_type = matches.points.are_float() ? MAXLOGDET_POINT_TYPE_FLOAT32 : MAXLOGDET_POINT_TYPE_FLOAT64;
  made.sigmas = matches.sigmas;
  made.has_third = matches.has_third;
  made.usable = matches.usable;
  made.weights = matches.weights;
  made.map_covariances = matches.map_covariances;
  made.jacobians = matches.jacobians;
  made.camera_ids = matches.camera_ids;
  return made;
}

maxlogdet_camera in_c(const Camera& camera) {
  maxlogdet_camera made;
  EXPECT_EQ(maxlogdet_camera_init(&made, sizeof made), MAXLOGDET_STATUS_OK);
  made.fx = camera.pinhole.fx;
  made.fy = camera.pinhole.fy;
  made.cx = camera.pinhole.cx;
  made.cy = camera.pinhole.cy;
  made.bf = camera.pinhole.bf;
  made.model = static_cast<maxlogdet_camera_model>(camera.model);
  std::copy(std::begin(camera.parameters), std::end(camera.parameters), made.parameters);
  return made;
}

// One of any model, or a rig of two of them.
struct Cameras {
  std::vector<Camera> all;
  std::vector<double> T_cb;  // of a rig, 3 x 4 each
};

Cameras random_cameras(Random& random, const PinholeCamera& pinhole) {
  Cameras cameras;
  const Camera models[] = {pinhole, pinhole, Camera::radial_tangential(pinhole, -0.28, 0.07, 2e-4, 2e-5),
                           Camera::kannala_brandt(pinhole, 3e-3, 7e-4, -2e-3, 2e-4),
                           Camera::double_sphere(pinhole, -0.2, 0.59)};
  const bool is_rig = random.chance(0.5);
  for (int i = is_rig ? 2 : 1; i > 0; --i) cameras.all.push_back(models[random.integer(0, 4)]);
  if (is_rig) cameras.T_cb = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 0.2, 0, 1, 0, 0, 1, 0, 0, -0.1};
  return cameras;
}

BlockReport append_in_cpp(const Cameras& cameras, const double* T, const Matches& matches, const BlockOptions& options,
                          BlockStore& blocks) {
  if (cameras.T_cb.empty()) return append_blocks(cameras.all[0], T, matches, options, blocks);
  const RigCamera of_rig[2] = {{cameras.all[0], cameras.T_cb.data()}, {cameras.all[1], &cameras.T_cb[12]}};
  return append_blocks(Rig{of_rig, 2}, T, matches, options, blocks);
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
              match_information(cameras.all[0], T_cw, p_w, noise, expected));
    EXPECT_TRUE(std::equal(actual, actual + 9, expected)) << i;
    ASSERT_EQ(maxlogdet_match_whitening(&camera, T_cw, &given, i, &options, actual) != 0,
              match_whitening(cameras.all[0], T_cw, p_w, noise, expected));
    EXPECT_TRUE(std::equal(actual, actual + 9, expected)) << i;
  }
}

// Stored entries are out of sight in C; what is selected of them, with the bits of its gains, is not.
TEST(CApi, blocks_equal_those_of_cpp) {
  constexpr std::size_t n = 300;
  for (const sim::Scene scene : sim::scenes) {
    for (const Weighting weighting : sim::weightings) {
      for (const ThirdMeasurement third : {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth}) {
        Random random(static_cast<std::uint64_t>(weighting) * 3 + static_cast<std::uint64_t>(third));
        SCOPED_TRACE(random.name());
        const sim::Frame frame = make_scene(scene, n, random.seed());
        const sim::MatchArrays arrays(frame);
        Matches matches = arrays.view();
        std::vector<double> sigmas, weights, covariances;
        std::vector<double> jacobians;
        std::vector<float> points;
        std::vector<unsigned char> has_third, usable, camera_ids;
        for (std::size_t i = 0; i < n; ++i) {
          sigmas.push_back(random.uniform(-0.01, 3));
          weights.push_back(random.uniform(-0.01, 2));
          has_third.push_back(random.chance(0.5) ? 1 : 0);
          usable.push_back(random.chance(0.9) ? 1 : 0);
          const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return random.uniform(-0.2, 0.2); });
          const Eigen::Matrix3d covariance = root * root.transpose();
          covariances.insert(covariances.end(), covariance.data(), covariance.data() + 9);
          for (int e = 0; e < 6; ++e) jacobians.push_back(random.chance(0.001) ? NAN : random.uniform(-100, 100));
          camera_ids.push_back(static_cast<unsigned char>(random.integer(0, 1)));
          for (int d = 0; d < 4; ++d) points.push_back(static_cast<float>(random.uniform(0, 10)));
        }
        matches.sigmas = sigmas.data();
        matches.weights = weights.data();
        matches.has_third = has_third.data();
        matches.usable = usable.data();
        if (random.chance(0.5)) matches.map_covariances = covariances.data();
        if (random.chance(0.3)) matches.jacobians = jacobians.data();
        if (random.chance(0.3)) matches.points = Points(points.data(), 4 * sizeof(float));
        PinholeCamera camera = frame.camera;
        if (third == ThirdMeasurement::stereo) camera.bf = random.chance(0.9) ? 47.9 : 0;
        const Cameras cameras = random_cameras(random, camera);
        if (!cameras.T_cb.empty()) matches.camera_ids = camera_ids.data();
        BlockOptions cpp_options;
        cpp_options.min_depth = random.uniform(0, 4);
        cpp_options.weighting = weighting;
        cpp_options.third = third;
        cpp_options.map_sigma = random.uniform(0.01, 0.1);
        cpp_options.depth_sigma = random.uniform(0.01, 0.1);
        maxlogdet_block_options options;
        ASSERT_EQ(maxlogdet_block_options_init(&options, sizeof options), MAXLOGDET_STATUS_OK);
        options.weighting = static_cast<maxlogdet_weighting>(weighting);
        options.third = static_cast<maxlogdet_third_measurement>(third);
        options.map_sigma = cpp_options.map_sigma;
        options.depth_sigma = cpp_options.depth_sigma;
        options.min_depth = cpp_options.min_depth;

        BlockStore expected(n);
        const CBlocks blocks = c_blocks(n);
        const double* const T_cw = frame.T_cw_prior.data();
        const BlockReport in_cpp = append_in_cpp(cameras, T_cw, matches, cpp_options, expected);
        const maxlogdet_matches given_matches = in_c(matches);
        const maxlogdet_block_report* const report = &append_in_c(cameras, T_cw, given_matches, options, blocks.get());
        expect_same_weights(cameras, T_cw, matches, cpp_options, options);
        EXPECT_EQ(report->status, static_cast<int>(in_cpp.status));
        EXPECT_STREQ(maxlogdet_block_status_name(report->status), to_string(in_cpp.status));
        EXPECT_EQ(report->appended, in_cpp.appended);
        EXPECT_EQ(report->invalid, in_cpp.invalid);
        EXPECT_EQ(report->behind_camera, in_cpp.behind_camera);
        EXPECT_EQ(report->unusable, in_cpp.unusable);
        EXPECT_EQ(report->too_near, in_cpp.too_near);
        EXPECT_EQ(report->singular_rays, in_cpp.singular_rays);
        EXPECT_EQ(report->unsound_covariances, in_cpp.unsound_covariances);
        EXPECT_EQ(report->invalid_jacobians, in_cpp.invalid_jacobians);
        expect_same(*blocks, expected);
        const CSelector selector = c_selector(n);
        Selector cpp_selector(n);
        Options all;
        all.budget = n;
        const maxlogdet_options select_options = options_in_c(all);
        expect_same(*maxlogdet_selector_select(selector.get(), blocks.get(), &select_options),
                    cpp_selector.select(expected, all));
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
