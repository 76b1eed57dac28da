// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"

namespace maxlogdet::sim {

// Eigenvalues of symmetric matrices, in a file of their own because Eigen's solver takes seconds to compile.

/// Returns the eigenvalues in ascending order.
Vector6 eigenvalues_of(const Matrix6& Q);

/// Returns the unit eigenvector of the largest eigenvalue.
Vector6 largest_eigenvector(const Matrix6& Q);

}  // namespace maxlogdet::sim
