// SPDX-License-Identifier: MIT
#include "tests/fuzz/c_api_misuse.hpp"

#include "tests/fuzz/c_api_given.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cmath>
#include <cstring>
#include <string>

namespace maxlogdet::fuzz {
namespace {

using NullCalls = std::vector<NullCall>;

constexpr int refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;
constexpr double block[6] = {1, 2, 3, 4, 5, 6};
constexpr double poses[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr const double* pose = poses;

bool is_told(const char* reason) { return std::strcmp(reason, "invalid_argument") == 0; }

bool destroys_nothing() {
  maxlogdet_block_store_destroy(nullptr);
  maxlogdet_selector_destroy(nullptr);
  maxlogdet_active_selection_destroy(nullptr);
  maxlogdet_good_features_destroy(nullptr);
  return true;
}

NullCalls of_stores_and_selectors(maxlogdet_block_store* store, maxlogdet_selector* selector) {
  const auto options = defaults_of(maxlogdet_options_init);
  return {{"destroy", destroys_nothing()},
          {"block_store_create", maxlogdet_block_store_create(1, nullptr) == refused},
          {"block_store_reserve", maxlogdet_block_store_reserve(nullptr, 1) == refused},
          {"block_store_clear", maxlogdet_block_store_clear(nullptr) == refused},
          {"block_store_push_back", maxlogdet_block_store_push_back(nullptr, block, 1) == refused},
          {"block_store_push_back_invalid", maxlogdet_block_store_push_back_invalid(nullptr) == refused},
          {"block_store_size", maxlogdet_block_store_size(nullptr) == 0},
          {"block_store_capacity", maxlogdet_block_store_capacity(nullptr) == 0},
          {"block_store_rows", maxlogdet_block_store_rows(nullptr) == 0},
          {"block_store_is_valid", maxlogdet_block_store_is_valid(nullptr, 0) == 0},
          {"block_store_invalid_count", maxlogdet_block_store_invalid_count(nullptr) == 0},
          {"selector_create", maxlogdet_selector_create(1, nullptr, nullptr) == refused},
          {"selector_capacity", maxlogdet_selector_capacity(nullptr) == 0},
          {"select without a selector", is_refusal(maxlogdet_selector_select(nullptr, store, &options))},
          {"select without a store", is_refusal(maxlogdet_selector_select(selector, nullptr, &options))},
          {"select without options", is_refusal(maxlogdet_selector_select(selector, store, nullptr))},
          {"selection_has_answer", maxlogdet_selection_has_answer(nullptr) == 0},
          {"selection_reason", is_told(maxlogdet_selection_reason(nullptr))},
          {"selection_certified_efficiency", std::isnan(maxlogdet_selection_certified_efficiency(nullptr))},
          {"isa_is_supported", maxlogdet_isa_is_supported(nullptr) == 0}};
}

NullCalls of_blocks(maxlogdet_block_store* store) {
  auto camera = defaults_of(maxlogdet_camera_init);
  camera.fx = camera.fy = 450;
  const maxlogdet_camera* const cameras[2] = {&camera, nullptr};
  const auto options = defaults_of(maxlogdet_block_options_init);
  const double point[3] = {0, 0, 5};
  auto matches = defaults_of(maxlogdet_matches_init);
  matches.size = 1;
  auto no_points = matches;
  matches.points = point;
  double to = 7;
  return {
      {"append_blocks without a camera",
       maxlogdet_append_blocks(nullptr, pose, &matches, &options, store, nullptr)->error == refused},
      {"append_blocks without matches",
       maxlogdet_append_blocks(&camera, pose, nullptr, &options, store, nullptr)->error == refused},
      {"append_blocks without options",
       maxlogdet_append_blocks(&camera, pose, &matches, nullptr, store, nullptr)->error == refused},
      {"append_blocks without a store",
       maxlogdet_append_blocks(&camera, pose, &matches, &options, nullptr, nullptr)->error == refused},
      {"append_blocks_of_rig without cameras",
       maxlogdet_append_blocks_of_rig(nullptr, pose, 1, pose, &matches, &options, store, nullptr)->error == refused},
      {"append_blocks_of_rig without T_cb",
       maxlogdet_append_blocks_of_rig(cameras, nullptr, 1, pose, &matches, &options, store, nullptr)->error == refused},
      {"append_blocks_of_rig without its second camera",
       maxlogdet_append_blocks_of_rig(cameras, poses, 2, pose, &matches, &options, store, nullptr)->error == refused},
      {"append_blocks_of_rig without a store",
       maxlogdet_append_blocks_of_rig(cameras, pose, 1, pose, &matches, &options, nullptr, nullptr)->error == refused},
      {"match_information without a camera",
       maxlogdet_match_information(nullptr, pose, &matches, 0, &options, &to) == 0},
      {"match_information without a pose",
       maxlogdet_match_information(&camera, nullptr, &matches, 0, &options, &to) == 0},
      {"match_information without matches", maxlogdet_match_information(&camera, pose, nullptr, 0, &options, &to) == 0},
      {"match_information without points",
       maxlogdet_match_information(&camera, pose, &no_points, 0, &options, &to) == 0},
      {"match_information without options", maxlogdet_match_information(&camera, pose, &matches, 0, nullptr, &to) == 0},
      {"match_information to nowhere", maxlogdet_match_information(&camera, pose, &matches, 0, &options, nullptr) == 0},
      {"match_information of no match", maxlogdet_match_information(&camera, pose, &matches, 1, &options, &to) == 0},
      {"match_whitening", maxlogdet_match_whitening(nullptr, pose, &matches, 0, &options, &to) == 0},
      {"nothing is written", to == 7}};
}

bool proposes_nothing(maxlogdet_active_selection* active) {
  std::uint32_t index = 5;
  return maxlogdet_active_selection_next(active) == MAXLOGDET_NONE &&
         maxlogdet_active_selection_next_batch(active, &index, 1) == 0 && index == 5;
}

NullCalls of_active_selections(const maxlogdet_block_store* store) {
  const auto options = defaults_of(maxlogdet_options_init);
  const std::uint8_t matched[1] = {1};
  return {{"active_selection_create", maxlogdet_active_selection_create(1, nullptr) == refused},
          {"active_selection_capacity", maxlogdet_active_selection_capacity(nullptr) == 0},
          {"active_selection_start", maxlogdet_active_selection_start(nullptr, store, &options) == refused},
          {"active_selection_next", proposes_nothing(nullptr)},
          {"active_selection_accept", maxlogdet_active_selection_accept(nullptr) == refused},
          {"active_selection_accept_block", maxlogdet_active_selection_accept_block(nullptr, block, 1) == refused},
          {"active_selection_reject", maxlogdet_active_selection_reject(nullptr) == refused},
          {"active_selection_accept_index", maxlogdet_active_selection_accept_index(nullptr, 0) == refused},
          {"active_selection_accept_block_index",
           maxlogdet_active_selection_accept_block_index(nullptr, 0, block, 1) == refused},
          {"active_selection_reject_index", maxlogdet_active_selection_reject_index(nullptr, 0) == refused},
          {"active_selection_answer", maxlogdet_active_selection_answer(nullptr, matched, 1) == refused},
          {"active_selection_selection", is_refusal(maxlogdet_active_selection_selection(nullptr))}};
}

std::int32_t never(void* /*context*/, std::size_t i, maxlogdet_match* /*match*/) {
  fail("without a handle nothing is tried", i);
}

bool has_no_outliers(maxlogdet_good_features* good) {
  const std::uint32_t some = 0;
  const std::uint32_t* outliers = &some;
  return maxlogdet_good_features_outliers(good, pose, &outliers) == 0 && outliers == nullptr;
}

NullCalls of_good_features() {
  const auto camera = defaults_of(maxlogdet_camera_init);
  const maxlogdet_camera* const cameras[1] = {&camera};
  const auto match = defaults_of(maxlogdet_match_init);
  const auto options = defaults_of(maxlogdet_options_init);
  const auto block_options = defaults_of(maxlogdet_block_options_init);
  double to = 7;
  return {{"good_features_create", maxlogdet_good_features_create(1, nullptr, nullptr) == refused},
          {"good_features_set_block_options",
           maxlogdet_good_features_set_block_options(nullptr, &block_options) == refused},
          {"good_features_set_spread", maxlogdet_good_features_set_spread(nullptr, 1) == refused},
          {"good_features_set_weighted", maxlogdet_good_features_set_weighted(nullptr, 1) == refused},
          {"good_features_start", maxlogdet_good_features_start(nullptr, &camera, pose) == refused},
          {"good_features_start_rig", maxlogdet_good_features_start_rig(nullptr, cameras, pose, 1, pose) == refused},
          {"good_features_add", maxlogdet_good_features_add(nullptr, &match) == refused},
          {"good_features_size", maxlogdet_good_features_size(nullptr) == 0},
          {"good_features_id", maxlogdet_good_features_id(nullptr, 0) == MAXLOGDET_NONE},
          {"good_features_select", is_refusal(maxlogdet_good_features_select(nullptr, &options))},
          {"good_features_match", is_refusal(maxlogdet_good_features_match(nullptr, &options, never, nullptr))},
          {"good_features_selection", is_refusal(maxlogdet_good_features_selection(nullptr))},
          {"good_features_reason", is_told(maxlogdet_good_features_reason(nullptr))},
          {"good_features_is_selected", maxlogdet_good_features_is_selected(nullptr, 0) == 0},
          {"good_features_is_outlier", maxlogdet_good_features_is_outlier(nullptr, 0) == 0},
          {"good_features_block_report", maxlogdet_good_features_block_report(nullptr)->error == refused},
          {"good_features_efficiency", std::isnan(maxlogdet_good_features_efficiency(nullptr))},
          {"good_features_chi2", std::isnan(maxlogdet_good_features_chi2(nullptr, 0))},
          {"good_features_outliers", has_no_outliers(nullptr)},
          {"good_features_information", maxlogdet_good_features_information(nullptr, 0, &to) == 0},
          {"good_features_whitening", maxlogdet_good_features_whitening(nullptr, 0, &to) == 0},
          {"good_features_record", maxlogdet_good_features_record(nullptr, "folder") == 0}};
}

}  // namespace

std::vector<NullCall> call_with_nulls(maxlogdet_block_store* store, maxlogdet_selector* selector) {
  NullCalls all = of_good_features();
  for (const NullCalls& some :
       {of_stores_and_selectors(store, selector), of_blocks(store), of_active_selections(store)}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

bool is_refusal(const maxlogdet_selection* selection) {
  return selection != nullptr && selection->status == MAXLOGDET_STATUS_ERROR && selection->error == refused &&
         selection->size == 0 && selection->searched == 0 && selection->indices == nullptr &&
         std::isnan(selection->log_det) && std::isnan(selection->upper_bound) && std::isnan(selection->efficiency) &&
         std::isnan(selection->translation_sigma) && std::isnan(selection->rotation_sigma) && selection->threads == 1 &&
         is_told(maxlogdet_selection_reason(selection)) && maxlogdet_selection_has_answer(selection) == 0 &&
         std::isnan(maxlogdet_selection_certified_efficiency(selection));
}

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

}  // namespace maxlogdet::fuzz
