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

constexpr double prior_information = 1e-5;

// det(I + Y Y^T), given Y^T.
double determinant(const Eigen::Matrix<double, 6, 1>& y) { return 1 + y.squaredNorm(); }
double determinant(const Eigen::Matrix<double, 6, 2>& y) {
  const double off_diagonal = y.col(0).dot(y.col(1));
  return (1 + y.col(0).squaredNorm()) * (1 + y.col(1).squaredNorm()) - off_diagonal * off_diagonal;
}
double determinant(const Eigen::Matrix<double, 6, 3>& y) {
  return (Eigen::Matrix3d::Identity() + y.transpose() * y).determinant();
}

struct Entry {
  double gain;
  std::uint32_t index;
  std::uint32_t round;  // in which the gain was computed

  // The order of a heap: the greatest gain is on top, and among equal gains the lowest index.
  bool operator<(const Entry& other) const { return gain < other.gain || (gain == other.gain && index > other.index); }
};

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
    indices_.reserve(blocks_.size());
  }

  double log_det() const override {
    return 2 * information_.llt().matrixL().toDenseMatrix().diagonal().array().log().sum();
  }

 protected:
  std::size_t size() const { return blocks_.size(); }
  std::size_t at_most_all(std::size_t budget) const { return std::min(budget, size()); }

  void start() {
    information_ = prior_information * Matrix6::Identity();
    indices_.clear();
    evaluations_ = 0;
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
  Matrix6 information_ = prior_information * Matrix6::Identity();
  Matrix6 inverse_ = Matrix6::Identity();  // of its lower Cholesky factor
};

template <int rows>
class Exact : public FixedSizeSelector<rows> {
 public:
  void select(std::size_t budget, double, std::uint64_t) override {
    this->start();
    is_taken_.assign(this->size(), 0);
    const auto n = static_cast<std::uint32_t>(this->size());
    for (std::size_t round = 0; round < this->at_most_all(budget); ++round) {
      if (round > 0) this->factorise();
      std::uint32_t best = 0;
      double best_gain = -1;
      for (std::uint32_t i = 0; i < n; ++i) {
        if (is_taken_[i] != 0) continue;
        const double gain = this->gain(i);
        if (gain > best_gain) {
          best_gain = gain;
          best = i;
        }
      }
      this->evaluations_ += n - round;
      is_taken_[best] = 1;
      this->take(best);
    }
  }

 private:
  std::vector<unsigned char> is_taken_;
};

template <int rows>
class ExactBatched : public FixedSizeSelector<rows> {
 public:
  void load(const BlockStore& store) override {
    FixedSizeSelector<rows>::load(store);
    const auto n = static_cast<Eigen::Index>(this->size());
    for (int row = 0; row < rows; ++row) {
      stacked_[row].resize(n, 6);
      y_[row].resize(n, 6);
      for (Eigen::Index i = 0; i < n; ++i) {
        stacked_[row].row(i) = this->blocks_[static_cast<std::size_t>(i)].col(row).transpose();
      }
    }
    if (rows == 3) {
      for (Eigen::ArrayXd& entries : gram_) entries.resize(n);
    }
    gains_.resize(n);
    is_left_.resize(n);
  }

  void select(std::size_t budget, double, std::uint64_t) override {
    this->start();
    is_left_.setOnes();
    for (std::size_t round = 0; round < this->at_most_all(budget); ++round) {
      if (round > 0) this->factorise();
      const Matrix6 upper = this->inverse_.transpose();
      for (int row = 0; row < rows; ++row) y_[row] = stacked_[row].lazyProduct(upper);
      determinants();
      Eigen::Index best = 0;
      (gains_ * is_left_).maxCoeff(&best);
      this->evaluations_ += this->size() - round;
      is_left_[best] = 0;
      this->take(static_cast<std::uint32_t>(best));
    }
  }

 private:
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 6>;

  auto product(int a, int b) const { return y_[a].cwiseProduct(y_[b]).rowwise().sum().array(); }

  void determinants() {
    if constexpr (rows == 1) {
      gains_ = 1 + product(0, 0);
    } else if constexpr (rows == 2) {
      gains_ = (1 + product(0, 0)) * (1 + product(1, 1)) - product(0, 1).square();
    } else {
      auto& [a, b, c, d, e, f] = gram_;  // I + Y Y^T: the diagonal, then (0, 1), (0, 2), (1, 2)
      a = 1 + product(0, 0);
      b = 1 + product(1, 1);
      c = 1 + product(2, 2);
      d = product(0, 1);
      e = product(0, 2);
      f = product(1, 2);
      gains_ = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e);
    }
  }

  Columns stacked_[rows];
  Columns y_[rows];
  Eigen::ArrayXd gram_[6];  // 3 rows only
  Eigen::ArrayXd gains_;
  Eigen::ArrayXd is_left_;
};

template <int rows>
class Lazy : public FixedSizeSelector<rows> {
 public:
  void load(const BlockStore& store) override {
    FixedSizeSelector<rows>::load(store);
    heap_.resize(this->size());
  }

  void select(std::size_t budget, double, std::uint64_t) override {
    this->start();
    const auto n = static_cast<std::uint32_t>(this->size());
    for (std::uint32_t i = 0; i < n; ++i) heap_[i] = {this->gain(i), i, 0};
    this->evaluations_ = n;
    std::make_heap(heap_.begin(), heap_.end());
    auto end = heap_.end();
    for (std::uint32_t round = 0; round < this->at_most_all(budget); ++round) {
      if (round > 0) this->factorise();
      while (heap_.front().round != round) {
        Entry stale = heap_.front();
        stale = {this->gain(stale.index), stale.index, round};
        ++this->evaluations_;
        sift_down(stale, static_cast<std::size_t>(end - heap_.begin()));
      }
      this->take(heap_.front().index);
      std::pop_heap(heap_.begin(), end--);
    }
  }

 private:
  // Replaces the top by an entry that is not greater.
  void sift_down(const Entry& entry, std::size_t size) {
    std::size_t at = 0;
    for (std::size_t child = 1; child < size; child = 2 * at + 1) {
      if (child + 1 < size && heap_[child] < heap_[child + 1]) ++child;
      if (!(entry < heap_[child])) break;
      heap_[at] = heap_[child];
      at = child;
    }
    heap_[at] = entry;
  }

  std::vector<Entry> heap_;
};

template <int rows>
class LazyScan : public FixedSizeSelector<rows> {
 public:
  void load(const BlockStore& store) override {
    FixedSizeSelector<rows>::load(store);
    gains_.resize(this->size());
  }

  void select(std::size_t budget, double, std::uint64_t) override {
    this->start();
    const auto n = static_cast<std::uint32_t>(this->size());
    gains_.assign(n, std::numeric_limits<double>::infinity());
    for (std::size_t round = 0; round < this->at_most_all(budget); ++round) {
      if (round > 0) this->factorise();
      auto best = static_cast<std::uint32_t>(std::max_element(gains_.begin(), gains_.end()) - gains_.begin());
      gains_[best] = this->gain(best);
      ++this->evaluations_;
      for (std::uint32_t i = 0; i < n; ++i) {
        if (gains_[i] < gains_[best] || i == best) continue;
        gains_[i] = this->gain(i);
        ++this->evaluations_;
        if (gains_[i] > gains_[best] || (gains_[i] == gains_[best] && i < best)) best = i;
      }
      gains_[best] = -1;
      this->take(best);
    }
  }

 private:
  std::vector<double> gains_;  // as last evaluated
};

// The search that the two stochastic methods share; it maximises Self::value(i).
template <int rows, class Self>
class Sampling : public FixedSizeSelector<rows> {
 public:
  void select(std::size_t budget, double epsilon, std::uint64_t seed) override {
    this->start();
    std::mt19937_64 random(seed);
    std::size_t left = this->size();
    const std::size_t rounds = this->at_most_all(budget);
    const double s = std::ceil(static_cast<double>(left) / static_cast<double>(rounds) * std::log(1 / epsilon) - 1e-9);
    const auto wanted = static_cast<std::size_t>(std::max(1.0, s));
    for (std::size_t round = 0; round < rounds; ++round) {
      if (round > 0) static_cast<Self&>(*this).prepare_round();
      const std::size_t sampled = std::min(wanted, left);
      std::size_t best = 0;
      double best_value = -std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < sampled; ++j) {  // the first steps of a Fisher-Yates shuffle
        std::swap(this->pool_[j], this->pool_[j + (((random() >> 32) * (left - j)) >> 32)]);
        const double value = static_cast<Self&>(*this).value(this->pool_[j]);
        if (value > best_value) {
          best_value = value;
          best = j;
        }
      }
      this->evaluations_ += sampled;
      this->take(this->pool_[best]);
      this->pool_[best] = this->pool_[--left];
    }
  }
};

template <int rows>
class Stochastic : public Sampling<rows, Stochastic<rows>> {
 public:
  void prepare_round() { this->factorise(); }
  double value(std::uint32_t i) const { return this->gain(i); }
};

template <int rows>
class LogDet : public Sampling<rows, LogDet<rows>> {
 public:
  void prepare_round() {}
  double value(std::uint32_t i) const {
    const Matrix6 sum = this->information_ + this->blocks_[i] * this->blocks_[i].transpose();
    return 2 * sum.llt().matrixLLT().diagonal().array().log().sum();
  }
};

template <int rows>
std::unique_ptr<EigenSelector> make(EigenMethod method) {
  switch (method) {
    case EigenMethod::exact: return std::make_unique<Exact<rows>>();
    case EigenMethod::exact_batched: return std::make_unique<ExactBatched<rows>>();
    case EigenMethod::lazy: return std::make_unique<Lazy<rows>>();
    case EigenMethod::lazy_scan: return std::make_unique<LazyScan<rows>>();
    case EigenMethod::stochastic: return std::make_unique<Stochastic<rows>>();
    case EigenMethod::log_det: return std::make_unique<LogDet<rows>>();
  }
  return nullptr;
}

std::unique_ptr<EigenSelector> make(EigenMethod method, int rows) {
  switch (rows) {
    case 1: return make<1>(method);
    case 2: return make<2>(method);
    default: return make<3>(method);
  }
}

}  // namespace

const char* to_string(EigenMethod method) noexcept {
  switch (method) {
    case EigenMethod::exact: return "eigen_exact";
    case EigenMethod::exact_batched: return "eigen_exact_batched";
    case EigenMethod::lazy: return "eigen_lazy";
    case EigenMethod::lazy_scan: return "eigen_lazy_scan";
    case EigenMethod::stochastic: return "eigen_stochastic";
    case EigenMethod::log_det: return "eigen_log_det";
  }
  return "unknown";
}

std::unique_ptr<EigenSelector> make_eigen_selector(EigenMethod method, const BlockStore& blocks) {
  std::unique_ptr<EigenSelector> selector = make(method, blocks.rows());
  selector->load(blocks);
  return selector;
}

}  // namespace maxlogdet::bench
