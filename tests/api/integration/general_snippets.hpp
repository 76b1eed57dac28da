// SPDX-License-Identifier: MIT
#pragma once

// The guide's code that belongs to no tracker.

#include <maxlogdet/active_selection.hpp>
#include <maxlogdet/good_features.hpp>
#include <maxlogdet/image_cells.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "budget_in_accuracy.inc"
#include "match_actively.inc"
#include "match_in_batches.inc"
#include "more_options.inc"
#include "own_jacobians.inc"
#include "own_tracker.inc"
#include "own_types.inc"
#include "per_thread.inc"
#include "priors.inc"
#include "record.inc"
#include "spread_over_image.inc"
#include "weigh_rows.inc"
