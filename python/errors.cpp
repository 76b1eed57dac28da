// SPDX-License-Identifier: MIT
#include "python/errors.hpp"

#include "python/bindings.hpp"

#include <exception>
#include <string>

namespace maxlogdet::python {
namespace {

const char* explain(Status status) noexcept {
  switch (status) {
    case Status::ok:
    case Status::all_selected:
    case Status::deadline_reached:
    case Status::target_reached: return "not an error";
    case Status::invalid_budget: return "the budget is above the selector's capacity";
    case Status::invalid_epsilon: return "stochastic_greedy takes 0 < epsilon < 1";
    case Status::invalid_prior: return "the prior is not finite, not symmetric, or not safely positive definite";
    case Status::capacity_exceeded: return "more candidates than the selector's capacity";
    case Status::invalid_strategy: return "this kind of selection does not know the strategy";
    case Status::invalid_time_limit: return "time_limit is negative or NaN";
    case Status::invalid_threads: return "threads is negative";
    case Status::invalid_groups: return "a group without a maximum";
    case Status::infeasible:
      return "a required candidate is excluded or invalid, or more are required than the budget or a group allows";
    case Status::unsupported_groups: return "the strategy has no way to keep to groups";
    case Status::nothing_proposed: return "an answer without a proposal";
    case Status::invalid_block: return "the block as measured is not finite";
    case Status::unsupported_isa: return "MAXLOGDET_ISA names an instruction set not built in, or not of this machine";
    case Status::invalid_target: return "a target is negative, NaN or infinite, or target_efficiency is above 1";
    case Status::unsupported_target:
      return "the strategy, or exchange_sweeps, has no order in which to stop at a target";
  }
  return "unknown";
}

const char* explain(BlockStatus status) noexcept {
  switch (status) {
    case BlockStatus::ok:
    case BlockStatus::singular_rays:
    case BlockStatus::invalid_jacobians: return "not an error";
    case BlockStatus::invalid_camera:
      return "fx, fy, and for stereo rows bf of a pinhole, must be positive and finite, and distortion in its range";
    case BlockStatus::invalid_pose:
      return "the left 3 x 3 part R of T_cw, or of a T_cb, is no rotation: expected R R^T = I within 1e-3, det R > 0";
    case BlockStatus::invalid_options:
      return "map_sigma and min_depth must not be negative, depth_sigma must be positive, all finite; threads must not "
             "be negative";
    case BlockStatus::missing_points: return "no points";
    case BlockStatus::invalid_stride: return "points are not rows of three";
    case BlockStatus::unknown_camera_model: return "there is no such model";
    case BlockStatus::invalid_camera_id:
      return "a rig has 1 to 256 cameras, camera_ids are below their number, and a camera alone has none";
  }
  return "unknown";
}

void raise(const StatusError& error, const char* type_name) {
  const py::object type = py::module_::import("maxlogdet._core").attr(type_name);
  const py::object value = type(error.what());
  value.attr("status") = error.status();
  PyErr_SetObject(type.ptr(), value.ptr());
}

}  // namespace

StatusError::StatusError(const char* status, const std::string& explanation)
    : std::runtime_error(status + (": " + explanation)), status_(status) {}
StatusError::StatusError(Status status) : StatusError(to_string(status), explain(status)) {}
StatusError::StatusError(BlockStatus status) : StatusError(status, explain(status)) {}
StatusError::StatusError(BlockStatus status, const std::string& explanation)
    : StatusError(to_string(status), explanation) {}

void bind_errors(py::module_& module) {
  module.attr("SelectionError") = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      "maxlogdet.SelectionError",
      "The library refused the request. `status` is the name of the reason, as 'invalid_prior'.", PyExc_ValueError,
      nullptr));
  py::register_exception_translator([](std::exception_ptr pointer) {  // NOLINT(performance-unnecessary-value-param)
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const StatusError& error) {
      raise(error, "SelectionError");
    }
  });
}

}  // namespace maxlogdet::python
