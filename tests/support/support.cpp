// SPDX-License-Identifier: MIT
#include "tests/support/support.hpp"

#include "bench/world/data_folder.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/hash.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cstdlib>

namespace maxlogdet::test {
namespace {

std::string running_test() {
  const auto* const info = ::testing::UnitTest::GetInstance()->current_test_info();
  return info == nullptr ? "no test" : std::string(info->test_suite_name()) + "." + info->name();
}

}  // namespace

Random::Random(std::uint64_t variation) : Random(running_test(), variation) {}

Random::Random(const std::string& name, std::uint64_t variation)
    : seed_(sim::hash_of(name) + variation), random_(seed_) {}

double Random::uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(random_.bits() >> 11) * 0x1p-53);
}

int Random::integer(int low, int high) {
  return low + static_cast<int>(random_.below(static_cast<std::uint32_t>(high - low + 1)));
}

Block random_block(Random& random, int rows, double scale) {
  Block block(rows, state_dimension);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < state_dimension; ++j) block(i, j) = random.uniform(-scale, scale);
  }
  return block;
}

Matrix6 random_prior(Random& random) {
  const Matrix6 a = random_block(random, state_dimension);
  return a * a.transpose() + 0.1 * Matrix6::Identity();
}

Block stored_block(const BlockStore& blocks, std::size_t i) {
  Block block = Block::Zero(blocks.rows(), state_dimension);
  blocks.block(i, block.data());
  return block;
}

Block rounded(Block block) {
  for (double& entry : block.reshaped()) {
    const volatile auto stored = static_cast<float>(entry);
    entry = static_cast<double>(stored);
  }
  return block;
}

BlockStore awkward_blocks(Random& random, std::size_t n) {
  BlockStore blocks;
  std::vector<Block> made;
  for (std::size_t i = 0; i < n; ++i) {
    Block block = random_block(random, random.integer(1, 3));
    if (!made.empty()) {
      const Block& other = made[random.index(made.size())];
      const int kind = random.integer(0, 9);
      if (kind == 0) block = other;
      if (kind == 1) block = other * random.uniform(-2, 2);
      if (kind == 2) block.setZero();
      if (kind == 3) block = other + 1e-6 * random_block(random, static_cast<int>(other.rows()));
      if (kind == 4) block *= 1e3;
      if (kind == 5) block *= 1e-3;
    }
    push_back(blocks, block);
    made.push_back(block);
  }
  return blocks;
}

Options with_budget(std::size_t budget, Strategy strategy) {
  Options options;
  options.budget = budget;
  options.strategy = strategy;
  return options;
}

std::vector<std::uint32_t> indices_of(const Selection& selection) { return {selection.begin(), selection.end()}; }

std::vector<std::uint32_t> select_indices(const BlockStore& blocks, const Options& options) {
  Selector selector(std::max(blocks.size(), options.budget));
  return indices_of(selector.select(blocks, options));
}

std::vector<const simd::Kernel*> supported_kernels() {
  std::vector<const simd::Kernel*> kernels;
  for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
    if (simd::is_supported(**kernel)) kernels.push_back(*kernel);
  }
  return kernels;
}

std::size_t trials(std::size_t count) {
  const char* const given = std::getenv("MAXLOGDET_TEST_SHARE");
  const double share = given == nullptr ? 1 : std::strtod(given, nullptr);
  return std::max<std::size_t>(1, static_cast<std::size_t>(static_cast<double>(count) * std::clamp(share, 0.0, 1.0)));
}

std::string data_folder() { return sim::data_folder(MAXLOGDET_DEFAULT_DATA); }

std::vector<sim::Frame> real_frames() {
  std::vector<sim::Frame> frames = sim::read_frames(data_folder() + "/orb_slam2_frames");
  EXPECT_EQ(frames.size(), 50U);
  return frames;
}

BlockStore blocks_of(const sim::Frame& frame, const BlockKind& kind) {
  constexpr double covariance[9] = {0.0025, 0, 0, 0, 0.0025, 0, 0, 0, 0.0025};
  std::vector<FeatureMatch> matches;
  for (const sim::Match& match : frame.matches) {
    matches.push_back(sim::feature_match(match, kind.depth_cue));
    if (kind.has_covariances) matches.back().covariance = covariance;
  }
  BlockStore blocks;
  const RigidTransform T_cw = RigidTransform::row_major(frame.T_cw_prior.data());
  const Camera camera = PinholeCamera(frame.camera);
  const BlockReport report = append_blocks(&camera, 1, T_cw, matches.data(), matches.size(), BlockOptions(), blocks);
  EXPECT_EQ(report.error, Error::none) << frame.name << ' ' << kind.name;
  return blocks;
}

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
