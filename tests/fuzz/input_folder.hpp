// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/input_error.hpp"
#include "tests/fuzz/require.hpp"

#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace maxlogdet::fuzz {

/// A folder for this process alone, for readers of files; in memory unless TMPDIR names a place. Removed when
/// destroyed.
class InputFolder {
 public:
  InputFolder() {
    namespace fs = std::filesystem;
    const char* const in_memory = "/dev/shm";
    const bool is_told = std::getenv("TMPDIR") != nullptr || access(in_memory, W_OK) != 0;
    path_ = (is_told ? fs::temp_directory_path() : fs::path(in_memory)) / "maxlogdet_fuzz_XXXXXX";
    require(mkdtemp(path_.data()) != nullptr, "a folder can be made as", path_);
  }
  ~InputFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  std::string path(const std::string& name) const { return path_ + "/" + name; }

  void make_folder(const std::string& name) const { std::filesystem::create_directories(path(name)); }

  void write(const std::string& name, std::string_view bytes) const {
    std::ofstream stream(path(name), std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    require(!stream.fail(), "a file can be written:", path(name));
  }

  void remove(const std::string& name) const {
    std::error_code error;
    std::filesystem::remove(path(name), error);
  }

 private:
  std::string path_;
};

/// Calls read(), which returns or throws an InputError of one line that begins with `place`; true if it returned.
template <class Read>
bool reads(const Read& read, const std::string& place) {
  try {
    read();
    return true;
  } catch (const sim::InputError& error) {
    const std::string message = error.what();
    require(message.rfind(place, 0) == 0, "an error begins with the file's name:", message);
    require(message.find('\n') == std::string::npos, "an error is one line:", message);
    require(message.find("expected") != std::string::npos, "an error tells what was expected:", message);
  } catch (const std::exception& error) {
    fail("a reader throws nothing but InputError:", error.what());
  }
  return false;
}

}  // namespace maxlogdet::fuzz
