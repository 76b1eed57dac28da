// SPDX-License-Identifier: MIT
#include "tests/support/linear_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <limits>

namespace maxlogdet::test {

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b; }

Eigen::MatrixXd gram(const Eigen::MatrixXd& a) { return product(a.transpose(), a); }

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) { return a.inverse(); }

Eigen::MatrixXd cholesky(const Eigen::MatrixXd& s) {
  const Eigen::LLT<Eigen::MatrixXd> factor(s);
  if (factor.info() != Eigen::Success) {
    return Eigen::MatrixXd::Constant(s.rows(), s.cols(), std::numeric_limits<double>::quiet_NaN());
  }
  return factor.matrixL();
}

Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& l, const Eigen::MatrixXd& b) {
  return l.triangularView<Eigen::Lower>().solve(b);
}

double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / b.norm(); }

double largest_entry(const Eigen::MatrixXd& a) { return a.cwiseAbs().maxCoeff(); }

double largest_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

double log_det(const Eigen::MatrixXd& s) { return 2 * cholesky(s).diagonal().array().log().sum(); }

Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a) { return a.colPivHouseholderQr().householderQ(); }

Vector6 eigenvalues(const Matrix6& s) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(s, Eigen::EigenvaluesOnly).eigenvalues();
}

WideMatrix wide_product(const WideMatrix& a, const WideMatrix& b) { return a * b; }

WideMatrix wide_gram(const WideMatrix& a) { return wide_product(a.transpose(), a); }

WideMatrix wide_inverse(const WideMatrix& a) { return a.inverse(); }

WideVector6 wide_eigenvalues(const WideMatrix6& s) {
  return Eigen::SelfAdjointEigenSolver<WideMatrix6>(s, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& a) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(a).singularValues();
}

Spectrum4 spectrum(const Eigen::Matrix4d& s) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(s);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace maxlogdet::test
