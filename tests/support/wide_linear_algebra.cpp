// SPDX-License-Identifier: MIT
#include "tests/support/linear_algebra.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace maxlogdet::test {

WideMatrix wide_product(const WideMatrix& a, const WideMatrix& b) { return a * b; }

WideMatrix wide_gram(const WideMatrix& a) { return wide_product(a.transpose(), a); }

WideMatrix wide_inverse(const WideMatrix& a) { return a.inverse(); }

WideVector6 wide_eigenvalues(const WideMatrix6& s) {
  return Eigen::SelfAdjointEigenSolver<WideMatrix6>(s, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace maxlogdet::test
