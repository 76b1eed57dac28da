// SPDX-License-Identifier: MIT
#include "bench/how_fast/eigen_baselines.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace maxlogdet::bench {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// det(I + Y Y^T), given Y^T.
double determinant(const Eigen::Matrix<double, 6, 2>& y) {
  const double off_diagonal = y.col(0).dot(y.col(1));
  return (1 + y.col(0).squaredNorm()) * (1 + y.col(1).squaredNorm()) - off_diagonal * off_diagonal;
}
double determinant(const Eigen::Matrix<double, 6, 3>& y) {
  return (Eigen::Matrix3d::Identity() + y.transpose() * y).determinant();
}

template <int rows>
class FixedSizeSelector : public EigenSelector {
 public:
  using Block = Eigen::Matrix<double, 6, rows>;  // H^T, so that Y^T = L^-1 H^T is a plain product

  void load(const BlockStore& store) override {
    blocks_.clear();
    store_indices_.clear();
    for (std::size_t i = 0; i < store.size(); ++i) {
      Block block;
      if (store.block(i, block.data()) == 0) continue;  // rows of H are columns of its transpose
      blocks_.push_back(block);
      store_indices_.push_back(static_cast<std::uint32_t>(i));
    }
    pool_.resize(blocks_.size());
    gains_.resize(blocks_.size());
    indices_.reserve(blocks_.size());
  }

  double log_det() const override {
    return 2 * information_.llt().matrixL().toDenseMatrix().diagonal().array().log().sum();
  }

  void lazy_greedy(std::size_t budget) override {
    start();
    const auto n = static_cast<std::uint32_t>(size());
    gains_.assign(n, std::numeric_limits<double>::infinity());
    for (std::size_t round = 0; round < at_most_all(budget); ++round) {
      if (round > 0) factorise();
      auto best = static_cast<std::uint32_t>(std::max_element(gains_.begin(), gains_.end()) - gains_.begin());
      gains_[best] = gain(best);
      for (std::uint32_t i = 0; i < n; ++i) {
        if (gains_[i] < gains_[best] || i == best) continue;
        gains_[i] = gain(i);
        if (gains_[i] > gains_[best] || (gains_[i] == gains_[best] && i < best)) best = i;
      }
      gains_[best] = -1;
      take(best);
    }
  }

  void stochastic_greedy(std::size_t budget, double epsilon, std::uint64_t seed) override {
    start();
    std::mt19937_64 random(seed);
    std::size_t left = size();
    const std::size_t rounds = at_most_all(budget);
    const double s = std::ceil(static_cast<double>(left) / static_cast<double>(rounds) * std::log(1 / epsilon) - 1e-9);
    const auto wanted = static_cast<std::size_t>(std::max(1.0, s));
    for (std::size_t round = 0; round < rounds; ++round) {
      if (round > 0) factorise();
      const std::size_t sampled = std::min(wanted, left);
      std::size_t best = 0;
      double best_gain = -std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < sampled; ++j) {  // the first steps of a Fisher-Yates shuffle
        std::swap(pool_[j], pool_[j + (((random() >> 32) * (left - j)) >> 32)]);
        const double value = gain(pool_[j]);
        if (value > best_gain) {
          best_gain = value;
          best = j;
        }
      }
      take(pool_[best]);
      pool_[best] = pool_[--left];
    }
  }

 private:
  std::size_t size() const { return blocks_.size(); }
  std::size_t at_most_all(std::size_t budget) const { return std::min(budget, size()); }

  void start() {
    information_ = Matrix6(common_prior());
    indices_.clear();
    for (std::size_t i = 0; i < pool_.size(); ++i) pool_[i] = static_cast<std::uint32_t>(i);
    factorise();
  }

  void factorise() {
    inverse_.setIdentity();
    const Eigen::LLT<Matrix6> cholesky(information_);
    // Column by column: Eigen unrolls the solve for a vector, but not for a small matrix.
    for (int j = 0; j < 6; ++j) {
      auto column = inverse_.col(j);
      cholesky.matrixL().solveInPlace(column);
    }
  }

  double gain(std::uint32_t i) const { return determinant(Block(inverse_ * blocks_[i])); }

  void take(std::uint32_t i) {
    indices_.push_back(store_indices_[i]);
    information_.noalias() += blocks_[i] * blocks_[i].transpose();
  }

  std::vector<Block> blocks_;
  std::vector<std::uint32_t> store_indices_;  // of the blocks
  std::vector<std::uint32_t> pool_;           // its first entries are the remaining candidates
  std::vector<double> gains_;                 // as last evaluated
  Matrix6 information_ = Matrix6(common_prior());
  Matrix6 inverse_ = Matrix6::Identity();  // of its lower Cholesky factor
};

}  // namespace

std::unique_ptr<EigenSelector> make_eigen_selector(const BlockStore& blocks) {
  std::unique_ptr<EigenSelector> selector;
  if (blocks.rows() == 2) selector = std::make_unique<FixedSizeSelector<2>>();
  if (blocks.rows() == 3) selector = std::make_unique<FixedSizeSelector<3>>();
  selector->load(blocks);
  return selector;
}

}  // namespace maxlogdet::bench
