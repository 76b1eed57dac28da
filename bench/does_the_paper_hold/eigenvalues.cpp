// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/eigenvalues.hpp"

#include <Eigen/Eigenvalues>

namespace maxlogdet::sim {

Vector6 eigenvalues_of(const Matrix6& Q) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(Q, Eigen::EigenvaluesOnly).eigenvalues();
}

Vector6 largest_eigenvector(const Matrix6& Q) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(Q).eigenvectors().col(5);
}

}  // namespace maxlogdet::sim
