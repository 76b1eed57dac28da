// SPDX-License-Identifier: MIT
// The compiled part of the Python package `maxlogdet`, which maxlogdet/__init__.py imports.
#include "python/bindings.hpp"
#include "python/executor.hpp"
#include "python/names.hpp"

#include <maxlogdet/isa.hpp>
#include <maxlogdet/version.hpp>

#include <cstddef>

namespace {

namespace py = pybind11;

// To a function that takes an object whose __init__ never ran, as Selector.__new__(Selector), pybind11 gives memory in
// which nothing was constructed. It asks the class for that memory, and for no other: so the class refuses.
void* refuse_uninitialised(std::size_t) {
  throw py::type_error("the object is not initialised: call its __init__, or super().__init__, first");
}

// Makes misused objects of all classes raise errors where pybind11 would crash.
void protect_classes(const py::module_& module) {
  const py::dict members = module.attr("__dict__");
  for (const auto& [name, member] : members) {
    if (!py::isinstance<py::type>(member)) continue;
    py::detail::type_info* const bound = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(member.ptr()));
    if (bound == nullptr) continue;
    bound->operator_new = &refuse_uninitialised;
    // A __new__ of its own, though the same one: for pickle's protocols 0 and 1, copyreg calls the class that has it,
    // and pybind11's base class would end the process.
    const auto* const inherited = reinterpret_cast<PyCFunctionObject*>(py::object(member.attr("__new__")).ptr());
    member.attr("__new__") = py::reinterpret_steal<py::object>(PyCFunction_New(inherited->m_ml, member.ptr()));
  }
}

}  // namespace

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
  bind_good_features(module);
  protect_classes(module);

  module.def("isa", &maxlogdet::active_isa, R"(isa()
--

The instruction set of a Selector made now, one of `isas`, those built in; the environment variable MAXLOGDET_ISA
selects one. 'none' if that is not built in or not supported by this machine: selecting then raises SelectionError
('unsupported_isa'). Answers do not depend on it.)");
  module.attr("__version__") = maxlogdet::version();
  module.attr("errors") = explanations();
  module.attr("strategies") = strategy_names();
  module.attr("camera_models") = camera_model_names();
  module.attr("isas") = isa_names();
  module.attr("has_tbb") = has_executor();
}
