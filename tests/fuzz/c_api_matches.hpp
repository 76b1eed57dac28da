// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/c_api_given.hpp"

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::fuzz {

maxlogdet_camera any_camera(Bytes& bytes);
std::vector<double> any_pose(Bytes& bytes);
maxlogdet_block_options any_block_options(Bytes& bytes);

/// What they are in C++.
Camera in_cpp(const maxlogdet_camera& camera);
BlockOptions in_cpp(const maxlogdet_block_options& options);

/// Any camera, pose, matches and options, read from the bytes in this order, as maxlogdet_append_blocks takes them.
class AnyMatches {
 public:
  /// Without matches where the store is full.
  AnyMatches(Bytes& bytes, bool is_full);
  AnyMatches(const AnyMatches&) = delete;  // the matches point into it
  AnyMatches& operator=(const AnyMatches&) = delete;

  /// Whether the header calls the structs valid.
  bool is_understood() const;

  const maxlogdet_block_report* append_in_c(maxlogdet_block_store* store) const;
  BlockReport append_in_cpp(BlockStore& store) const;
  /// Compares the weight of each match, by the camera, with that of C++; blocks of the structs must be possible.
  void check_weights() const;

 private:
  static std::vector<double> numbers(Bytes& bytes, std::size_t size, double usual);
  static std::vector<std::uint8_t> flags(Bytes& bytes, std::size_t size);
  maxlogdet_matches any_matches(Bytes& bytes);

  maxlogdet_camera camera_;
  std::vector<double> T_cw_;
  std::size_t count_;
  std::vector<double> points_, sigmas_, weights_, covariances_, jacobians_;
  std::vector<std::uint8_t> has_depth_cue_, usable_, camera_ids_;
  maxlogdet_matches matches_;
  maxlogdet_block_options options_;
  Given<maxlogdet_camera> given_camera_;
  Given<maxlogdet_matches> given_matches_;
  Given<maxlogdet_block_options> given_options_;
  const double* pose_;
  bool is_rig_;  // of three, the same camera looking three ways; ids are 0 and 2
};

}  // namespace maxlogdet::fuzz
