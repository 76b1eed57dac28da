// SPDX-License-Identifier: MIT
#include "sim/plot_style.hpp"

#include <map>

namespace maxlogdet::sim {
namespace {

struct Style {
  const char* colour;
  const char* rest;
};

const Style& style_of(const std::string& name) {
  static const std::map<std::string, Style> styles = {
      {"max_log_det", {"#d55e00", "dt 1 lw 2.5 pt 7"}},
      {"max_trace", {"#0072b2", "dt 1 lw 1.5 pt 5"}},
      {"min_condition", {"#009e73", "dt 1 lw 1.5 pt 9"}},
      {"max_min_eigenvalue", {"#cc79a7", "dt 1 lw 1.5 pt 11"}},
      {"md", {"#d55e00", "dt 1 lw 2.5 pt 7"}},
      {"quality_md", {"#e69f00", "dt 1 lw 1.5 pt 13"}},
      {"quality", {"#0072b2", "dt 1 lw 1.5 pt 5"}},
      {"bucket", {"#009e73", "dt 1 lw 1.5 pt 9"}},
      {"observability", {"#cc79a7", "dt 1 lw 1.5 pt 11"}},
      {"random", {"#808080", "dt 3 lw 1.5 pt 1"}},
      {"inl", {"#d62020", "dt 2 lw 2 pt 2"}},
      {"all", {"#000000", "dt 1 lw 2 pt 3"}},
      {"all_weighted", {"#56b4e9", "dt 2 lw 2 pt 4"}},
      {"leverage", {"#b0a000", "dt 3 lw 1.5 pt 8"}},
      {"half_random", {"#a0522d", "dt 2 lw 1.5 pt 10"}},
      {"md_cells", {"#8e44ad", "dt 2 lw 1.5 pt 4"}},
      {"md_keyframes", {"#0072b2", "dt 2 lw 1.5 pt 6"}},
      {"shared_cells", {"#8e44ad", "dt 1 lw 2 pt 5"}},
      {"shared_keyframes", {"#0072b2", "dt 1 lw 2 pt 7"}},
      {"active", {"#8a2be2", "dt 1 lw 2 pt 12"}},
  };
  static const Style other = {"#404040", "dt 1 lw 1 pt 6"};
  const auto found = styles.find(name);
  return found == styles.end() ? other : found->second;
}

}  // namespace

std::string plot_style() {
  return "set encoding utf8\nset grid lc rgb '#e0e0e0' lw 0.7\nset tics nomirror out\nset border 3\n"
         "set key outside right center reverse Left spacing 1.2\n";
}

std::string colour_of(const std::string& name) { return std::string("'") + style_of(name).colour + "'"; }

std::string line_style(const std::string& name) {
  return "lc rgb " + colour_of(name) + " " + style_of(name).rest + " ps 0.7";
}

}  // namespace maxlogdet::sim
