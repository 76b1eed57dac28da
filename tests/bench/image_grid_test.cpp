// SPDX-License-Identifier: MIT
#include "bench/world/image_grid.hpp"

#include "tests/support/support.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

TEST(ImageGrid, numbers_cells_row_by_row_and_clamps_pixels_to_the_image) {
  sim::Frame frame;
  frame.width = 752;
  frame.height = 480;
  const sim::ImageGrid grid{10, 8};
  const auto cell_of = [&](double u, double v) {
    sim::Match match;
    match.u = u;
    match.v = v;
    return grid.cell_of(frame, match);
  };
  EXPECT_EQ(grid.cells(), 80U);
  EXPECT_EQ(cell_of(0, 0), 0U);
  EXPECT_EQ(cell_of(75.19, 59.99), 0U);
  EXPECT_EQ(cell_of(75.21, 59.99), 1U);
  EXPECT_EQ(cell_of(75.19, 60.01), 10U);
  EXPECT_EQ(cell_of(751.99, 479.99), 79U);
  EXPECT_EQ(cell_of(752, 480), 79U);
  EXPECT_EQ(cell_of(1e300, -5), 9U);
  EXPECT_EQ(cell_of(-1e300, std::numeric_limits<double>::infinity()), 70U);
  EXPECT_EQ(cell_of(std::nan(""), 61), 10U);
  frame.width = frame.height = 0;
  EXPECT_LT(cell_of(300, 200), 80U) << "an image of unknown size";
}

}  // namespace
}  // namespace maxlogdet::test
