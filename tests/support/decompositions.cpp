// SPDX-License-Identifier: MIT
#include "tests/support/decompositions.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace maxlogdet::test {

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
