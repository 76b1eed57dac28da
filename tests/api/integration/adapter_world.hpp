// SPDX-License-Identifier: MIT
#pragma once

#include "tests/api/integration/oracle.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/adapters/hook.hpp>

#include <cstddef>
#include <map>
#include <memory>
#include <ostream>
#include <set>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// A frame of a tracker in which the lines of the guide stand, and what its adapter has to make of it. Candidates count
/// from 0, in the order in which the adapter meets them.
class AdapterWorld {
 public:
  virtual ~AdapterWorld() = default;

  /// The tracker's own.
  virtual TrackerHook& hook() = 0;
  /// A frame: the candidates that the tracker continues with.
  virtual std::set<std::size_t> run() = 0;
  /// H^T H of each, by the tracker's own chain of transforms.
  virtual std::vector<Matrix6> informations() const = 0;

  /// Leaves the frame without a pose, or with none.
  virtual void lose_pose() = 0;
  virtual void make_not_finite(std::size_t i) = 0;
  virtual void put_behind_camera(std::size_t i) = 0;
  /// Of what cannot be a candidate. Where it is no outlier, the tracker keeps it.
  virtual bool is_outlier(std::size_t /*i*/) const { return false; }
  virtual bool has_outliers() const { return false; }

  /// A recorded frame's row of a candidate, by column.
  virtual std::map<std::string, double> recorded(std::size_t i) const = 0;
};

struct AdapterCase {
  const char* name;
  /// n candidates; budget and capacity are those of the adapter.
  std::unique_ptr<AdapterWorld> (*make)(Random& random, std::size_t n, std::size_t budget, std::size_t capacity);
  double tolerance;  ///< of H^T H: what the tracker's scalars leave
};

inline void PrintTo(const AdapterCase& of, std::ostream* out) { *out << of.name; }

/// The world of a type, as AdapterCase::make.
template <class World>
std::unique_ptr<AdapterWorld> make_world(Random& random, std::size_t n, std::size_t budget, std::size_t capacity) {
  return std::make_unique<World>(random, n, budget, capacity);
}

/// What holds of every adapter (adapters_test.cpp); the file of each tracker adds its own.
class AnyAdapter : public ::testing::TestWithParam<AdapterCase> {
 protected:
  std::unique_ptr<AdapterWorld> world_of(std::size_t n, std::size_t budget, std::size_t capacity = 1000) {
    return GetParam().make(random, n, budget, capacity);
  }

  Random random;
  ::testing::ScopedTrace trace{__FILE__, __LINE__, random.name()};
};

inline std::string name_of(const ::testing::TestParamInfo<AdapterCase>& info) { return info.param.name; }

}  // namespace maxlogdet::test
