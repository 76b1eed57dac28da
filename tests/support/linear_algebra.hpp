// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <Eigen/Core>

namespace maxlogdet::test {

// The linear algebra of oracles, compiled once: a test that instantiates a decomposition or a large product itself
// takes seconds longer to compile for each.

using Vector6 = Eigen::Matrix<double, state_dimension, 1>;
using WideMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using WideMatrix6 = Eigen::Matrix<long double, state_dimension, state_dimension>;
using WideVector6 = Eigen::Matrix<long double, state_dimension, 1>;

/// A B.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
WideMatrix wide_product(const WideMatrix& a, const WideMatrix& b);

/// A^T A: the information of stacked rows.
Eigen::MatrixXd gram(const Eigen::MatrixXd& a);
WideMatrix wide_gram(const WideMatrix& a);

/// The inverse, by LU with pivoting.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
WideMatrix wide_inverse(const WideMatrix& a);

/// L, lower triangular, of a symmetric positive definite S = L L^T; not finite where S is not.
Eigen::MatrixXd cholesky(const Eigen::MatrixXd& s);

/// L^-1 B for a lower triangular L.
Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& l, const Eigen::MatrixXd& b);

/// |A - B| / |B|, Frobenius.
double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The largest |entry| of A, and of A - B.
double largest_entry(const Eigen::MatrixXd& a);
double largest_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The log determinant of a symmetric positive definite matrix.
double log_det(const Eigen::MatrixXd& s);

/// The eigenvalues of a symmetric matrix in ascending order.
Vector6 eigenvalues(const Matrix6& s);
WideVector6 wide_eigenvalues(const WideMatrix6& s);

/// The singular values in descending order.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);

/// Eigenvalues of a symmetric matrix in ascending order, and their eigenvectors of length 1, as columns.
struct Spectrum4 {
  Eigen::Vector4d values;
  Eigen::Matrix4d vectors;
};
Spectrum4 spectrum(const Eigen::Matrix4d& s);

/// The x that minimises |A x - b| for an A of full column rank, by QR with pivoting.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// The orthogonal Q of A = Q R P, all its columns: those of the range of A are the first.
Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a);

}  // namespace maxlogdet::test
