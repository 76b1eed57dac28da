// SPDX-License-Identifier: MIT
#pragma once

#include "tests/bench/random_similarity.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"

namespace maxlogdet::test {

struct HornAlignment {
  sim::Similarity similarity;
  double separation = 0;  // relative, of the two largest eigenvalues
};

// Horn, Closed-form solution of absolute orientation using unit quaternions, 1987.
inline HornAlignment horn(const Matrix3Xd& from, const Matrix3Xd& to) {
  const Vector3d from_mean = from.rowwise().mean();
  const Vector3d to_mean = to.rowwise().mean();
  const Matrix3Xd p = from.colwise() - from_mean;
  const Matrix3Xd q = to.colwise() - to_mean;
  const Eigen::Matrix3d M = product(p, q.transpose());
  Eigen::Matrix4d N;
  N << M.trace(), M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0),                    //
      M(1, 2) - M(2, 1), M(0, 0) - M(1, 1) - M(2, 2), M(0, 1) + M(1, 0), M(2, 0) + M(0, 2),   //
      M(2, 0) - M(0, 2), M(0, 1) + M(1, 0), -M(0, 0) + M(1, 1) - M(2, 2), M(1, 2) + M(2, 1),  //
      M(0, 1) - M(1, 0), M(2, 0) + M(0, 2), M(1, 2) + M(2, 1), -M(0, 0) - M(1, 1) + M(2, 2);
  const Spectrum4 of_N = spectrum(N);
  const Eigen::Vector4d w = of_N.vectors.col(3);
  HornAlignment result;
  sim::Similarity& s = result.similarity;
  s.R = Eigen::Quaterniond(w[0], w[1], w[2], w[3]).normalized().toRotationMatrix();
  s.scale = q.cwiseProduct(transformed(s, p)).sum() / p.squaredNorm();
  const Vector3d centre = transformed(s, from_mean);
  s.t = to_mean - centre;
  result.separation = (of_N.values[3] - of_N.values[2]) / of_N.values[3];
  return result;
}

}  // namespace maxlogdet::test
