// SPDX-License-Identifier: MIT
#include "tracker.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>

int main() {
  std::vector<double> points;
  for (int i = 0; i < 500; ++i) {
    const double z = 2 + i % 17;
    const double point[3] = {z * (i % 23 - 11) / 12, z * (i % 19 - 9) / 15, z};
    points.insert(points.end(), point, point + 3);
  }
  const std::vector<std::uint32_t> selected = select_matches(points);
  const bool is_right = selected.size() == 200 &&
                        std::set<std::uint32_t>(selected.begin(), selected.end()).size() == 200 &&
                        helpers_change_nothing(points) && std::abs(log_det_with_eigen() - std::log(13.0)) < 1e-12 &&
                        std::strcmp(maxlogdet::version(), MAXLOGDET_VERSION) == 0;
  std::printf("maxlogdet %s on %s: %zu selected, %s\n", maxlogdet::version(), maxlogdet::active_isa(), selected.size(),
              is_right ? "right" : "WRONG");
  return is_right ? 0 : 1;
}
