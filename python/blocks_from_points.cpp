// SPDX-License-Identifier: MIT
#include "python/blocks_from_points.hpp"

#include "python/arrays.hpp"
#include "python/errors.hpp"
#include "python/executor.hpp"
#include "python/names.hpp"
#include "python/pickling.hpp"

#include <maxlogdet/jacobian.hpp>

#include <algorithm>
#include <string>

namespace maxlogdet::python {
namespace {

// 3 x 4, or 4 x 4 with the last row that a pose has: a transposed one is a mistake that would show nowhere else.
Array<double> pose_of(const py::object& T_cw) {
  Array<double> pose = real_array(T_cw, "T_cw", {});
  const double last_row[] = {0, 0, 0, 1};
  const bool has_columns = pose.ndim() == 2 && pose.shape(1) == 4;
  const bool is_square = has_columns && pose.shape(0) == 4;
  if (!(has_columns && pose.shape(0) == 3) && !(is_square && std::equal(last_row, last_row + 4, pose.data() + 12))) {
    throw py::value_error("T_cw: expected shape (3, 4), or (4, 4) with the last row 0, 0, 0, 1; got " +
                          std::string(py::str(pose.attr("shape"))));
  }
  return pose;
}

BlockReport append_blocks(Store& store, const PinholeCamera& camera, const py::object& T_cw, const py::object& points,
                          const py::object& sigmas, const py::object& has_third, const py::object& usable,
                          const py::object& weights, const py::object& map_covariances, const std::string& weighting,
                          const std::string& third, double map_sigma, double depth_sigma, const py::object& threads) {
  const Array<double> pose = pose_of(T_cw);
  const Array<double> all_points = real_array(points, "points", {any_n, 3});
  const py::ssize_t n = all_points.shape(0);
  const auto size = static_cast<std::size_t>(n);
  const Array<double> all_sigmas = optional_real_array(sigmas, "sigmas", {n});
  const Array<bool> all_third = optional_mask(has_third, "has_third", size);
  const Array<bool> all_usable = optional_mask(usable, "usable", size);
  const Array<double> all_weights = optional_real_array(weights, "weights", {n});
  const Array<double> covariances = optional_real_array(map_covariances, "map_covariances", {n, 3, 3});

  Matches matches;
  matches.size = size;
  matches.points = data_or_null(all_points);
  matches.sigmas = data_or_null(all_sigmas);
  matches.has_third = data_or_null(all_third);
  matches.usable = data_or_null(all_usable);
  matches.weights = data_or_null(all_weights);
  matches.map_covariances = data_or_null(covariances);
  BlockOptions options;
  options.weighting = weighting_of(weighting);
  options.third = third_measurement_of(third);
  options.map_sigma = map_sigma;
  options.depth_sigma = depth_sigma;
  options.threads = int_from(threads, "threads");
  // With the GIL held: microseconds, in which nobody can change the arrays.
  const BlockReport report =
      maxlogdet::append_blocks(camera, pose.data(), matches, options, store.changeable(), executor());
  if (report.status != BlockStatus::ok && report.status != BlockStatus::singular_rays) throw StatusError(report.status);
  return report;
}

std::string text_of(const PinholeCamera& camera) {
  return py::str("PinholeCamera(fx={}, fy={}, cx={}, cy={}, bf={})")
      .format(camera.fx, camera.fy, camera.cx, camera.cy, camera.bf);
}

std::string text_of(const BlockReport& report) {
  return py::str("<maxlogdet.BlockReport: {}, {} appended, {} of them invalid>")
      .format(to_string(report.status), report.appended, report.invalid);
}

}  // namespace

void bind_blocks_from_points(py::module_& module, py::class_<Store, std::shared_ptr<Store>>& store) {
  py::class_<PinholeCamera> pinhole(module, "PinholeCamera", R"(PinholeCamera(fx, fy, cx=0.0, cy=0.0, bf=0.0)

A rectified pinhole camera, px; bf: stereo baseline times fx, px m, 0 if monocular. No Jacobian depends on cx and cy.)");
  pinhole
      .def(py::init([](double fx, double fy, double cx, double cy, double bf) {
             PinholeCamera camera;
             camera.fx = fx;
             camera.fy = fy;
             camera.cx = cx;
             camera.cy = cy;
             camera.bf = bf;
             return camera;
           }),
           py::arg("fx"), py::arg("fy"), py::arg("cx") = 0.0, py::arg("cy") = 0.0, py::arg("bf") = 0.0)
      .def_readwrite("fx", &PinholeCamera::fx)
      .def_readwrite("fy", &PinholeCamera::fy)
      .def_readwrite("cx", &PinholeCamera::cx)
      .def_readwrite("cy", &PinholeCamera::cy)
      .def_readwrite("bf", &PinholeCamera::bf)
      .def("__repr__", py::overload_cast<const PinholeCamera&>(&text_of));
  def_pickle(pinhole, &PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy,
             &PinholeCamera::bf);

  py::class_<BlockReport> report(module, "BlockReport", "What BlockStore.append_blocks appended.");
  report
      .def_property_readonly(
          "status", [](const BlockReport& self) { return to_string(self.status); },
          "'ok', or 'singular_rays' (map_bias_world) if some rays are orthogonal to the world's z axis.")
      .def_readonly("appended", &BlockReport::appended, "How many candidates: n.")
      .def_readonly("invalid", &BlockReport::invalid, "Of these, how many are kept as invalid, for any reason.")
      .def_readonly("behind_camera", &BlockReport::behind_camera, "Of these, how many have Z <= 0.")
      .def_readonly("singular_rays", &BlockReport::singular_rays, "Of these, how many have a singular ray.")
      .def("__repr__", py::overload_cast<const BlockReport&>(&text_of));
  def_pickle(report, &BlockReport::status, &BlockReport::appended, &BlockReport::invalid, &BlockReport::behind_camera,
             &BlockReport::singular_rays);

  store.def(
      "append_blocks", &append_blocks, py::arg("camera"), py::arg("T_cw"), py::arg("points"), py::kw_only(),
      py::arg("sigmas") = py::none(), py::arg("has_third") = py::none(), py::arg("usable") = py::none(),
      py::arg("weights") = py::none(), py::arg("map_covariances") = py::none(), py::arg("weighting") = "map_bias",
      py::arg("third") = "none", py::arg("map_sigma") = 0.05, py::arg("depth_sigma") = 0.05, py::arg("threads") = 0,
      R"(append_blocks(self, camera, T_cw, points, *, sigmas=None, has_third=None, usable=None, weights=None, map_covariances=None, weighting='map_bias', third='none', map_sigma=0.05, depth_sigma=0.05, threads=0)
--

Appends one block a match, in their order. Returns a BlockReport; raises SelectionError ('invalid_camera',
'invalid_pose', 'invalid_options'), and then appends nothing. C-contiguous float64 arrays are read where they are, others
are converted.

T_cw: (3, 4) or (4, 4), world to camera, camera frame x right, y down, z forward, m. The blocks are about xi =
  (translation, rotation) of T_cw <- exp(xi^) T_cw, m and rad.
points: (n, 3), world frame, m.
sigmas: (n,), px, deviation of each measurement; None: 1.
has_third: (n,) bool, where the third measurement exists; None: everywhere.
usable: (n,) bool, False keeps a match as an invalid candidate; None: all are usable.
weights: (n,), not negative, multiplies H^T H; None: 1.
map_covariances: (n, 3, 3), world frame, m^2 (measurement_and_map), the upper triangle is read; None: map_sigma^2 I.
weighting: 'map_bias' (the paper's H_c), 'map_bias_world', 'measurement' or 'measurement_and_map'.
third: 'none', 'stereo' (px, needs camera.bf) or 'depth' (m, of deviation depth_sigma).
threads: 1: the calling one alone; 0: as many as pay off; n: at most n.)");
}

}  // namespace maxlogdet::python
