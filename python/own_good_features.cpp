// SPDX-License-Identifier: MIT
#include "python/own_good_features.hpp"

#include "python/arrays.hpp"
#include "python/executor.hpp"
#include "python/feature_matches.hpp"
#include "python/match_weights.hpp"
#include "python/select_options.hpp"
#include "python/turn.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::python {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr const char* busy =
    "this GoodFeatures is selecting or matching: a thread, or a function that match() calls, "
    "needs one of its own";

}  // namespace

OwnGoodFeatures::OwnGoodFeatures(std::size_t capacity, int threads)
    : good_(capacity, executor()), cameras_{}, capacity_(capacity), threads_(threads) {}

GoodFeatures& OwnGoodFeatures::idle() {
  const Turn turn(is_busy_, busy);
  return good_;
}

void OwnGoodFeatures::start(const py::object& camera, const py::object& T_cw) {
  OwnCameras cameras = cameras_of(camera, WrongPose::passes);
  const RigidTransform pose = pose_of(T_cw, "T_cw", WrongPose::passes);
  GoodFeatures& good = idle();
  cameras_ = std::move(cameras);
  good.start(cameras_.view(), pose);
}

void OwnGoodFeatures::add(const py::object& points, const py::object& measured, const py::object& sigmas,
                          const py::kwargs& keywords) {
  FeatureMatches matches(points, measured, sigmas);
  for (const auto& [key, item] : keywords) {
    const auto name = key.cast<std::string>();
    const auto value = py::reinterpret_borrow<py::object>(item);
    if (!matches.take(name, value) && !matches.take_of_frame(name, value)) throw_unexpected(name);
  }
  matches.add_to(idle());
}

Answer OwnGoodFeatures::select(const py::object& budget, const py::kwargs& keywords) {
  const Turn turn(is_busy_, busy);  // before converting arguments, which may run Python code
  SelectOptions asked(SelectionKind::whole, good_.size(), budget, keywords);
  if (!asked.has_threads) asked.options.threads = threads_;
  good_.block_options.threads = std::max(asked.options.threads, 0);
  {
    const py::gil_scoped_release others_may_run;
    good_.select(asked.options);
  }
  return copy_of(good_.selection());
}

Answer OwnGoodFeatures::match(const py::object& try_to_match, const py::object& budget, const py::kwargs& keywords) {
  if (PyCallable_Check(try_to_match.ptr()) == 0) throw py::type_error("try_to_match: expected a function");
  const Turn turn(is_busy_, busy);
  const SelectOptions asked(SelectionKind::active, good_.size(), budget, keywords);
  good_.block_options.threads = std::max(threads_, 0);
  return copy_of(
      good_.match(asked.options, [&](std::size_t i, FeatureMatch& match) { return fill_in(try_to_match(i), match); }));
}

py::array_t<py::ssize_t> OwnGoodFeatures::outliers(const py::object& T_cw) {
  const RigidTransform pose = pose_of(T_cw, "T_cw", WrongPose::passes);
  const IndexRange found = idle().outliers(pose);
  py::array_t<py::ssize_t> numbers(static_cast<py::ssize_t>(found.size()));
  std::copy(found.begin(), found.end(), numbers.mutable_data());
  return numbers;
}

py::array_t<double> OwnGoodFeatures::chi2() {
  const GoodFeatures& good = idle();
  py::array_t<double> all(static_cast<py::ssize_t>(good.size()));
  for (std::size_t i = 0; i < good.size(); ++i) all.mutable_data()[i] = good.chi2(i);
  return all;
}

py::array_t<double> OwnGoodFeatures::weights(bool is_whitening) {
  const GoodFeatures& good = idle();
  constexpr std::size_t entries = 9;
  std::vector<double> all(entries * good.size(), not_a_number);
  std::size_t r = 2;
  for (std::size_t i = 0; i < good.size(); ++i) {
    double* const weight = &all[entries * i];
    is_whitening ? match_whitening(good, i, weight) : match_information(good, i, weight);
    if (!std::isnan(weight[entries - 1])) r = 3;
  }
  const auto side = static_cast<py::ssize_t>(r);
  py::array_t<double> weights({static_cast<py::ssize_t>(good.size()), side, side});
  for (std::size_t i = 0; i < good.size(); ++i) {
    const double* const weight = &all[entries * i];
    put_weight(weight, std::isnan(weight[entries - 1]) ? 2 : 3, r, weights.mutable_data() + r * r * i);
  }
  return weights;
}

std::shared_ptr<Store> OwnGoodFeatures::blocks() {
  auto store = std::make_shared<Store>(0);
  store->changeable() = idle().blocks();
  return store;
}

bool OwnGoodFeatures::record(const py::object& folder) {
  const auto path = py::module_::import("os").attr("fsencode")(folder).cast<std::string>();
  return idle().record(path.c_str());
}

Answer select_once(const py::object& camera, const py::object& T_cw, const py::object& points,
                   const py::object& measured, const py::object& sigmas, const py::object& budget,
                   const py::kwargs& keywords) {
  FeatureMatches matches(points, measured, sigmas);
  BlockOptions block_options;
  py::kwargs options;
  for (const auto& [key, item] : keywords) {
    const auto name = key.cast<std::string>();
    const auto value = py::reinterpret_borrow<py::object>(item);
    if (!matches.take(name, value) && !take(block_options, name, value)) options[key] = item;
  }
  OwnGoodFeatures good(matches.size(), 0);
  good.idle().block_options = block_options;
  good.start(camera, T_cw);
  matches.add_to(good.idle());
  return good.select(budget, options);
}

}  // namespace maxlogdet::python
