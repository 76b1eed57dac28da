// SPDX-License-Identifier: MIT
#pragma once

#include "python/arrays.hpp"
#include "python/cameras.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/jacobian.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::python {

/// The arrays of append_blocks and of the weights of residuals, converted and checked against their shapes.
class MatchArrays {
 public:
  MatchArrays(const py::object& points, const py::object& sigmas, const py::object& has_depth_cue,
              const py::object& map_covariances, const py::object& jacobians, const py::object& camera_ids);

  /// Only blocks have these.
  void add(const py::object& usable, const py::object& weights);

  py::ssize_t size() const { return points_.shape(0); }

  /// Views into this object.
  Matches view() const;

 private:
  py::array points_;
  Array<double> sigmas_;
  Array<bool> has_depth_cue_;
  Array<double> map_covariances_;
  Array<double> jacobians_;
  std::vector<unsigned char> camera_ids_;
  Array<bool> usable_;
  Array<double> weights_;
};

/// The options that blocks and weights share.
BlockOptions options_of(const std::optional<std::string>& weighting, bool has_covariances, const std::string& depth_cue,
                        double map_sigma, double depth_sigma);

/// As maxlogdet::append_blocks, for one camera or a rig; throws SelectionError.
BlockReport append(const OwnCameras& cameras, const RigidTransform& pose, const Matches& matches,
                   const BlockOptions& options, BlockStore& blocks);

}  // namespace maxlogdet::python
