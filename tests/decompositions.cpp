// SPDX-License-Identifier: MIT
#include "tests/linear_algebra.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace maxlogdet::test {

Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  Eigen::MatrixXd result(a.cols(), a.rows());
  for (Eigen::Index j = 0; j < a.rows(); ++j) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(a.rows(), j);
    result.col(j) = qr.solve(unit);
  }
  return result;
}

Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a) { return a.colPivHouseholderQr().householderQ(); }

Vector6 eigenvalues(const Matrix6& s) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(s, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace maxlogdet::test
