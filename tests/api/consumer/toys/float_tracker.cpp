// SPDX-License-Identifier: MIT
// A toy tracker with arrays of float, stereo, and every trouble a frame can have: a deadline that is over at once,
// numbers that are not finite, too few matches, no pose.
#include <maxlogdet/good_features.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "world.hpp"

namespace {

using maxlogdet::RigidTransform;

struct Match {
  float point[3];
  float pixel[2];
  float u_right;  // negative: none
  float sigma;
  bool is_used, is_outlier;
};

Match match_of(const toy::Seen& seen, bool is_stereo) {
  Match match{};
  for (int d = 0; d < 3; ++d) match.point[d] = static_cast<float>(seen.point[d]);
  match.pixel[0] = static_cast<float>(seen.u);
  match.pixel[1] = static_cast<float>(seen.v);
  match.u_right = is_stereo ? static_cast<float>(seen.u_right) : -1;
  match.sigma = static_cast<float>(seen.sigma);
  return match;
}

toy::Observation observation_of(const Match& m) {
  const Eigen::Vector3d point = Eigen::Map<const Eigen::Vector3f>(m.point).cast<double>();
  return {point, double{m.pixel[0]}, double{m.pixel[1]}, double{m.u_right}, double{m.sigma}};
}

bool is_finite(const Match& m) {
  return std::isfinite(m.point[0] + m.point[1] + m.point[2] + m.pixel[0] + m.pixel[1] + m.sigma) && m.sigma > 0;
}

maxlogdet::FeatureMatch stereo(const Match& m) {
  maxlogdet::FeatureMatch match(m.point, m.pixel, double{m.sigma});
  match.u_right = double{m.u_right};
  return match;
}

class Tracker {
 public:
  void track(std::vector<Match>& matches) {
    std::vector<toy::Observation> used;
    good_.start(camera_, RigidTransform::row_major(T_cw));
    for (const Match& m : matches) good_.add(stereo(m));
    for (const std::size_t i : good_.select(options)) {
      used.push_back(observation_of(matches[i]));
      matches[i].is_used = true;
    }
    store(toy::optimize(pose(), used));
    for (const std::size_t i : good_.outliers(RigidTransform::row_major(T_cw))) matches[i].is_outlier = true;
  }

  Eigen::Isometry3d pose() const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = double{T_cw[i]};
    return T;
  }
  void store(const Eigen::Isometry3d& T) {
    for (int i = 0; i < 12; ++i) T_cw[i] = static_cast<float>(T.matrix()(i / 4, i % 4));
  }

  float T_cw[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  maxlogdet::Options options = 100;

 private:
  const maxlogdet::Camera camera_{toy::fx, toy::fy, toy::cx, toy::cy, toy::bf};
  maxlogdet::GoodFeatures good_{2000};
};

// Tracks a frame, and looks at what is used: only what is finite, of that the budget, and all of it without a pose.
void track(Tracker& tracker, int number, std::vector<Match>& matches, bool is_lost, toy::Judge& judge) {
  std::size_t usable = 0, used = 0;
  for (const Match& m : matches) usable += is_finite(m) ? 1 : 0;
  const std::size_t expected = is_lost ? usable : std::min(usable, tracker.options.budget);
  tracker.track(matches);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    used += matches[i].is_used ? 1 : 0;
    judge.expect(is_finite(matches[i]) || (!matches[i].is_used && matches[i].is_outlier), "match", static_cast<int>(i));
  }
  judge.expect(used == expected, "number used in", number);
}

void track_well(bool is_stereo, double time_limit, toy::Judge& judge) {
  Tracker tracker;
  tracker.options.time_limit = time_limit;
  for (int number = 0; number < 20; ++number) {
    const std::vector<toy::Seen> frame = toy::see(number);
    std::vector<Match> matches;
    for (const toy::Seen& seen : frame) matches.push_back(match_of(seen, is_stereo && seen.octave % 2 == 0));
    track(tracker, number, matches, false, judge);
    judge.pose(tracker.pose(), number);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      judge.outlier(frame[i], matches[i].is_used, matches[i].is_outlier, i);
    }
  }
}

void track_in_trouble(int count, double time_limit, toy::Judge& judge) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Tracker tracker;
  tracker.options.time_limit = time_limit;
  for (int number = 0; number < 20; ++number) {
    std::vector<Match> matches;
    for (const toy::Seen& seen : toy::see(number, count)) matches.push_back(match_of(seen, true));
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (i % 11 == 3) matches[i].point[i % 3] = nan;
      if (i % 11 == 5) matches[i].pixel[i % 2] = infinity;
      if (i % 11 == 7) matches[i].sigma = i % 2 == 0 ? nan : 0;
      if (i % 11 == 9) matches[i].u_right = nan;
    }
    tracker.store(toy::true_pose(number));
    const bool is_lost = number % 5 == 4;
    if (is_lost) tracker.T_cw[number % 12] = nan;
    track(tracker, number, matches, is_lost, judge);
    if (!is_lost && count > 100) judge.pose(tracker.pose(), number);
  }
}

}  // namespace

int main() {
  toy::Judge judge;
  track_well(false, 0, judge);
  track_well(true, 0, judge);
  track_well(true, 1e-6, judge);
  for (const int count : {0, 1, 5, 50, 600}) {
    track_in_trouble(count, 0, judge);
    track_in_trouble(count, 1e-6, judge);
  }
  return judge.end("a tracker with floats");
}
