// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/evaluation.hpp"
#include "bench/world/table.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace maxlogdet::sim {

/// One object (docs/evaluate.md); lengths in mm and mrad, null for what is unknown.
nlohmann::ordered_json to_json(const Evaluation& evaluation);

/// The verdict, what the frames are, and the tables, as a terminal shows them.
std::string to_text(const Evaluation& evaluation);

/// Every number of every selector and budget; and chi2 by leverage: for CSV.
Table deviation_table(const Evaluation& evaluation);
Table leverage_table(const Evaluation& evaluation);

}  // namespace maxlogdet::sim
