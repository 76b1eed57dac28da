// SPDX-License-Identifier: MIT
#include "cli/plot.hpp"

#include "sim/gnuplot.hpp"
#include "sim/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace maxlogdet::cli {
namespace {

std::string script(const sim::Frame& frame, const std::vector<std::uint32_t>& selected) {
  std::vector<bool> is_selected(frame.matches.size());
  for (const std::uint32_t index : selected) is_selected[index] = true;

  std::ostringstream data[2];
  std::vector<double> depths;
  std::vector<double> sides;
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    const auto& match = frame.matches[i];
    const auto p = in_camera(frame, match);
    depths.push_back(p[2]);
    sides.push_back(std::abs(p[0]));
    data[is_selected[i] ? 1 : 0] << p[0] << ' ' << p[2] << ' ' << match.u << ' ' << match.v << '\n';
  }
  // A few points at hundreds of metres would squeeze all the others into a corner: the map view reaches as far as 97 %
  // of them, and as the selected ones.
  double depth = depths.empty() ? 1 : std::max(sim::quantile_of(depths, 0.97), 1.0);
  double side = sides.empty() ? 1 : std::max(sim::quantile_of(sides, 0.97), 1.0);
  for (const std::uint32_t index : selected) {
    depth = std::max(depth, depths[index]);
    side = std::max(side, sides[index]);
  }
  depth *= 1.05;
  side *= 1.05;

  std::ostringstream out;
  for (int s = 0; s < 2; ++s) {
    out << (s == 0 ? "$unselected" : "$selected") << " << EOD\n" << data[s].str();
    if (data[s].str().empty()) out << "NaN NaN NaN NaN\n";
    out << "EOD\n";
  }
  out << "set multiplot layout 1,2 title "
      << sim::quoted(frame.name + ": " + std::to_string(selected.size()) + " of " +
                     std::to_string(frame.matches.size()) + " matches selected")
      << "\nset style line 1 lc rgb '#3465c4' pt 7 ps 0.3\nset style line 2 lc rgb '#d62020' pt 7 ps 0.6\n"
      << "set tics nomirror out\nset key outside bottom center horizontal\n"
      << "set title 'map view (from above, camera at the bottom)'\nset xlabel 'right (m)'\nset ylabel 'forward "
         "(m)'\n"
      << "set xrange [" << -side << ':' << side << "]\nset yrange [0:" << depth << "]\n"
      << "plot $unselected using 1:2 with points ls 1 title 'unselected', "
      << "$selected using 1:2 with points ls 2 title 'selected', "
      << "'-' using 1:2 with points lc rgb 'black' pt 9 ps 1.5 notitle\n0 0\ne\n"
      << "set title 'camera view'\nset xlabel 'u (px)'\nset ylabel 'v (px)'\n"
      << "set xrange [0:" << frame.width << "]\nset yrange [" << frame.height << ":0]\nset size ratio "
      << static_cast<double>(frame.height) / frame.width << '\n'
      << "plot $unselected using 3:4 with points ls 1 title 'unselected', "
      << "$selected using 3:4 with points ls 2 title 'selected'\nunset multiplot\n";
  return out.str();
}

}  // namespace

void plot_selection(const sim::Frame& frame, const std::vector<std::uint32_t>& selected, const std::string& file) {
  sim::draw(script(frame, selected), file, 1200, 480);
}

}  // namespace maxlogdet::cli
