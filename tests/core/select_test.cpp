// SPDX-License-Identifier: MIT
// select(), the one call for scripts, against a Selector on the same candidates; and that no view of a temporary's
// answer compiles.
#include "tests/core/feature_frame.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/select.hpp>

#include <cmath>
#include <type_traits>
#include <utility>

namespace maxlogdet::test {
namespace {

TEST(Select, of_blocks_is_what_a_selector_gives) {
  for (std::uint64_t variation = 0; variation < trials(20); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 150);
    for (const std::size_t budget : {std::size_t{0}, std::size_t{30}, std::size_t{150}, std::size_t{500}}) {
      const Options options = with_budget(budget);
      Selector selector(500);
      const Selection expected = selector.select(blocks, options);
      const SelectedMatches selected = select(blocks, options);
      EXPECT_EQ(selected.indices, indices_of(expected));
      EXPECT_EQ(selected.status, expected.status);
      EXPECT_EQ(selected.log_det, expected.log_det);
      EXPECT_EQ(selected.invalid, expected.invalid_candidates);
      EXPECT_TRUE(selected.has_answer);
    }
    Options wrong;
    wrong.time_limit = -1;
    const SelectedMatches selected = select(blocks, wrong);
    EXPECT_EQ(selected.error, Error::invalid_time_limit);
    EXPECT_FALSE(selected.has_answer);
    EXPECT_TRUE(selected.indices.empty());
    EXPECT_TRUE(std::isnan(selected.log_det));
  }
}

TEST(Select, of_matches_is_append_blocks_and_a_selector) {
  for (std::uint64_t variation = 0; variation < trials(30); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    FeatureKind kind = random_kind(random);
    kind.has_jacobians = false;
    const FeatureFrame frame(random, 150, kind);
    const Matches matches = frame.arrays();
    const RigidTransform T_cw = rows_of(frame.T_cw);
    const SelectedMatches selected =
        kind.has_rig ? select(Rig{frame.rig_cameras, 2}, T_cw, matches, with_budget(30), frame.options)
                     : select(frame.rig_cameras[0].camera, T_cw, matches, with_budget(30), frame.options);
    EXPECT_EQ(selected.indices, select_indices(frame.blocks(), with_budget(30)));
    EXPECT_EQ(selected.block_status, Error::none);
    EXPECT_EQ(selected.status, Status::ok);
    EXPECT_TRUE(selected.has_answer);
  }
}

TEST(Select, of_matches_without_blocks_has_no_answer) {
  const double points[3] = {0, 0, 5};
  Matches matches;
  matches.size = 1;
  matches.points = points;
  const SelectedMatches selected = select(typical_camera(CameraModel::pinhole), RigidTransform(nullptr), matches);
  EXPECT_EQ(selected.block_status, Error::invalid_pose);
  EXPECT_FALSE(selected.has_answer);
  EXPECT_TRUE(selected.indices.empty());
}

// A view of an object that ends with the statement does not compile.
template <class Taken, class = void>
struct CanSelect : std::false_type {};
template <class Taken>
struct CanSelect<Taken, decltype(static_cast<void>(std::declval<Taken>().select(std::declval<const BlockStore&>(),
                                                                                Options())))> : std::true_type {};
template <class Taken, class = void>
struct HasSelection : std::false_type {};
template <class Taken>
struct HasSelection<Taken, decltype(static_cast<void>(std::declval<Taken>().selection()))> : std::true_type {};

static_assert(CanSelect<Selector&>::value && !CanSelect<Selector>::value, "Selector(10).select(...) would dangle");
static_assert(HasSelection<ActiveSelection&>::value && HasSelection<const ActiveSelection&>::value &&
                  !HasSelection<ActiveSelection>::value && !HasSelection<const ActiveSelection>::value,
              "a temporary ActiveSelection's selection() would dangle");

}  // namespace
}  // namespace maxlogdet::test
