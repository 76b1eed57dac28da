// SPDX-License-Identifier: MIT
#include "tracker.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>

int main() {
  std::vector<double> points;
  for (int i = 0; i < 500; ++i) {
    const double z = 2 + i % 17;
    const double point[3] = {z * (i % 23 - 11) / 12, z * (i % 19 - 9) / 15, z};
    points.insert(points.end(), point, point + 3);
  }
  const Tracked tracked = track_frame(points);
  const bool is_right = tracked.selected == 100 && tracked.outliers > 50 && tracked.outliers <= 100 &&
                        helpers_change_nothing(points) && std::abs(log_det_with_eigen() - std::log(13.0)) < 1e-12 &&
                        std::strcmp(maxlogdet::version(), MAXLOGDET_VERSION) == 0;
  std::printf("maxlogdet %s on %s: %zu selected, %zu outliers, %s\n", maxlogdet::version(), maxlogdet::active_isa(),
              tracked.selected, tracked.outliers, is_right ? "right" : "WRONG");
  return is_right ? 0 : 1;
}
