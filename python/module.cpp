// SPDX-License-Identifier: MIT
// The compiled part of the Python package `maxlogdet`, which maxlogdet/__init__.py imports.
#include "python/bindings.hpp"
#include "python/executor.hpp"
#include "python/names.hpp"

#include <maxlogdet/isa.hpp>
#include <maxlogdet/version.hpp>

PYBIND11_MODULE(_core, module) {
  using namespace maxlogdet::python;
  // inspect.signature() cannot read pybind11's signatures: docstrings begin with hand-written ones that it can.
  py::options docstrings;
  docstrings.disable_function_signatures();

  bind_errors(module);
  bind_cameras(module);
  bind_block_report(module);
  bind_store(module);
  bind_match_weights(module);
  bind_selection(module);
  bind_selector(module);
  bind_active_selection(module);

  module.def("isa", &maxlogdet::active_isa, R"(isa()
--

The instruction set of a Selector made now, one of `isas`, those built in; the environment variable MAXLOGDET_ISA
selects one. 'none' if that is not built in or not supported by this machine: selecting then raises SelectionError
('unsupported_isa'). Answers do not depend on it.)");
  module.attr("__version__") = maxlogdet::version();
  module.attr("strategies") = strategy_names();
  module.attr("camera_models") = camera_model_names();
  module.attr("isas") = isa_names();
  module.attr("has_tbb") = has_executor();
}
