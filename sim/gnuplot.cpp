// SPDX-License-Identifier: MIT
#include "sim/gnuplot.hpp"

#include "sim/table.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>

namespace maxlogdet::sim {
namespace {

std::string terminal_of(const std::string& file, int width, int height) {
  const std::string size = std::to_string(width) + "," + std::to_string(height);
  const std::string ending = std::filesystem::path(file).extension().string();
  if (ending == ".svg") return "svg size " + size + " dynamic noenhanced font 'sans-serif,14' background 'white'";
  if (ending == ".png") return "pngcairo size " + size + " noenhanced font 'sans-serif,11' background 'white'";
  throw InputError(file + ": expected a plot file that ends in .svg or .png");
}

// What gnuplot draws, from its standard output. Writing it to a file is not left to gnuplot: it would not tell of a
// full disk, and draw to standard output where it could not open the file.
std::string picture_of(const std::string& commands, const std::string& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> script(std::tmpfile(), &std::fclose);
  if (!script || std::fwrite(commands.data(), 1, commands.size(), script.get()) != commands.size() ||
      std::fflush(script.get()) != 0) {
    throw InputError(file + ": cannot be drawn; expected room for a temporary file");
  }
  std::rewind(script.get());
  const std::string command = "exec gnuplot 2>/dev/null </dev/fd/" + std::to_string(fileno(script.get()));
  std::FILE* const gnuplot = popen(command.c_str(), "r");
  std::string picture;
  char part[4096];
  while (gnuplot != nullptr) {
    const std::size_t size = std::fread(part, 1, sizeof part, gnuplot);
    if (size == 0) break;
    picture.append(part, size);
  }
  if (gnuplot == nullptr || pclose(gnuplot) != 0 || picture.empty()) {
    throw DrawError(file +
                    ": gnuplot could not draw it; expected gnuplot to be installed (Debian: apt-get install "
                    "gnuplot-nox)");
  }
  return picture;
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
  const std::filesystem::file_status there = std::filesystem::status(file, error);
  if (std::filesystem::is_directory(there)) throw InputError(file + ": is a folder; expected a plot file");
  const std::string folder = std::filesystem::path(file).parent_path().string();
  const bool is_possible = there.type() != std::filesystem::file_type::none;  // as a name that is too long
  const std::string& written = std::filesystem::exists(there) ? file : folder.empty() ? "." : folder;
  if (!is_possible || access(written.c_str(), W_OK) != 0) {
    throw InputError(file + ": cannot be written; expected a folder that exists and can be written to");
  }
}

void draw(const std::string& script, const std::string& file, int width, int height) {
  write_file(file, picture_of("set terminal " + terminal_of(file, width, height) + '\n' + script, file));
}

}  // namespace maxlogdet::sim
