// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace maxlogdet::sim {

/// Writes a file, and replaces an old one only when the new one is complete. Throws InputError if it cannot be written,
/// and then leaves the old one.
void write_file(const std::string& file, const std::string& text);

/// Throws InputError if it is clear beforehand that the file cannot be written.
void check_output_file(const std::string& file);

/// Throws the InputError of a file that could not be written, with the cause that errno names.
[[noreturn]] void fail_to_write(const std::string& file);

}  // namespace maxlogdet::sim
