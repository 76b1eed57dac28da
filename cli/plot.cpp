// SPDX-License-Identifier: MIT
#include "cli/plot.hpp"

#include "sim/frame_reader.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <vector>

namespace maxlogdet::cli {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

std::string terminal_of(const std::string& file) {
  const std::string ending = std::filesystem::path(file).extension().string();
  if (ending == ".svg") return "svg size 1200,480 dynamic noenhanced font 'sans-serif,14' background 'white'";
  if (ending == ".png") return "pngcairo size 1200,480 noenhanced font 'sans-serif,11' background 'white'";
  throw sim::InputError(file + ": expected a plot file that ends in .svg or .png");
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

std::string script(const sim::Frame& frame, const Selection& selection, const std::string& file) {
  std::vector<bool> is_selected(frame.matches.size());
  for (const std::uint32_t index : selection) is_selected[index] = true;

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
  double depth = std::max(quantile(depths, 0.97), 1.0);
  double side = std::max(quantile(sides, 0.97), 1.0);
  for (const std::uint32_t index : selection) {
    depth = std::max(depth, depths[index]);
    side = std::max(side, sides[index]);
  }
  depth *= 1.05;
  side *= 1.05;

  std::ostringstream out;
  out << "set terminal " << terminal_of(file) << "\nset output " << quoted(file) << '\n';
  for (int s = 0; s < 2; ++s) {
    out << (s == 0 ? "$unselected" : "$selected") << " << EOD\n" << data[s].str();
    if (data[s].str().empty()) out << "NaN NaN NaN NaN\n";
    out << "EOD\n";
  }
  out << "set multiplot layout 1,2 title "
      << quoted(frame.name + ": " + std::to_string(selection.size) + " of " + std::to_string(frame.matches.size()) +
                " matches selected")
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

void check_plot_file(const std::string& file) {
  terminal_of(file);
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw sim::InputError(file + ": is a folder; expected a plot file");
  const std::string folder = std::filesystem::path(file).parent_path().string();
  if (access(folder.empty() ? "." : folder.c_str(), W_OK) != 0) {
    throw sim::InputError(file + ": cannot be written; expected a folder that exists and can be written to");
  }
}

void plot_selection(const sim::Frame& frame, const Selection& selection, const std::string& file) {
  const std::string commands = script(frame, selection, file);
  const auto previous = std::signal(SIGPIPE, SIG_IGN);  // a gnuplot that is not there shows in its exit code
  std::FILE* const gnuplot = popen("gnuplot 2>/dev/null", "w");
  bool is_drawn = gnuplot != nullptr && std::fwrite(commands.data(), 1, commands.size(), gnuplot) == commands.size();
  is_drawn = gnuplot != nullptr && pclose(gnuplot) == 0 && is_drawn;
  std::signal(SIGPIPE, previous);
  if (!is_drawn) {
    throw sim::InputError(file +
                          ": gnuplot could not draw it; expected gnuplot to be installed (Debian: apt-get install "
                          "gnuplot-nox) and the file to be writable");
  }
}

}  // namespace maxlogdet::cli
