// SPDX-License-Identifier: MIT
// What the header of the C API calls wrong, and what the library answers: null pointers, sizes of structs, wrong
// values.
#include "tests/fuzz/c_api_misuse.hpp"
#include "tests/api/c_api.hpp"
#include "tests/fuzz/c_api_given.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr int none = MAXLOGDET_ERROR_NONE;
constexpr int refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;
constexpr int no_memory = MAXLOGDET_ERROR_OUT_OF_MEMORY;
constexpr std::size_t absurd = std::numeric_limits<std::size_t>::max();
constexpr double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

TEST(CApiMisuse, null_is_refused_everywhere) {
  const CBlocks blocks = c_blocks(10);
  const CSelector selector = c_selector(10);
  for (const fuzz::NullCall& call : fuzz::call_with_nulls(blocks.get(), selector.get())) {
    EXPECT_TRUE(call.is_refused) << call.name;
  }
  const CGoodFeatures good = c_good_features(10);
  const std::uint32_t* outliers = nullptr;
  double to[9];
  EXPECT_EQ(maxlogdet_good_features_outliers(good.get(), nullptr, &outliers), 0U);
  EXPECT_EQ(maxlogdet_good_features_outliers(good.get(), identity, nullptr), 0U);
  EXPECT_EQ(maxlogdet_good_features_set_block_options(good.get(), nullptr), refused);
  EXPECT_EQ(maxlogdet_good_features_information(good.get(), 0, nullptr), 0);
  EXPECT_EQ(maxlogdet_good_features_whitening(good.get(), 0, nullptr), 0);
  EXPECT_EQ(maxlogdet_good_features_information(good.get(), 0, to), 0) << "there is no match";
  EXPECT_EQ(maxlogdet_good_features_record(good.get(), nullptr), 0);
  EXPECT_EQ(maxlogdet_good_features_record(good.get(), ""), 0);
}

// Creates a handle, and returns the error; a handle that is not created is null.
template <class Handle, class Create>
int error_of(const Create& create) {
  int something = 0;  // what may not stay in the pointer
  auto* made = reinterpret_cast<Handle*>(&something);
  const maxlogdet_error error = create(&made);
  EXPECT_EQ(made == nullptr, error != none);
  const Owned<Handle> owned(made);
  return error;
}

int of_selector(std::size_t capacity, const maxlogdet_executor* executor) {
  return error_of<maxlogdet_selector>([=](auto** to) { return maxlogdet_selector_create(capacity, executor, to); });
}
int of_good_features(std::size_t capacity, const maxlogdet_executor* executor) {
  return error_of<maxlogdet_good_features>(
      [=](auto** to) { return maxlogdet_good_features_create(capacity, executor, to); });
}

TEST(CApiMisuse, what_cannot_be_created_is_told_and_null) {
  for (const std::size_t capacity : {std::size_t{10}, absurd}) {
    const int expected = capacity == absurd ? no_memory : none;
    EXPECT_EQ(error_of<maxlogdet_block_store>([=](auto** to) { return maxlogdet_block_store_create(capacity, to); }),
              expected);
    EXPECT_EQ(of_selector(capacity, nullptr), expected);
    EXPECT_EQ(of_good_features(capacity, nullptr), expected);
    EXPECT_EQ(error_of<maxlogdet_active_selection>(
                  [=](auto** to) { return maxlogdet_active_selection_create(capacity, to); }),
              expected);
  }
  const CBlocks blocks = c_blocks(4);
  for (const std::size_t capacity : {absurd, std::size_t{1} << 32U}) {
    EXPECT_EQ(maxlogdet_block_store_reserve(blocks.get(), capacity), no_memory);
    EXPECT_EQ(maxlogdet_block_store_capacity(blocks.get()), 4U);
  }
}

// As of a caller whose declaration ends there, in memory that ends there as well.
template <class Struct>
struct Cut {
  Cut(const Struct& whole, std::size_t size) : memory(new unsigned char[size]()) {
    std::memcpy(memory.get(), &whole, std::min(size, sizeof whole));
    std::memcpy(memory.get(), &size, sizeof size);
  }
  const Struct* get() const { return reinterpret_cast<const Struct*>(memory.get()); }

  std::unique_ptr<unsigned char[]> memory;  // aligned for any struct, and guarded by AddressSanitizer
};

// That `answer`, what a function answers to the struct, is the same with the defaults in place of what is cut off, and
// "invalid_argument" for a size that is none.
template <class Struct, class Answer>
void expect_sizes(Struct whole, maxlogdet_error (*init)(Struct*, std::size_t), const Answer& answer) {
  EXPECT_NE(answer(&whole), "invalid_argument");
  for (std::size_t size = 8; size <= sizeof whole + 8; ++size) {
    SCOPED_TRACE(size);
    std::string expected = "invalid_argument";
    if (fuzz::is_size_of<Struct>(size)) {
      auto completed = fuzz::defaults_of(init);
      const std::size_t full = completed.struct_size;
      std::memcpy(&completed, &whole, size);
      completed.struct_size = full;
      expected = answer(&completed);
    }
    EXPECT_EQ(answer(Cut<Struct>(whole, size).get()), expected);
  }
  for (const std::size_t size : {std::size_t{0}, absurd, static_cast<std::size_t>(0xA5A5A5A5A5A5A5A8)}) {
    whole.struct_size = size;
    EXPECT_EQ(answer(&whole), "invalid_argument") << size;
  }
}

std::string text_of(const maxlogdet_selection* selection) {
  std::ostringstream text;
  text << maxlogdet_selection_reason(selection);
  if (selection->error != none) return text.str();
  text << std::hexfloat << ' ' << selection->log_det << ' ' << selection->upper_bound << ' ' << selection->efficiency;
  for (std::size_t j = 0; j < selection->size; ++j) text << ' ' << selection->indices[j] << ' ' << selection->gains[j];
  return text.str();
}

// What a caller gives for blocks, each field other than its default, and where they go.
struct Call {
  static constexpr std::size_t n = 6;

  Call() {
    camera.fx = camera.fy = 300;
    camera.cx = 200;
    camera.cy = 100;
    camera.model = MAXLOGDET_CAMERA_MODEL_KANNALA_BRANDT;
    for (double& parameter : camera.parameters) parameter = 0.001;
    for (std::size_t i = 0; i < n; ++i) {
      const double x[3] = {0.1 * static_cast<double>(i), 0.3, 2 + static_cast<double>(i)};
      std::memcpy(points + 3 * i, x, sizeof x);
      for (std::size_t e = 0; e < 9; ++e) covariances[9 * i + e] = e % 4 == 0 ? 0.1 : 0;
      for (std::size_t e = 0; e < 6; ++e) jacobians[6 * i + e] = static_cast<double>(1 + (e * i) % 5);
      sigmas[i] = weights[i] = 0.5;
      flags[i] = i == 2 ? 0 : 1;
    }
    matches.size = n;
    matches.points = points;
    matches.point_stride = 3 * sizeof(double);
    matches.sigmas = sigmas;
    matches.usable = flags;
    matches.weights = weights;
    matches.map_covariances = covariances;
    matches.jacobians = jacobians;
    options.weighting = MAXLOGDET_WEIGHTING_MEASUREMENT_AND_MAP;
    options.map_sigma = 0.2;
    options.min_depth = 2.5;
  }
  Call(const Call&) = delete;  // the matches point into it
  Call& operator=(const Call&) = delete;

  const maxlogdet_block_report* append(const maxlogdet_camera* of, const maxlogdet_matches* the_matches,
                                       const maxlogdet_block_options* with) const {
    maxlogdet_block_store_clear(blocks.get());
    if (rig_size == 0) return maxlogdet_append_blocks(of, pose, the_matches, with, blocks.get(), executor);
    const maxlogdet_camera* const cameras[2] = {of, of};
    const double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    return maxlogdet_append_blocks_of_rig(cameras, T_cb, rig_size, pose, the_matches, with, blocks.get(), executor);
  }
  int error() const {
    const maxlogdet_block_report* const report = append(&camera, &matches, &options);
    EXPECT_EQ(report->appended, report->error == none ? n : 0);
    return report->error;
  }
  // What is made, and what is selected of it.
  std::string answer(const maxlogdet_camera* of, const maxlogdet_matches* the_matches,
                     const maxlogdet_block_options* with) const {
    const maxlogdet_block_report report = *append(of, the_matches, with);
    if (report.error != none) return maxlogdet_error_name(report.error);
    const auto all = fuzz::defaults_of(maxlogdet_options_init);
    return std::to_string(report.invalid) + text_of(maxlogdet_selector_select(selector.get(), blocks.get(), &all));
  }

  double points[3 * n], covariances[9 * n], jacobians[6 * n], sigmas[n], weights[n];
  std::uint8_t flags[n];
  maxlogdet_camera camera = fuzz::defaults_of(maxlogdet_camera_init);
  maxlogdet_matches matches = fuzz::defaults_of(maxlogdet_matches_init);
  maxlogdet_block_options options = fuzz::defaults_of(maxlogdet_block_options_init);
  const double* pose = identity;
  const maxlogdet_executor* executor = nullptr;
  std::size_t rig_size = 0;
  CBlocks blocks = c_blocks(n);
  CSelector selector = c_selector(n);
};

TEST(CApiMisuse, structs_of_blocks_are_read_up_to_their_size) {
  Call call;
  expect_sizes(call.matches, maxlogdet_matches_init,
               [&](const auto* matches) { return call.answer(&call.camera, matches, &call.options); });
  expect_sizes(call.options, maxlogdet_block_options_init,
               [&](const auto* options) { return call.answer(&call.camera, &call.matches, options); });
  call.matches.jacobians = nullptr;
  expect_sizes(call.camera, maxlogdet_camera_init,
               [&](const auto* camera) { return call.answer(camera, &call.matches, &call.options); });
}

TEST(CApiMisuse, options_are_read_up_to_their_size) {
  constexpr std::size_t n = 200;
  Random random;
  SCOPED_TRACE(random.name());
  const CBlocks blocks = c_blocks(n);
  for (std::size_t i = 0; i < n; ++i) {
    maxlogdet_block_store_push_back(blocks.get(), random_block(random, 2).data(), 2);
  }
  const CSelector selector = c_selector(n);
  std::vector<std::uint8_t> required(n), excluded(n);
  std::vector<std::uint32_t> groups(n), maxima(4, 30);
  std::vector<double> prior(36);
  required[3] = excluded[4] = 1;
  for (std::uint32_t i = 0; i < n; ++i) groups[i] = i % 4;
  for (std::size_t i = 0; i < 6; ++i) prior[7 * i] = 2;
  auto options = fuzz::defaults_of(maxlogdet_options_init);
  options.budget = 40;
  options.prior = prior.data();
  options.time_limit = 1000;
  options.strategy = MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY;
  options.threads = 1;
  options.required = required.data();
  options.excluded = excluded.data();
  options.target_efficiency = options.target_translation_sigma = options.target_rotation_sigma = 0.5;
  options.group_ids = groups.data();
  options.group_count = 4;
  options.group_maximum = 30;
  options.group_maxima = maxima.data();
  options.certificate_compute = 1;
  options.certificate_passes = 2;
  options.stochastic_epsilon = 0.3;
  options.stochastic_seed = 7;
  options.exchange_sweeps = 1;
  const auto answer = [&](const maxlogdet_options* given) {
    return text_of(maxlogdet_selector_select(selector.get(), blocks.get(), given));
  };
  expect_sizes(options, maxlogdet_options_init, answer);
  options.reserved = 1;
  EXPECT_EQ(answer(&options), "invalid_argument");
}

TEST(CApiMisuse, matches_and_executors_are_read_up_to_their_size) {
  Call call;
  const CGoodFeatures good = c_good_features(1);
  const double entries[9] = {0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.3};
  auto match = fuzz::defaults_of(maxlogdet_match_init);
  std::memcpy(match.point, call.points + 3, sizeof match.point);
  match.measured[0] = match.measured[1] = 7;
  match.sigma = 2;
  match.covariance = entries;
  match.id = 7;
  match.is_required = 1;
  const auto added = [&](const maxlogdet_match* given) -> std::string {
    maxlogdet_good_features_start(good.get(), &call.camera, identity);
    const maxlogdet_error error = maxlogdet_good_features_add(good.get(), given);
    if (error != none) return maxlogdet_error_name(error);
    const auto options = fuzz::defaults_of(maxlogdet_options_init);
    return text_of(maxlogdet_good_features_select(good.get(), &options)) +
           std::to_string(maxlogdet_good_features_id(good.get(), 0));
  };
  expect_sizes(match, maxlogdet_match_init, added);
  match.reserved = 1;
  EXPECT_EQ(added(&match), "invalid_argument");

  auto executor = fuzz::defaults_of(maxlogdet_executor_init);
  executor.concurrency = [](void*) { return 1; };
  executor.run = [](void*, std::int32_t, maxlogdet_body body, void* context) { body(context, 0); };
  const auto created = [](const maxlogdet_executor* given) -> std::string {
    EXPECT_EQ(of_selector(1, given), of_good_features(1, given));
    return maxlogdet_error_name(of_selector(1, given));
  };
  expect_sizes(executor, maxlogdet_executor_init, created);
  executor.concurrency = nullptr;
  EXPECT_EQ(created(&executor), "invalid_argument");
}

// A rule of the header that a caller breaks, and the error that it names.
struct Mistake {
  int error;
  void (*make)(Call& call);
};

TEST(CApiMisuse, blocks_that_cannot_be_made_are_told) {
  static const std::uint8_t ids[Call::n] = {0, 1, 0, 1, 0, 1};
  static const auto no_functions = fuzz::defaults_of(maxlogdet_executor_init);
  const Mistake mistakes[] = {
      {none, [](Call&) {}},
      {none, [](Call& call) { call.rig_size = 2, call.matches.camera_ids = ids; }},
      {refused, [](Call& call) { call.executor = &no_functions; }},
      {refused, [](Call& call) { call.camera.reserved = 1; }},
      {refused, [](Call& call) { call.camera.reserved = 1, call.rig_size = 2; }},
      {refused, [](Call& call) { call.matches.reserved = 1; }},
      {refused, [](Call& call) { call.options.reserved = 1; }},
      {refused, [](Call& call) { call.matches.point_type = 2; }},
      {no_memory, [](Call& call) { call.matches.size = absurd; }},  // more than there can be
      {no_memory, [](Call& call) { call.matches.size = absurd - 3; }},
      {MAXLOGDET_ERROR_INVALID_POSE, [](Call& call) { call.pose = nullptr; }},
      {MAXLOGDET_ERROR_MISSING_POINTS, [](Call& call) { call.matches.points = nullptr; }},
      {MAXLOGDET_ERROR_INVALID_STRIDE, [](Call& call) { call.matches.point_stride = 10; }},
      {MAXLOGDET_ERROR_INVALID_BLOCK_OPTIONS, [](Call& call) { call.options.weighting = 77; }},
      {MAXLOGDET_ERROR_INVALID_CAMERA, [](Call& call) { call.matches.jacobians = nullptr, call.camera.fx = 0; }},
      {MAXLOGDET_ERROR_UNKNOWN_CAMERA_MODEL, [](Call& call) { call.camera.model = 1000; }},
      {MAXLOGDET_ERROR_INVALID_CAMERA_ID, [](Call& call) { call.matches.camera_ids = ids; }},
      {MAXLOGDET_ERROR_INVALID_CAMERA_ID, [](Call& call) { call.rig_size = 1, call.matches.camera_ids = ids; }},
      {MAXLOGDET_ERROR_INVALID_CAMERA_ID, [](Call& call) { call.rig_size = 257; }}};
  for (const Mistake& mistake : mistakes) {
    Call call;
    mistake.make(call);
    EXPECT_EQ(call.error(), mistake.error) << "row " << &mistake - mistakes;
  }
  const Call call;
  EXPECT_EQ(maxlogdet_append_blocks_of_rig(nullptr, nullptr, 0, identity, &call.matches, &call.options,
                                           call.blocks.get(), nullptr)
                ->error,
            MAXLOGDET_ERROR_INVALID_CAMERA_ID);
}

// A frame of n matches, of which a budget of 40 is asked for; `error`: that of its start.
class CFrame {
 public:
  static constexpr std::size_t n = 200;

  CFrame() {
    camera.fx = camera.fy = 450;
    options.budget = 40;
  }

  void start_and_add(int error) {
    const maxlogdet_camera* const cameras[2] = {&camera, &camera};
    const double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    EXPECT_EQ(rig_size == 0 ? maxlogdet_good_features_start(good.get(), has_camera ? &camera : nullptr, pose)
                            : maxlogdet_good_features_start_rig(good.get(), has_camera ? cameras : nullptr,
                                                                has_extrinsics ? T_cb : nullptr, rig_size, pose),
              error);
    auto match = fuzz::defaults_of(maxlogdet_match_init);
    for (std::size_t i = 0; i < n; ++i) {
      const double point[3] = {0.1 * static_cast<double>(i % 19), 0.2 * static_cast<double>(i % 7),
                               5 + 0.01 * static_cast<double>(i)};
      std::memcpy(match.point, point, sizeof point);
      match.id = static_cast<std::uint32_t>(1000 + i);
      EXPECT_EQ(maxlogdet_good_features_add(good.get(), &match), none);
    }
  }
  const maxlogdet_selection* select() const {
    return maxlogdet_good_features_select(good.get(), has_options ? &options : nullptr);
  }

  CGoodFeatures good = c_good_features(n);
  maxlogdet_camera camera = fuzz::defaults_of(maxlogdet_camera_init);
  maxlogdet_options options = fuzz::defaults_of(maxlogdet_options_init);
  const double* pose = identity;
  std::size_t rig_size = 0;
  bool has_camera = true, has_extrinsics = true, has_options = true;
};

// What is wrong with a frame, the error of start, and that of select.
struct WrongFrame {
  int of_start, of_select;
  void (*make)(CFrame& frame);
};

TEST(CApiMisuse, whatever_is_refused_all_usable_matches_are_selected) {
  static const double zeros[12] = {};
  const WrongFrame frames[] = {
      {none, none, [](CFrame&) {}},
      {none, none, [](CFrame& frame) { frame.rig_size = 2; }},
      {refused, refused, [](CFrame& frame) { frame.has_camera = false; }},
      {refused, refused, [](CFrame& frame) { frame.camera.reserved = 1; }},
      {refused, refused, [](CFrame& frame) { frame.pose = nullptr; }},
      {refused, refused, [](CFrame& frame) { frame.rig_size = 2, frame.has_camera = false; }},
      {refused, refused, [](CFrame& frame) { frame.rig_size = 2, frame.camera.reserved = 1; }},
      {refused, refused, [](CFrame& frame) { frame.rig_size = 2, frame.pose = nullptr; }},
      {refused, refused, [](CFrame& frame) { frame.rig_size = 2, frame.has_extrinsics = false; }},
      {none, MAXLOGDET_ERROR_INVALID_CAMERA_ID, [](CFrame& frame) { frame.rig_size = 257; }},
      {none, MAXLOGDET_ERROR_INVALID_POSE, [](CFrame& frame) { frame.pose = zeros; }},
      {none, refused, [](CFrame& frame) { frame.has_options = false; }},
      {none, refused, [](CFrame& frame) { frame.options.reserved = 1; }},
      {none, MAXLOGDET_ERROR_INVALID_STRATEGY, [](CFrame& frame) { frame.options.strategy = 1000; }},
      {none, MAXLOGDET_ERROR_INVALID_GROUPS,
       [](CFrame& frame) { maxlogdet_good_features_set_spread(frame.good.get(), -1); }}};
  for (const WrongFrame& wrong : frames) {
    SCOPED_TRACE(&wrong - frames);
    CFrame frame;
    wrong.make(frame);
    frame.start_and_add(wrong.of_start);
    const maxlogdet_selection* const selection = frame.select();
    EXPECT_EQ(selection, maxlogdet_good_features_selection(frame.good.get()));
    EXPECT_EQ(selection->error, wrong.of_select);
    EXPECT_EQ(selection->size, wrong.of_select == none ? 40U : CFrame::n);
    EXPECT_STREQ(maxlogdet_good_features_reason(frame.good.get()),
                 wrong.of_select == none ? "ok" : maxlogdet_error_name(wrong.of_select));
    EXPECT_EQ(std::isnan(maxlogdet_good_features_efficiency(frame.good.get())), wrong.of_select != none);
    if (wrong.of_select == none) continue;
    EXPECT_EQ(selection->status, MAXLOGDET_STATUS_ERROR);
    for (std::size_t j = 0; j < selection->size; ++j) EXPECT_EQ(selection->indices[j], j);
    frame.camera.reserved = 0;
    frame.pose = identity;
    frame.has_camera = frame.has_extrinsics = true;
    frame.rig_size = 2;
    frame.start_and_add(none);  // a right start makes up for it
  }
}

TEST(CApiMisuse, matches_beyond_the_capacity_and_refused_ones_take_their_numbers) {
  CFrame frame;
  frame.start_and_add(none);
  auto match = fuzz::defaults_of(maxlogdet_match_init);
  EXPECT_EQ(maxlogdet_good_features_add(frame.good.get(), &match), MAXLOGDET_ERROR_CAPACITY_EXCEEDED);
  match.reserved = 1;
  EXPECT_EQ(maxlogdet_good_features_add(frame.good.get(), &match), refused);
  EXPECT_EQ(maxlogdet_good_features_add(frame.good.get(), nullptr), refused);
  EXPECT_EQ(maxlogdet_good_features_size(frame.good.get()), CFrame::n + 3);
  EXPECT_EQ(maxlogdet_good_features_id(frame.good.get(), CFrame::n), MAXLOGDET_NONE);
  EXPECT_EQ(frame.select()->status, MAXLOGDET_STATUS_OK);
  EXPECT_STREQ(maxlogdet_good_features_reason(frame.good.get()), "capacity_exceeded");
}

TEST(CApiMisuse, active_matching_without_options_tries_in_order_and_without_a_function_nothing) {
  CFrame frame;
  std::size_t calls = 0;
  const auto find_even = [](void* context, std::size_t i, maxlogdet_match* match) {
    ++*static_cast<std::size_t*>(context);
    EXPECT_EQ(match->id, 1000 + i);
    EXPECT_EQ(match->struct_size, sizeof *match);
    return i % 2 == 0 ? std::int32_t{9} : 0;
  };
  const auto spoil = [](void* /*context*/, std::size_t /*i*/, maxlogdet_match* match) {
    match->struct_size = 3;
    return std::int32_t{1};
  };
  frame.start_and_add(none);
  const maxlogdet_selection* selection =
      maxlogdet_good_features_match(frame.good.get(), &frame.options, find_even, &calls);
  EXPECT_EQ(selection->size, 40U);
  frame.start_and_add(none);
  EXPECT_EQ(maxlogdet_good_features_match(frame.good.get(), &frame.options, spoil, nullptr)->size, 0U);
  frame.start_and_add(none);
  calls = 0;
  selection = maxlogdet_good_features_match(frame.good.get(), nullptr, find_even, &calls);
  EXPECT_EQ(selection->error, refused);
  EXPECT_EQ(calls, CFrame::n);
  ASSERT_EQ(selection->size, CFrame::n / 2);
  EXPECT_EQ(selection->indices[1], 2U);
  frame.start_and_add(none);
  EXPECT_TRUE(fuzz::is_refusal(maxlogdet_good_features_match(frame.good.get(), &frame.options, nullptr, nullptr)));
  EXPECT_EQ(frame.select()->status, MAXLOGDET_STATUS_OK);
}

// The candidates of the previous start may no longer exist: nothing may access them.
TEST(CApiMisuse, a_start_that_is_refused_ends_what_was_under_way) {
  const auto options = fuzz::defaults_of(maxlogdet_options_init);
  auto broken = options;
  broken.struct_size = 3;
  const CActive owned = c_active(20);
  maxlogdet_active_selection* const active = owned.get();
  EXPECT_EQ(maxlogdet_active_selection_selection(active)->error, MAXLOGDET_ERROR_NOTHING_PROPOSED);
  const maxlogdet_options* const all_given[] = {&options, &broken, nullptr};
  for (const maxlogdet_options* const given : all_given) {
    const double block[6] = {1, 2, 3, 4, 5, 6};
    const std::uint8_t matched[1] = {1};
    std::uint32_t index = MAXLOGDET_NONE;
    {
      const CBlocks blocks = c_blocks(1);
      maxlogdet_block_store_push_back(blocks.get(), block, 1);
      EXPECT_EQ(maxlogdet_active_selection_start(active, blocks.get(), &options), none);
      EXPECT_EQ(maxlogdet_active_selection_next_batch(active, &index, 1), 1U);
      EXPECT_EQ(maxlogdet_active_selection_start(active, given == &options ? nullptr : blocks.get(), given), refused);
    }
    EXPECT_EQ(maxlogdet_active_selection_next(active), MAXLOGDET_NONE);
    EXPECT_EQ(maxlogdet_active_selection_next_batch(active, &index, 1), 0U);
    for (const maxlogdet_error error :
         {maxlogdet_active_selection_accept(active), maxlogdet_active_selection_accept_block(active, block, 1),
          maxlogdet_active_selection_reject(active), maxlogdet_active_selection_accept_index(active, index),
          maxlogdet_active_selection_accept_block_index(active, index, block, 1),
          maxlogdet_active_selection_reject_index(active, index),
          maxlogdet_active_selection_answer(active, matched, 1)}) {
      EXPECT_EQ(error, MAXLOGDET_ERROR_NOTHING_PROPOSED);
    }
    EXPECT_TRUE(fuzz::is_refusal(maxlogdet_active_selection_selection(active)));
  }
}

}  // namespace
}  // namespace maxlogdet::test
