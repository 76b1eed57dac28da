// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

namespace maxlogdet {

/// Returns the first error of the caller's arguments, or ok.
Error check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept;

/// An empty selection, as after an error.
Selection empty_selection(Error error) noexcept;

}  // namespace maxlogdet
