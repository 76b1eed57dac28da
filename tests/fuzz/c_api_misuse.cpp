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

void check_null_good_features(const maxlogdet_options& options) {
  const auto camera = defaults_of(maxlogdet_camera_init);
  const auto match = defaults_of(maxlogdet_match_init);
  const auto block_options = defaults_of(maxlogdet_block_options_init);
  require_error(maxlogdet_good_features_create(1, nullptr, nullptr), refused, property);
  maxlogdet_good_features_destroy(nullptr);
  require_error(maxlogdet_good_features_set_block_options(nullptr, &block_options), refused, property);
  require_error(maxlogdet_good_features_set_spread(nullptr, 1), refused, property);
  require_error(maxlogdet_good_features_set_weighted(nullptr, 1), refused, property);
  require_error(maxlogdet_good_features_start(nullptr, &camera, nullptr), refused, property);
  require_error(maxlogdet_good_features_start_rig(nullptr, nullptr, nullptr, 0, nullptr), refused, property);
  require_error(maxlogdet_good_features_add(nullptr, &match), refused, property);
  check_refused(maxlogdet_good_features_select(nullptr, &options));
  check_refused(maxlogdet_good_features_match(nullptr, &options, nullptr, nullptr));
  check_refused(maxlogdet_good_features_selection(nullptr));
  require_error(maxlogdet_good_features_block_report(nullptr)->error, refused, property);
  require(maxlogdet_good_features_size(nullptr) == 0 && maxlogdet_good_features_id(nullptr, 0) == MAXLOGDET_NONE &&
              maxlogdet_good_features_is_selected(nullptr, 0) == 0 &&
              maxlogdet_good_features_is_outlier(nullptr, 0) == 0 &&
              maxlogdet_good_features_outliers(nullptr, nullptr, nullptr) == 0 &&
              std::isnan(maxlogdet_good_features_chi2(nullptr, 0)) &&
              std::isnan(maxlogdet_good_features_efficiency(nullptr)) &&
              maxlogdet_good_features_information(nullptr, 0, nullptr) == 0 &&
              maxlogdet_good_features_whitening(nullptr, 0, nullptr) == 0 &&
              maxlogdet_good_features_record(nullptr, nullptr) == 0,
          "no good features answer nothing");
}

}  // namespace

void check_names(Bytes& bytes) {
  const int value = bytes.chance(32) ? bytes.raw<std::int32_t>() : bytes.raw<std::int8_t>() % 25;
  const std::string error = maxlogdet_error_name(value);
  const bool is_of_c = value == MAXLOGDET_ERROR_OUT_OF_MEMORY || value == MAXLOGDET_ERROR_INVALID_ARGUMENT;
  require(is_of_c || error == to_string(static_cast<Error>(value)), "names of errors are those of C++", value, error);
  require((error == "unknown") == (value > MAXLOGDET_ERROR_INVALID_BLOCK || (value < 0 && !is_of_c)),
          "every error has a name", value, error);
  require((maxlogdet_error_explanation(value) == std::string("unknown")) == (error == "unknown"), "and an explanation",
          value);
  require(maxlogdet_status_name(value) == std::string(to_string(static_cast<Status>(value))),
          "names of statuses are those of C++", value);
  require(maxlogdet_strategy_name(value) == std::string(to_string(static_cast<Strategy>(value))),
          "names of strategies are those of C++", value);
  require(maxlogdet_weighting_name(value) == std::string(to_string(static_cast<Weighting>(value))),
          "names of weightings are those of C++", value);
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
  check_null_good_features(options);
  require(maxlogdet_selection_has_answer(nullptr) == 0 && std::isnan(maxlogdet_selection_certified_efficiency(nullptr)),
          "no selection is no answer");
  require(maxlogdet_append_blocks(nullptr, nullptr, nullptr, nullptr, store, nullptr)->error == refused, property);
  require(maxlogdet_isa_is_supported(nullptr) == 0, "no name is no instruction set");
}

}  // namespace maxlogdet::fuzz
