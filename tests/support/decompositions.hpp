// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace maxlogdet::test {

// Decompositions for the tests of experiments, compiled once.

/// In descending order.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);

/// Eigenvalues of a symmetric matrix in ascending order, and their eigenvectors of length 1, as columns.
struct Spectrum4 {
  Eigen::Vector4d values;
  Eigen::Matrix4d vectors;
};
Spectrum4 spectrum(const Eigen::Matrix4d& s);

/// The x that minimises |A x - b| for an A of full column rank, by QR with pivoting.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace maxlogdet::test
