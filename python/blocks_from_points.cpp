// SPDX-License-Identifier: MIT
#include "python/blocks_from_points.hpp"

#include "python/matches.hpp"
#include "python/pickling.hpp"

#include <pybind11/stl.h>

#include <optional>
#include <string>

namespace maxlogdet::python {
namespace {

BlockReport append_blocks(Store& store, const py::object& camera, const py::object& T_cw, const py::object& points,
                          const py::object& sigmas, const py::object& has_depth_cue, const py::object& usable,
                          const py::object& weights, const py::object& map_covariances, const py::object& jacobians,
                          const py::object& camera_ids, const std::optional<std::string>& weighting,
                          const std::string& depth_cue, double map_sigma, double depth_sigma, double min_depth,
                          const py::object& threads) {
  const OwnCameras cameras = cameras_of(camera);
  const RigidTransform pose = pose_of(T_cw, "T_cw");
  MatchArrays arrays(points, sigmas, has_depth_cue, map_covariances, jacobians, camera_ids);
  arrays.add(usable, weights);
  BlockOptions options = options_of(weighting, !map_covariances.is_none(), depth_cue, map_sigma, depth_sigma);
  options.min_depth = min_depth;
  options.threads = int_from(threads, "threads");
  // Holds the GIL: this takes microseconds, in which the arrays must not change.
  BlockStore& blocks = store.changeable();
  return append(cameras, pose, arrays.view(), options, blocks);
}

std::string text_of(const BlockReport& report) {
  return py::str("<maxlogdet.BlockReport: error {}, {} appended, {} of them invalid>")
      .format(to_string(report.error), report.appended, report.invalid);
}

}  // namespace

void bind_block_report(py::module_& module) {
  py::class_<BlockReport> report(module, "BlockReport", "The result of BlockStore.append_blocks.");
  report
      .def_property_readonly(
          "error", [](const BlockReport& self) { return to_string(self.error); },
          "Why nothing was appended, a key of maxlogdet.errors; 'none' from append_blocks, which raises it.")
      .def_readonly("appended", &BlockReport::appended, "The number of candidates, n.")
      .def_readonly("invalid", &BlockReport::invalid, "Of these, how many are kept as invalid, for any reason.")
      .def_readonly("unusable", &BlockReport::unusable, "Of these, how many are not usable.")
      .def_readonly("behind_camera", &BlockReport::behind_camera,
                    "Of these, how many the camera's model has no image of.")
      .def_readonly("too_near", &BlockReport::too_near, "Of these, how many are nearer than min_depth.")
      .def_readonly("singular_rays", &BlockReport::singular_rays,
                    "Of these, how many have a ray orthogonal to the world's z axis (map_bias_world).")
      .def_readonly(
          "invalid_covariances", &BlockReport::invalid_covariances,
          "Of these, how many have a covariance that is not positive definite, or so large that float64 keeps "
          "no digits.")
      .def_readonly("invalid_jacobians", &BlockReport::invalid_jacobians, "Of these, how many are not finite.")
      .def("__repr__", py::overload_cast<const BlockReport&>(&text_of));
  def_pickle(report, &BlockReport::error, &BlockReport::appended, &BlockReport::invalid, &BlockReport::behind_camera,
             &BlockReport::singular_rays, &BlockReport::unusable, &BlockReport::too_near,
             &BlockReport::invalid_covariances, &BlockReport::invalid_jacobians);
}

void bind_append_blocks(py::class_<Store, std::shared_ptr<Store>>& store) {
  store.def(
      "append_blocks", &append_blocks, py::arg("camera"), py::arg("T_cw"), py::arg("points"), py::kw_only(),
      py::arg("sigmas") = py::none(), py::arg("has_depth_cue") = py::none(), py::arg("usable") = py::none(),
      py::arg("weights") = py::none(), py::arg("map_covariances") = py::none(), py::arg("jacobians") = py::none(),
      py::arg("camera_ids") = py::none(), py::arg("weighting") = py::none(), py::arg("depth_cue") = "none",
      py::arg("map_sigma") = 0.05, py::arg("depth_sigma") = 0.05, py::arg("min_depth") = 0.01, py::arg("threads") = 0,
      R"(append_blocks(self, camera, T_cw, points, *, sigmas=None, has_depth_cue=None, usable=None, weights=None, map_covariances=None, jacobians=None, camera_ids=None, weighting=None, depth_cue='none', map_sigma=0.05, depth_sigma=0.05, min_depth=0.01, threads=0)
--

Appends one block per match, in their order. Returns a BlockReport; raises SelectionError ('invalid_camera',
'invalid_pose', 'invalid_block_options', 'invalid_camera_id'), and then appends nothing. C-contiguous float64 arrays, and
points of float32 too, are read in place; others are converted.

camera: PinholeCamera or Camera; or a rig, a list of (camera, T_cb), T_cb body to camera: T_cw is then the body's.
T_cw: (3, 4) or (4, 4), world to camera, camera frame x right, y down, z forward, m. The blocks are about xi =
  (translation, rotation) of T_cw <- exp(xi^) T_cw, m and rad.
points: (n, 3), world frame, m; float32 or float64.
sigmas: (n,), px, standard deviation of each measurement; None: 1.
has_depth_cue: (n,) bool, where the depth cue is measured; None: everywhere.
usable: (n,) bool, False keeps a match as an invalid candidate; None: all are usable.
weights: (n,), not negative, multiplies H^T H; None: 1.
map_covariances: (n, 3, 3), world frame, m^2 (measurement_and_map), the upper triangle is read; None: map_sigma^2 I.
jacobians: (n, 2, 3), d (u, v) / d p_c, px per m, of a camera model of your own; None: the camera's.
camera_ids: (n,) integers, index of the match's camera in the rig; None: 0.
weighting: 'measurement', 'measurement_and_map', 'map_bias' (the paper's H_c) or 'map_bias_world'; None: 'measurement',
  or with map_covariances 'measurement_and_map'.
depth_cue: 'none', 'stereo' (px, needs camera.bf) or 'depth' (m, of standard deviation depth_sigma).
min_depth: m, nearer matches are no candidates.
threads: 1: only the calling one; 0: as many as pay off; n: at most n.)");
}

}  // namespace maxlogdet::python
