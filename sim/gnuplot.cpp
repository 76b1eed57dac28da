// SPDX-License-Identifier: MIT
#include "sim/gnuplot.hpp"

#include "sim/frame_reader.hpp"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>

namespace maxlogdet::sim {
namespace {

std::string terminal_of(const std::string& file, int width, int height) {
  const std::string size = std::to_string(width) + "," + std::to_string(height);
  const std::string ending = std::filesystem::path(file).extension().string();
  if (ending == ".svg") return "svg size " + size + " dynamic noenhanced font 'sans-serif,14' background 'white'";
  if (ending == ".png") return "pngcairo size " + size + " noenhanced font 'sans-serif,11' background 'white'";
  throw InputError(file + ": expected a plot file that ends in .svg or .png");
}

}  // namespace

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

void check_plot_file(const std::string& file) {
  terminal_of(file, 1, 1);
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw InputError(file + ": is a folder; expected a plot file");
  const std::string folder = std::filesystem::path(file).parent_path().string();
  if (access(folder.empty() ? "." : folder.c_str(), W_OK) != 0) {
    throw InputError(file + ": cannot be written; expected a folder that exists and can be written to");
  }
}

void draw(const std::string& script, const std::string& file, int width, int height) {
  const std::string commands =
      "set terminal " + terminal_of(file, width, height) + "\nset output " + quoted(file) + '\n' + script;
  const auto previous = std::signal(SIGPIPE, SIG_IGN);  // a gnuplot that is not there shows in its exit code
  std::FILE* const gnuplot = popen("gnuplot 2>/dev/null", "w");
  bool is_drawn = gnuplot != nullptr && std::fwrite(commands.data(), 1, commands.size(), gnuplot) == commands.size();
  is_drawn = gnuplot != nullptr && pclose(gnuplot) == 0 && is_drawn;
  std::signal(SIGPIPE, previous);
  if (!is_drawn) {
    std::remove(file.c_str());  // half a picture
    throw InputError(file +
                     ": gnuplot could not draw it; expected gnuplot to be installed (Debian: apt-get install "
                     "gnuplot-nox) and the file to be writable");
  }
}

}  // namespace maxlogdet::sim
