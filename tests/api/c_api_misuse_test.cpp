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
  const auto no_functions = fuzz::defaults_of(maxlogdet_executor_init);
  EXPECT_EQ(of_selector(10, &no_functions), refused);
  EXPECT_EQ(of_good_features(10, &no_functions), refused);
  const CBlocks blocks = c_blocks(4);
  for (const std::size_t capacity : {absurd, std::size_t{1} << 32U}) {
    EXPECT_EQ(maxlogdet_block_store_reserve(blocks.get(), capacity), no_memory);
    EXPECT_EQ(maxlogdet_block_store_capacity(blocks.get()), 4U);
  }
}

// What a caller gives for blocks, and where they go.
struct Call {
  static constexpr std::size_t n = 3;

  Call() {
    camera.fx = camera.fy = 300;
    matches.size = n;
    matches.points = points;
  }
  Call(const Call&) = delete;  // the matches point into it
  Call& operator=(const Call&) = delete;

  int error() const {
    const maxlogdet_camera* const cameras[2] = {&camera, &camera};
    const double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const CBlocks blocks = c_blocks(n);
    const maxlogdet_block_report* const report =
        rig_size == 0
            ? maxlogdet_append_blocks(&camera, pose, &matches, &options, blocks.get(), executor)
            : maxlogdet_append_blocks_of_rig(cameras, T_cb, rig_size, pose, &matches, &options, blocks.get(), executor);
    EXPECT_EQ(report->appended, report->error == none ? n : 0);
    EXPECT_EQ(maxlogdet_block_store_size(blocks.get()), report->appended);
    return report->error;
  }

  const double points[3 * n] = {0, 0, 5, 1, -1, 4, 2, 1, 3};
  maxlogdet_camera camera = fuzz::defaults_of(maxlogdet_camera_init);
  maxlogdet_matches matches = fuzz::defaults_of(maxlogdet_matches_init);
  maxlogdet_block_options options = fuzz::defaults_of(maxlogdet_block_options_init);
  const double* pose = identity;
  const maxlogdet_executor* executor = nullptr;
  std::size_t rig_size = 0;
};

// A rule of the header that a caller breaks, and the error that it names.
struct Mistake {
  int error;
  void (*make)(Call& call);
};

TEST(CApiMisuse, blocks_that_cannot_be_made_are_told) {
  static const std::uint8_t ids[Call::n] = {0, 1, 0};
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
      {MAXLOGDET_ERROR_INVALID_CAMERA, [](Call& call) { call.camera.fx = 0; }},
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
  const CBlocks blocks = c_blocks(1);
  EXPECT_EQ(
      maxlogdet_append_blocks_of_rig(nullptr, nullptr, 0, identity, &call.matches, &call.options, blocks.get(), nullptr)
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
