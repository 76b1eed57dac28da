// SPDX-License-Identifier: MIT
#include "python/cameras.hpp"

#include "python/arrays.hpp"
#include "python/errors.hpp"
#include "python/names.hpp"
#include "python/pickling.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace maxlogdet::python {
namespace {

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

Camera camera_of(const std::string& model, const PinholeCamera& pinhole, const std::vector<double>& parameters) {
  Camera camera(pinhole);
  camera.model = camera_model_of(model);
  const std::size_t count = parameter_count(camera.model);
  if (parameters.size() != count) {
    throw py::value_error("parameters: expected " + std::to_string(count) + " of " + model + ", got " +
                          std::to_string(parameters.size()));
  }
  std::copy(parameters.begin(), parameters.end(), camera.parameters);
  return camera;
}

// The pickled state: the model, and the numbers fx, fy, cx, cy, bf, and all five parameters.
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

void bind_pinhole(py::module_& module) {
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
}

void bind_camera(py::module_& module) {
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
      .def_static(
          "of_model", &camera_of, py::arg("model"), py::arg("pinhole"), py::arg("parameters"),
          "of_model(model, pinhole, parameters)\n--\n\nA camera of one of `camera_models`, with its parameters in "
          "the order of Camera.parameters.")
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
}

bool is_camera(const py::handle& object) {
  return py::isinstance<PinholeCamera>(object) || py::isinstance<Camera>(object);
}

}  // namespace

RigidTransform pose_of(const py::handle& T, const char* name, WrongPose wrong) {
  const Array<double> pose = real_array(T, name, {});
  if (pose.ndim() != 2 || pose.shape(1) != 4 || (pose.shape(0) != 3 && pose.shape(0) != 4)) {
    throw py::value_error(std::string(name) + ": expected shape (3, 4) or (4, 4), got " +
                          std::string(py::str(pose.attr("shape"))));
  }
  const double* const entries = pose.data();
  const double last_row[] = {0, 0, 0, 1};
  const bool has_last_row = pose.shape(0) == 3 || std::equal(last_row, last_row + 4, entries + 12);
  if (wrong == WrongPose::passes) return RigidTransform::row_major(has_last_row ? entries : nullptr);
  if (!std::all_of(entries, entries + pose.size(), [](double entry) { return std::isfinite(entry); })) {
    throw SelectionError(Error::invalid_pose,
                         std::string(name) + " is not finite: expected numbers, no NaN or infinity");
  }
  if (!has_last_row) {
    throw py::value_error(std::string(name) + ": expected the last row 0, 0, 0, 1, got " +
                          std::string(py::str(pose[py::int_(3)])) + "; is it transposed?");
  }
  return RigidTransform::row_major(entries);
}

OwnCameras cameras_of(const py::object& camera, WrongPose wrong) {
  if (is_camera(camera)) {
    return {{RigCamera{camera.cast<Camera>(), RigidTransform::identity()}}, false};
  }
  const char* const expected = "camera: expected a PinholeCamera, a Camera, or a list of (camera, T_cb)";
  if (!py::isinstance<py::list>(camera) && !py::isinstance<py::tuple>(camera)) throw py::type_error(expected);
  OwnCameras cameras{{}, true};
  for (const py::handle& item : camera) {
    const bool is_pair = py::isinstance<py::tuple>(item) && py::len(item) == 2;
    const py::tuple pair = is_pair ? item.cast<py::tuple>() : py::tuple();
    if (!is_pair || !is_camera(pair[0])) {
      throw py::type_error(expected);
    }
    cameras.all.emplace_back(pair[0].cast<Camera>(), pose_of(pair[1], "T_cb", wrong));
  }
  return cameras;
}

void bind_cameras(py::module_& module) {
  bind_pinhole(module);
  bind_camera(module);
}

}  // namespace maxlogdet::python
