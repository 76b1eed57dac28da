// SPDX-License-Identifier: MIT
#include "python/selection.hpp"

#include "python/errors.hpp"
#include "python/pickling.hpp"

#include <algorithm>
#include <string>

namespace maxlogdet::python {
namespace {

std::string text_of(const Answer& answer) {
  return py::str("<maxlogdet.Selection: {}, {} selected by {}, log_det {:.6g}>")
      .format(answer.selection.reason(), answer.selection.size, to_string(answer.selection.strategy),
              answer.selection.log_det);
}

// All members that the arrays do not determine.
constexpr PlainMembers numbers(&Selection::status, &Selection::error, &Selection::searched, &Selection::log_det,
                               &Selection::evaluations, &Selection::float64_decisions, &Selection::invalid_candidates,
                               &Selection::upper_bound, &Selection::strategy, &Selection::threads,
                               &Selection::efficiency, &Selection::translation_sigma, &Selection::rotation_sigma);

Answer unpickled(const py::tuple& state) {
  check_state(state, 3);
  Answer answer{numbers.object_of(state[0]), state[1].cast<py::array_t<py::ssize_t>>(),
                state[2].cast<py::array_t<double>>()};
  answer.selection.size = static_cast<std::size_t>(answer.indices.size());
  return answer;
}

}  // namespace

Answer answer_of(const Selection& selection) {
  check(selection.error);
  return copy_of(selection);
}

Answer copy_of(const Selection& selection) {
  const auto size = static_cast<py::ssize_t>(selection.size);
  Answer answer{selection, py::array_t<py::ssize_t>(size), py::array_t<double>(size)};
  std::copy_n(selection.indices, selection.size, answer.indices.mutable_data());
  std::copy_n(selection.gains, selection.size, answer.gains.mutable_data());
  answer.selection.indices = nullptr;
  answer.selection.gains = nullptr;
  return answer;
}

void bind_selection(py::module_& module) {
  const auto number = [](auto member) { return [member](const Answer& self) { return self.selection.*member; }; };
  py::class_<Answer>(module, "Selection",
                     R"(The answer. It owns its arrays: the next select() does not change them.

len() is the number selected; iteration gives their indices.)")
      .def_readonly("indices", &Answer::indices,
                    "(k,) of numpy.intp: required ones, then in order of selection; of backward_greedy by index.")
      .def_readonly("gains", &Answer::gains, "(k,): the increase of log det by each after those before it, nats.")
      .def_property_readonly("log_det", number(&Selection::log_det), "log det(prior + sum of selected H^T H), nats.")
      .def_property_readonly(
          "upper_bound", number(&Selection::upper_bound),
          "Proved bound, nats: no selection that the arguments allow has a greater log det. NaN unless "
          "certificate=True.")
      .def_property_readonly(
          "certified_efficiency", [](const Answer& self) { return self.selection.certified_efficiency(); },
          "(det M / det of the bound)^(1/6); NaN unless certificate=True.")
      .def_property_readonly(
          "status", [](const Answer& self) { return to_string(self.selection.status); },
          "'ok'; 'all_selected': no more may be selected; 'target_reached': all targets given are met; "
          "'deadline_reached': those of most information fill the answer in one pass; 'few_candidates' and "
          "'error': see GoodFeatures.select().")
      .def_property_readonly(
          "error", [](const Answer& self) { return to_string(self.selection.error); },
          "What is wrong, a key of maxlogdet.errors; 'none' unless status is 'error'.")
      .def_property_readonly(
          "reason", [](const Answer& self) { return self.selection.reason(); }, "For a log: the error, or the status.")
      .def_property_readonly("searched", number(&Selection::searched),
                             "How many of the indices, from the first on, the search itself selected: fewer than all "
                             "only at a deadline.")
      .def_property_readonly(
          "strategy", [](const Answer& self) { return to_string(self.selection.strategy); },
          "The requested one, or what 'automatic' chose.")
      .def_property_readonly("efficiency", number(&Selection::efficiency),
                             "(det M / det M_all)^(1/6), the share of the information of all valid candidates that are "
                             "not excluded; NaN without target_efficiency.")
      .def_property_readonly("translation_sigma", number(&Selection::translation_sigma),
                             "Expected standard deviation of the translation, m; NaN without target_translation_sigma.")
      .def_property_readonly("rotation_sigma", number(&Selection::rotation_sigma),
                             "Expected standard deviation of the rotation, rad; NaN without target_rotation_sigma.")
      .def_property_readonly("evaluations", number(&Selection::evaluations),
                             "Gains evaluated to exclude candidates, and losses; may differ between machines.")
      .def_property_readonly("float64_decisions", number(&Selection::float64_decisions),
                             "Of these, computed again to decide.")
      .def_property_readonly("invalid_candidates", number(&Selection::invalid_candidates),
                             "Candidates without a block: never selected.")
      .def_property_readonly("threads", number(&Selection::threads), "How many threads the work was offered to.")
      .def("__len__", [](const Answer& self) { return self.indices.size(); })
      .def("__iter__", [](const Answer& self) { return py::iter(self.indices.attr("tolist")()); })
      .def("__repr__", &text_of)
      .def(py::pickle(
          [](const Answer& self) { return py::make_tuple(numbers.state_of(self.selection), self.indices, self.gains); },
          &unpickled));
}

}  // namespace maxlogdet::python
