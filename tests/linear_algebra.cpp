// SPDX-License-Identifier: MIT
#include "tests/linear_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace maxlogdet::test {
namespace {

template <class Scalar>
using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

template <class Scalar>
Dense<Scalar> product_of(const Dense<Scalar>& a, const Dense<Scalar>& b) {
  Dense<Scalar> result = Dense<Scalar>::Zero(a.rows(), b.cols());
  for (Eigen::Index j = 0; j < b.cols(); ++j) {
    for (Eigen::Index k = 0; k < a.cols(); ++k) {
      for (Eigen::Index i = 0; i < a.rows(); ++i) result(i, j) += a(i, k) * b(k, j);
    }
  }
  return result;
}

template <class Scalar>
Dense<Scalar> inverse_of(Dense<Scalar> a) {
  const Eigen::Index n = a.rows();
  Dense<Scalar> result = Dense<Scalar>::Identity(n, n);
  for (Eigen::Index column = 0; column < n; ++column) {
    Eigen::Index pivot = column;
    for (Eigen::Index i = column + 1; i < n; ++i) {
      if (std::abs(a(i, column)) > std::abs(a(pivot, column))) pivot = i;
    }
    const Scalar scale = 1 / a(pivot, column);
    for (Eigen::Index j = 0; j < n; ++j) {
      std::swap(a(pivot, j), a(column, j));
      std::swap(result(pivot, j), result(column, j));
      a(column, j) *= scale;
      result(column, j) *= scale;
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i == column) continue;
      const Scalar factor = a(i, column);
      for (Eigen::Index j = 0; j < n; ++j) {
        a(i, j) -= factor * a(column, j);
        result(i, j) -= factor * result(column, j);
      }
    }
  }
  return result;
}

// Jacobi's rotations, until all of s that is off the diagonal is rounding; the columns of vectors turn along.
template <class Square>
void diagonalize(Square& s, Square& vectors) {
  using Scalar = typename Square::Scalar;
  const Scalar enough = std::numeric_limits<Scalar>::epsilon() * s.norm() / 100;
  bool is_diagonal = false;
  for (int sweep = 0; sweep < 50 && !is_diagonal; ++sweep) {
    is_diagonal = true;
    for (Eigen::Index p = 0; p < s.rows(); ++p) {
      for (Eigen::Index q = p + 1; q < s.rows(); ++q) {
        if (std::abs(s(p, q)) <= enough) continue;
        is_diagonal = false;
        const Scalar cotangent = (s(q, q) - s(p, p)) / (2 * s(p, q));  // of twice the angle
        const Scalar t = (cotangent < 0 ? -1 : 1) / (std::abs(cotangent) + std::sqrt(cotangent * cotangent + 1));
        const Scalar c = 1 / std::sqrt(t * t + 1);
        for (Eigen::Index k = 0; k < s.rows(); ++k) {
          const Scalar of_p = s(k, p);
          s(k, p) = c * (of_p - t * s(k, q));
          s(k, q) = c * (s(k, q) + t * of_p);
        }
        for (Eigen::Index k = 0; k < s.rows(); ++k) {
          const Scalar of_p = s(p, k);
          s(p, k) = c * (of_p - t * s(q, k));
          s(q, k) = c * (s(q, k) + t * of_p);
        }
        s(p, q) = s(q, p) = 0;  // rounding apart, and rounding would keep it from ending
        for (Eigen::Index k = 0; k < s.rows(); ++k) {
          const Scalar of_p = vectors(k, p);
          vectors(k, p) = c * (of_p - t * vectors(k, q));
          vectors(k, q) = c * (vectors(k, q) + t * of_p);
        }
      }
    }
  }
}

template <class Square>
auto eigenvalues_of(Square s) {
  Square vectors = Square::Identity();
  diagonalize(s, vectors);
  Eigen::Matrix<typename Square::Scalar, Square::RowsAtCompileTime, 1> values;
  for (Eigen::Index i = 0; i < s.rows(); ++i) values(i) = s(i, i);
  std::sort(values.data(), values.data() + values.size());
  return values;
}

}  // namespace

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return product_of<double>(a, b); }

WideMatrix wide_product(const WideMatrix& a, const WideMatrix& b) { return product_of<long double>(a, b); }

Eigen::MatrixXd gram(const Eigen::MatrixXd& a) { return product_of<double>(a.transpose(), a); }

WideMatrix wide_gram(const WideMatrix& a) { return product_of<long double>(a.transpose(), a); }

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) { return inverse_of<double>(a); }

WideMatrix wide_inverse(const WideMatrix& a) { return inverse_of<long double>(a); }

Eigen::MatrixXd cholesky(const Eigen::MatrixXd& s) {
  Eigen::MatrixXd l = Eigen::MatrixXd::Zero(s.rows(), s.rows());
  for (Eigen::Index i = 0; i < s.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      double rest = s(i, j);
      for (Eigen::Index k = 0; k < j; ++k) rest -= l(i, k) * l(j, k);
      l(i, j) = i == j ? std::sqrt(rest) : rest / l(j, j);
    }
  }
  return l;
}

Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& l, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd x = b;
  for (Eigen::Index j = 0; j < b.cols(); ++j) {
    for (Eigen::Index i = 0; i < l.rows(); ++i) {
      for (Eigen::Index k = 0; k < i; ++k) x(i, j) -= l(i, k) * x(k, j);
      x(i, j) /= l(i, i);
    }
  }
  return x;
}

double log_det(const Eigen::MatrixXd& s) {
  const Eigen::MatrixXd l = cholesky(s);
  double sum = 0;
  for (Eigen::Index i = 0; i < l.rows(); ++i) sum += 2 * std::log(l(i, i));
  return sum;
}

double squared_deviation(const Eigen::VectorXd& x, const Eigen::MatrixXd& s) {
  return solve_lower(cholesky(s), x).squaredNorm();
}

double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / b.norm(); }

double largest_entry(const Eigen::MatrixXd& a) { return a.cwiseAbs().maxCoeff(); }

double largest_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Rotations of pairs of columns, until all are orthogonal: then their lengths are the singular values (Hestenes).
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd columns = a;
  if (a.rows() < a.cols()) columns = a.transpose();
  const Eigen::Index n = columns.cols();
  bool is_orthogonal = false;
  for (int sweep = 0; sweep < 50 && !is_orthogonal; ++sweep) {
    is_orthogonal = true;
    for (Eigen::Index p = 0; p < n; ++p) {
      for (Eigen::Index q = p + 1; q < n; ++q) {
        double pp = 0, pq = 0, qq = 0;
        for (Eigen::Index k = 0; k < columns.rows(); ++k) {
          pp += columns(k, p) * columns(k, p);
          pq += columns(k, p) * columns(k, q);
          qq += columns(k, q) * columns(k, q);
        }
        if (std::abs(pq) <= 1e-14 * std::sqrt(pp * qq)) continue;
        is_orthogonal = false;
        const double cotangent = (qq - pp) / (2 * pq);  // of twice the angle
        const double t = (cotangent < 0 ? -1 : 1) / (std::abs(cotangent) + std::sqrt(cotangent * cotangent + 1));
        const double c = 1 / std::sqrt(t * t + 1);
        for (Eigen::Index k = 0; k < columns.rows(); ++k) {
          const double of_p = columns(k, p);
          columns(k, p) = c * (of_p - t * columns(k, q));
          columns(k, q) = c * (columns(k, q) + t * of_p);
        }
      }
    }
  }
  Eigen::VectorXd values(n);
  for (Eigen::Index i = 0; i < n; ++i) values(i) = columns.col(i).norm();
  std::sort(values.data(), values.data() + n, std::greater<>());
  return values;
}

Spectrum4 spectrum(const Eigen::Matrix4d& s) {
  Eigen::Matrix4d diagonal = s;
  Eigen::Matrix4d vectors = Eigen::Matrix4d::Identity();
  diagonalize(diagonal, vectors);
  int order[4] = {0, 1, 2, 3};
  std::sort(order, order + 4, [&](int i, int j) { return diagonal(i, i) < diagonal(j, j); });
  Spectrum4 result;
  for (int i = 0; i < 4; ++i) {
    result.values(i) = diagonal(order[i], order[i]);
    result.vectors.col(i) = vectors.col(order[i]);
  }
  return result;
}

WideVector6 wide_eigenvalues(const WideMatrix6& s) { return eigenvalues_of(s); }

}  // namespace maxlogdet::test
