// SPDX-License-Identifier: MIT
#pragma once

#include "python/cameras.hpp"
#include "python/selection.hpp"
#include "python/store.hpp"

#include <maxlogdet/good_features.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet::python {

/// A GoodFeatures with what it refers to. Only arguments of wrong types or shapes throw: what is wrong with a pose, a
/// camera or an option is told by the selection. While it selects or matches, every member throws RuntimeError.
class OwnGoodFeatures {
 public:
  OwnGoodFeatures(std::size_t capacity, int threads);

  std::size_t capacity() const noexcept { return capacity_; }
  /// The object itself, unless it is selecting or matching.
  GoodFeatures& idle();

  void start(const py::object& camera, const py::object& T_cw);
  void add(const py::object& points, const py::object& measured, const py::object& sigmas, const py::kwargs& keywords);
  Answer select(const py::object& budget, const py::kwargs& keywords);
  Answer match(const py::object& try_to_match, const py::object& budget, const py::kwargs& keywords);

  py::array_t<py::ssize_t> outliers(const py::object& T_cw);
  py::array_t<double> chi2();
  /// (n, r, r); r = 3 if some match has a depth cue, else 2.
  py::array_t<double> weights(bool is_whitening);
  std::shared_ptr<Store> blocks();
  bool record(const py::object& folder);

 private:
  GoodFeatures good_;
  OwnCameras cameras_;  // of the frame: a rig is not copied by good_
  std::size_t capacity_;
  int threads_;
  bool is_busy_ = false;
};

/// maxlogdet::select for arrays.
Answer select_once(const py::object& camera, const py::object& T_cw, const py::object& points,
                   const py::object& measured, const py::object& sigmas, const py::object& budget,
                   const py::kwargs& keywords);

}  // namespace maxlogdet::python
