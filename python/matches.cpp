// SPDX-License-Identifier: MIT
#include "python/matches.hpp"

#include "python/errors.hpp"
#include "python/executor.hpp"
#include "python/names.hpp"

#include <cstdint>

namespace maxlogdet::python {
namespace {

std::vector<unsigned char> ids_of(const py::object& camera_ids, py::ssize_t n) {
  if (camera_ids.is_none()) return {};
  std::vector<unsigned char> ids;
  for (const std::uint32_t id : integers<std::uint32_t>(camera_ids, "camera_ids", {n})) {
    if (id > 255) throw SelectionError(Error::invalid_camera_id);
    ids.push_back(static_cast<unsigned char>(id));
  }
  return ids;
}

Weighting weighting_from(const std::optional<std::string>& weighting, bool has_covariances) {
  if (weighting.has_value()) return weighting_of(*weighting);
  const Weighting by_default = BlockOptions().weighting;
  return has_covariances ? with_covariances(by_default) : by_default;
}

}  // namespace

MatchArrays::MatchArrays(const py::object& points, const py::object& sigmas, const py::object& has_depth_cue,
                         const py::object& map_covariances, const py::object& jacobians, const py::object& camera_ids)
    : points_(point_array(points, "points")),
      sigmas_(optional_real_array(sigmas, "sigmas", {size()})),
      has_depth_cue_(optional_mask(has_depth_cue, "has_depth_cue", static_cast<std::size_t>(size()))),
      map_covariances_(optional_real_array(map_covariances, "map_covariances", {size(), 3, 3})),
      jacobians_(optional_real_array(jacobians, "jacobians", {size(), 2, 3})),
      camera_ids_(ids_of(camera_ids, size())) {}

void MatchArrays::add(const py::object& usable, const py::object& weights) {
  usable_ = optional_mask(usable, "usable", static_cast<std::size_t>(size()));
  weights_ = optional_real_array(weights, "weights", {size()});
}

Matches MatchArrays::view() const {
  Matches matches;
  matches.size = static_cast<std::size_t>(size());
  matches.points = points_of(points_);
  matches.sigmas = data_or_null(sigmas_);
  matches.has_depth_cue = data_or_null(has_depth_cue_);
  matches.usable = data_or_null(usable_);
  matches.weights = data_or_null(weights_);
  matches.map_covariances = data_or_null(map_covariances_);
  matches.jacobians = data_or_null(jacobians_);
  matches.camera_ids = data_or_null(camera_ids_);
  return matches;
}

BlockOptions options_of(const std::optional<std::string>& weighting, bool has_covariances, const std::string& depth_cue,
                        double map_sigma, double depth_sigma) {
  BlockOptions options;
  options.weighting = weighting_from(weighting, has_covariances);
  options.depth_cue = depth_cue_of(depth_cue);
  options.map_sigma = map_sigma;
  options.depth_sigma = depth_sigma;
  return options;
}

BlockReport append(const OwnCameras& cameras, const RigidTransform& pose, const Matches& matches,
                   const BlockOptions& options, BlockStore& blocks) {
  const BlockReport report = append_blocks(cameras.view(), pose, matches, options, blocks, executor());
  if (report.error == Error::invalid_pose) {
    throw SelectionError(report.error,
                         "the left 3 x 3 part R of T_cw, or of a T_cb, is no rotation: expected R R^T = I within 1e-3, "
                         "det R > 0");
  }
  check(report.error);
  return report;
}

}  // namespace maxlogdet::python
