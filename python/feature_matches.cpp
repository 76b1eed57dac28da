// SPDX-License-Identifier: MIT
#include "python/feature_matches.hpp"

#include "python/names.hpp"

#include <algorithm>

namespace maxlogdet::python {

FeatureMatches::FeatureMatches(const py::object& points, const py::object& measured, const py::object& sigmas)
    : points_(real_array(points, "points", {any_n, 3})),
      measured_(optional_real_array(measured, "measured", {points_.shape(0), 2})),
      sigmas_(optional_real_array(sigmas, "sigmas", {points_.shape(0)})) {}

bool FeatureMatches::take(const std::string& name, const py::object& value) {
  const py::ssize_t n = points_.shape(0);
  if (name == "u_right") {
    u_right_ = optional_real_array(value, "u_right", {n});
  } else if (name == "depth") {
    depth_ = optional_real_array(value, "depth", {n});
  } else if (name == "covariances") {
    covariances_ = optional_real_array(value, "covariances", {n, 3, 3});
  } else if (name == "jacobians") {
    jacobians_ = optional_real_array(value, "jacobians", {n, 2, 3});
  } else if (name == "camera_ids") {
    if (!value.is_none()) camera_ids_ = integers<std::uint8_t>(value, "camera_ids", {n});
  } else {
    return false;
  }
  return true;
}

bool FeatureMatches::take_of_frame(const std::string& name, const py::object& value) {
  const py::ssize_t n = points_.shape(0);
  if (name == "required") {
    required_ = optional_mask(value, "required", size());
  } else if (name == "point_ids") {
    if (!value.is_none()) point_ids_ = integers<std::int64_t>(value, "point_ids", {n});
  } else if (name == "keyframes") {
    if (!value.is_none()) keyframes_ = integers<std::int64_t>(value, "keyframes", {n});
  } else {
    return false;
  }
  return true;
}

FeatureMatch FeatureMatches::match(std::size_t i) const {
  FeatureMatch match;
  std::copy_n(points_.data() + 3 * i, 3, match.point);
  if (measured_.size() > 0) std::copy_n(measured_.data() + 2 * i, 2, match.measured);
  if (sigmas_.size() > 0) match.sigma = sigmas_.data()[i];
  if (u_right_.size() > 0) match.u_right = u_right_.data()[i];
  if (depth_.size() > 0) match.depth = depth_.data()[i];
  if (covariances_.size() > 0) match.covariance = covariances_.data() + 9 * i;
  if (jacobians_.size() > 0) match.jacobian = jacobians_.data() + 6 * i;
  if (required_.size() > 0) match.is_required = required_.data()[i];
  if (!camera_ids_.empty()) match.camera_id = camera_ids_[i];
  if (!point_ids_.empty()) match.point_id = point_ids_[i];
  if (!keyframes_.empty()) match.keyframe = keyframes_[i];
  return match;
}

void FeatureMatches::add_to(GoodFeatures& good) const {
  for (std::size_t i = 0; i < size(); ++i) good.add(match(i));
}

bool take(BlockOptions& options, const std::string& name, const py::object& value) {
  if (name == "weighting") {
    options.weighting = weighting_of(string_from(value, "weighting"));
  } else if (name == "map_sigma") {
    options.map_sigma = number_from(value, "map_sigma");
  } else if (name == "depth_sigma") {
    options.depth_sigma = number_from(value, "depth_sigma");
  } else if (name == "min_depth") {
    options.min_depth = number_from(value, "min_depth");
  } else {
    return false;
  }
  return true;
}

bool fill_in(const py::object& found, FeatureMatch& match) {
  if (found.is_none()) return false;
  if (is_bool(found)) return found.cast<bool>();
  const auto measure = [&match](const py::handle& value) {
    std::copy_n(real_array(value, "measured", {2}).data(), 2, match.measured);
  };
  if (!py::isinstance<py::dict>(found)) {
    measure(found);
    return true;
  }
  for (const auto& [key, value] : found.cast<py::dict>()) {
    const std::string name = string_from(key, "try_to_match(i)");
    if (name == "measured") {
      measure(value);
    } else if (name == "sigma") {
      match.sigma = number_from(value, "sigma");
    } else if (name == "u_right") {
      match.u_right = number_from(value, "u_right");
    } else if (name == "depth") {
      match.depth = number_from(value, "depth");
    } else {
      throw py::type_error("try_to_match(i): unexpected key '" + name + "'");
    }
  }
  return true;
}

}  // namespace maxlogdet::python
