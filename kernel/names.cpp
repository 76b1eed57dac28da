// SPDX-License-Identifier: MIT
// What the library says of itself: the names of enumerators, its version, and its instruction sets.
#include "simd/kernel.hpp"

#include <maxlogdet/camera.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/status.hpp>
#include <maxlogdet/version.hpp>

#include <cstddef>
#include <cstring>

namespace maxlogdet {
namespace {

template <class Enumerator, std::size_t count>
const char* entry_of(const char* const (&entries)[count], Enumerator enumerator) noexcept {
  const auto i = static_cast<std::ptrdiff_t>(enumerator);
  return i >= 0 && i < static_cast<std::ptrdiff_t>(count) ? entries[i] : "unknown";
}

#define MAXLOGDET_NAME(name) #name,
#define MAXLOGDET_NAME_OF_PAIR(name, explanation) #name,
#define MAXLOGDET_EXPLANATION(name, explanation) explanation,
constexpr const char* models[] = {MAXLOGDET_CAMERA_MODELS(MAXLOGDET_NAME)};
constexpr const char* names_of_strategies[] = {MAXLOGDET_STRATEGIES(MAXLOGDET_NAME)};
constexpr const char* errors[] = {MAXLOGDET_ERRORS(MAXLOGDET_NAME_OF_PAIR)};
// NOLINTBEGIN(bugprone-suspicious-missing-comma): some are of two lines
constexpr const char* explanations_of_errors[] = {MAXLOGDET_ERRORS(MAXLOGDET_EXPLANATION)};
constexpr const char* warnings[] = {MAXLOGDET_WARNINGS(MAXLOGDET_NAME_OF_PAIR)};
constexpr const char* explanations_of_warnings[] = {MAXLOGDET_WARNINGS(MAXLOGDET_EXPLANATION)};
// NOLINTEND(bugprone-suspicious-missing-comma)
constexpr const char* statuses[] = {
    "ok", "all_selected", "target_reached", "deadline_reached", "few_candidates", "few_inliers", "error"};
static_assert(sizeof statuses / sizeof *statuses == static_cast<std::size_t>(Status::error) + 1, "a name for each");
constexpr const char* alignment_statuses[] = {"none",         "aligned",  "few_matches",
                                              "no_consensus", "singular", "not_converged"};
static_assert(sizeof alignment_statuses / sizeof *alignment_statuses ==
                  static_cast<std::size_t>(AlignmentStatus::not_converged) + 1,
              "a name for each");

}  // namespace

const char* version() noexcept { return MAXLOGDET_VERSION; }

const char* to_string(CameraModel model) noexcept { return entry_of(models, model); }
const char* to_string(Strategy strategy) noexcept { return entry_of(names_of_strategies, strategy); }
const char* to_string(Status status) noexcept { return entry_of(statuses, status); }
const char* to_string(AlignmentStatus status) noexcept { return entry_of(alignment_statuses, status); }
const char* to_string(Error error) noexcept { return entry_of(errors, error); }
const char* to_string(Warning warning) noexcept { return entry_of(warnings, warning); }
const char* explain(Error error) noexcept { return entry_of(explanations_of_errors, error); }
const char* explain(Warning warning) noexcept { return entry_of(explanations_of_warnings, warning); }

const char* active_isa() noexcept {
  const simd::Kernel* const kernel = simd::active();
  return kernel == nullptr ? "none" : kernel->isa;
}

const char* built_in_isa(int i) noexcept {
  const simd::Kernel* const* kernel = simd::built_in();
  for (; *kernel != nullptr && i > 0; --i) ++kernel;
  return i < 0 || *kernel == nullptr ? nullptr : (*kernel)->isa;
}

bool isa_is_supported(const char* name) noexcept {
  if (name == nullptr) return false;
  for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
    if (std::strcmp((*kernel)->isa, name) == 0) return simd::is_supported(**kernel);
  }
  return false;
}

}  // namespace maxlogdet
