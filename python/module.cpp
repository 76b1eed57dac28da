// SPDX-License-Identifier: MIT
// The compiled part of the Python package `maxlogdet`, which maxlogdet/__init__.py imports.
//
// Threads of Python may share objects: calls keep the GIL, and run no Python code, which could let another thread in,
// from the first look at an object to the last. So arguments are converted before, and answers become arrays after.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace maxlogdet::python {
namespace {

namespace py = pybind11;

// As the library reads it: C-contiguous, aligned, in this machine's byte order. The caller's memory if that complies.
template <class T>
using Array =
    py::array_t<T, py::array::c_style | py::array::forcecast | py::detail::npy_api::constants::NPY_ARRAY_ALIGNED_>;

// Expected extents; any_n accepts every extent. Empty: every shape.
using Shape = std::vector<py::ssize_t>;
constexpr py::ssize_t any_n = -1;

std::string text_of(const py::handle& object) { return py::str(object); }

[[noreturn]] void refuse_shape(const char* name, const std::string& expected, const py::array& array) {
  throw py::value_error(std::string(name) + ": expected shape " + expected + ", got " + text_of(array.attr("shape")));
}

void check_shape(const py::array& array, const char* name, const Shape& shape) {
  bool fits = static_cast<std::size_t>(array.ndim()) == shape.size();
  std::string expected;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    fits = fits && (shape[axis] == any_n || shape[axis] == array.shape(static_cast<py::ssize_t>(axis)));
    expected += (axis > 0 ? ", " : "") + (shape[axis] == any_n ? "n" : std::to_string(shape[axis]));
  }
  if (!fits) refuse_shape(name, "(" + expected + (shape.size() == 1 ? ",)" : ")"), array);
}

// Whether it is a masked array, or a list with one: NumPy converts these without a look at the mask.
bool is_masked(const py::handle& object) {
  if (py::isinstance(object, py::module_::import("numpy.ma").attr("MaskedArray"))) return true;
  if (!py::isinstance<py::list>(object) && !py::isinstance<py::tuple>(object)) return false;
  return std::any_of(object.begin(), object.end(), &is_masked);
}

// As numpy.asarray; TypeError and ValueError name the argument. Bools are refused as numbers, and integers as bools:
// NumPy would read them as indices, the library as flags.
template <class T>
Array<T> array_of(const py::handle& object, const char* name, const Shape& shape) {
  constexpr bool is_mask = std::is_same_v<T, bool>;
  constexpr bool is_integer = std::is_integral_v<T> && !is_mask;
  const char* const entries = is_mask ? "bools" : is_integer ? "integers" : "numbers";
  const std::string expected = std::string(name) + ": expected an array of " + entries;
  const py::array array = py::array::ensure(object);
  if (!array) throw py::type_error(expected);
  if (is_masked(object)) throw py::type_error(expected + ", got a masked array: fill or compress it");
  const char kind = array.dtype().kind();
  const bool has_kind = std::string(is_mask ? "b" : is_integer ? "iu" : "fiu").find(kind) != std::string::npos;
  if (!has_kind && array.size() > 0) throw py::type_error(expected + ", got " + text_of(array.dtype()));
  if (!shape.empty()) check_shape(array, name, shape);
  if constexpr (is_integer) {
    const py::int_ lowest(std::numeric_limits<T>::min());
    const py::int_ highest(std::numeric_limits<T>::max());
    if (array.size() > 0 && (py::int_(array.attr("min")()) < lowest || py::int_(array.attr("max")()) > highest)) {
      throw py::value_error(expected + " from " + text_of(lowest) + " to " + text_of(highest));
    }
  }
  Array<T> converted = Array<T>::ensure(array);
  if (!converted) throw py::type_error(expected);
  return converted;
}

// Empty for None.
template <class T>
Array<T> optional_array(const py::handle& object, const char* name, const Shape& shape) {
  return object.is_none() ? Array<T>() : array_of<T>(object, name, shape);
}

template <class T>
const T* data_or_null(const Array<T>& array) {
  return array.size() == 0 ? nullptr : array.data();
}

template <class T>
py::array_t<T> to_numpy(const std::vector<T>& entries) {
  return py::array_t<T>(static_cast<py::ssize_t>(entries.size()), entries.data());
}

// A pose as 3 x 4, or as 4 x 4 with the last row 0, 0, 0, 1: with another one it is perhaps transposed, and becomes a
// transform that the library refuses.
RigidTransform pose_of(const py::object& T, const char* name) {
  const Array<double> pose = array_of<double>(T, name, {});
  if (pose.ndim() != 2 || pose.shape(1) != 4 || (pose.shape(0) != 3 && pose.shape(0) != 4)) {
    refuse_shape(name, "(3, 4) or (4, 4)", pose);
  }
  const double last_row[] = {0, 0, 0, 1};
  const bool is_pose = pose.shape(0) == 3 || std::equal(last_row, last_row + 4, pose.data() + 12);
  return RigidTransform::row_major(is_pose ? pose.data() : nullptr);
}

template <class Enum, std::size_t n>
Enum named(const std::string& name, const char* argument, const Enum (&all)[n]) {
  std::string names;
  for (const Enum value : all) {
    if (name == to_string(value)) return value;
    names += (names.empty() ? "'" : ", '") + std::string(to_string(value)) + "'";
  }
  throw py::value_error(std::string(argument) + ": expected one of " + names + ", got '" + name + "'");
}

// To a method of an object whose __init__ never ran, pybind11 gives memory in which nothing was constructed. It asks
// the class for that memory, and for no other: so the class refuses. Pickling would end the process.
template <class T>
py::class_<T> class_of(py::module_& module, const char* name, const char* doc) {
  py::class_<T> bound(module, name, doc);
  py::detail::get_type_info(typeid(T), true)->operator_new = [](std::size_t) -> void* {
    throw py::type_error("the object is not initialised: call its __init__ first");
  };
  bound.def("__reduce_ex__", [](const py::object& self, int) -> py::object {
    throw py::type_error("cannot pickle or copy a " + text_of(py::type::of(self).attr("__name__")));
  });
  return bound;
}

Camera camera_of(double fx, double fy, double cx, double cy, double bf, const py::object& cx_right,
                 const std::string& model, const py::object& parameters, const py::object& T_cb) {
  Camera camera(fx, fy, cx, cy, bf, cx_right.is_none() ? cx : cx_right.cast<double>());
  camera.model = named(model, "model", camera_models);
  const auto count = static_cast<py::ssize_t>(parameter_count(camera.model));
  const Array<double> given = array_of<double>(parameters, "parameters", {count});
  std::copy_n(given.data(), count, camera.parameters);
  if (!T_cb.is_none()) camera.T_cb = pose_of(T_cb, "T_cb");
  return camera;
}

// As maxlogdet.Selection, which __init__.py defines and whose arrays are its own.
py::object answer_of(const Selection& selection) {
  const std::vector<py::ssize_t> indices(selection.begin(), selection.end());
  const std::vector<double> gains(selection.gains, selection.gains + selection.size);
  using namespace py::literals;
  return py::module_::import("maxlogdet")
      .attr("Selection")(
          "indices"_a = to_numpy(indices), "gains"_a = to_numpy(gains), "status"_a = to_string(selection.status),
          "error"_a = to_string(selection.error), "warning"_a = to_string(selection.warning),
          "reason"_a = selection.reason(), "log_det"_a = selection.log_det, "upper_bound"_a = selection.upper_bound,
          "certified_efficiency"_a = selection.certified_efficiency(), "efficiency"_a = selection.efficiency,
          "searched"_a = selection.searched, "evaluations"_a = selection.evaluations,
          "invalid_candidates"_a = selection.invalid_candidates);
}

// What select() and select_blocks() are asked for, with the arrays that Options point to.
struct Asked {
  Options options;
  Array<double> prior;
  Array<std::uint32_t> groups;
  bool has_groups;  // whose number is not checked yet
};

constexpr const char* doc_of_options = R"(

prior: (6, 6), symmetric; where it leaves a direction free, or None, a weak one that follows the blocks.
strategy: one of maxlogdet.strategies; epsilon and seed are of stochastic_greedy.
time_limit: s, after which those of most information fill the budget; 0: none.
groups: (n,) integers, the group of each; at most `maximum` of a group are selected.
target_efficiency: the efficiency against all candidates that ends the selection before the budget; 0: off.
certificate: whether to compute upper_bound.)";

// Defines a function that takes its own arguments, and then the options.
template <class Scope, class... Own, class... Arguments>
void def_select(Scope& scope, const char* name, const std::string& doc, py::object (*select)(Asked&, Own...),
                const Arguments&... arguments) {
  scope.def(
      name,
      [select](Own... own, const py::object& prior, const std::string& strategy, double epsilon, std::uint64_t seed,
               double time_limit, const py::object& groups, std::size_t maximum, double target_efficiency,
               bool certificate) {
        Asked asked{{},
                    optional_array<double>(prior, "prior", {state_dimension, state_dimension}),
                    optional_array<std::uint32_t>(groups, "groups", {any_n}),
                    !groups.is_none()};
        Options& options = asked.options;
        options.prior = data_or_null(asked.prior);
        options.strategy = named(strategy, "strategy", strategies);
        options.stochastic.epsilon = epsilon;
        options.stochastic.seed = seed;
        options.time_limit = time_limit;
        options.groups.maximum = maximum;
        options.groups.ids = data_or_null(asked.groups);
        const std::uint32_t* const ids = options.groups.ids;
        if (ids != nullptr) options.groups.count = std::size_t{1} + *std::max_element(ids, ids + asked.groups.size());
        options.target_efficiency = target_efficiency;
        options.certificate = certificate;
        return select(asked, own...);
      },
      arguments..., py::arg("prior") = py::none(), py::arg("strategy") = "lazy_greedy", py::arg("epsilon") = 0.1,
      py::arg("seed") = 0, py::arg("time_limit") = 0.0, py::arg("groups") = py::none(), py::arg("maximum") = 1,
      py::arg("target_efficiency") = 0.0, py::arg("certificate") = false, (doc + doc_of_options).c_str());
}

py::object select_blocks(Asked& asked, const py::object& given, std::size_t budget, const py::object& given_required) {
  const Array<double> blocks = array_of<double>(given, "blocks", {});
  const bool are_blocks = blocks.ndim() == 3 && blocks.shape(2) == state_dimension;
  if (!are_blocks || blocks.shape(1) < 1 || blocks.shape(1) > max_block_rows) {
    refuse_shape("blocks", "(n, r, 6) with r from 1 to 3", blocks);
  }
  const auto n = static_cast<std::size_t>(blocks.shape(0));
  if (asked.has_groups) check_shape(asked.groups, "groups", {blocks.shape(0)});
  const Array<bool> required = optional_array<bool>(given_required, "required", {blocks.shape(0)});
  asked.options.budget = budget;
  asked.options.required = static_cast<const unsigned char*>(static_cast<const void*>(data_or_null(required)));
  const auto rows = static_cast<int>(blocks.shape(1));
  BlockStore store(n);
  for (py::ssize_t i = 0; i < blocks.shape(0); ++i) store.push_back(blocks.data(i, 0, 0), rows);
  Selector selector(n);
  const Selection selection = selector.select(store, asked.options);
  if (!selection.has_answer()) {
    const py::object type = py::module_::import("maxlogdet").attr("SelectionError");
    PyErr_SetObject(type.ptr(), type(to_string(selection.error)).ptr());
    throw py::error_already_set();
  }
  return answer_of(selection);
}

struct OwnGoodFeatures : GoodFeatures {
  using GoodFeatures::GoodFeatures;

  std::vector<Camera> cameras;  // of the frame, which the base refers to
};

void start_with(OwnGoodFeatures& self, const py::object& camera, const py::object& T_cw) {
  const RigidTransform pose = pose_of(T_cw, "T_cw");
  const bool is_rig = !py::isinstance<Camera>(camera);
  const char* const expected = "camera: expected a Camera or a sequence of them";
  if (is_rig && !py::isinstance<py::sequence>(camera)) throw py::type_error(expected);
  std::vector<Camera> cameras;
  for (const py::handle& item : is_rig ? camera : py::make_tuple(camera)) {
    if (!py::isinstance<Camera>(item)) throw py::type_error(expected);
    cameras.push_back(item.cast<Camera>());
  }
  self.cameras.swap(cameras);  // the former ones stay until the frame has started
  self.start(self.cameras.data(), self.cameras.size(), pose);
}

void add(OwnGoodFeatures& self, const py::object& given_points, const py::object& given_pixels,
         const py::object& given_sigmas, const py::object& given_u_right, const py::object& given_depth,
         const py::object& given_covariances, const py::object& given_camera_ids, const py::object& given_required,
         const py::object& given_point_ids, const py::object& given_keyframes) {
  const auto points = array_of<double>(given_points, "points", {any_n, 3});
  const py::ssize_t n = points.shape(0);
  const auto pixels = optional_array<double>(given_pixels, "pixels", {n, 2});
  const auto sigmas = optional_array<double>(given_sigmas, "sigmas", {n});
  const auto u_right = optional_array<double>(given_u_right, "u_right", {n});
  const auto depth = optional_array<double>(given_depth, "depth", {n});
  const auto covariances = optional_array<double>(given_covariances, "covariances", {n, 3, 3});
  const auto camera_ids = optional_array<std::uint8_t>(given_camera_ids, "camera_ids", {n});
  const auto required = optional_array<bool>(given_required, "required", {n});
  const auto point_ids = optional_array<std::int64_t>(given_point_ids, "point_ids", {n});
  const auto keyframes = optional_array<std::int64_t>(given_keyframes, "keyframes", {n});
  for (py::ssize_t i = 0; i < n; ++i) {
    FeatureMatch match;
    const auto take = [i](auto& member, const auto& array) {
      if (array.size() > 0) member = array.data()[i];
    };
    std::copy_n(points.data(i, 0), 3, match.point);
    if (pixels.size() > 0) std::copy_n(pixels.data(i, 0), 2, match.measured);
    if (covariances.size() > 0) match.covariance = covariances.data(i, 0, 0);
    take(match.sigma, sigmas);
    take(match.u_right, u_right);
    take(match.depth, depth);
    take(match.camera_id, camera_ids);
    take(match.is_required, required);
    take(match.point_id, point_ids);
    take(match.keyframe, keyframes);
    self.add(match);
  }
}

py::object select(Asked& asked, OwnGoodFeatures& self, std::size_t budget) {
  if (asked.has_groups) check_shape(asked.groups, "groups", {static_cast<py::ssize_t>(self.size())});
  asked.options.budget = budget;
  return answer_of(self.select(asked.options));
}

py::dict alignment_of(const Alignment& alignment) {
  using namespace py::literals;
  return py::dict("status"_a = alignment.reason(), "measured"_a = alignment.measured, "inliers"_a = alignment.inliers,
                  "scale"_a = alignment.scale, "iterations"_a = alignment.iterations);
}

py::dict align(OwnGoodFeatures& self, const py::object& given_prior) {
  const auto prior = optional_array<double>(given_prior, "prior", {state_dimension, state_dimension});
  return alignment_of(self.align(prior.size() > 0 ? prior.data() : nullptr));
}

py::array_t<bool> is_inlier(const OwnGoodFeatures& self) {
  py::array_t<bool> all(static_cast<py::ssize_t>(self.size()));
  for (std::size_t i = 0; i < self.size(); ++i) all.mutable_data()[i] = self.is_inlier(i);
  return all;
}

py::array_t<py::ssize_t> outliers(OwnGoodFeatures& self, const py::object& T_cw) {
  const RigidTransform pose = pose_of(T_cw, "T_cw");
  const IndexRange found = self.outliers(pose);
  return to_numpy(std::vector<py::ssize_t>(found.begin(), found.end()));
}

py::array_t<double> chi2(const OwnGoodFeatures& self) {
  std::vector<double> all(self.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = self.chi2(i);
  return to_numpy(all);
}

bool record(OwnGoodFeatures& self, const py::object& folder) {
  const auto path = py::module_::import("os").attr("fsencode")(folder).cast<std::string>();
  if (path.find('\0') != std::string::npos) throw py::value_error("folder: expected a path without a NUL byte");
  return self.record(path.c_str());
}

py::dict block_report(const OwnGoodFeatures& self) {
  const BlockReport report = self.block_report();
  using namespace py::literals;
  return py::dict("error"_a = to_string(report.error), "invalid"_a = report.invalid, "unusable"_a = report.unusable,
                  "behind_camera"_a = report.behind_camera, "invalid_covariances"_a = report.invalid_covariances);
}

void bind_good_features(py::module_& module) {
  auto bound =
      class_of<OwnGoodFeatures>(module, "GoodFeatures", R"(All that a tracker does with selection, once a frame.

What is selected can be used whatever happens: after an error, which `reason` of the selection names, all usable matches
are. Only arguments of wrong types or shapes raise.)");
  bound.def(py::init<std::size_t>(), py::arg("capacity"), "Reserves memory for frames of up to `capacity` matches.")
      .def("start", &start_with, py::arg("camera"), py::arg("T_cw"), R"(Starts a frame without matches.

camera: a Camera, or a sequence of them, which camera_ids refer to.
T_cw: (3, 4) or (4, 4), world to body, which is the camera unless that has a T_cb. It is the predicted pose.)")
      .def("add", &add, py::arg("points"), py::arg("pixels") = py::none(), py::kw_only(),
           py::arg("sigmas") = py::none(), py::arg("u_right") = py::none(), py::arg("depth") = py::none(),
           py::arg("covariances") = py::none(), py::arg("camera_ids") = py::none(), py::arg("required") = py::none(),
           py::arg("point_ids") = py::none(), py::arg("keyframes") = py::none(),
           R"(Copies and adds n matches. Those beyond the capacity are counted, but neither kept nor selected.

points: (n, 3), world frame, m.
pixels: (n, 2), px, as the camera's model has them. align(), spread and record() need them.
sigmas: (n,), px, standard deviation of u, v and u_right; None: 1.
u_right: (n,), px, the column in the right image; negative or NaN: not measured.
depth: (n,), m; 0, negative or NaN: not measured.
covariances: (n, 3, 3), of the points, world frame, m^2; None: unknown.
camera_ids: (n,) integers; None: 0.
required: (n,) bools: selected in any case, and counts towards the budget.
point_ids, keyframes: (n,) integers, of the map point and of what mapped it; only record() reads them.)")
      .def(
          "align", &align, py::arg("prior") = py::none(),
          R"(Rejects wrong matches, and aligns the pose with all others; select() does it first. Returns what was found.

prior: (6, 6), information about the pose of start(); None: none.)")
      .def_property_readonly(
          "pose",
          [](const OwnGoodFeatures& self) {
            return py::array_t<double>({3, 4}, self.pose().data());
          },
          "The aligned pose, (3, 4), T_cw as in start(); that of start() if there is none.")
      .def_property_readonly(
          "pose_information",
          [](const OwnGoodFeatures& self) {
            return py::array_t<double>({6, 6}, self.pose_information());
          },
          "(6, 6), of the aligned pose, for (translation, rotation); zeros if there is none.")
      .def_property_readonly("is_inlier", &is_inlier, "(n,) bools: whether a match fits the aligned pose.")
      .def_property_readonly(
          "alignment", [](const OwnGoodFeatures& self) { return alignment_of(self.alignment()); },
          "What the last alignment of the frame found: its status, counts, and the robust scale.")
      .def("outliers", &outliers, py::arg("T_cw"),
           "Compares the unselected matches with the optimised pose; returns the numbers of outliers, ascending.")
      .def("chi2", &chi2, "Returns (n,), after outliers(): squared errors in standard deviations; NaN of the selected.")
      .def(
          "efficiency", [](OwnGoodFeatures& self) { return self.efficiency(); },
          "Returns (det M of the selected / det M of all)^(1/6), the share of the information that is kept.")
      .def(
          "record", &record, py::arg("folder"),
          "Writes the frames from the next start() on into a folder, for `maxlogdet evaluate`. Returns whether it can.")
      .def_property_readonly("block_report", &block_report, "Counts of the matches that were no candidates, by reason.")
      .def_property_readonly(
          "reason", [](const OwnGoodFeatures& self) { return self.reason(); },
          "That of the last selection, or 'capacity_exceeded' if some matches were not kept.")
      .def_property_readonly(
          "size", [](const OwnGoodFeatures& self) { return self.size(); }, "The number of matches.")
      .def_readwrite("spread", &OwnGoodFeatures::spread,
                     "At most one match of each of spread * budget cells of the image. 0: off.")
      .def_readwrite("rejects_outliers", &OwnGoodFeatures::rejects_outliers,
                     "Whether select() aligns first, and selects inliers alone.");
  const auto def_option = [&bound](const char* name, double BlockOptions::*member, const char* doc) {
    bound.def_property(
        name, [member](const OwnGoodFeatures& self) { return self.block_options.*member; },
        [member](OwnGoodFeatures& self, double value) { self.block_options.*member = value; }, doc);
  };
  def_option("map_sigma", &BlockOptions::map_sigma,
             "m, standard deviation of a point without a covariance, where others have one.");
  def_option("depth_sigma", &BlockOptions::depth_sigma, "m, standard deviation of a depth.");
  def_select(bound, "select", "Returns the Selection of so many matches, or of all usable ones if there are fewer.",
             &select, py::arg("budget") = 200, py::kw_only());
}

}  // namespace
}  // namespace maxlogdet::python

PYBIND11_MODULE(_core, module) {
  using namespace maxlogdet::python;
  class_of<maxlogdet::Camera>(module, "Camera", R"(A camera on a body: x right, y down, z forward, m; u and v in px.

model: 'pinhole' (rectified images), 'radial_tangential' (OpenCV's), 'kannala_brandt' (its fisheye).
parameters: none; k1, k2, p1, p2, k3; or k1, k2, k3, k4.
bf: of a stereo pinhole, baseline times fx, px m.
cx_right: cx of the right image; None: the same.
T_cb: body to camera, (3, 4) or (4, 4). None: the camera is the body.)")
      .def(py::init(&camera_of), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"), py::arg("bf") = 0.0,
           py::kw_only(), py::arg("cx_right") = py::none(), py::arg("model") = "pinhole",
           py::arg("parameters") = py::tuple(), py::arg("T_cb") = py::none());
  bind_good_features(module);
  def_select(module, "select_blocks", R"(Returns the Selection of `budget` blocks. Raises SelectionError.

blocks: (n, r, 6), whitened Jacobians of 1 to 3 rows; one with a NaN is never selected.
required: (n,) bools: selected in any case, and counts towards the budget.)",
             &select_blocks, py::arg("blocks"), py::arg("budget") = 200, py::kw_only(),
             py::arg("required") = py::none());
  module.def("isa", &maxlogdet::active_isa,
             "The instruction set in use; the environment variable MAXLOGDET_ISA names it.");
  module.attr("__version__") = maxlogdet::version();
  py::list strategies;
  for (const maxlogdet::Strategy strategy : maxlogdet::strategies) strategies.append(to_string(strategy));
  module.attr("strategies") = py::tuple(strategies);
  py::dict errors;
#define MAXLOGDET_ENTRY(name, explanation) errors[#name] = explanation;
  MAXLOGDET_ERRORS(MAXLOGDET_ENTRY)
#undef MAXLOGDET_ENTRY
  module.attr("errors") = errors;
  py::dict warnings;
#define MAXLOGDET_ENTRY(name, explanation) warnings[#name] = explanation;
  MAXLOGDET_WARNINGS(MAXLOGDET_ENTRY)
#undef MAXLOGDET_ENTRY
  module.attr("warnings") = warnings;
}
