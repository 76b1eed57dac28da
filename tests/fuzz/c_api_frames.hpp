// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>

namespace maxlogdet::fuzz {

/// Frames of a tracker, in C and C++, with any refused structs: what is refused in C becomes what C++ refuses, and all
/// answers are the same, but for the error that says so.
class Frames {
 public:
  /// Of handles of this capacity.
  Frames(Bytes& bytes, std::size_t capacity);
  ~Frames();
  Frames(const Frames&) = delete;
  Frames& operator=(const Frames&) = delete;

  /// One frame: matches, a selection or active matching, and what is said about every match.
  void run();

 private:
  void set_options();
  void start();
  void add_matches();
  void add(const maxlogdet_match& match);
  void select();
  void check_answer(const maxlogdet_selection* selection, bool is_understood) const;
  void check_judgement();
  void check_match(std::size_t i) const;

  Bytes& bytes_;
  maxlogdet_good_features* good_ = nullptr;
  GoodFeatures expected_;
  RigCamera rig_[2];  // of the last start
  std::size_t capacity_;
  bool is_start_understood_ = false;
};

}  // namespace maxlogdet::fuzz
