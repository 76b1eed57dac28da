// SPDX-License-Identifier: MIT
#pragma once

#include "sim/se3.hpp"

namespace maxlogdet::sim {

// Of a symmetric matrix. Here, and not where they are needed, because Eigen's solver takes seconds to compile.

/// The smallest first.
Vector6 eigenvalues_of(const Matrix6& Q);

/// The eigenvector of the largest eigenvalue, of length 1.
Vector6 largest_eigenvector(const Matrix6& Q);

}  // namespace maxlogdet::sim
