// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace maxlogdet::sim {

/// Writes a whole file; an old one is replaced only when the new one is complete. Throws InputError if it cannot be
/// written, and then leaves what there was.
void write_file(const std::string& file, const std::string& text);

/// Throws InputError unless the file can be written as far as one can tell beforehand.
void check_output_file(const std::string& file);

/// Throws the InputError of a file that could not be written, with what errno says of it.
[[noreturn]] void fail_to_write(const std::string& file);

}  // namespace maxlogdet::sim
