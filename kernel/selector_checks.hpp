// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

namespace maxlogdet {

/// The first thing wrong with what the caller asks for; ok if nothing is.
Status check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept;

/// A selection of nothing, as it is after an error.
Selection empty_selection(Status status) noexcept;

}  // namespace maxlogdet
