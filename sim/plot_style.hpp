// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace maxlogdet::sim {

/// What all pictures of experiments share: grid, tics, key.
std::string plot_style();

/// Line and point of a metric or selector, the same in every picture. Okabe and Ito's colours: told apart by all eyes.
std::string line_style(const std::string& name);

/// The colour alone, as gnuplot writes it: '#rrggbb' with quotes.
std::string colour_of(const std::string& name);

}  // namespace maxlogdet::sim
