// SPDX-License-Identifier: MIT
#include "tests/fuzz/c_api_misuse.hpp"

#include "tests/fuzz/c_api_given.hpp"
#include "tests/fuzz/c_api_same.hpp"

#include <cmath>
#include <string>

namespace maxlogdet::fuzz {
namespace {

constexpr int refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;
constexpr const char* property = "a null pointer is refused";

void check_null_stores() {
  require_error(maxlogdet_block_store_create(1, nullptr), refused, property);
  require_error(maxlogdet_selector_create(1, nullptr, nullptr), refused, property);
  require_error(maxlogdet_active_selection_create(1, nullptr), refused, property);
  maxlogdet_block_store_destroy(nullptr);
  maxlogdet_selector_destroy(nullptr);
  maxlogdet_active_selection_destroy(nullptr);
  require_error(maxlogdet_block_store_reserve(nullptr, 1), refused, property);
  require_error(maxlogdet_block_store_clear(nullptr), refused, property);
  require_error(maxlogdet_block_store_push_back(nullptr, nullptr, 2), refused, property);
  require_error(maxlogdet_block_store_push_back_invalid(nullptr), refused, property);
  require(maxlogdet_block_store_size(nullptr) == 0 && maxlogdet_block_store_capacity(nullptr) == 0 &&
              maxlogdet_block_store_rows(nullptr) == 0 && maxlogdet_block_store_is_valid(nullptr, 0) == 0 &&
              maxlogdet_block_store_invalid_count(nullptr) == 0,
          "no store holds nothing");
}

void check_null_active_selections(const maxlogdet_block_store* store, const maxlogdet_options& options) {
  require_error(maxlogdet_active_selection_start(nullptr, store, &options), refused, property);
  require_error(maxlogdet_active_selection_accept(nullptr), refused, property);
  require_error(maxlogdet_active_selection_accept_block(nullptr, nullptr, 1), refused, property);
  require_error(maxlogdet_active_selection_reject(nullptr), refused, property);
  require_error(maxlogdet_active_selection_accept_index(nullptr, 0), refused, property);
  require_error(maxlogdet_active_selection_accept_block_index(nullptr, 0, nullptr, 1), refused, property);
  require_error(maxlogdet_active_selection_reject_index(nullptr, 0), refused, property);
  require_error(maxlogdet_active_selection_answer(nullptr, nullptr, 0), refused, property);
  require(maxlogdet_active_selection_next_batch(nullptr, nullptr, 1) == 0, "no handle proposes no batch");
  require(maxlogdet_active_selection_next(nullptr) == MAXLOGDET_NONE, "no handle proposes nothing");
  check_refused(maxlogdet_active_selection_selection(nullptr));
}

}  // namespace

void check_names(Bytes& bytes) {
  const int value = bytes.chance(32) ? bytes.raw<std::int32_t>() : bytes.raw<std::int8_t>() % 20;
  const std::string status = maxlogdet_status_name(value);
  if (value >= 0) require(status == to_string(static_cast<Status>(value)), "names are those of C++", value, status);
  const bool is_of_c = value == MAXLOGDET_ERROR_OUT_OF_MEMORY || value == MAXLOGDET_ERROR_INVALID_ARGUMENT;
  require((status == "unknown") == (value > MAXLOGDET_ERROR_UNSUPPORTED_TARGET || (value < 0 && !is_of_c)),
          "every status has a name", value, status);
  require(maxlogdet_strategy_name(value) == std::string(to_string(static_cast<Strategy>(value))),
          "names of strategies are those of C++", value);
  require(maxlogdet_weighting_name(value) == std::string(to_string(static_cast<Weighting>(value))),
          "names of weightings are those of C++", value);
  const std::string block_status = maxlogdet_error_name(value);
  require(is_of_c || block_status == to_string(static_cast<Error>(value)), "and of block statuses", value);
  const char* const isa = maxlogdet_built_in_isa(value);
  require(isa == built_in_isa(value), "instruction sets are those of C++", value);
  require((maxlogdet_isa_is_supported(isa) != 0) == isa_is_supported(isa), "and so is what is supported", value);
}

void check_nulls(maxlogdet_block_store* store, maxlogdet_selector* selector) {
  check_null_stores();
  require(maxlogdet_selector_capacity(nullptr) == 0 && maxlogdet_active_selection_capacity(nullptr) == 0,
          "no handle has no capacity");
  const auto options = defaults_of(maxlogdet_options_init);
  check_refused(maxlogdet_selector_select(nullptr, store, &options));
  check_refused(maxlogdet_selector_select(selector, nullptr, &options));
  check_refused(maxlogdet_selector_select(selector, store, nullptr));
  check_null_active_selections(store, options);
  require(maxlogdet_selection_has_answer(nullptr) == 0 && std::isnan(maxlogdet_selection_certified_efficiency(nullptr)),
          "no selection is no answer");
  require(maxlogdet_append_blocks(nullptr, nullptr, nullptr, nullptr, store, nullptr)->error == refused, property);
  require(maxlogdet_isa_is_supported(nullptr) == 0, "no name is no instruction set");
}

}  // namespace maxlogdet::fuzz
