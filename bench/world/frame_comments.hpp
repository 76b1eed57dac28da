// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/text_file.hpp"

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace maxlogdet::sim {

/// A comment `# NAME (remark): VALUES`.
struct Comment {
  std::string name;  ///< without blanks
  std::vector<std::string> values;
};

/// Returns whether a line is a comment, perhaps in quotes.
bool is_comment(std::string_view line);

/// Returns the comment that a line is, also if a spreadsheet has divided it into fields; nothing if it has no values.
std::optional<Comment> comment_of(std::string_view line);

/// Returns the integer that a field of the last line is; otherwise fails with a message that names `what`.
std::int64_t integer(const TextFile& file, std::string_view field, const std::string& what);

/// The comment lines of a frame file (docs/frame_format.md): camera, image and poses.
class FrameComments {
 public:
  /// Takes a comment's values into the frame; comments of other names are skipped. Throws InputError.
  void read(const Comment& comment, const TextFile& file, Frame& frame);

  /// Returns whether rows depend on the comment, which therefore has to come before them.
  static bool decides_rows(const std::string& name);

  bool has(const std::string& name) const { return seen_.count(name) != 0; }
  bool has_camera() const { return has("fx,fy,cx,cy,bf") || has("camera") || has("camera0"); }

 private:
  void read_camera_of_rig(const Comment& comment, const TextFile& file, Frame& frame) const;

  std::set<std::string> seen_;
};

}  // namespace maxlogdet::sim
