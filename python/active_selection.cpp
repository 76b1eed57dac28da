// SPDX-License-Identifier: MIT
#include <maxlogdet/active_selection.hpp>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/errors.hpp"
#include "python/select_options.hpp"
#include "python/selection.hpp"
#include "python/store.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::python {
namespace {

/// An ActiveSelection with what it refers to: the lease keeps the candidates, the options keep their arrays.
class OwnActiveSelection {
 public:
  explicit OwnActiveSelection(const py::object& capacity) : active_(count_from(capacity, "capacity")) {}

  // Ends the previous selection even if this one fails.
  void start(const py::object& blocks, const py::object& budget, const py::kwargs& keywords) {
    stop();
    Lease lease(store_of(blocks));  // before converting arguments, which may run Python code that changes the store
    SelectOptions asked(SelectionKind::active, lease.blocks().size(), budget, keywords);
    if (lease_) throw std::runtime_error("another thread started this ActiveSelection meanwhile");
    check(active_.start(lease.blocks(), asked.options));
    asked_.emplace(std::move(asked));
    lease_.emplace(std::move(lease));
  }

  void stop() noexcept {
    lease_.reset();
    asked_.reset();
    unanswered_ = 0;
  }

  py::object next() {
    std::uint32_t proposal = ActiveSelection::none;
    if (propose(&proposal, 1) == 0) return py::none();
    return py::int_(proposal);
  }

  py::array next_batch(const py::object& count) {
    std::vector<std::uint32_t> batch(std::min(count_from(count, "count"), active_.capacity()));
    const std::size_t size = propose(batch.data(), batch.size());
    return py::array_t<std::uint32_t>(static_cast<py::ssize_t>(size), batch.data());
  }

  py::object next_of_iteration() {
    if (unanswered_ > 0) throw std::runtime_error("answer the proposal with accept() or reject() before the next one");
    py::object proposal = next();
    if (proposal.is_none()) throw py::stop_iteration();
    return proposal;
  }

  void accept(const py::object& block, const py::object& index) {
    if (block.is_none()) {
      answer_one(index, [this](auto... of) { return active_.accept(of...); });
      return;
    }
    const Array<double> measured = block_array(block, "block");
    const int rows = static_cast<int>(measured.shape(0));
    answer_one(index, [&](auto... of) { return active_.accept(of..., measured.data(), rows); });
  }

  void reject(const py::object& index) {
    answer_one(index, [this](auto... of) { return active_.reject(of...); });
  }

  void answer(const py::object& matched) {
    if (matched.is_none()) throw py::type_error("matched: expected an array of bools, got None");
    if (unanswered_ == 0) throw SelectionError(Error::nothing_proposed);
    const Array<bool> flags = optional_mask(matched, "matched", unanswered_);
    give([&] { return active_.answer(data_or_null(flags), static_cast<std::size_t>(flags.size())); });
    unanswered_ = 0;
  }

  Answer selection() const {
    if (!lease_) throw SelectionError(Error::nothing_proposed);
    return answer_of(active_.selection());
  }

  std::size_t capacity() const noexcept { return active_.capacity(); }

 private:
  std::size_t propose(std::uint32_t* indices, std::size_t count) {
    const std::size_t size = lease_ ? active_.next(indices, count) : 0;
    if (unanswered_ == 0) unanswered_ = size;
    return size;
  }

  // Answers the first proposal, or the one with the index.
  template <class Give>
  void answer_one(const py::object& index, const Give& give_answer) {
    if (index.is_none()) {
      give([&] { return give_answer(); });
    } else {
      const std::size_t none = ActiveSelection::none;
      const auto of = static_cast<std::uint32_t>(std::min(count_from(index, "index"), none));
      give([&] { return give_answer(of); });
    }
    --unanswered_;
  }

  template <class Give>
  void give(const Give& give_answer) {
    if (!lease_) throw SelectionError(Error::nothing_proposed);
    check(give_answer());
  }

  ActiveSelection active_;
  std::optional<SelectOptions> asked_;
  std::optional<Lease> lease_;  // held from start() to stop()
  std::size_t unanswered_ = 0;  // proposals
};

}  // namespace

void bind_active_selection(py::module_& module) {
  py::class_<OwnActiveSelection>(module, "ActiveSelection", R"(ActiveSelection(capacity)

Active matching: candidates are points that are not matched yet; each proposal is the candidate of maximum gain, and is
answered with accept() or reject(). If everything is accepted as proposed, the answer is that of lazy_greedy.

    with maxlogdet.ActiveSelection(2000) as active:
        active.start(blocks, budget=100)
        for i in active:
            active.accept() if match(i) else active.reject()
        selection = active.selection()

From start() to stop() the store cannot change; the next start(), the end of `with` and deletion also stop.)")
      .def(py::init<const py::object&>(), py::arg("capacity"))
      .def(
          "start", &OwnActiveSelection::start, py::arg("blocks"), py::arg("budget") = 200,
          R"(start(self, blocks, budget=200, *, prior=None, time_limit=0.0, strategy='lazy_greedy', required=None, excluded=None, target_efficiency=0.0, target_translation_sigma=0.0, target_rotation_sigma=0.0, groups=None, group_maximum=1, group_maxima=None)
--

Starts a new selection, with the arguments of Selector.select(); the time limit includes the matching, groups count
accepted candidates, target_efficiency compares with all blocks as offered. strategy is 'greedy', 'lazy_greedy' or
'automatic', which are the same here.)")
      .def("next", &OwnActiveSelection::next, R"(next(self)
--

Returns the candidate of maximum gain that is neither accepted nor rejected; while proposals are unanswered, the first
of these again. None when the budget is reached, nothing is left, the time limit has passed, or the targets are met.)")
      .def("next_batch", &OwnActiveSelection::next_batch, py::arg("count"), R"(next_batch(self, count)
--

Returns the indices of the `count` candidates of maximum current gain, best first, as an array. There are fewer only
where no more may all be accepted: by what is left, by the budget, and by the maximum of a group. While proposals are
unanswered, returns these again, at most `count`.)")
      .def("accept", &OwnActiveSelection::accept, py::arg("block") = py::none(), py::kw_only(),
           py::arg("index") = py::none(), R"(accept(self, block=None, *, index=None)
--

Adds the first unanswered proposal, or that of an index, to the selection: as proposed, or with the (r, 6) block as
measured, r in {1, 2, 3}.)")
      .def("reject", &OwnActiveSelection::reject, py::kw_only(), py::arg("index") = py::none(),
           R"(reject(self, *, index=None)
--

Rejects the first unanswered proposal, or that of an index: it is not proposed again.)")
      .def("answer", &OwnActiveSelection::answer, py::arg("matched"), R"(answer(self, matched)
--

Answers all unanswered proposals in their order: one bool for each, True accepts.)")
      .def("selection", &OwnActiveSelection::selection, R"(selection(self)
--

Returns a Selection of what has been accepted so far, in that order.)")
      .def("stop", &OwnActiveSelection::stop, R"(stop(self)
--

Ends the selection and releases the store.)")
      .def_property_readonly("capacity", &OwnActiveSelection::capacity, "The maximum number of candidates of start().")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &OwnActiveSelection::next_of_iteration)
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](OwnActiveSelection& self, const py::args&) { self.stop(); })
      .def("__repr__", [](const OwnActiveSelection& self) {
        return "<maxlogdet.ActiveSelection: capacity " + std::to_string(self.capacity()) + ">";
      });
}

}  // namespace maxlogdet::python
