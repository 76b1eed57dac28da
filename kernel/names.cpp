// SPDX-License-Identifier: MIT
#include <maxlogdet/alignment.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/status.hpp>
#include <maxlogdet/version.hpp>

namespace maxlogdet {

const char* version() noexcept { return MAXLOGDET_VERSION; }

const char* to_string(Strategy strategy) noexcept {
#define MAXLOGDET_CASE(name) \
  case Strategy::name: return #name;
  switch (strategy) { MAXLOGDET_STRATEGIES(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

const char* to_string(Status status) noexcept {
  switch (status) {
    case Status::ok: return "ok";
    case Status::all_selected: return "all_selected";
    case Status::target_reached: return "target_reached";
    case Status::deadline_reached: return "deadline_reached";
    case Status::few_candidates: return "few_candidates";
    case Status::few_inliers: return "few_inliers";
    case Status::error: return "error";
  }
  return "unknown";
}

const char* to_string(AlignmentStatus status) noexcept {
  switch (status) {
    case AlignmentStatus::none: return "none";
    case AlignmentStatus::aligned: return "aligned";
    case AlignmentStatus::few_matches: return "few_matches";
    case AlignmentStatus::no_consensus: return "no_consensus";
    case AlignmentStatus::singular: return "singular";
    case AlignmentStatus::not_converged: return "not_converged";
  }
  return "unknown";
}

const char* to_string(Error error) noexcept {
#define MAXLOGDET_CASE(name, explanation) \
  case Error::name: return #name;
  switch (error) { MAXLOGDET_ERRORS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

const char* explain(Error error) noexcept {
#define MAXLOGDET_CASE(name, explanation) \
  case Error::name: return explanation;
  switch (error) { MAXLOGDET_ERRORS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

const char* to_string(Warning warning) noexcept {
#define MAXLOGDET_CASE(name, explanation) \
  case Warning::name: return #name;
  switch (warning) { MAXLOGDET_WARNINGS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

const char* explain(Warning warning) noexcept {
#define MAXLOGDET_CASE(name, explanation) \
  case Warning::name: return explanation;
  switch (warning) { MAXLOGDET_WARNINGS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

}  // namespace maxlogdet
