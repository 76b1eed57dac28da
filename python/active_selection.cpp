// SPDX-License-Identifier: MIT
#include <maxlogdet/active_selection.hpp>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/errors.hpp"
#include "python/select_options.hpp"
#include "python/selection.hpp"
#include "python/store.hpp"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace maxlogdet::python {
namespace {

/// An ActiveSelection with what it refers to: the lease keeps the candidates, `asked` the arrays.
class OwnActiveSelection {
 public:
  explicit OwnActiveSelection(const py::object& capacity) : active_(count_from(capacity, "capacity")) {}

  // After an error the one before has ended too.
  void start(const py::object& blocks, const py::object& budget, const py::kwargs& keywords) {
    stop();
    Lease lease(store_of(blocks));  // first: converting arguments may run Python code, which could change the store
    SelectOptions asked(SelectionKind::active, lease.blocks().size(), budget, keywords);
    if (lease_) throw std::runtime_error("this ActiveSelection was started by another thread meanwhile");
    const Status status = active_.start(lease.blocks(), asked.options);
    if (status != Status::ok) throw StatusError(status);
    asked_.emplace(std::move(asked));
    lease_.emplace(std::move(lease));
  }

  void stop() noexcept {
    lease_.reset();
    asked_.reset();
    is_proposing_ = false;
  }

  py::object next() {
    const std::uint32_t proposal = lease_ ? active_.next() : ActiveSelection::none;
    is_proposing_ = proposal != ActiveSelection::none;
    if (!is_proposing_) return py::none();
    return py::int_(proposal);
  }

  py::object next_of_iteration() {
    if (is_proposing_) throw std::runtime_error("answer the proposal with accept() or reject() before the next one");
    py::object proposal = next();
    if (proposal.is_none()) throw py::stop_iteration();
    return proposal;
  }

  void accept(const py::object& block) {
    if (block.is_none()) {
      answer([this] { return active_.accept(); });
      return;
    }
    const Array<double> measured = real_array(block, "block", {any_r, state_dimension});
    if (measured.shape(0) < 1 || measured.shape(0) > max_block_rows) {
      throw py::value_error("block: expected shape (r, 6) with r in {1, 2, 3}, got " +
                            std::string(py::str(measured.attr("shape"))));
    }
    answer([&] { return active_.accept(measured.data(), static_cast<int>(measured.shape(0))); });
  }

  void reject() {
    answer([this] { return active_.reject(); });
  }

  Answer selection() const {
    if (!lease_) throw StatusError(Status::nothing_proposed);
    return answer_of(active_.selection());
  }

  std::size_t capacity() const noexcept { return active_.capacity(); }

 private:
  template <class Give>
  void answer(const Give& give) {
    if (!lease_) throw StatusError(Status::nothing_proposed);
    const Status status = give();
    if (status != Status::ok) throw StatusError(status);
    is_proposing_ = false;
  }

  ActiveSelection active_;
  std::optional<SelectOptions> asked_;
  std::optional<Lease> lease_;  // none before start() and after stop()
  bool is_proposing_ = false;
};

}  // namespace

void bind_active_selection(py::module_& module) {
  py::class_<OwnActiveSelection>(module, "ActiveSelection", R"(ActiveSelection(capacity)

Selection hand in hand with matching: candidates are points not matched yet, each proposal is the one that adds most to
what has been accepted, and is answered with accept() or reject(). If everything is accepted as proposed the answer is
that of lazy_greedy.

    with maxlogdet.ActiveSelection(2000) as active:
        active.start(blocks, budget=100)
        for i in active:
            active.accept() if match(i) else active.reject()
        selection = active.selection()

From start() to stop() the store cannot change; the next start(), the end of the `with` and of the object stop too.)")
      .def(py::init<const py::object&>(), py::arg("capacity"))
      .def(
          "start", &OwnActiveSelection::start, py::arg("blocks"), py::arg("budget") = 100,
          R"(start(self, blocks, budget=100, *, strategy='lazy_greedy', prior=None, time_limit=0.0, required=None, excluded=None, groups=None, group_maxima=None, max_per_group=1)
--

Begins anew, with arguments as of Selector.select(); the time limit includes the matching, groups count what is accepted.
Strategies are 'greedy', 'lazy_greedy' and 'automatic', here all the same.)")
      .def("next", &OwnActiveSelection::next, R"(next(self)
--

The best of what has been neither accepted nor rejected; the same again until it is answered. None when the budget is
reached, nothing is left, or the time limit has passed.)")
      .def("accept", &OwnActiveSelection::accept, py::arg("block") = py::none(), R"(accept(self, block=None)
--

The proposal is matched: it enters the selection as proposed, or with the (r, 6) block as measured, r in {1, 2, 3}.)")
      .def("reject", &OwnActiveSelection::reject, R"(reject(self)
--

The proposal is not matched, and not proposed again.)")
      .def("selection", &OwnActiveSelection::selection, R"(selection(self)
--

A Selection of what has been accepted so far, in that order.)")
      .def("stop", &OwnActiveSelection::stop, R"(stop(self)
--

Lets go of the store, and ends what start() began.)")
      .def_property_readonly("capacity", &OwnActiveSelection::capacity, "Most candidates that start() accepts.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &OwnActiveSelection::next_of_iteration)
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](OwnActiveSelection& self, const py::args&) { self.stop(); })
      .def("__repr__", [](const OwnActiveSelection& self) {
        return "<maxlogdet.ActiveSelection: capacity " + std::to_string(self.capacity()) + ">";
      });
}

}  // namespace maxlogdet::python
