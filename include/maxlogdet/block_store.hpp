// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/status.hpp>

#include <cstddef>
#include <memory>

// From matches to blocks. World points p_w, pose T_cw = [R | t] (world to camera), p_c = R p_w + t = (X, Y, Z), camera
// frame x right, y down, z forward, m. Any other unit of length serves as well, if all lengths have it: points, poses,
// depths, bf, and the deviations of BlockOptions. The measurement z is (u, v), px, as the camera projects p_c
// (camera.hpp), and optionally one row more:
//
//   u_right = u - bf / Z + shift_of_right  (stereo, of a pinhole)   or   depth = Z  (m).
//
// The pose is perturbed on the left, T_cw <- exp(xi^) T_cw, xi = (translation, rotation) in m and rad, so that
//
//   H_x = d z / d xi  = J [ I | -[p_c]x ]      rows x 6,
//   H_p = d z / d p_w = J R                    rows x 3,     with J = d z / d p_c.
//
// The noise of z is Sigma = Sigma_z + H_p Sigma_p H_p^T: Sigma_z is that of the measurement, sigma^2 for u, v and
// u_right, and depth_sigma^2; Sigma_p, the covariance of the point, counts if any match of the frame has one. A block
// is C^-1 H_x with C C^T = Sigma, so that the sum of H^T H is the information of the pose, where points are held fixed.
//
// Of a camera with a pose T_cb on a body, the pose is that of the body, T_bw, p_b = T_bw p_w, p_c = T_cb p_b, and H_x =
// J R_cb [ I | -[p_b]x ].
//
// The rows of a block are those of the whitened measurements up to a rotation Q, which changes no information H^T H:
// H = A [ I | -[p_c]x ] with an upper triangular A. With a stereo row they are for example those of ((u + u_right) /
// sqrt(2), v, (u_right - u) / sqrt(2)).
//
// A prior for these blocks is an information of this xi, in this order and in the units of the blocks.

namespace maxlogdet {

struct BlockReport;
struct MatchedFrame;
namespace simd {
struct Kernel;
}

/// Dimension of the state: camera pose, xi = (translation, rotation).
constexpr int state_dimension = 6;
/// The maximum number of rows of a block: 3 for a stereo match; a monocular match has 2, a photometric residual 1.
constexpr int max_block_rows = 3;

/// Candidate blocks H_i (rows x 6) in float32, of append_blocks or of the caller's own Jacobians, as a structure of
/// arrays: a plane for each entry, so that one vector load reads this entry of several candidates. A candidate without
/// a block (an empty slot, a point behind the camera) has an index, zeros in the planes, and is never selected. Fill
/// the store once a frame; clear() keeps its memory. As in a Selector, the instruction set of append_blocks is picked
/// on construction. A store that was moved from is empty, with a capacity of 0, and may be filled again.
class BlockStore {
 public:
  /// Reserves room: see reserve().
  explicit BlockStore(std::size_t capacity = 0);
  /// Copies, with room for as many as there are. Throws std::bad_alloc.
  BlockStore(const BlockStore& other);
  /// Takes over candidates and memory.
  BlockStore(BlockStore&& other) noexcept;
  /// Copies, as the copy constructor, or takes over. Throws std::bad_alloc.
  BlockStore& operator=(BlockStore other) noexcept;
  ~BlockStore() = default;

  /// Makes room for `capacity` candidates, at most 2^32 - 1, and keeps those stored. Throws std::bad_alloc, also above
  /// that, and then has no effect.
  void reserve(std::size_t capacity);
  /// Removes all candidates; keeps the memory.
  void clear() noexcept;

  /// The number of candidates, with and without a block.
  std::size_t size() const noexcept { return size_; }
  /// The number of candidates that fit without allocating.
  std::size_t capacity() const noexcept { return capacity_; }

  /// Appends a block, rows x 6 row-major, rounded to float32; returns its index. One that is null, has not 1 to 3 rows,
  /// or does not fit into float32 (NaN, Inf, overflow) becomes an invalid candidate, so that indices stay those of the
  /// caller's matches. Allocates, and may throw std::bad_alloc, only when size() has reached capacity().
  std::size_t push_back(const double* block, int rows);
  /// Appends an invalid candidate, a match without a block; returns its index.
  std::size_t push_back_invalid() { return push_back(nullptr, 0); }

  /// The maximum number of rows of a block since clear(); 0 while no block is valid. Shorter blocks are padded with
  /// zero rows, which do not change any gain.
  int rows() const noexcept { return rows_; }
  /// Returns whether the candidate exists and has a block.
  bool is_valid(std::size_t index) const noexcept { return index < size_ && valid_[index] != 0; }
  /// Copies the candidate's block as stored, rows() x 6 row-major, to `entries`; returns rows(). Returns 0, and writes
  /// nothing, if the candidate is invalid.
  int block(std::size_t index, double* entries) const noexcept;

  /// The number of candidates with a block.
  std::size_t stored() const noexcept { return size_ - invalid_count_; }
  /// 1 per candidate with a block, else 0; size() of them.
  const unsigned char* validity() const noexcept { return valid_.get(); }
  /// Entry (row, column) of candidate i is planes()[(6 * row + column) * stride() + i], row < rows(); 64-byte aligned,
  /// and readable up to the next multiple of 16 candidates.
  const float* planes() const noexcept { return planes_; }
  /// The number of floats from one plane to the next.
  std::size_t stride() const noexcept { return stride_; }
  /// The largest |entry| of each column, 6 values.
  const double* column_max() const noexcept { return column_max_; }
  /// Whether all blocks are A [ I | -[p]x ] of three rows, with an upper triangular A, as append_blocks makes them:
  /// then planes 18 to 20 have p.
  bool is_factored() const noexcept;
  /// The same as column_max() of |A| [ I | |[p]x| ], with A and p in float32, or more.
  const double* factored_max() const noexcept { return factored_max_; }

 private:
  friend BlockReport append_blocks(const MatchedFrame& frame, BlockStore& blocks);

  void make_room(std::size_t more);
  void take(BlockStore& other) noexcept;
  void grow_to_rows(int rows) noexcept;

  std::unique_ptr<float[]> memory_;
  std::unique_ptr<unsigned char[]> valid_;
  float* planes_ = nullptr;  // in memory_, aligned
  std::size_t stride_ = 0;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  std::size_t invalid_count_ = 0;
  double column_max_[state_dimension] = {};
  double factored_max_[state_dimension] = {};
  const simd::Kernel* kernel_;
  int rows_ = 0;
};

/// How blocks are made of matches.
struct BlockOptions {
  double map_sigma = 0.05;    ///< m, standard deviation of a point without covariance, where other matches have one
  double depth_sigma = 0.05;  ///< m, standard deviation of a depth measurement
};

/// The result of append_blocks.
struct BlockReport {
  Error error = Error::none;            ///< none, or why nothing was appended
  std::size_t appended = 0;             ///< the number of matches, or 0 after an error
  std::size_t invalid = 0;              ///< of these, the invalid candidates: those counted below, and those with a
                                        ///< sigma that is not positive, or numbers beyond float32
  std::size_t unusable = 0;             ///< matches of a camera that is not there; of GoodFeatures all that are not
                                        ///< usable, and rejected ones but for those counted below
  std::size_t behind_camera = 0;        ///< Z <= 0, or where the camera's model has no image
  std::size_t invalid_covariances = 0;  ///< Sigma not positive definite, or Sigma_p so large along the ray that float64
                                        ///< keeps no digits across it (docs/numerics.md)
};

/// Appends one block for each of `size` matches, in their order; a match without one (BlockReport tells why) becomes an
/// invalid candidate. Allocates only when the capacity of the blocks does not suffice. `cameras`: 1 to 256 on one body;
/// FeatureMatch::camera_id says which of them has seen the match. T_bw: world to body; of one camera whose T_cb is I,
/// world to camera.
BlockReport append_blocks(const Camera* cameras, std::size_t count, const RigidTransform& T_bw,
                          const FeatureMatch* matches, std::size_t size, const BlockOptions& options,
                          BlockStore& blocks);

}  // namespace maxlogdet
