// SPDX-License-Identifier: MIT
#pragma once

#include "python/store.hpp"

namespace maxlogdet::python {

/// Adds BlockStore.append_blocks.
void bind_append_blocks(py::class_<Store, std::shared_ptr<Store>>& store);

}  // namespace maxlogdet::python
