// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/executor.hpp"
#include "python/select_options.hpp"
#include "python/selection.hpp"
#include "python/store.hpp"
#include "python/turn.hpp"

#include <cstddef>
#include <memory>
#include <string>

namespace maxlogdet::python {
namespace {

/// A Selector with its default number of threads, and whether it is selecting: meanwhile, another Python thread may
/// run, but must not select with the same selector.
struct OwnSelector {
  OwnSelector(std::size_t capacity, int threads_by_default)
      : selector(capacity, executor()), threads(threads_by_default) {}

  Selector selector;
  int threads;
  bool is_busy = false;  // changed with the GIL held
};

// The caller holds a lease of `blocks`.
Answer run(OwnSelector& self, const BlockStore& blocks, const Options& options) {
  const Turn turn(self.is_busy, "this Selector is selecting in another thread: give each thread a Selector of its own");
  Selection selection{};
  {
    const py::gil_scoped_release others_may_run;
    selection = self.selector.select(blocks, options);
  }
  return answer_of(selection);
}

Answer select(OwnSelector& self, const py::object& blocks, const py::object& budget, const py::kwargs& keywords) {
  const Lease lease(store_of(blocks));  // before converting arguments, which may run Python code that changes the store
  SelectOptions asked(SelectionKind::whole, lease.blocks().size(), budget, keywords);
  if (!asked.has_threads) asked.options.threads = self.threads;
  return run(self, lease.blocks(), asked.options);
}

Answer select_blocks(const py::object& blocks, const py::object& budget, const py::kwargs& keywords) {
  const Lease lease(store_of(blocks));
  const std::size_t n = lease.blocks().size();
  const SelectOptions asked(SelectionKind::whole, n, budget, keywords);
  OwnSelector selector(n, 0);
  return run(selector, lease.blocks(), asked.options);
}

}  // namespace

void bind_selector(py::module_& module) {
  py::class_<OwnSelector>(module, "Selector", R"(Selector(capacity, threads=0)

Owns all the memory for selecting from up to `capacity` candidates: keep one per thread for all frames. threads: 1:
only the calling one; 0: as many as pay off; n: at most n, with oneTBB (has_tbb; always 1 without). The answer does not
depend on it. select() releases the GIL, and raises RuntimeError in a second thread.)")
      .def(py::init([](const py::object& capacity, const py::object& threads) {
             return std::make_unique<OwnSelector>(count_from(capacity, "capacity"), int_from(threads, "threads"));
           }),
           py::arg("capacity"), py::arg("threads") = 0)
      .def(
          "select", &select, py::arg("blocks"), py::arg("budget") = 200,
          R"(select(self, blocks, budget=200, *, prior=None, time_limit=0.0, strategy='lazy_greedy', threads=None, required=None, excluded=None, target_efficiency=0.0, target_translation_sigma=0.0, target_rotation_sigma=0.0, groups=None, group_maximum=1, group_maxima=None, certificate=False, certificate_passes=0, epsilon=0.1, seed=0, exchange_sweeps=0)
--

Selects `budget` candidates of a BlockStore (or of what makes one), or all if there are fewer: those that maximise
log det(prior + sum of selected H^T H). Returns a Selection; raises SelectionError.

prior: (6, 6), symmetric positive definite, in the units and the frame of the blocks; None: 1e-5 I.
time_limit: s, after which those of most information fill the answer in one pass, with the status
  'deadline_reached'; 0: none.
strategy: one of maxlogdet.strategies; 'lazy_greedy' gives greedy's answer, faster; 'stochastic_greedy' uses epsilon
  and seed; 'automatic' chooses by the size of the problem.
threads: as of Selector(); None: the value given there.
required, excluded: (n,) bool: selected in any case, never selected.
target_efficiency: in (0, 1]; 0: none. Stops, with the status 'target_reached', when (det M / det M_all)^(1/6) is that
  high, M the information of prior and selected, M_all with all valid candidates that are not excluded.
target_translation_sigma, target_rotation_sigma: m, rad; 0: none. Stops when the expected standard deviations are at
  most these, the root of the trace of the block of M^-1. Several targets must all be met; greedy strategies take them.
groups: (n,) integers from 0 on, the group of each; at most group_maximum of each are selected, or, unless that is None,
  group_maxima[g], (groups,).
certificate: fills upper_bound; certificate_passes Frank-Wolfe passes tighten it.
exchange_sweeps: maximum number of sweeps of swaps after the search; pays for budgets of 20 or less.

All arrays are copied before the search begins.)")
      .def_property_readonly(
          "capacity", [](const OwnSelector& self) { return self.selector.capacity(); },
          "The maximum number of candidates of select().")
      .def("__repr__", [](const OwnSelector& self) {
        return "<maxlogdet.Selector: capacity " + std::to_string(self.selector.capacity()) + ">";
      });
  module.def(
      "select_blocks", &select_blocks, py::arg("blocks"), py::arg("budget") = 200,
      R"(select_blocks(blocks, budget=200, *, prior=None, time_limit=0.0, strategy='lazy_greedy', threads=None, required=None, excluded=None, target_efficiency=0.0, target_translation_sigma=0.0, target_rotation_sigma=0.0, groups=None, group_maximum=1, group_maxima=None, certificate=False, certificate_passes=0, epsilon=0.1, seed=0, exchange_sweeps=0)
--

Calls select() of a temporary Selector, just large enough; in a loop over frames keep a Selector instead.
`blocks` is a BlockStore, an (n, r, 6) array of floats, or a list of (r, 6) arrays. Any number of threads may call it.)");
}

}  // namespace maxlogdet::python
