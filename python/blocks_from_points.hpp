// SPDX-License-Identifier: MIT
#pragma once

#include "python/store.hpp"

namespace maxlogdet::python {

/// Adds PinholeCamera, BlockReport and BlockStore.append_blocks: the Jacobians of jacobian.hpp.
void bind_blocks_from_points(py::module_& module, py::class_<Store, std::shared_ptr<Store>>& store);

}  // namespace maxlogdet::python
