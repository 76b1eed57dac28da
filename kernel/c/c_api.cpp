// SPDX-License-Identifier: MIT
// Block stores, selectors and active selections of the C API: each owns an object of C++ and the structs that it
// returns.
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include "kernel/base/limits.hpp"
#include "kernel/blocks/block_checks.hpp"
#include "kernel/c/c_handles.hpp"
#include "kernel/c/c_structs.hpp"

#include <cstring>
#include <vector>

using maxlogdet::ActiveSelection;
using maxlogdet::BlockOptions;
using maxlogdet::Camera;
using maxlogdet::Matches;
using maxlogdet::MatchNoise;
using maxlogdet::not_a_number;
using maxlogdet::Options;
using maxlogdet::RigidTransform;
using namespace maxlogdet::c_api;

namespace maxlogdet {
namespace c_api {

namespace {

constexpr maxlogdet_selection no_answer() noexcept {
  maxlogdet_selection selection{};
  selection.status = MAXLOGDET_STATUS_ERROR;
  selection.error = refused;
  selection.log_det = selection.upper_bound = not_a_number;
  selection.strategy = MAXLOGDET_STRATEGY_LAZY_GREEDY;
  selection.threads = 1;
  selection.efficiency = selection.translation_sigma = selection.rotation_sigma = not_a_number;
  return selection;
}

constexpr maxlogdet_block_report no_blocks(maxlogdet_error error) noexcept {
  maxlogdet_block_report report{};
  report.error = error;
  return report;
}

}  // namespace

constexpr maxlogdet_selection refused_selection = no_answer();
constexpr maxlogdet_block_report refused_report = no_blocks(refused);

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

  CallbackExecutor executor;
  maxlogdet::Selector selector;
  maxlogdet_selection selection{};
};

struct maxlogdet_active_selection {
  explicit maxlogdet_active_selection(size_t capacity) : active(capacity) {}

  ActiveSelection active;
  bool is_refused = false;  // by the last start; the selection before it has ended, its candidates may be gone
  maxlogdet_selection selection{};
};

namespace {

constexpr maxlogdet_block_report no_memory_report = no_blocks(MAXLOGDET_ERROR_OUT_OF_MEMORY);

// For a camera or a rig.
template <class Cameras>
const maxlogdet_block_report* append_to(maxlogdet_block_store* blocks, const Cameras& cameras, const double* T,
                                        const maxlogdet_matches* matches, const maxlogdet_block_options* options,
                                        const maxlogdet_executor* executor) noexcept {
  Matches cpp_matches;
  BlockOptions cpp_options;
  maxlogdet_executor callbacks;
  if (blocks == nullptr || !read(matches, cpp_matches) || !read(options, cpp_options) || !read(executor, callbacks)) {
    return &refused_report;
  }
  CallbackExecutor helpers(callbacks);
  const maxlogdet_error error = with_memory([&] {
    blocks->report = to_c(
        append_blocks(cameras, RigidTransform::row_major(T), cpp_matches, cpp_options, blocks->blocks, helpers.get()));
  });
  return error == MAXLOGDET_ERROR_NONE ? &blocks->report : &no_memory_report;
}

template <class Scalar>
void read_point(const maxlogdet::Points& points, size_t i, double (&p_w)[3]) noexcept {
  Scalar point[3];
  std::memcpy(point, static_cast<const unsigned char*>(points.data()) + points.stride() * i, sizeof point);
  for (int d = 0; d < 3; ++d) p_w[d] = static_cast<double>(point[d]);
}

// match_information or match_whitening.
using Weigh = bool(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                   double* to);

int32_t weigh(const maxlogdet_camera* camera, const double* T_cw, const maxlogdet_matches* matches, size_t i,
              const maxlogdet_block_options* options, double* to, Weigh& write) noexcept {
  Camera cpp_camera;
  Matches all;
  BlockOptions cpp_options;
  if (to == nullptr || !read(camera, cpp_camera) || !read(matches, all) || !read(options, cpp_options)) return 0;
  const bool is_readable =
      check(all.points, all.size) == maxlogdet::Error::none && check(cpp_options) == maxlogdet::Error::none;
  if (i >= all.size || !is_readable) return 0;
  double p_w[3];
  all.points.are_float() ? read_point<float>(all.points, i, p_w) : read_point<double>(all.points, i, p_w);
  return write(cpp_camera, RigidTransform::row_major(T_cw), p_w, match_noise(all, i, cpp_options), to) ? 1 : 0;
}

template <class Answer>
maxlogdet_error answered(maxlogdet_active_selection* active, const Answer& answer) {
  if (active == nullptr) return refused;
  if (active->is_refused) return MAXLOGDET_ERROR_NOTHING_PROPOSED;
  return static_cast<maxlogdet_error>(answer(active->active));
}

}  // namespace

maxlogdet_error maxlogdet_block_store_create(size_t capacity, maxlogdet_block_store** blocks) {
  return create(capacity, blocks);
}

void maxlogdet_block_store_destroy(maxlogdet_block_store* blocks) { delete blocks; }

maxlogdet_error maxlogdet_block_store_reserve(maxlogdet_block_store* blocks, size_t capacity) {
  return change(blocks, [=](maxlogdet_block_store& of) { of.blocks.reserve(capacity); });
}

maxlogdet_error maxlogdet_block_store_clear(maxlogdet_block_store* blocks) {
  return change(blocks, [](maxlogdet_block_store& of) { of.blocks.clear(); });
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
  return change(blocks, [=](maxlogdet_block_store& of) { of.blocks.push_back(block, rows); });
}

maxlogdet_error maxlogdet_block_store_push_back_invalid(maxlogdet_block_store* blocks) {
  return change(blocks, [](maxlogdet_block_store& of) { of.blocks.push_back_invalid(); });
}

const maxlogdet_block_report* maxlogdet_append_blocks(const maxlogdet_camera* camera, const double* T_cw,
                                                      const maxlogdet_matches* matches,
                                                      const maxlogdet_block_options* options,
                                                      maxlogdet_block_store* blocks,
                                                      const maxlogdet_executor* executor) {
  Camera cpp_camera;
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
  if (error == MAXLOGDET_ERROR_NONE) return append_to(blocks, rig, T_bw, matches, options, executor);
  return error == MAXLOGDET_ERROR_OUT_OF_MEMORY ? &no_memory_report : &refused_report;
}

int32_t maxlogdet_match_information(const maxlogdet_camera* camera, const double* T_cw,
                                    const maxlogdet_matches* matches, size_t i, const maxlogdet_block_options* options,
                                    double* omega) {
  return weigh(camera, T_cw, matches, i, options, omega, maxlogdet::match_information);
}

int32_t maxlogdet_match_whitening(const maxlogdet_camera* camera, const double* T_cw, const maxlogdet_matches* matches,
                                  size_t i, const maxlogdet_block_options* options, double* W) {
  return weigh(camera, T_cw, matches, i, options, W, maxlogdet::match_whitening);
}

int32_t maxlogdet_selection_has_answer(const maxlogdet_selection* selection) {
  return selection != nullptr && selection->status != MAXLOGDET_STATUS_ERROR ? 1 : 0;
}

const char* maxlogdet_selection_reason(const maxlogdet_selection* selection) {
  if (selection == nullptr) return maxlogdet_error_name(refused);
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
  return create(capacity, executor, selector);
}

void maxlogdet_selector_destroy(maxlogdet_selector* selector) { delete selector; }

size_t maxlogdet_selector_capacity(const maxlogdet_selector* selector) {
  return selector == nullptr ? 0 : selector->selector.capacity();
}

const maxlogdet_selection* maxlogdet_selector_select(maxlogdet_selector* selector, const maxlogdet_block_store* blocks,
                                                     const maxlogdet_options* options) {
  Options cpp_options;
  if (selector == nullptr || blocks == nullptr || !read(options, cpp_options)) return &refused_selection;
  selector->selection = to_c(selector->selector.select(blocks->blocks, cpp_options));
  return &selector->selection;
}

maxlogdet_error maxlogdet_active_selection_create(size_t capacity, maxlogdet_active_selection** active) {
  return create(capacity, active);
}

void maxlogdet_active_selection_destroy(maxlogdet_active_selection* active) { delete active; }

size_t maxlogdet_active_selection_capacity(const maxlogdet_active_selection* active) {
  return active == nullptr ? 0 : active->active.capacity();
}

maxlogdet_error maxlogdet_active_selection_start(maxlogdet_active_selection* active,
                                                 const maxlogdet_block_store* candidates,
                                                 const maxlogdet_options* options) {
  if (active == nullptr) return refused;
  Options cpp_options;
  active->is_refused = candidates == nullptr || !read(options, cpp_options);
  if (active->is_refused) return refused;
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
