// SPDX-License-Identifier: MIT
#pragma once

#include "python/arrays.hpp"

#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/good_features.hpp>
#include <maxlogdet/jacobian.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::python {

/// FeatureMatches from Python's arrays, one for each member, converted and checked against their shapes; without an
/// array, or with None, the member keeps its default.
class FeatureMatches {
 public:
  FeatureMatches(const py::object& points, const py::object& measured, const py::object& sigmas);

  /// Takes another array by the name of its keyword. Returns false if there is no such keyword.
  bool take(const std::string& name, const py::object& value);
  /// Takes what only GoodFeatures.add() has.
  bool take_of_frame(const std::string& name, const py::object& value);

  std::size_t size() const { return static_cast<std::size_t>(points_.shape(0)); }
  void add_to(GoodFeatures& good) const;

 private:
  FeatureMatch match(std::size_t i) const;

  Array<double> points_, measured_, sigmas_, u_right_, depth_, covariances_, jacobians_;
  Array<bool> required_;
  std::vector<std::uint8_t> camera_ids_;
  std::vector<std::int64_t> point_ids_, keyframes_;
};

/// Takes a keyword of BlockOptions. Returns false if there is no such keyword.
bool take(BlockOptions& options, const std::string& name, const py::object& value);

/// Fills in what a function that tries to match has returned: None or False, True, (u, v), or a dict. Returns whether
/// the match is found.
bool fill_in(const py::object& found, FeatureMatch& match);

}  // namespace maxlogdet::python
