// SPDX-License-Identifier: MIT
#include "python/blocks_from_points.hpp"

#include "python/arrays.hpp"
#include "python/errors.hpp"
#include "python/executor.hpp"
#include "python/names.hpp"
#include "python/pickling.hpp"

#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/match_information.hpp>

#include <pybind11/stl.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::python {
namespace {

// 3 x 4, or 4 x 4 with the last row that a pose has: a transposed one is a mistake that would show nowhere else.
RigidTransform pose_of(const py::handle& T, const char* name) {
  const Array<double> pose = real_array(T, name, {});
  const double last_row[] = {0, 0, 0, 1};
  const bool has_columns = pose.ndim() == 2 && pose.shape(1) == 4;
  const bool is_square = has_columns && pose.shape(0) == 4;
  if (!(has_columns && pose.shape(0) == 3) && !(is_square && std::equal(last_row, last_row + 4, pose.data() + 12))) {
    throw py::value_error(std::string(name) + ": expected shape (3, 4), or (4, 4) with the last row 0, 0, 0, 1; got " +
                          std::string(py::str(pose.attr("shape"))));
  }
  return pose.data();
}

// The only camera, or those of a list of (camera, T_cb).
struct Cameras {
  std::vector<RigCamera> all;
  bool is_rig;
};

Cameras cameras_of(const py::object& camera) {
  if (py::isinstance<PinholeCamera>(camera) || py::isinstance<Camera>(camera)) {
    return {{RigCamera{camera.cast<Camera>(), RigidTransform::identity()}}, false};
  }
  const char* const expected = "camera: expected a PinholeCamera, a Camera, or a list of (camera, T_cb)";
  if (!py::isinstance<py::list>(camera) && !py::isinstance<py::tuple>(camera)) throw py::type_error(expected);
  Cameras cameras{{}, true};
  for (const py::handle& item : camera) {
    const bool is_pair = py::isinstance<py::tuple>(item) && py::len(item) == 2;
    const py::tuple pair = is_pair ? item.cast<py::tuple>() : py::tuple();
    if (!is_pair || !(py::isinstance<PinholeCamera>(pair[0]) || py::isinstance<Camera>(pair[0]))) {
      throw py::type_error(expected);
    }
    cameras.all.emplace_back(pair[0].cast<Camera>(), pose_of(pair[1], "T_cb"));
  }
  return cameras;
}

std::vector<unsigned char> ids_of(const py::object& camera_ids, py::ssize_t n) {
  if (camera_ids.is_none()) return {};
  std::vector<unsigned char> ids;
  for (const std::uint32_t id : small_integers(camera_ids, "camera_ids", {n})) {
    if (id > 255) throw StatusError(BlockStatus::invalid_camera_id);
    ids.push_back(static_cast<unsigned char>(id));
  }
  return ids;
}

Weighting weighting_from(const std::optional<std::string>& weighting, bool has_covariances) {
  if (weighting.has_value()) return weighting_of(*weighting);
  const Weighting by_default = BlockOptions().weighting;
  return has_covariances ? with_covariances(by_default) : by_default;
}

BlockReport append(const Cameras& cameras, const RigidTransform& pose, const Matches& matches,
                   const BlockOptions& options, BlockStore& blocks) {
  const BlockReport report =
      cameras.is_rig ? maxlogdet::append_blocks(Rig{cameras.all.data(), cameras.all.size()}, pose, matches, options,
                                                blocks, executor())
                     : maxlogdet::append_blocks(cameras.all[0].camera, pose, matches, options, blocks, executor());
  if (!report.is_done()) throw StatusError(report.status);
  return report;
}

BlockReport append_blocks(Store& store, const py::object& camera, const py::object& T_cw, const py::object& points,
                          const py::object& sigmas, const py::object& has_third, const py::object& usable,
                          const py::object& weights, const py::object& map_covariances, const py::object& jacobians,
                          const py::object& camera_ids, const std::optional<std::string>& weighting,
                          const std::string& third, double map_sigma, double depth_sigma, double min_depth,
                          const py::object& threads) {
  const Cameras cameras = cameras_of(camera);
  const RigidTransform pose = pose_of(T_cw, "T_cw");
  const py::array all_points = point_array(points, "points");
  const py::ssize_t n = all_points.shape(0);
  const auto size = static_cast<std::size_t>(n);
  const Array<double> all_sigmas = optional_real_array(sigmas, "sigmas", {n});
  const Array<bool> all_third = optional_mask(has_third, "has_third", size);
  const Array<bool> all_usable = optional_mask(usable, "usable", size);
  const Array<double> all_weights = optional_real_array(weights, "weights", {n});
  const Array<double> covariances = optional_real_array(map_covariances, "map_covariances", {n, 3, 3});
  const Array<double> all_jacobians = optional_real_array(jacobians, "jacobians", {n, 2, 3});
  const std::vector<unsigned char> ids = ids_of(camera_ids, n);

  Matches matches;
  matches.size = size;
  matches.points = points_of(all_points);
  matches.sigmas = data_or_null(all_sigmas);
  matches.has_third = data_or_null(all_third);
  matches.usable = data_or_null(all_usable);
  matches.weights = data_or_null(all_weights);
  matches.map_covariances = data_or_null(covariances);
  matches.jacobians = data_or_null(all_jacobians);
  matches.camera_ids = ids.empty() ? nullptr : ids.data();
  BlockOptions options;
  options.weighting = weighting_from(weighting, !map_covariances.is_none());
  options.third = third_measurement_of(third);
  options.map_sigma = map_sigma;
  options.depth_sigma = depth_sigma;
  options.min_depth = min_depth;
  options.threads = int_from(threads, "threads");
  // With the GIL held: microseconds, in which nobody can change the arrays.
  BlockStore& blocks = store.changeable();
  return append(cameras, pose, matches, options, blocks);
}

// A weight has the same arguments as a block: one that could not be made says what is wrong with them.
void refuse_what_blocks_refuse(const Cameras& cameras, const RigidTransform& pose, const Matches& matches,
                               const BlockOptions& options) {
  BlockStore blocks(matches.size);
  append(cameras, pose, matches, options, blocks);
}

// Writes r x r of a match with `rows` of them, zeros where it has no third row; NaN where it has no weight.
template <class Write>
void write_weight(const Write& write, std::size_t rows, std::size_t r, double* to) {
  double entries[9];
  const bool is_there = write(entries);
  std::fill_n(to, r * r, is_there ? 0 : std::numeric_limits<double>::quiet_NaN());
  for (std::size_t a = 0; is_there && a < rows; ++a) std::copy_n(entries + rows * a, rows, to + r * a);
}

py::array_t<double> weights_of(bool is_whitening, const py::object& camera, const py::object& T_cw,
                               const py::object& points, const py::object& sigmas, const py::object& has_third,
                               const py::object& map_covariances, const py::object& jacobians,
                               const py::object& camera_ids, const std::optional<std::string>& weighting,
                               const std::string& third, double map_sigma, double depth_sigma) {
  const Cameras cameras = cameras_of(camera);
  const RigidTransform pose = pose_of(T_cw, "T_cw");
  const Array<double> all_points = real_array(points, "points", {any_n, 3});
  const py::ssize_t n = all_points.shape(0);
  const Array<double> all_sigmas = optional_real_array(sigmas, "sigmas", {n});
  const Array<bool> all_third = optional_mask(has_third, "has_third", static_cast<std::size_t>(n));
  const Array<double> covariances = optional_real_array(map_covariances, "map_covariances", {n, 3, 3});
  const Array<double> all_jacobians = optional_real_array(jacobians, "jacobians", {n, 2, 3});
  const std::vector<unsigned char> ids = ids_of(camera_ids, n);

  Matches matches;
  matches.size = static_cast<std::size_t>(n);
  matches.points = points_of(all_points);
  matches.camera_ids = ids.empty() ? nullptr : ids.data();
  matches.sigmas = data_or_null(all_sigmas);
  matches.has_third = data_or_null(all_third);
  matches.map_covariances = data_or_null(covariances);
  matches.jacobians = data_or_null(all_jacobians);
  BlockOptions options;
  options.weighting = weighting_from(weighting, !map_covariances.is_none());
  options.third = third_measurement_of(third);
  options.map_sigma = map_sigma;
  options.depth_sigma = depth_sigma;
  refuse_what_blocks_refuse(cameras, pose, matches, options);
  const std::size_t r = residual_rows(options.third);
  py::array_t<double> weights({n, static_cast<py::ssize_t>(r), static_cast<py::ssize_t>(r)});
  for (py::ssize_t i = 0; i < n; ++i) {
    const auto match = static_cast<std::size_t>(i);
    const RigCamera& seen_by = cameras.all[ids.empty() ? 0 : ids[match]];
    const MatchNoise noise = match_noise(matches, match, options);
    const double* const p_w = all_points.data(i, 0);
    const auto write = [&](double* to) {
      return is_whitening ? match_whitening(seen_by, pose, p_w, noise, to)
                          : match_information(seen_by, pose, p_w, noise, to);
    };
    write_weight(write, residual_rows(noise.third), r, weights.mutable_data(i, 0, 0));
  }
  return weights;
}

py::array_t<double> projected(const Camera& camera, const py::object& points) {
  const Array<double> all = real_array(points, "points", {any_n, 3});
  py::array_t<double> images({all.shape(0), py::ssize_t{2}});
  for (py::ssize_t i = 0; i < all.shape(0); ++i) {
    double* const uv = images.mutable_data(i, 0);
    uv[0] = uv[1] = std::numeric_limits<double>::quiet_NaN();
    project(camera, all.data(i, 0), uv);
  }
  return images;
}

py::tuple parameters_of(const Camera& camera) {
  py::list parameters;
  for (std::size_t i = 0; i < parameter_count(camera.model); ++i) parameters.append(camera.parameters[i]);
  return parameters;
}

// For pickle and copy: the model, fx, fy, cx, cy, bf, and all five parameters.
constexpr std::size_t numbers_of_camera = 10;

py::tuple state_of(const Camera& camera) {
  const PinholeCamera& pinhole = camera.pinhole;
  py::list numbers;
  for (const double number : {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, pinhole.bf}) numbers.append(number);
  for (const double parameter : camera.parameters) numbers.append(parameter);
  return py::make_tuple(static_cast<int>(camera.model), py::tuple(numbers));
}

Camera camera_of_state(const py::tuple& state) {
  check_state(state, 2);
  const auto numbers = state[1].cast<py::tuple>();
  check_state(numbers, numbers_of_camera);
  const auto number = [&](std::size_t i) { return numbers[i].cast<double>(); };
  Camera camera(number(0), number(1), number(2), number(3), number(4));
  const int model = state[0].cast<int>();
  const int models = static_cast<int>(std::size(camera_models));
  if (model < 0 || model >= models) throw py::value_error("this was pickled by another version of maxlogdet");
  camera.model = static_cast<CameraModel>(model);
  for (std::size_t i = 0; i < 5; ++i) camera.parameters[i] = number(5 + i);
  return camera;
}

std::string text_of(const PinholeCamera& camera) {
  return py::str("PinholeCamera(fx={}, fy={}, cx={}, cy={}, bf={})")
      .format(camera.fx, camera.fy, camera.cx, camera.cy, camera.bf);
}

std::string text_of(const Camera& camera) {
  return py::str("<maxlogdet.Camera: {}, {}, {}>")
      .format(to_string(camera.model), text_of(camera.pinhole), parameters_of(camera));
}

std::string text_of(const BlockReport& report) {
  return py::str("<maxlogdet.BlockReport: {}, {} appended, {} of them invalid>")
      .format(to_string(report.status), report.appended, report.invalid);
}

template <class Function>
void def_weights(py::module_& module, const char* name, const Function& function, const char* documentation) {
  module.def(name, function, py::arg("camera"), py::arg("T_cw"), py::arg("points"), py::kw_only(),
             py::arg("sigmas") = py::none(), py::arg("has_third") = py::none(), py::arg("map_covariances") = py::none(),
             py::arg("jacobians") = py::none(), py::arg("camera_ids") = py::none(), py::arg("weighting") = py::none(),
             py::arg("third") = "none", py::arg("map_sigma") = 0.05, py::arg("depth_sigma") = 0.05, documentation);
}

template <bool is_whitening>
py::array_t<double> weights(const py::object& camera, const py::object& T_cw, const py::object& points,
                            const py::object& sigmas, const py::object& has_third, const py::object& map_covariances,
                            const py::object& jacobians, const py::object& camera_ids,
                            const std::optional<std::string>& weighting, const std::string& third, double map_sigma,
                            double depth_sigma) {
  return weights_of(is_whitening, camera, T_cw, points, sigmas, has_third, map_covariances, jacobians, camera_ids,
                    weighting, third, map_sigma, depth_sigma);
}

void bind_weights(py::module_& module) {
  def_weights(
      module, "match_information", &weights<false>,
      R"(match_information(camera, T_cw, points, *, sigmas=None, has_third=None, map_covariances=None, jacobians=None, camera_ids=None, weighting=None, third='none', map_sigma=0.05, depth_sigma=0.05)
--

Returns (n, r, r): the weight of each match's residual, (u, v) or (u, v, third), in an optimiser that holds points
fixed: the inverse of Sigma_z + J Sigma_p J^T, the noise that whitens its block, at T_cw; r = 3 with a third
measurement, else 2. Zero in the third row and column of a match without one; NaN where the point has no image or
numbers are unusable.

Arguments are those of BlockStore.append_blocks. map_covariances count only with weighting 'measurement_and_map'.)");
  def_weights(
      module, "match_whitening", &weights<true>,
      R"(match_whitening(camera, T_cw, points, *, sigmas=None, has_third=None, map_covariances=None, jacobians=None, camera_ids=None, weighting=None, third='none', map_sigma=0.05, depth_sigma=0.05)
--

Returns (n, r, r): W of each match, lower triangular, W^T W its match_information: W times the residual has independent
entries of variance 1. Otherwise as match_information.)");
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

  py::class_<Camera> any_camera(module, "Camera", R"(Camera(pinhole)

A camera of any model; a PinholeCamera converts to it.

p_c: x right, y down, z forward, m. u = fx m_x + cx, v = fy m_y + cy, of the image as the model has it: distorted,
unless it has been rectified. Only pinholes have a bf.)");
  any_camera.def(py::init<const PinholeCamera&>(), py::arg("pinhole"))
      .def_static("radial_tangential", &Camera::radial_tangential, py::arg("pinhole"), py::arg("k1"), py::arg("k2"),
                  py::arg("p1"), py::arg("p2"), py::arg("k3") = 0.0,
                  "radial_tangential(pinhole, k1, k2, p1, p2, k3=0.0)\n--\n\nOpenCV's distortion.")
      .def_static(
          "kannala_brandt", &Camera::kannala_brandt, py::arg("pinhole"), py::arg("k1"), py::arg("k2"), py::arg("k3"),
          py::arg("k4"),
          "kannala_brandt(pinhole, k1, k2, k3, k4)\n--\n\nOpenCV's fisheye, also called equidistant or KannalaBrandt8.")
      .def_static(
          "double_sphere", &Camera::double_sphere, py::arg("pinhole"), py::arg("xi"), py::arg("alpha"),
          "double_sphere(pinhole, xi, alpha)\n--\n\nUsenko, Demmel, Cremers, 3DV 2018; xi > -1, alpha in [0, 1].")
      .def_property_readonly(
          "model", [](const Camera& self) { return to_string(self.model); }, "The model's name.")
      .def_property_readonly(
          "pinhole", [](const Camera& self) { return self.pinhole; }, "fx, fy, cx, cy.")
      .def_property_readonly("parameters", &parameters_of, "The model's parameters, in the order of its constructor.")
      .def("project", &projected, py::arg("points"),
           "project(self, points)\n--\n\nReturns (n, 2), px, of points (n, 3) in the camera's frame; NaN where the "
           "model has no image.")
      .def("__repr__", py::overload_cast<const Camera&>(&text_of));
  any_camera.def(py::pickle([](const Camera& self) { return state_of(self); }, &camera_of_state));
  py::implicitly_convertible<PinholeCamera, Camera>();

  py::class_<BlockReport> report(module, "BlockReport", "The result of BlockStore.append_blocks.");
  report
      .def_property_readonly(
          "status", [](const BlockReport& self) { return to_string(self.status); },
          "'ok'; 'singular_rays' (map_bias_world) if some rays are orthogonal to the world's z axis; "
          "'invalid_jacobians' "
          "if some are not finite.")
      .def_readonly("appended", &BlockReport::appended, "The number of candidates, n.")
      .def_readonly("invalid", &BlockReport::invalid, "Of these, how many are kept as invalid, for any reason.")
      .def_readonly("unusable", &BlockReport::unusable, "Of these, how many are not usable.")
      .def_readonly("behind_camera", &BlockReport::behind_camera,
                    "Of these, how many the camera's model has no image of.")
      .def_readonly("too_near", &BlockReport::too_near, "Of these, how many are nearer than min_depth.")
      .def_readonly("singular_rays", &BlockReport::singular_rays, "Of these, how many have a singular ray.")
      .def_readonly(
          "unsound_covariances", &BlockReport::unsound_covariances,
          "Of these, how many have a covariance that is not positive definite, or so large that float64 keeps "
          "no digits.")
      .def_readonly("invalid_jacobians", &BlockReport::invalid_jacobians, "Of these, how many are not finite.")
      .def("__repr__", py::overload_cast<const BlockReport&>(&text_of));
  def_pickle(report, &BlockReport::status, &BlockReport::appended, &BlockReport::invalid, &BlockReport::behind_camera,
             &BlockReport::singular_rays, &BlockReport::unusable, &BlockReport::too_near,
             &BlockReport::unsound_covariances, &BlockReport::invalid_jacobians);

  store.def(
      "append_blocks", &append_blocks, py::arg("camera"), py::arg("T_cw"), py::arg("points"), py::kw_only(),
      py::arg("sigmas") = py::none(), py::arg("has_third") = py::none(), py::arg("usable") = py::none(),
      py::arg("weights") = py::none(), py::arg("map_covariances") = py::none(), py::arg("jacobians") = py::none(),
      py::arg("camera_ids") = py::none(), py::arg("weighting") = py::none(), py::arg("third") = "none",
      py::arg("map_sigma") = 0.05, py::arg("depth_sigma") = 0.05, py::arg("min_depth") = 0.01, py::arg("threads") = 0,
      R"(append_blocks(self, camera, T_cw, points, *, sigmas=None, has_third=None, usable=None, weights=None, map_covariances=None, jacobians=None, camera_ids=None, weighting=None, third='none', map_sigma=0.05, depth_sigma=0.05, min_depth=0.01, threads=0)
--

Appends one block per match, in their order. Returns a BlockReport; raises SelectionError ('invalid_camera',
'invalid_pose', 'invalid_options', 'invalid_camera_id'), and then appends nothing. C-contiguous float64 arrays, and
points of float32 too, are read in place; others are converted.

camera: PinholeCamera or Camera; or a rig, a list of (camera, T_cb), T_cb body to camera: T_cw is then the body's.
T_cw: (3, 4) or (4, 4), world to camera, camera frame x right, y down, z forward, m. The blocks are about xi =
  (translation, rotation) of T_cw <- exp(xi^) T_cw, m and rad.
points: (n, 3), world frame, m; float32 or float64.
sigmas: (n,), px, standard deviation of each measurement; None: 1.
has_third: (n,) bool, where the third measurement exists; None: everywhere.
usable: (n,) bool, False keeps a match as an invalid candidate; None: all are usable.
weights: (n,), not negative, multiplies H^T H; None: 1.
map_covariances: (n, 3, 3), world frame, m^2 (measurement_and_map), the upper triangle is read; None: map_sigma^2 I.
jacobians: (n, 2, 3), d (u, v) / d p_c, px per m, of a camera model of your own; None: the camera's.
camera_ids: (n,) integers, index of the match's camera in the rig; None: 0.
weighting: 'measurement', 'measurement_and_map', 'map_bias' (the paper's H_c) or 'map_bias_world'; None: 'measurement',
  or with map_covariances 'measurement_and_map'.
third: 'none', 'stereo' (px, needs camera.bf) or 'depth' (m, of standard deviation depth_sigma).
min_depth: m, nearer matches are no candidates.
threads: 1: only the calling one; 0: as many as pay off; n: at most n.)");
  bind_weights(module);
}

}  // namespace maxlogdet::python
