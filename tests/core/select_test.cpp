// SPDX-License-Identifier: MIT
// select(), the one call for scripts, against GoodFeatures on the same matches; and that no view of a temporary's
// answer compiles.
#include "tests/core/feature_frame.hpp"
#include "tests/support/block_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/select.hpp>

#include <type_traits>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

TEST(Select, is_what_good_features_give) {
  GoodFeatures good(150);
  for_frames_of_all_kinds(trials(30), 150, [&](Random&, const FeatureFrame& frame) {
    const RigidTransform T_cw = rows_of(frame.T_cw);
    frame.start(good);
    for (const FeatureMatch& match : frame.matches) good.add(match);  // without covariances and Jacobians
    Options options(30);
    options.certificate.compute = true;
    const Selection expected = good.select(options);
    const SelectedMatches selected =
        frame.kind.has_rig ? select(Rig{frame.rig_cameras, 2}, T_cw, frame.matches, options, frame.options)
                           : select(frame.rig_cameras[0].camera, T_cw, frame.matches, options, frame.options);
    EXPECT_EQ(selected.indices, indices_of(expected));
    EXPECT_EQ(selected.gains, std::vector<double>(expected.gains, expected.gains + expected.size));
    EXPECT_EQ(selected.log_det, expected.log_det);
    EXPECT_EQ(selected.upper_bound, expected.upper_bound);
    EXPECT_EQ(selected.status, Status::ok);
    EXPECT_STREQ(selected.reason(), "ok");
  });
}

TEST(Select, takes_points_and_returns_all_usable_ones_after_an_error) {
  const std::vector<Eigen::Vector3d> points = {{0, 0, 5}, {nan, 0, 5}, {1, 0, 5}};
  const Camera camera = typical_camera(CameraModel::pinhole);
  EXPECT_EQ(select(camera, identity_pose, points, 1).size(), 1U);
  const SelectedMatches selected = select(camera, nullptr, points, 1);
  EXPECT_EQ(selected.error, Error::invalid_pose);
  EXPECT_STREQ(selected.reason(), "invalid_pose");
  EXPECT_EQ(std::vector<std::uint32_t>(selected.begin(), selected.end()), (std::vector<std::uint32_t>{0, 2}));
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
