// SPDX-License-Identifier: MIT
#pragma once

// The guide's code that belongs to no tracker.

#include "good_features.inc"

#include "active_features.inc"

#include "budget.inc"
#include "match_in_batches.inc"
#include "per_thread.inc"
#include "point_covariance.inc"
#include "priors.inc"
