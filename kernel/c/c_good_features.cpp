// SPDX-License-Identifier: MIT
// The front door in C.
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/good_features.hpp>

#include "kernel/base/limits.hpp"
#include "kernel/c/c_handles.hpp"
#include "kernel/c/c_structs.hpp"

#include <vector>

using maxlogdet::RigidTransform;
using namespace maxlogdet::c_api;

struct maxlogdet_good_features {
  maxlogdet_good_features(size_t capacity_, const maxlogdet_executor& callbacks)
      : executor(callbacks), features(capacity_, executor.get()), capacity(capacity_) {
    keep_answer(MAXLOGDET_ERROR_NONE);
  }

  // Refused arguments become some that C++ refuses.
  template <class Cameras>
  maxlogdet_error start(const Cameras& given, const double* T, maxlogdet_error error) noexcept {
    of_start = T == nullptr ? refused : error;
    features.start(of_start == MAXLOGDET_ERROR_NONE ? given : Cameras(), RigidTransform::row_major(T));
    keep_answer(MAXLOGDET_ERROR_NONE);
    return of_start;
  }

  // What C++ has answered, with the errors that only C has.
  const maxlogdet_selection* keep_answer(maxlogdet_error of_call) noexcept {
    report = to_c(features.block_report());
    selection = to_c(features.selection());
    const maxlogdet_error error = of_start != MAXLOGDET_ERROR_NONE ? of_start : of_call;
    if (error != MAXLOGDET_ERROR_NONE) {
      selection.status = MAXLOGDET_STATUS_ERROR;
      selection.error = error;
    }
    return &selection;
  }

  CallbackExecutor executor;
  maxlogdet::GoodFeatures features;
  size_t capacity;
  std::vector<maxlogdet::RigCamera> cameras;  // of the last rig started on
  maxlogdet_error of_start = MAXLOGDET_ERROR_NONE;
  maxlogdet_selection selection{};
  maxlogdet_block_report report{};
};

namespace {

// Refused options become some that C++ refuses.
maxlogdet_error read_or_spoil(const maxlogdet_options* given, maxlogdet::Options& options) noexcept {
  if (read(given, options)) return MAXLOGDET_ERROR_NONE;
  options.strategy = static_cast<maxlogdet::Strategy>(-1);
  return refused;
}

}  // namespace

maxlogdet_error maxlogdet_good_features_create(size_t capacity, const maxlogdet_executor* executor,
                                               maxlogdet_good_features** good) {
  return create(capacity, executor, good);
}

void maxlogdet_good_features_destroy(maxlogdet_good_features* good) { delete good; }

maxlogdet_error maxlogdet_good_features_set_block_options(maxlogdet_good_features* good,
                                                          const maxlogdet_block_options* options) {
  return good != nullptr && read(options, good->features.block_options) ? MAXLOGDET_ERROR_NONE : refused;
}

maxlogdet_error maxlogdet_good_features_set_spread(maxlogdet_good_features* good, double spread) {
  return change(good, [=](maxlogdet_good_features& of) { of.features.spread = spread; });
}

maxlogdet_error maxlogdet_good_features_set_weighted(maxlogdet_good_features* good, int32_t is_weighted) {
  return change(good, [=](maxlogdet_good_features& of) { of.features.is_weighted = is_weighted != 0; });
}

maxlogdet_error maxlogdet_good_features_start(maxlogdet_good_features* good, const maxlogdet_camera* camera,
                                              const double* T_cw) {
  if (good == nullptr) return refused;
  maxlogdet::Camera cpp_camera;
  const maxlogdet_error error = read(camera, cpp_camera) ? MAXLOGDET_ERROR_NONE : refused;
  return good->start(cpp_camera, T_cw, error);
}

maxlogdet_error maxlogdet_good_features_start_rig(maxlogdet_good_features* good, const maxlogdet_camera* const* cameras,
                                                  const double* T_cb, size_t camera_count, const double* T_bw) {
  if (good == nullptr) return refused;
  maxlogdet::Rig rig;
  const maxlogdet_error error = read(cameras, T_cb, camera_count, good->cameras, rig);
  return good->start(rig, T_bw, error);
}

maxlogdet_error maxlogdet_good_features_add(maxlogdet_good_features* good, const maxlogdet_match* match) {
  if (good == nullptr) return refused;
  maxlogdet::FeatureMatch cpp_match;
  const bool is_read = read(match, cpp_match);
  if (!is_read) cpp_match.sigma = maxlogdet::not_a_number;  // takes its number, but is not usable
  good->features.add(cpp_match);
  if (!is_read) return refused;
  return good->features.size() > good->capacity ? MAXLOGDET_ERROR_CAPACITY_EXCEEDED : MAXLOGDET_ERROR_NONE;
}

size_t maxlogdet_good_features_size(const maxlogdet_good_features* good) {
  return good == nullptr ? 0 : good->features.size();
}

uint32_t maxlogdet_good_features_id(const maxlogdet_good_features* good, size_t i) {
  return good == nullptr ? MAXLOGDET_NONE : good->features.id(i);
}

const maxlogdet_selection* maxlogdet_good_features_select(maxlogdet_good_features* good,
                                                          const maxlogdet_options* options) {
  if (good == nullptr) return &refused_selection;
  maxlogdet::Options cpp_options;
  const maxlogdet_error error = read_or_spoil(options, cpp_options);
  good->features.select(cpp_options);
  return good->keep_answer(error);
}

const maxlogdet_selection* maxlogdet_good_features_match(maxlogdet_good_features* good,
                                                         const maxlogdet_options* options,
                                                         maxlogdet_match_function try_to_match, void* context) {
  if (good == nullptr || try_to_match == nullptr) return &refused_selection;
  maxlogdet::Options cpp_options;
  const maxlogdet_error error = read_or_spoil(options, cpp_options);
  const maxlogdet_error of_memory = with_memory([&] {
    good->features.match(cpp_options, [=](std::size_t i, maxlogdet::FeatureMatch& match) {
      maxlogdet_match measured = to_c(match);
      return try_to_match(context, i, &measured) != 0 && read(&measured, match);
    });
  });
  return good->keep_answer(of_memory != MAXLOGDET_ERROR_NONE ? of_memory : error);
}

const maxlogdet_selection* maxlogdet_good_features_selection(const maxlogdet_good_features* good) {
  return good == nullptr ? &refused_selection : &good->selection;
}

const char* maxlogdet_good_features_reason(const maxlogdet_good_features* good) {
  const bool has_error = good == nullptr || good->selection.status == MAXLOGDET_STATUS_ERROR;
  return has_error ? maxlogdet_selection_reason(maxlogdet_good_features_selection(good)) : good->features.reason();
}

int32_t maxlogdet_good_features_is_selected(const maxlogdet_good_features* good, size_t i) {
  return good != nullptr && good->features.is_selected(i) ? 1 : 0;
}

const maxlogdet_block_report* maxlogdet_good_features_block_report(const maxlogdet_good_features* good) {
  return good == nullptr ? &refused_report : &good->report;
}

double maxlogdet_good_features_efficiency(maxlogdet_good_features* good) {
  return good == nullptr ? maxlogdet::not_a_number : efficiency(good->features);
}

size_t maxlogdet_good_features_outliers(maxlogdet_good_features* good, const double* T_cw, const uint32_t** indices) {
  if (indices == nullptr) return 0;
  *indices = nullptr;
  if (good == nullptr || T_cw == nullptr) return 0;
  const maxlogdet::IndexRange outliers = good->features.outliers(RigidTransform::row_major(T_cw));
  *indices = outliers.indices;
  return outliers.count;
}

int32_t maxlogdet_good_features_is_outlier(const maxlogdet_good_features* good, size_t i) {
  return good != nullptr && good->features.is_outlier(i) ? 1 : 0;
}

double maxlogdet_good_features_chi2(const maxlogdet_good_features* good, size_t i) {
  return good == nullptr ? maxlogdet::not_a_number : good->features.chi2(i);
}

int32_t maxlogdet_good_features_information(const maxlogdet_good_features* good, size_t i, double* omega) {
  return good != nullptr && omega != nullptr && match_information(good->features, i, omega) ? 1 : 0;
}

int32_t maxlogdet_good_features_whitening(const maxlogdet_good_features* good, size_t i, double* W) {
  return good != nullptr && W != nullptr && match_whitening(good->features, i, W) ? 1 : 0;
}

int32_t maxlogdet_good_features_record(maxlogdet_good_features* good, const char* folder) {
  return good != nullptr && good->features.record(folder) ? 1 : 0;
}
