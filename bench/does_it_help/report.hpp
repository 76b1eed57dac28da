// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/evaluation.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace maxlogdet::sim {

/// One object (docs/evaluate.md); null for what is unknown.
nlohmann::ordered_json to_json(const Evaluation& evaluation);

/// The verdict, the advice, what the frames are, and the tables, as a terminal shows them.
std::string to_text(const Evaluation& evaluation);

}  // namespace maxlogdet::sim
