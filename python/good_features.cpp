// SPDX-License-Identifier: MIT
#include <maxlogdet/good_features.hpp>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/feature_matches.hpp"
#include "python/own_good_features.hpp"

#include <memory>
#include <string>

namespace maxlogdet::python {
namespace {

using Bound = py::class_<OwnGoodFeatures>;

void def_options(Bound& bound) {
  bound.def_property(
      "weighting", [](OwnGoodFeatures& self) { return to_string(self.idle().block_options.weighting); },
      [](OwnGoodFeatures& self, const py::object& value) { take(self.idle().block_options, "weighting", value); },
      "As of BlockStore.append_blocks; 'measurement' becomes 'measurement_and_map' in a frame where some match has a "
      "covariance: one without has map_sigma^2 I.");
  const auto def_number = [&bound](const char* name, double BlockOptions::*member, const char* documentation) {
    bound.def_property(
        name, [member](OwnGoodFeatures& self) { return self.idle().block_options.*member; },
        [member, name](OwnGoodFeatures& self, const py::object& value) {
          self.idle().block_options.*member = number_from(value, name);
        },
        documentation);
  };
  def_number("map_sigma", &BlockOptions::map_sigma, "m, standard deviation of a point without a covariance.");
  def_number("depth_sigma", &BlockOptions::depth_sigma, "m, standard deviation of a measured depth.");
  def_number("min_depth", &BlockOptions::min_depth, "m, nearer matches are no candidates.");
  bound
      .def_property(
          "spread", [](OwnGoodFeatures& self) { return self.idle().spread; },
          [](OwnGoodFeatures& self, const py::object& value) { self.idle().spread = number_from(value, "spread"); },
          "Where neighbouring matches share errors, 1.5: at most one match of each of spread * budget cells of the "
          "image. 0: off. Needs measurements; ignored where groups are given.")
      .def_property(
          "is_weighted", [](OwnGoodFeatures& self) { return self.idle().is_weighted; },
          [](OwnGoodFeatures& self, const py::object& value) {
            self.idle().is_weighted = bool_from(value, "is_weighted");
          },
          "Whether the optimiser weights residuals by information(); outliers() then does, too.");
}

void def_frame(Bound& bound) {
  bound
      .def("start", &OwnGoodFeatures::start, py::arg("camera"), py::arg("T_cw"), R"(start(self, camera, T_cw)
--

Starts a frame without matches: camera or rig, and pose, as of BlockStore.append_blocks.)")
      .def(
          "add", &OwnGoodFeatures::add, py::arg("points"), py::arg("measured") = py::none(),
          py::arg("sigmas") = py::none(),
          R"(add(self, points, measured=None, sigmas=None, *, u_right=None, depth=None, covariances=None, jacobians=None, camera_ids=None, required=None, point_ids=None, keyframes=None)
--

Copies and adds n matches, whose numbers begin with len(). Those beyond the capacity are counted, but neither kept nor
selected.

points: (n, 3), world frame, m.
measured: (n, 2), px, as the camera's model has them; None: not measured. outliers(), spread and record() need them.
sigmas: (n,), px, standard deviation of u, v and u_right; None: 1.
u_right: (n,), px, the column in the right image; negative or NaN: not measured.
depth: (n,), m; 0, negative or NaN: not measured.
covariances: (n, 3, 3), of the points, world frame, m^2; None: unknown.
jacobians: (n, 2, 3), d (u, v) / d p_c, px per m, of a camera model of your own; None: the camera's.
camera_ids: (n,) integers, which camera of a rig; None: 0.
required: (n,) bool, selected in any case; counts towards the budget.
point_ids, keyframes: (n,) integers, of the map point, the same in every frame, and of what mapped it; only record()
  reads them.)")
      .def("__len__", [](OwnGoodFeatures& self) { return self.idle().size(); })
      .def_property_readonly("capacity", &OwnGoodFeatures::capacity, "The maximum number of matches that are kept.")
      .def("record", &OwnGoodFeatures::record, py::arg("folder"), R"(record(self, folder)
--

From the next start() on, writes every frame that is selected from into the folder, for `maxlogdet evaluate FOLDER`.
Returns whether frames will be recorded; a problem, also a later one, is said in one line on stderr.)")
      .def("__repr__", [](OwnGoodFeatures& self) {
        return "<maxlogdet.GoodFeatures: " + std::to_string(self.idle().size()) + " matches, capacity " +
               std::to_string(self.capacity()) + ">";
      });
}

void def_selection(Bound& bound) {
  bound
      .def(
          "select", &OwnGoodFeatures::select, py::arg("budget") = 200,
          R"(select(self, budget=200, *, prior=None, time_limit=0.0, strategy='lazy_greedy', threads=None, required=None, excluded=None, target_efficiency=0.0, target_translation_sigma=0.0, target_rotation_sigma=0.0, groups=None, group_maximum=1, group_maxima=None, certificate=False, certificate_passes=0, epsilon=0.1, seed=0, exchange_sweeps=0)
--

Returns a Selection of match numbers that can be optimised with whatever happens; options as of Selector.select().

They are as many as the budget, or all usable ones if there are fewer (groups and a target may leave them shorter). A
match is usable if its point, measurement and sigma are finite, sigma is positive, and it is not excluded. Where fewer
than the budget have a block, as behind the camera, usable ones without a block fill it, with gains of NaN; the status
is then 'few_candidates'. After an error, of pose, camera or options, the status is 'error', and all usable matches are
selected. Only arguments of wrong types or shapes raise.)")
      .def(
          "match", &OwnGoodFeatures::match, py::arg("try_to_match"), py::arg("budget") = 200,
          R"(match(self, try_to_match, budget=200, *, prior=None, time_limit=0.0, strategy='lazy_greedy', required=None, excluded=None, target_efficiency=0.0, target_translation_sigma=0.0, target_rotation_sigma=0.0, groups=None, group_maximum=1, group_maxima=None)
--

Active matching: calls try_to_match(i) for the points of maximum gain, one after the other, until as many are matched as
the options ask for. It returns None or False if it has not found match i; else True, its (u, v), or a dict with some of
measured, sigma, u_right, depth.

Returns those matched, in that order. select(), outliers() and record() then go on with them. An exception passes
through; then start() the frame again.)")
      .def_property_readonly(
          "selection", [](OwnGoodFeatures& self) { return copy_of(self.idle().selection()); },
          "The last answer of select() or match() in this frame.")
      .def_property_readonly(
          "reason", [](OwnGoodFeatures& self) { return self.idle().reason(); },
          "For a log: the error, or the status; 'capacity_exceeded' if some matches were not kept.")
      .def_property_readonly(
          "block_report", [](OwnGoodFeatures& self) { return self.idle().block_report(); },
          "BlockReport of the last selection: how many matches were no candidates, for which reason.")
      .def("blocks", &OwnGoodFeatures::blocks, R"(blocks(self)
--

Returns a copy of the BlockStore of the last selection: candidate i is match i.)")
      .def(
          "efficiency", [](OwnGoodFeatures& self) { return efficiency(self.idle()); }, R"(efficiency(self)
--

Returns (det M of the selected / det M of all candidates)^(1/6), in (0, 1]: the share of the information that is kept.
NaN after an error and without candidates. Needs weighting 'measurement' or 'measurement_and_map'.)");
}

void def_judgement(Bound& bound) {
  bound
      .def("outliers", &OwnGoodFeatures::outliers, py::arg("T_cw"), R"(outliers(self, T_cw)
--

Compares the unselected matches with the optimised pose, and returns the numbers of outliers, ascending: those whose
chi2 is above the 95 % quantile, 5.991 for two measurements, 7.815 for three.)")
      .def_property_readonly("chi2", &OwnGoodFeatures::chi2,
                             "(n,), after outliers(): squared error in standard deviations. Infinite where the point "
                             "has no image or the match is not usable; NaN for selected and unmeasured matches, and in "
                             "a frame with jacobians.")
      .def(
          "information", [](OwnGoodFeatures& self) { return self.weights(false); }, R"(information(self)
--

Returns (n, r, r): the weight of each match's residual at the pose of start(), as match_information.)")
      .def(
          "whitening", [](OwnGoodFeatures& self) { return self.weights(true); }, R"(whitening(self)
--

Returns (n, r, r): W of each match, W^T W its information(), as match_whitening.)");
}

}  // namespace

void bind_good_features(py::module_& module) {
  Bound bound(module, "GoodFeatures", R"(GoodFeatures(capacity, threads=0)

All that a tracker does with selection, once a frame:

    good = maxlogdet.GoodFeatures(2000)  # once a thread: all the memory
    good.start(camera, T_cw)             # the pose that optimisation starts from
    good.add(points, measured, sigmas)
    selection = good.select(200)         # optimise the pose with selection.indices
    outliers = good.outliers(T_cw)       # unselected, and far off at the optimised pose

threads: as of Selector. select() releases the GIL; meanwhile, and while match() runs, every member raises
RuntimeError.)");
  bound.def(py::init([](const py::object& capacity, const py::object& threads) {
              return std::make_unique<OwnGoodFeatures>(count_from(capacity, "capacity"), int_from(threads, "threads"));
            }),
            py::arg("capacity"), py::arg("threads") = 0);
  def_frame(bound);
  def_options(bound);
  def_selection(bound);
  def_judgement(bound);
  module.def(
      "select", &select_once, py::arg("camera"), py::arg("T_cw"), py::arg("points"), py::arg("measured") = py::none(),
      py::arg("sigmas") = py::none(), py::kw_only(), py::arg("budget") = 200,
      R"(select(camera, T_cw, points, measured=None, sigmas=None, *, u_right=None, depth=None, covariances=None, jacobians=None, camera_ids=None, weighting='measurement', map_sigma=0.05, depth_sigma=0.05, min_depth=0.01, budget=200, prior=None, time_limit=0.0, strategy='lazy_greedy', threads=None, required=None, excluded=None, target_efficiency=0.0, target_translation_sigma=0.0, target_rotation_sigma=0.0, groups=None, group_maximum=1, group_maxima=None, certificate=False, certificate_passes=0, epsilon=0.1, seed=0, exchange_sweeps=0)
--

GoodFeatures in one call, for scripts and tests: start(), add() and select(), whose arguments it takes. Any number of
threads may call it.)");
}

}  // namespace maxlogdet::python
