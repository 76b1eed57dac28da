// SPDX-License-Identifier: MIT
#include "python/match_weights.hpp"

#include "python/matches.hpp"

#include <maxlogdet/match_information.hpp>

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>

namespace maxlogdet::python {
namespace {

// A weight has the arguments of a block: appending reports what is wrong with them.
void check(const OwnCameras& cameras, const RigidTransform& pose, const Matches& matches, const BlockOptions& options) {
  BlockStore blocks(matches.size);
  append(cameras, pose, matches, options, blocks);
}

template <bool is_whitening>
py::array_t<double> weights_of(const py::object& camera, const py::object& T_cw, const py::object& points,
                               const py::object& sigmas, const py::object& has_depth_cue,
                               const py::object& map_covariances, const py::object& jacobians,
                               const py::object& camera_ids, const std::optional<std::string>& weighting,
                               const std::string& depth_cue, double map_sigma, double depth_sigma) {
  const OwnCameras cameras = cameras_of(camera);
  const RigidTransform pose = pose_of(T_cw, "T_cw");
  const Array<double> positions = real_array(points, "points", {any_n, 3});
  const MatchArrays arrays(positions, sigmas, has_depth_cue, map_covariances, jacobians, camera_ids);
  const Matches matches = arrays.view();
  const BlockOptions options = options_of(weighting, !map_covariances.is_none(), depth_cue, map_sigma, depth_sigma);
  check(cameras, pose, matches, options);

  const std::size_t r = residual_rows(options.depth_cue);
  py::array_t<double> weights({arrays.size(), static_cast<py::ssize_t>(r), static_cast<py::ssize_t>(r)});
  for (std::size_t i = 0; i < matches.size; ++i) {
    const RigCamera& seen_by = cameras.all[matches.camera_ids == nullptr ? 0 : matches.camera_ids[i]];
    const MatchNoise noise = match_noise(matches, i, options);
    const double* const p_w = positions.data() + 3 * i;
    const auto write_by = [&](const auto& by, double* to) {
      return is_whitening ? match_whitening(by, pose, p_w, noise, to) : match_information(by, pose, p_w, noise, to);
    };
    const auto write = [&](double* to) {
      return cameras.is_rig ? write_by(seen_by, to) : write_by(seen_by.camera, to);
    };
    double weight[9] = {std::numeric_limits<double>::quiet_NaN()};
    write(weight);
    put_weight(weight, residual_rows(noise.depth_cue), r, weights.mutable_data() + r * r * i);
  }
  return weights;
}

template <class Function>
void def_weights(py::module_& module, const char* name, const Function& function, const char* documentation) {
  module.def(name, function, py::arg("camera"), py::arg("T_cw"), py::arg("points"), py::kw_only(),
             py::arg("sigmas") = py::none(), py::arg("has_depth_cue") = py::none(),
             py::arg("map_covariances") = py::none(), py::arg("jacobians") = py::none(),
             py::arg("camera_ids") = py::none(), py::arg("weighting") = py::none(), py::arg("depth_cue") = "none",
             py::arg("map_sigma") = 0.05, py::arg("depth_sigma") = 0.05, documentation);
}

}  // namespace

void put_weight(const double* weight, std::size_t rows, std::size_t r, double* to) {
  const bool is_there = !std::isnan(weight[0]);
  std::fill_n(to, r * r, is_there ? 0 : std::numeric_limits<double>::quiet_NaN());
  for (std::size_t a = 0; is_there && a < rows; ++a) std::copy_n(weight + rows * a, rows, to + r * a);
}

void bind_match_weights(py::module_& module) {
  def_weights(
      module, "match_information", &weights_of<false>,
      R"(match_information(camera, T_cw, points, *, sigmas=None, has_depth_cue=None, map_covariances=None, jacobians=None, camera_ids=None, weighting=None, depth_cue='none', map_sigma=0.05, depth_sigma=0.05)
--

Returns (n, r, r): the weight of each match's residual, (u, v) or (u, v, third), in an optimiser that holds points
fixed: the inverse of Sigma_z + J Sigma_p J^T, the noise that whitens its block, at T_cw; r = 3 with a third
measurement, else 2. Zero in the third row and column of a match without one; NaN where the point has no image or
numbers are unusable.

Arguments are those of BlockStore.append_blocks. map_covariances count only with weighting 'measurement_and_map'.)");
  def_weights(
      module, "match_whitening", &weights_of<true>,
      R"(match_whitening(camera, T_cw, points, *, sigmas=None, has_depth_cue=None, map_covariances=None, jacobians=None, camera_ids=None, weighting=None, depth_cue='none', map_sigma=0.05, depth_sigma=0.05)
--

Returns (n, r, r): W of each match, lower triangular, W^T W its match_information: W times the residual has independent
entries of variance 1. Otherwise as match_information.)");
}

}  // namespace maxlogdet::python
