// SPDX-License-Identifier: MIT
// Any calls of the C API in any order, with the misuse that its header has answers for, beside the same calls in C++.
#include "tests/api/c_api.hpp"
#include "tests/fuzz/answer.hpp"
#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/problem.hpp"
#include "tests/fuzz/require.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace maxlogdet::fuzz {
namespace {

using test::Owned;

constexpr std::size_t absurd = std::numeric_limits<std::size_t>::max();

void require_status(maxlogdet_status status, int expected, const char* property) {
  require(status == expected, property, maxlogdet_status_name(status), status, "instead of", expected);
}

// Whether the header takes a struct of that size.
template <class Struct>
bool is_size_of(std::size_t size) {
  return size % 8 == 0 && size >= 16 && size <= sizeof(Struct);
}

// A struct as a caller has it whose declaration ends earlier, in memory that ends there as well; or of a size that is
// none, in memory for the whole one.
template <class Struct>
class Given {
 public:
  Given(Bytes& bytes, const Struct& whole, const Struct& defaults) : seen_(defaults) {
    std::size_t size = sizeof(Struct);
    if (bytes.chance(48)) size = bytes.chance(64) ? bytes.raw<std::size_t>() : 8 * bytes.below(sizeof(Struct) / 8 + 2);
    is_good_ = is_size_of<Struct>(size);
    const std::size_t room = is_good_ ? size : sizeof(Struct);
    memory_.reset(new unsigned char[room]);  // aligned for any struct, and guarded by AddressSanitizer
    std::memcpy(memory_.get(), &whole, room);
    std::memcpy(memory_.get(), &size, sizeof size);
    if (is_good_) std::memcpy(&seen_, &whole, size);
    is_null_ = bytes.chance(8);
    is_good_ = is_good_ && !is_null_;
  }

  const Struct* get() const {
    return is_null_ ? nullptr : reinterpret_cast<const Struct*>(memory_.get());  // NOLINT(*-reinterpret-cast)
  }
  /// Whether it is one at all; reserved fields aside.
  bool is_good() const { return is_good_; }
  /// What the library has to read in it, defaults included.
  const Struct& seen() const { return seen_; }

 private:
  std::unique_ptr<unsigned char[]> memory_;
  Struct seen_;
  bool is_good_ = false;
  bool is_null_ = false;
};

template <class Struct>
Struct defaults_of(maxlogdet_status (*init)(Struct*, std::size_t)) {
  Struct made;
  require_status(init(&made, sizeof made), MAXLOGDET_STATUS_OK, "init takes the size of its struct");
  return made;
}

// init() writes what the size says and no more, or marks the struct.
template <class Struct>
void check_init(Bytes& bytes, maxlogdet_status (*init)(Struct*, std::size_t)) {
  const std::size_t size = bytes.chance(64) ? bytes.raw<std::size_t>() : bytes.below(sizeof(Struct) + 20);
  require_status(init(nullptr, size), MAXLOGDET_STATUS_INVALID_ARGUMENT, "init refuses a null pointer");
  constexpr int untouched = 0xA5;
  Struct made;
  std::memset(&made, untouched, sizeof made);
  const maxlogdet_status status = init(&made, size);
  const bool is_good = is_size_of<Struct>(size);
  require_status(status, is_good ? MAXLOGDET_STATUS_OK : MAXLOGDET_STATUS_INVALID_ARGUMENT, "init knows its sizes");
  const Struct defaults = defaults_of(init);
  std::array<unsigned char, sizeof(Struct)> expected;
  expected.fill(untouched);
  if (is_good) std::memcpy(expected.data(), &defaults, size);
  const std::size_t marked = is_good ? size : 0;
  if (is_good || size >= sizeof marked) std::memcpy(expected.data(), &marked, sizeof marked);
  require(std::memcmp(&made, expected.data(), sizeof made) == 0, "init writes the defaults up to the size", size);
}

Options in_cpp(const maxlogdet_options& options) {
  Options made;
  made.budget = options.budget;
  made.strategy = static_cast<Strategy>(options.strategy);
  made.threads = options.threads;
  made.epsilon = options.epsilon;
  made.seed = options.seed;
  made.prior = options.prior;
  made.time_limit = options.time_limit;
  made.certify = options.certify != 0;
  made.certificate_passes = options.certificate_passes;
  made.exchange_sweeps = options.exchange_sweeps;
  made.required = options.required;
  made.excluded = options.excluded;
  made.groups = options.groups;
  made.group_count = options.group_count;
  made.max_per_group = options.max_per_group;
  made.group_maxima = options.group_maxima;
  made.target_efficiency = options.target_efficiency;
  made.target_translation_sigma = options.target_translation_sigma;
  made.target_rotation_sigma = options.target_rotation_sigma;
  return made;
}

void check_same(const maxlogdet_selection* in_c, const Selection& in_cpp) {
  require(in_c != nullptr, "a selection is never null");
  require_status(in_c->status, static_cast<int>(in_cpp.status), "statuses are those of C++");
  require(in_c->size == in_cpp.size, "sizes are those of C++", in_c->size, in_cpp.size);
  require(std::equal(in_cpp.begin(), in_cpp.end(), in_c->indices), "indices are those of C++");
  for (std::size_t j = 0; j < in_c->size; ++j) {
    require(same_value(in_c->gains[j], in_cpp.gains[j]), "gains are those of C++", in_c->gains[j], in_cpp.gains[j]);
  }
  require(same_value(in_c->log_det, in_cpp.log_det), "log det is that of C++", in_c->log_det, in_cpp.log_det);
  require(same_value(in_c->upper_bound, in_cpp.upper_bound), "bounds are those of C++", in_c->upper_bound);
  require(same_value(maxlogdet_selection_efficiency(in_c), in_cpp.efficiency()), "efficiency is that of C++");
  require(same_value(in_c->efficiency_of_all, in_cpp.efficiency_of_all) &&
              same_value(in_c->translation_sigma, in_cpp.translation_sigma) &&
              same_value(in_c->rotation_sigma, in_cpp.rotation_sigma),
          "what targets are about is that of C++");
  require(in_c->evaluations == in_cpp.evaluations && in_c->float64_decisions == in_cpp.float64_decisions,
          "the work told is that of C++", in_c->evaluations, in_cpp.evaluations);
  require(in_c->invalid_candidates == in_cpp.invalid_candidates, "invalid candidates are those of C++");
  require(in_c->strategy == static_cast<int>(in_cpp.strategy), "the strategy told is that of C++", in_c->strategy);
  require(in_c->threads == in_cpp.threads && in_c->reserved == 0, "threads are those of C++", in_c->threads);
  require((maxlogdet_selection_has_answer(in_c) != 0) == in_cpp.has_answer(), "an answer is one in C and C++");
}

void check_refused(const maxlogdet_selection* selection) {
  require(selection != nullptr, "a selection is never null");
  require_status(selection->status, MAXLOGDET_STATUS_INVALID_ARGUMENT, "what is not understood is refused");
  require(selection->size == 0 && std::isnan(selection->log_det) && maxlogdet_selection_has_answer(selection) == 0,
          "a refusal carries an empty answer");
}

// Executors whose helpers never come, and that count, in C and in C++.
int concurrency(void*) { return 2; }
void run_alone(void* user_data, std::int32_t, maxlogdet_body body, void* context) {
  ++*static_cast<int*>(user_data);
  body(context, 0);
}
class LonelyExecutor final : public Executor {
 public:
  int concurrency() const noexcept override { return 2; }
  void run(int, Body body, void* context) noexcept override {
    ++calls;
    body(context, 0);
  }
  int calls = 0;
};

class Machine {
 public:
  explicit Machine(Bytes& bytes) : bytes_(bytes) {
    make_store();
    make_selector();
    make_active();
  }

  void run() {
    for (int calls = 0; calls < 300 && !bytes_.is_empty(); ++calls) call();
    if (is_active_) check_active();
  }

 private:
  void call() {
    switch (bytes_.below(20)) {
      case 0: make_store(); break;
      case 1: make_selector(); break;
      case 2: make_active(); break;
      case 3: check_nulls(); break;
      case 4: check_names(); break;
      case 5: check_inits(); break;
      case 6: reserve(); break;
      case 7: clear(); break;
      case 8: push_many(); break;
      case 9:
      case 10: push(); break;
      case 11: append(); break;
      case 12: start(); break;
      case 13: next(); break;
      case 14: accept(); break;
      case 15: accept_block(); break;
      case 16: reject(); break;
      case 17: check_active(); break;
      case 18: next_batch(); break;
      default: select();
    }
    check_store();
  }

  void make_store() {
    const std::size_t capacity = bytes_.chance(8) ? absurd : bytes_.below(300);
    store_changes();
    maxlogdet_block_store* made = nullptr;
    const maxlogdet_status status = maxlogdet_block_store_create(capacity, &made);
    require_status(status, capacity == absurd ? MAXLOGDET_STATUS_OUT_OF_MEMORY : MAXLOGDET_STATUS_OK,
                   "a store is made where there is memory");
    require((made == nullptr) == (capacity == absurd), "without memory there is no store");
    if (made == nullptr) require_status(maxlogdet_block_store_create(0, &made), MAXLOGDET_STATUS_OK, "a store is made");
    store_.reset(made);
    expected_store_ = BlockStore(capacity == absurd ? 0 : capacity);
  }

  void make_selector() {
    const std::size_t capacity = bytes_.chance(8) ? std::size_t{1} << 32U : bytes_.below(400);
    auto executor = defaults_of(maxlogdet_executor_init);
    executor.user_data = &calls_of_executor_;
    if (!bytes_.chance(32)) executor.concurrency = &concurrency;
    if (!bytes_.chance(32)) executor.run = &run_alone;
    const Given<maxlogdet_executor> given(bytes_, executor, defaults_of(maxlogdet_executor_init));
    const bool is_good = given.get() == nullptr ||
                         (given.is_good() && given.seen().concurrency != nullptr && given.seen().run != nullptr);
    const int expected = !is_good                   ? MAXLOGDET_STATUS_INVALID_ARGUMENT
                         : capacity > 0xFFFFFFFFULL ? MAXLOGDET_STATUS_OUT_OF_MEMORY
                                                    : MAXLOGDET_STATUS_OK;
    maxlogdet_selector* made = nullptr;
    require_status(maxlogdet_selector_create(capacity, given.get(), &made), expected,
                   "a selector is made, or said why not");
    require((made != nullptr) == (expected == MAXLOGDET_STATUS_OK), "a selector is stored if it was made");
    require(maxlogdet_selector_capacity(made) == (made == nullptr ? 0 : capacity), "a selector has its capacity");
    selector_.reset(made);
    expected_selector_ =
        std::make_unique<Selector>(made == nullptr ? 0 : capacity, given.get() == nullptr ? nullptr : &executor_);
  }

  void make_active() {
    const std::size_t capacity = bytes_.chance(8) ? absurd : bytes_.below(400);
    maxlogdet_active_selection* made = nullptr;
    require_status(maxlogdet_active_selection_create(capacity, &made),
                   capacity == absurd ? MAXLOGDET_STATUS_OUT_OF_MEMORY : MAXLOGDET_STATUS_OK,
                   "an active selection is made where there is memory");
    require(maxlogdet_active_selection_capacity(made) == (made == nullptr ? 0 : capacity), "it has its capacity");
    active_.reset(made);
    expected_active_ = std::make_unique<ActiveSelection>(made == nullptr ? 0 : capacity);
    is_active_ = made != nullptr;
    is_refused_ = false;
  }

  // What has begun on the candidates as they were must not be asked any more.
  void store_changes() { is_active_ = false; }

  void check_store() const {
    const maxlogdet_block_store* const store = store_.get();
    require(maxlogdet_block_store_size(store) == expected_store_.size(), "stores have the same size");
    require(maxlogdet_block_store_rows(store) == expected_store_.rows(), "stores have the same rows");
    require(maxlogdet_block_store_invalid_count(store) == expected_store_.invalid_count(),
            "and as many invalid blocks");
    require(maxlogdet_block_store_capacity(store) == expected_store_.capacity(), "and the same capacity");
    const std::size_t last = expected_store_.size() - 1;
    require(maxlogdet_block_store_is_valid(store, last) ==
                (expected_store_.size() > 0 && expected_store_.is_valid(last) ? 1 : 0),
            "blocks are valid in C and C++");
    require(maxlogdet_block_store_is_valid(store, expected_store_.size()) == 0, "beyond the end nothing is valid");
  }

  void reserve() {
    store_changes();
    const std::size_t capacity = bytes_.chance(64) ? absurd : bytes_.below(500);
    require_status(maxlogdet_block_store_reserve(store_.get(), capacity),
                   capacity == absurd ? MAXLOGDET_STATUS_OUT_OF_MEMORY : MAXLOGDET_STATUS_OK, "a store grows");
    if (capacity != absurd) expected_store_.reserve(capacity);
  }

  void clear() {
    store_changes();
    require_status(maxlogdet_block_store_clear(store_.get()), MAXLOGDET_STATUS_OK, "a store is cleared");
    expected_store_.clear();
  }

  void push(const double* block, int rows) {
    require_status(maxlogdet_block_store_push_back(store_.get(), block, rows), MAXLOGDET_STATUS_OK,
                   "any block takes its place");
    expected_store_.push_back(block, rows);
  }

  void push() {
    store_changes();
    if (bytes_.chance(16)) {
      require_status(maxlogdet_block_store_push_back_invalid(store_.get()), MAXLOGDET_STATUS_OK,
                     "no block has a place");
      expected_store_.push_back_invalid();
      return;
    }
    const AnyBlock block = any_block(bytes_);
    const double* const entries = bytes_.chance(16) ? nullptr : block.entries;
    const int rows = bytes_.chance(16) ? std::min(0, static_cast<int>(bytes_.raw<std::int8_t>())) : block.rows;
    push(entries, rows);
  }

  void push_many() {
    store_changes();
    BlockStore made;
    append_candidates(bytes_, made);
    const std::size_t count =
        std::min<std::size_t>(made.size(), 300 - std::min<std::size_t>(300, expected_store_.size()));
    for (std::size_t i = 0; i < count; ++i) {
      const test::Block block = test::stored_block(made, i);
      push(made.is_valid(i) ? block.data() : nullptr, std::max(1, made.rows()));
    }
  }

  void append() {
    store_changes();
    auto camera = defaults_of(maxlogdet_camera_init);
    camera.fx = bytes_.chance(16) ? bytes_.number() : 400 + bytes_.byte();
    camera.fy = bytes_.chance(16) ? bytes_.number() : 400 + bytes_.byte();
    camera.cx = bytes_.chance(16) ? bytes_.number() : 320;
    camera.bf = bytes_.chance(64) ? bytes_.number() : 40;
    camera.model = bytes_.chance(8) ? bytes_.raw<std::int32_t>() : static_cast<int>(bytes_.below(4));
    for (double& parameter : camera.parameters) parameter = bytes_.chance(16) ? bytes_.number() : 0.01;
    std::vector<double> T_cw = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    if (bytes_.chance(64)) T_cw[bytes_.below(12)] = bytes_.number();
    const std::size_t count = expected_store_.size() > 300 ? 0 : bytes_.below(40);
    const auto numbers = [&](std::size_t size, double usual) {
      std::vector<double> list(size, usual);
      for (double& value : list) value = bytes_.chance(16) ? bytes_.number() : usual + bytes_.byte() / 64.0;
      return list;
    };
    const auto bits = [&] {
      std::vector<std::uint8_t> list(count);
      for (std::uint8_t& value : list) value = bytes_.byte() & 2;
      return list;
    };
    const std::vector<double> points = numbers(3 * count, 1);
    const std::vector<double> sigmas = numbers(count, 1);
    const std::vector<double> weights = numbers(count, 0.5);
    const std::vector<double> covariances = numbers(9 * count, 0);
    const std::vector<double> jacobians = numbers(6 * count, 3);
    const std::vector<std::uint8_t> has_third = bits();
    const std::vector<std::uint8_t> usable = bits();
    auto matches = defaults_of(maxlogdet_matches_init);
    matches.size = count;
    if (!bytes_.chance(8)) matches.points = points.data();
    if (bytes_.chance(64)) matches.sigmas = sigmas.data();
    if (bytes_.chance(64)) matches.weights = weights.data();
    if (bytes_.chance(64)) matches.has_third = has_third.data();
    if (bytes_.chance(64)) matches.usable = usable.data();
    if (bytes_.chance(64)) matches.map_covariances = covariances.data();
    if (bytes_.chance(64)) matches.jacobians = jacobians.data();
    const std::vector<std::uint8_t> camera_ids = bits();
    if (bytes_.chance(64)) matches.camera_ids = camera_ids.data();
    if (bytes_.chance(64)) {
      matches.point_type = MAXLOGDET_POINT_TYPE_FLOAT32;  // what the same bytes are then
      matches.point_stride = 3 * sizeof(double);
    }
    if (bytes_.chance(8)) matches.point_stride = bytes_.below(24);
    auto options = defaults_of(maxlogdet_block_options_init);
    options.weighting = bytes_.chance(8) ? bytes_.raw<std::int32_t>() : static_cast<int>(bytes_.below(4));
    options.third = bytes_.chance(8) ? bytes_.raw<std::int32_t>() : static_cast<int>(bytes_.below(3));
    options.map_sigma = bytes_.chance(16) ? bytes_.number() : 0.1;
    options.depth_sigma = bytes_.chance(16) ? bytes_.number() : 0.1;
    options.min_depth = bytes_.chance(16) ? bytes_.number() : 0.1;
    options.threads = bytes_.raw<std::int8_t>();
    if (!bytes_.chance(16)) options.threads = std::max(0, options.threads);
    if (bytes_.chance(8)) options.reserved = bytes_.byte();

    const Given<maxlogdet_camera> given_camera(bytes_, camera, defaults_of(maxlogdet_camera_init));
    const Given<maxlogdet_matches> given_matches(bytes_, matches, defaults_of(maxlogdet_matches_init));
    const Given<maxlogdet_block_options> given_options(bytes_, options, defaults_of(maxlogdet_block_options_init));
    const double* const pose = bytes_.chance(8) ? nullptr : T_cw.data();
    // A rig of three, the same camera looking three ways; ids are 0 and 2.
    const bool is_rig = bytes_.chance(64);
    const maxlogdet_camera* const cameras[3] = {given_camera.get(), given_camera.get(), given_camera.get()};
    const std::vector<double> T_cb = {1, 0, 0,  0, 0, 1, 0, 0, 0, 0,   1, 0,  0, 0, 1, 0, 0,  1,
                                      0, 0, -1, 0, 0, 0, 1, 0, 0, 0.1, 0, -1, 0, 0, 0, 0, -1, 0};
    const maxlogdet_block_report* const report =
        is_rig ? maxlogdet_append_blocks_of_rig(cameras, T_cb.data(), 3, pose, given_matches.get(), given_options.get(),
                                                store_.get(), nullptr)
               : maxlogdet_append_blocks(given_camera.get(), pose, given_matches.get(), given_options.get(),
                                         store_.get(), nullptr);
    require(report != nullptr, "a report is never null");
    if (!given_camera.is_good() || !given_matches.is_good() || !given_options.is_good() ||
        given_options.seen().reserved != 0 || given_camera.seen().reserved != 0 || given_matches.seen().reserved != 0) {
      require_status(report->status, MAXLOGDET_BLOCK_STATUS_INVALID_ARGUMENT, "what is not understood is refused");
      require(report->appended == 0, "what is refused appends nothing");
      return;
    }
    check_report(*report, append_in_cpp(given_camera.seen(), is_rig ? T_cb.data() : nullptr, pose, given_matches.seen(),
                                        given_options.seen()));
  }

  // `T_cb`: of the three cameras of a rig, or nullptr.
  BlockReport append_in_cpp(const maxlogdet_camera& camera, const double* T_cb, const double* T_cw,
                            const maxlogdet_matches& matches, const maxlogdet_block_options& options) {
    Matches of_cpp;
    of_cpp.size = matches.size;
    of_cpp.points = points_in_cpp(matches);
    of_cpp.sigmas = matches.sigmas;
    of_cpp.has_third = matches.has_third;
    of_cpp.usable = matches.usable;
    of_cpp.weights = matches.weights;
    of_cpp.map_covariances = matches.map_covariances;
    of_cpp.jacobians = matches.jacobians;
    of_cpp.camera_ids = matches.camera_ids;
    BlockOptions block_options;
    block_options.weighting = static_cast<Weighting>(options.weighting);
    block_options.third = static_cast<ThirdMeasurement>(options.third);
    block_options.map_sigma = options.map_sigma;
    block_options.depth_sigma = options.depth_sigma;
    block_options.min_depth = options.min_depth;
    block_options.threads = options.threads;
    Camera of_any_model(camera.fx, camera.fy, camera.cx, camera.cy, camera.bf);
    of_any_model.model = static_cast<CameraModel>(camera.model);
    std::copy(std::begin(camera.parameters), std::end(camera.parameters), of_any_model.parameters);
    if (T_cb == nullptr) return append_blocks(of_any_model, T_cw, of_cpp, block_options, expected_store_);
    const RigCamera cameras[3] = {{of_any_model, T_cb}, {of_any_model, T_cb + 12}, {of_any_model, T_cb + 24}};
    return append_blocks(Rig{cameras, 3}, T_cw, of_cpp, block_options, expected_store_);
  }

  static Points points_in_cpp(const maxlogdet_matches& matches) {
    const std::size_t stride = matches.point_stride;
    if (matches.point_type == MAXLOGDET_POINT_TYPE_FLOAT32) {
      return {static_cast<const float*>(matches.points), stride == 0 ? 3 * sizeof(float) : stride};
    }
    return {static_cast<const double*>(matches.points), stride == 0 ? 3 * sizeof(double) : stride};
  }

  static void check_report(const maxlogdet_block_report& in_c, const BlockReport& in_cpp) {
    require(in_c.status == static_cast<int>(in_cpp.status), "block statuses are those of C++", in_c.status,
            to_string(in_cpp.status));
    require(in_c.appended == in_cpp.appended && in_c.invalid == in_cpp.invalid && in_c.unusable == in_cpp.unusable &&
                in_c.behind_camera == in_cpp.behind_camera && in_c.too_near == in_cpp.too_near &&
                in_c.singular_rays == in_cpp.singular_rays && in_c.unsound_covariances == in_cpp.unsound_covariances &&
                in_c.invalid_jacobians == in_cpp.invalid_jacobians,
            "block reports are those of C++", in_c.appended, in_c.invalid);
  }

  // Options for the candidates of the store, as a caller gives them.
  std::unique_ptr<Given<maxlogdet_options>> given_options() {
    request_ = std::make_unique<Request>(bytes_, expected_store_);
    maxlogdet_options whole = test::options_in_c(request_->options);
    if (bytes_.chance(64)) whole.strategy = static_cast<int>(bytes_.below(2));  // of an active selection
    // In time or not: the same in C and C++.
    if (whole.time_limit > 0) whole.time_limit = whole.time_limit < 1e-3 ? 1e-9 : 1e6;
    if (bytes_.chance(4)) whole.reserved = 1;
    return std::make_unique<Given<maxlogdet_options>>(bytes_, whole, defaults_of(maxlogdet_options_init));
  }

  void select() {
    is_active_ = false;  // the arrays of its options go
    const auto given = given_options();
    const maxlogdet_selection* const selection = maxlogdet_selector_select(selector_.get(), store_.get(), given->get());
    if (selector_ == nullptr || !given->is_good() || given->seen().reserved != 0) {
      check_refused(selection);
    } else {
      check_same(selection, expected_selector_->select(expected_store_, in_cpp(given->seen())));
      require(calls_of_executor_ == executor_.calls, "the executor is called as often in C and C++");
    }
  }

  void start() {
    is_active_ = false;
    const auto given = given_options();
    const bool has_blocks = !bytes_.chance(4);
    const maxlogdet_status status =
        maxlogdet_active_selection_start(active_.get(), has_blocks ? store_.get() : nullptr, given->get());
    if (active_ == nullptr) {
      require_status(status, MAXLOGDET_STATUS_INVALID_ARGUMENT, "without a handle nothing begins");
      return;
    }
    is_active_ = true;
    is_refused_ = !has_blocks || !given->is_good() || given->seen().reserved != 0;
    const int expected = is_refused_
                             ? MAXLOGDET_STATUS_INVALID_ARGUMENT
                             : static_cast<int>(expected_active_->start(expected_store_, in_cpp(given->seen())));
    require_status(status, expected, "active selections begin as in C++");
  }

  void next() {
    if (!is_active_) return;
    const std::uint32_t proposed = maxlogdet_active_selection_next(active_.get());
    const std::uint32_t expected = is_refused_ ? MAXLOGDET_NONE : expected_active_->next();
    require(proposed == expected, "proposals are those of C++", proposed, expected);
  }

  void accept() {
    if (!is_active_) return;
    const Status expected = is_refused_ ? Status::nothing_proposed : expected_active_->accept();
    require_status(maxlogdet_active_selection_accept(active_.get()), static_cast<int>(expected),
                   "accepting is as in C++");
  }

  void accept_block() {
    const AnyBlock block = any_block(bytes_);
    const double* const entries = bytes_.chance(8) ? nullptr : block.entries;
    const int rows = bytes_.chance(16) ? std::min(0, static_cast<int>(bytes_.raw<std::int8_t>())) : block.rows;
    if (!is_active_) return;
    const Status expected = is_refused_ ? Status::nothing_proposed : expected_active_->accept(entries, rows);
    require_status(maxlogdet_active_selection_accept_block(active_.get(), entries, rows), static_cast<int>(expected),
                   "accepting what was measured is as in C++");
  }

  void reject() {
    if (!is_active_) return;
    const Status expected = is_refused_ ? Status::nothing_proposed : expected_active_->reject();
    require_status(maxlogdet_active_selection_reject(active_.get()), static_cast<int>(expected),
                   "rejecting is as in C++");
  }

  void next_batch() {
    std::uint32_t batch[10] = {};
    std::uint32_t expected[10] = {};
    const std::size_t wanted = bytes_.below(10);
    const std::uint8_t matched[3] = {0, 1, bytes_.byte()};
    const std::uint32_t index = static_cast<std::uint32_t>(bytes_.below(10));
    const int kind = static_cast<int>(bytes_.below(4));
    if (!is_active_) return;
    const std::size_t count = maxlogdet_active_selection_next_batch(active_.get(), batch, wanted);
    require(count == (is_refused_ ? 0 : expected_active_->next(expected, wanted)), "batches are as long as in C++");
    require(std::equal(batch, batch + count, expected), "batches are those of C++");
    answer_batch(kind, count > 0 ? batch[index % count] : index, matched);
  }

  void answer_batch(int kind, std::uint32_t index, const std::uint8_t (&matched)[3]) {
    const double block[6] = {1, -2, 3, 0.5, 0, 1};
    maxlogdet_status status = MAXLOGDET_STATUS_OK;
    Status expected = Status::nothing_proposed;
    ActiveSelection& in_cpp = *expected_active_;
    switch (kind) {
      case 0:
        status = maxlogdet_active_selection_accept_index(active_.get(), index);
        if (!is_refused_) expected = in_cpp.accept(index);
        break;
      case 1:
        status = maxlogdet_active_selection_accept_block_index(active_.get(), index, block, 1);
        if (!is_refused_) expected = in_cpp.accept(index, block, 1);
        break;
      case 2:
        status = maxlogdet_active_selection_reject_index(active_.get(), index);
        if (!is_refused_) expected = in_cpp.reject(index);
        break;
      default:
        status = maxlogdet_active_selection_answer(active_.get(), matched, 3);
        if (!is_refused_) expected = in_cpp.answer(matched, 3);
    }
    require_status(status, static_cast<int>(expected), "answers to batches are as in C++");
  }

  void check_active() {
    if (!is_active_) return;
    const maxlogdet_selection* const selection = maxlogdet_active_selection_selection(active_.get());
    if (is_refused_) {
      check_refused(selection);
    } else {
      check_same(selection, expected_active_->selection());
    }
  }

  void check_inits() {
    check_init(bytes_, maxlogdet_camera_init);
    check_init(bytes_, maxlogdet_matches_init);
    check_init(bytes_, maxlogdet_block_options_init);
    check_init(bytes_, maxlogdet_options_init);
    check_init(bytes_, maxlogdet_executor_init);
  }

  void check_names() {
    const int value = bytes_.chance(32) ? bytes_.raw<std::int32_t>() : bytes_.raw<std::int8_t>() % 20;
    const std::string status = maxlogdet_status_name(value);
    if (value >= 0) require(status == to_string(static_cast<Status>(value)), "names are those of C++", value, status);
    const bool is_of_c = value == MAXLOGDET_STATUS_OUT_OF_MEMORY || value == MAXLOGDET_STATUS_INVALID_ARGUMENT;
    require((status == "unknown") == (value > MAXLOGDET_STATUS_UNSUPPORTED_TARGET || (value < 0 && !is_of_c)),
            "every status has a name", value, status);
    require(maxlogdet_strategy_name(value) == std::string(to_string(static_cast<Strategy>(value))),
            "names of strategies are those of C++", value);
    require(maxlogdet_weighting_name(value) == std::string(to_string(static_cast<Weighting>(value))),
            "names of weightings are those of C++", value);
    const std::string block_status = maxlogdet_block_status_name(value);
    require(is_of_c || block_status == to_string(static_cast<BlockStatus>(value)), "and of block statuses", value);
    const char* const isa = maxlogdet_built_in_isa(value);
    require(isa == built_in_isa(value), "instruction sets are those of C++", value);
    require((maxlogdet_isa_is_supported(isa) != 0) == isa_is_supported(isa), "and so is what is supported", value);
  }

  void check_nulls() const {
    constexpr int refused = MAXLOGDET_STATUS_INVALID_ARGUMENT;
    const char* const property = "a null pointer is refused";
    require_status(maxlogdet_block_store_create(1, nullptr), refused, property);
    require_status(maxlogdet_selector_create(1, nullptr, nullptr), refused, property);
    require_status(maxlogdet_active_selection_create(1, nullptr), refused, property);
    maxlogdet_block_store_destroy(nullptr);
    maxlogdet_selector_destroy(nullptr);
    maxlogdet_active_selection_destroy(nullptr);
    require_status(maxlogdet_block_store_reserve(nullptr, 1), refused, property);
    require_status(maxlogdet_block_store_clear(nullptr), refused, property);
    require_status(maxlogdet_block_store_push_back(nullptr, nullptr, 2), refused, property);
    require_status(maxlogdet_block_store_push_back_invalid(nullptr), refused, property);
    require(maxlogdet_block_store_size(nullptr) == 0 && maxlogdet_block_store_capacity(nullptr) == 0 &&
                maxlogdet_block_store_rows(nullptr) == 0 && maxlogdet_block_store_is_valid(nullptr, 0) == 0 &&
                maxlogdet_block_store_invalid_count(nullptr) == 0,
            "no store holds nothing");
    require(maxlogdet_selector_capacity(nullptr) == 0 && maxlogdet_active_selection_capacity(nullptr) == 0,
            "no handle has no capacity");
    const auto options = defaults_of(maxlogdet_options_init);
    check_refused(maxlogdet_selector_select(nullptr, store_.get(), &options));
    check_refused(maxlogdet_selector_select(selector_.get(), nullptr, &options));
    check_refused(maxlogdet_selector_select(selector_.get(), store_.get(), nullptr));
    require_status(maxlogdet_active_selection_start(nullptr, store_.get(), &options), refused, property);
    require_status(maxlogdet_active_selection_accept(nullptr), refused, property);
    require_status(maxlogdet_active_selection_accept_block(nullptr, nullptr, 1), refused, property);
    require_status(maxlogdet_active_selection_reject(nullptr), refused, property);
    require_status(maxlogdet_active_selection_accept_index(nullptr, 0), refused, property);
    require_status(maxlogdet_active_selection_accept_block_index(nullptr, 0, nullptr, 1), refused, property);
    require_status(maxlogdet_active_selection_reject_index(nullptr, 0), refused, property);
    require_status(maxlogdet_active_selection_answer(nullptr, nullptr, 0), refused, property);
    require(maxlogdet_active_selection_next_batch(nullptr, nullptr, 1) == 0, "no handle proposes no batch");
    require(maxlogdet_active_selection_next(nullptr) == MAXLOGDET_NONE, "no handle proposes nothing");
    check_refused(maxlogdet_active_selection_selection(nullptr));
    require(maxlogdet_selection_has_answer(nullptr) == 0 && std::isnan(maxlogdet_selection_efficiency(nullptr)),
            "no selection is no answer");
    require(maxlogdet_append_blocks(nullptr, nullptr, nullptr, nullptr, store_.get(), nullptr)->status == refused,
            property);
    require(maxlogdet_isa_is_supported(nullptr) == 0, "no name is no instruction set");
  }

  Bytes& bytes_;
  int calls_of_executor_ = 0;
  LonelyExecutor executor_;
  Owned<maxlogdet_block_store> store_;
  BlockStore expected_store_;
  Owned<maxlogdet_selector> selector_;  // none where making it was refused
  std::unique_ptr<Selector> expected_selector_;
  std::unique_ptr<Request> request_;
  Owned<maxlogdet_active_selection> active_;
  std::unique_ptr<ActiveSelection> expected_active_;
  bool is_active_ = false;   // may be asked: what it began with is still there
  bool is_refused_ = false;  // the last start was
};

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::Bytes bytes(data, size);
  maxlogdet::fuzz::Machine(bytes).run();
  return 0;
}
