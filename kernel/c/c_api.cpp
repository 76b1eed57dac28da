// SPDX-License-Identifier: MIT
// Block stores, selectors and active selections of the C API: each owns an object of C++ and the structs that it
// returns.
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include "kernel/base/limits.hpp"
#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/camera_checks.hpp"
#include "kernel/c/c_handles.hpp"
#include "kernel/c/c_structs.hpp"

#include <cstring>
#include <vector>

using maxlogdet::not_a_number;
using maxlogdet::c_api::CallbackExecutor;
using maxlogdet::c_api::read;
using maxlogdet::c_api::refused_report;
using maxlogdet::c_api::refused_selection;
using maxlogdet::c_api::to_c;
using maxlogdet::c_api::with_memory;

namespace maxlogdet {
namespace c_api {

const maxlogdet_selection refused_selection = {MAXLOGDET_STATUS_ERROR,
                                               MAXLOGDET_ERROR_INVALID_ARGUMENT,
                                               nullptr,
                                               0,
                                               0,
                                               nullptr,
                                               not_a_number,
                                               0,
                                               0,
                                               0,
                                               not_a_number,
                                               MAXLOGDET_STRATEGY_LAZY_GREEDY,
                                               1,
                                               not_a_number,
                                               not_a_number,
                                               not_a_number};
const maxlogdet_block_report refused_report = {MAXLOGDET_ERROR_INVALID_ARGUMENT, 0, 0, 0, 0, 0, 0, 0, 0};

}  // namespace c_api
}  // namespace maxlogdet

struct maxlogdet_block_store {
  explicit maxlogdet_block_store(size_t capacity) : blocks(capacity) {}

  maxlogdet::BlockStore blocks;
  std::vector<maxlogdet::RigCamera> cameras;  // of the last rig appended for
  maxlogdet_block_report report{};
};

struct maxlogdet_selector {
  maxlogdet_selector(size_t capacity, const maxlogdet_executor& callbacks)
      : executor(callbacks), selector(capacity, executor.get()) {}
  // Not copyable: the selector points to the executor.
  maxlogdet_selector(const maxlogdet_selector&) = delete;
  maxlogdet_selector& operator=(const maxlogdet_selector&) = delete;

  CallbackExecutor executor;
  maxlogdet::Selector selector;
  maxlogdet_selection selection{};
};

struct maxlogdet_active_selection {
  explicit maxlogdet_active_selection(size_t capacity) : active(capacity) {}

  maxlogdet::ActiveSelection active;
  bool is_refused = false;  // by the last start; the selection before it has ended, its candidates may be gone
  maxlogdet_selection selection{};
};

namespace {

using maxlogdet::ActiveSelection;

constexpr maxlogdet_block_report no_memory_report = {MAXLOGDET_ERROR_OUT_OF_MEMORY, 0, 0, 0, 0, 0, 0, 0, 0};

template <class Answer>
maxlogdet_error answered(maxlogdet_active_selection* active, const Answer& answer) {
  if (active == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  if (active->is_refused) return MAXLOGDET_ERROR_NOTHING_PROPOSED;
  return static_cast<maxlogdet_error>(answer(active->active));
}

// For a camera or a rig.
template <class Cameras>
const maxlogdet_block_report* append_to(maxlogdet_block_store* blocks, const Cameras& cameras, const double* T,
                                        const maxlogdet_matches* matches, const maxlogdet_block_options* options,
                                        const maxlogdet_executor* executor) noexcept {
  maxlogdet::Matches cpp_matches;
  maxlogdet::BlockOptions cpp_options;
  maxlogdet_executor callbacks{};
  if (blocks == nullptr || !read(matches, cpp_matches) || !read(options, cpp_options) ||
      (executor != nullptr && !read(executor, callbacks))) {
    return &refused_report;
  }
  CallbackExecutor helpers(callbacks);
  const maxlogdet_error error = with_memory([&] {
    blocks->report = to_c(append_blocks(cameras, maxlogdet::RigidTransform::row_major(T), cpp_matches, cpp_options,
                                        blocks->blocks, helpers.get()));
  });
  return error == MAXLOGDET_ERROR_NONE ? &blocks->report : &no_memory_report;
}

template <class Scalar>
void read_point(const maxlogdet::Points& points, size_t i, double* p_w) noexcept {
  Scalar point[3];
  std::memcpy(point, static_cast<const unsigned char*>(points.data()) + points.stride() * i, sizeof point);
  for (int d = 0; d < 3; ++d) p_w[d] = static_cast<double>(point[d]);
}

// For one match; `write` is match_information or match_whitening.
template <class Write>
int32_t weigh(const maxlogdet_camera* camera, const double* T_cw, const maxlogdet_matches* matches, size_t i,
              const maxlogdet_block_options* options, double* to, const Write& write) noexcept {
  maxlogdet::Camera cpp_camera;
  maxlogdet::Matches cpp_matches;
  maxlogdet::BlockOptions cpp_options;
  if (to == nullptr || !read(camera, cpp_camera) || !read(matches, cpp_matches) || !read(options, cpp_options))
    return 0;
  const maxlogdet::Points& points = cpp_matches.points;
  const bool is_readable =
      check(points, cpp_matches.size) == maxlogdet::Error::none && check(cpp_options) == maxlogdet::Error::none;
  if (i >= cpp_matches.size || !is_readable) return 0;
  double p_w[3];
  points.are_float() ? read_point<float>(points, i, p_w) : read_point<double>(points, i, p_w);
  return write(cpp_camera, maxlogdet::RigidTransform::row_major(T_cw), p_w, match_noise(cpp_matches, i, cpp_options),
               to)
             ? 1
             : 0;
}

}  // namespace

maxlogdet_error maxlogdet_block_store_create(size_t capacity, maxlogdet_block_store** blocks) {
  if (blocks == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  *blocks = nullptr;
  return with_memory([&] { *blocks = new maxlogdet_block_store(capacity); });
}

void maxlogdet_block_store_destroy(maxlogdet_block_store* blocks) { delete blocks; }

maxlogdet_error maxlogdet_block_store_reserve(maxlogdet_block_store* blocks, size_t capacity) {
  if (blocks == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  return with_memory([&] { blocks->blocks.reserve(capacity); });
}

maxlogdet_error maxlogdet_block_store_clear(maxlogdet_block_store* blocks) {
  if (blocks == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  blocks->blocks.clear();
  return MAXLOGDET_ERROR_NONE;
}

size_t maxlogdet_block_store_size(const maxlogdet_block_store* blocks) {
  return blocks == nullptr ? 0 : blocks->blocks.size();
}

size_t maxlogdet_block_store_capacity(const maxlogdet_block_store* blocks) {
  return blocks == nullptr ? 0 : blocks->blocks.capacity();
}

int32_t maxlogdet_block_store_rows(const maxlogdet_block_store* blocks) {
  return blocks == nullptr ? 0 : blocks->blocks.rows();
}

int32_t maxlogdet_block_store_is_valid(const maxlogdet_block_store* blocks, size_t index) {
  return blocks != nullptr && blocks->blocks.is_valid(index) ? 1 : 0;
}

size_t maxlogdet_block_store_invalid_count(const maxlogdet_block_store* blocks) {
  return blocks == nullptr ? 0 : blocks->blocks.invalid_count();
}

maxlogdet_error maxlogdet_block_store_push_back(maxlogdet_block_store* blocks, const double* block, int32_t rows) {
  if (blocks == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  return with_memory([&] { blocks->blocks.push_back(block, rows); });
}

maxlogdet_error maxlogdet_block_store_push_back_invalid(maxlogdet_block_store* blocks) {
  if (blocks == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  return with_memory([&] { blocks->blocks.push_back_invalid(); });
}

const maxlogdet_block_report* maxlogdet_append_blocks(const maxlogdet_camera* camera, const double* T_cw,
                                                      const maxlogdet_matches* matches,
                                                      const maxlogdet_block_options* options,
                                                      maxlogdet_block_store* blocks,
                                                      const maxlogdet_executor* executor) {
  maxlogdet::Camera cpp_camera;
  if (!read(camera, cpp_camera)) return &refused_report;
  return append_to(blocks, cpp_camera, T_cw, matches, options, executor);
}

const maxlogdet_block_report* maxlogdet_append_blocks_of_rig(const maxlogdet_camera* const* cameras, const double* T_cb,
                                                             size_t camera_count, const double* T_bw,
                                                             const maxlogdet_matches* matches,
                                                             const maxlogdet_block_options* options,
                                                             maxlogdet_block_store* blocks,
                                                             const maxlogdet_executor* executor) {
  if (blocks == nullptr) return &refused_report;
  maxlogdet::Rig rig;
  const maxlogdet_error error = read(cameras, T_cb, camera_count, blocks->cameras, rig);
  if (error != MAXLOGDET_ERROR_NONE) {
    return error == MAXLOGDET_ERROR_OUT_OF_MEMORY ? &no_memory_report : &refused_report;
  }
  return append_to(blocks, rig, T_bw, matches, options, executor);
}

int32_t maxlogdet_match_information(const maxlogdet_camera* camera, const double* T_cw,
                                    const maxlogdet_matches* matches, size_t i, const maxlogdet_block_options* options,
                                    double* omega) {
  return weigh(camera, T_cw, matches, i, options, omega,
               [](const maxlogdet::Camera& of, const maxlogdet::RigidTransform& T, const double* p_w,
                  const maxlogdet::MatchNoise& noise, double* to) { return match_information(of, T, p_w, noise, to); });
}

int32_t maxlogdet_match_whitening(const maxlogdet_camera* camera, const double* T_cw, const maxlogdet_matches* matches,
                                  size_t i, const maxlogdet_block_options* options, double* W) {
  return weigh(camera, T_cw, matches, i, options, W,
               [](const maxlogdet::Camera& of, const maxlogdet::RigidTransform& T, const double* p_w,
                  const maxlogdet::MatchNoise& noise, double* to) { return match_whitening(of, T, p_w, noise, to); });
}

int32_t maxlogdet_selection_has_answer(const maxlogdet_selection* selection) {
  if (selection == nullptr) return 0;
  maxlogdet::Selection cpp_selection{};
  cpp_selection.status = static_cast<maxlogdet::Status>(selection->status);
  return cpp_selection.has_answer() ? 1 : 0;
}

const char* maxlogdet_selection_reason(const maxlogdet_selection* selection) {
  if (selection == nullptr) return maxlogdet_error_name(MAXLOGDET_ERROR_INVALID_ARGUMENT);
  return selection->status == MAXLOGDET_STATUS_ERROR ? maxlogdet_error_name(selection->error)
                                                     : maxlogdet_status_name(selection->status);
}

double maxlogdet_selection_certified_efficiency(const maxlogdet_selection* selection) {
  if (selection == nullptr) return not_a_number;
  maxlogdet::Selection cpp_selection{};
  cpp_selection.log_det = selection->log_det;
  cpp_selection.upper_bound = selection->upper_bound;
  return cpp_selection.certified_efficiency();
}

maxlogdet_error maxlogdet_selector_create(size_t capacity, const maxlogdet_executor* executor,
                                          maxlogdet_selector** selector) {
  if (selector == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  *selector = nullptr;
  maxlogdet_executor callbacks{};
  if (executor != nullptr && !read(executor, callbacks)) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  return with_memory([&] { *selector = new maxlogdet_selector(capacity, callbacks); });
}

void maxlogdet_selector_destroy(maxlogdet_selector* selector) { delete selector; }

size_t maxlogdet_selector_capacity(const maxlogdet_selector* selector) {
  return selector == nullptr ? 0 : selector->selector.capacity();
}

const maxlogdet_selection* maxlogdet_selector_select(maxlogdet_selector* selector, const maxlogdet_block_store* blocks,
                                                     const maxlogdet_options* options) {
  maxlogdet::Options cpp_options;
  if (selector == nullptr || blocks == nullptr || !read(options, cpp_options)) return &refused_selection;
  selector->selection = to_c(selector->selector.select(blocks->blocks, cpp_options));
  return &selector->selection;
}

maxlogdet_error maxlogdet_active_selection_create(size_t capacity, maxlogdet_active_selection** active) {
  if (active == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  *active = nullptr;
  return with_memory([&] { *active = new maxlogdet_active_selection(capacity); });
}

void maxlogdet_active_selection_destroy(maxlogdet_active_selection* active) { delete active; }

size_t maxlogdet_active_selection_capacity(const maxlogdet_active_selection* active) {
  return active == nullptr ? 0 : active->active.capacity();
}

maxlogdet_error maxlogdet_active_selection_start(maxlogdet_active_selection* active,
                                                 const maxlogdet_block_store* candidates,
                                                 const maxlogdet_options* options) {
  if (active == nullptr) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  maxlogdet::Options cpp_options;
  active->is_refused = candidates == nullptr || !read(options, cpp_options);
  if (active->is_refused) return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  return static_cast<maxlogdet_error>(active->active.start(candidates->blocks, cpp_options));
}

uint32_t maxlogdet_active_selection_next(maxlogdet_active_selection* active) {
  return active == nullptr || active->is_refused ? MAXLOGDET_NONE : active->active.next();
}

size_t maxlogdet_active_selection_next_batch(maxlogdet_active_selection* active, uint32_t* indices, size_t count) {
  return active == nullptr || active->is_refused ? 0 : active->active.next(indices, count);
}

maxlogdet_error maxlogdet_active_selection_accept(maxlogdet_active_selection* active) {
  return answered(active, [](ActiveSelection& to) { return to.accept(); });
}

maxlogdet_error maxlogdet_active_selection_accept_block(maxlogdet_active_selection* active, const double* block,
                                                        int32_t rows) {
  return answered(active, [=](ActiveSelection& to) { return to.accept(block, rows); });
}

maxlogdet_error maxlogdet_active_selection_reject(maxlogdet_active_selection* active) {
  return answered(active, [](ActiveSelection& to) { return to.reject(); });
}

maxlogdet_error maxlogdet_active_selection_accept_index(maxlogdet_active_selection* active, uint32_t index) {
  return answered(active, [=](ActiveSelection& to) { return to.accept(index); });
}

maxlogdet_error maxlogdet_active_selection_accept_block_index(maxlogdet_active_selection* active, uint32_t index,
                                                              const double* block, int32_t rows) {
  return answered(active, [=](ActiveSelection& to) { return to.accept(index, block, rows); });
}

maxlogdet_error maxlogdet_active_selection_reject_index(maxlogdet_active_selection* active, uint32_t index) {
  return answered(active, [=](ActiveSelection& to) { return to.reject(index); });
}

maxlogdet_error maxlogdet_active_selection_answer(maxlogdet_active_selection* active, const uint8_t* matched,
                                                  size_t count) {
  return answered(active, [=](ActiveSelection& to) { return to.answer(matched, count); });
}

const maxlogdet_selection* maxlogdet_active_selection_selection(maxlogdet_active_selection* active) {
  if (active == nullptr || active->is_refused) return &refused_selection;
  active->selection = to_c(active->active.selection());
  return &active->selection;
}
