// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/block_oracle.hpp"
#include "tests/support/differences.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/jacobian.hpp>

// One match of a pinhole camera, drawn at random.

namespace maxlogdet::test {

struct PinholeCase {
  PinholeCamera camera;
  WideIsometry T_cw;
  WideVector3 p_w;
  DepthCue depth_cue;
};

inline PinholeCase random_case(Random& random, DepthCue depth_cue) {
  PinholeCase c;
  c.camera = {random.uniform(300, 800), random.uniform(300, 800), 320, 240, random.uniform(20, 400)};
  WideVector3 axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  c.T_cw = Eigen::AngleAxis<long double>(random.uniform(-3, 3), axis.normalized());
  c.T_cw.translation() << random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2);
  const double z = random.uniform(0.5, 50);
  c.p_w = c.T_cw.inverse() * WideVector3(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
  c.depth_cue = depth_cue;
  return c;
}

inline BlockOptions options_of(Weighting weighting, const PinholeCase& c) {
  BlockOptions options;
  options.weighting = weighting;
  options.depth_cue = c.depth_cue;
  options.depth_sigma = 0.07;
  options.map_sigma = 0.11;
  return options;
}

}  // namespace maxlogdet::test
