// SPDX-License-Identifier: MIT
#pragma once

#include "tests/api/c_api.hpp"
#include "tests/fuzz/bytes.hpp"

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <string>

namespace maxlogdet::fuzz {

/// Frames of a tracker, in C and C++, with any refused structs: what is refused in C becomes what C++ refuses, and all
/// answers are the same, but for the error that says so.
class Frames {
 public:
  /// Of handles of this capacity.
  Frames(Bytes& bytes, std::size_t capacity);
  Frames(const Frames&) = delete;
  Frames& operator=(const Frames&) = delete;

  /// Writes the frames from now on, those of C and those of C++.
  void record(const std::string& in_c, const std::string& in_cpp);

  /// One frame: matches, a selection or active matching, and what is said about every match.
  void run();

  std::size_t selected() const { return expected_.selection().size; }

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
  test::CGoodFeatures owned_;
  maxlogdet_good_features* good_;
  GoodFeatures expected_;
  RigCamera rig_[2];  // of the last start
  std::size_t capacity_;
  bool is_start_understood_ = false;
};

}  // namespace maxlogdet::fuzz
