// SPDX-License-Identifier: MIT
#include "bench/world/frame_reader.hpp"

#include "bench/world/csv.hpp"
#include "bench/world/frame_comments.hpp"
#include "bench/world/text.hpp"
#include "bench/world/text_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

namespace maxlogdet::sim {
namespace {

// All columns of docs/frame_format.md; other readers use those that are ignored here.
constexpr std::string_view known_columns[] = {
    "kp",     "mp_id",       "X",          "Y",         "Z",          "u",         "v",
    "octave", "u_right",     "depth",      "cov_xx",    "cov_xy",     "cov_xz",    "cov_yy",
    "cov_yz", "cov_zz",      "inv_sigma2", "desc_dist", "camera",     "keyframe",  "src",
    "n_obs",  "found_ratio", "response",   "selected",  "chi2_prior", "chi2_post", "outlier_post"};

constexpr std::size_t most_matches = 1000000;  // of a file that may never end

constexpr const char* covariance_columns[] = {"cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"};

// As numpy.savetxt writes it.
bool is_header_behind_sign(std::string_view line) {
  if (!is_comment(line)) return false;
  const std::vector<std::string> names = split_csv(line.substr(line.find('#') + 1));
  return std::count(names.begin(), names.end(), "mp_id") + std::count(names.begin(), names.end(), "X") == 2;
}

class FrameReader {
 public:
  explicit FrameReader(const std::string& file) : file_(file, "frame file") {
    frame_.name = std::filesystem::path(file).stem().string();
  }

  Frame read() {
    while (const auto line = file_.next()) {
      if (is_empty_row(*line) || line->substr(0, 4) == "sep=") continue;
      if (names_.empty() && is_header_behind_sign(*line)) {
        read_header(line->substr(line->find('#') + 1));
      } else if (is_comment(*line) && !is_row(*line)) {
        read_comment(*line);
      } else if (names_.empty()) {
        read_header(*line);
      } else {
        read_match(*line);
      }
    }
    require(comments_.has_camera(), "a comment '# fx,fy,cx,cy,bf: ...' or '# camera: ...'");
    require(comments_.has("Tcw_prior"), "a comment '# Tcw_prior: ...' with the pose to linearise at");
    require(!names_.empty(), "a header line that names the columns, then one row a match");
    if (has_covariances_) frame_.map_covariances = std::move(covariances_);
    return std::move(frame_);
  }

 private:
  void require(bool condition, const std::string& expected) const {
    if (!condition) file_.fail_at_end(expected);
  }

  // Also one that begins with #REF! or another text that is not read.
  bool is_row(std::string_view line) const {
    if (names_.empty() || comment_of(line)) return false;
    const std::vector<std::string> fields = split_csv(line, separator_);
    return fields.size() >= names_.size() && finite_number(fields[column_.find("X")->second]) &&
           finite_number(fields[column_.find("u")->second]);
  }

  // Comments with other names are skipped.
  void read_comment(std::string_view line) {
    const std::optional<Comment> comment = comment_of(line);
    if (!comment) return;
    if (!names_.empty() && FrameComments::decides_rows(comment->name)) {
      file_.fail("the comment '" + comment->name + "' above the header");
    }
    comments_.read(*comment, file_, frame_);
  }

  // Columns without a name are the index of pandas or R.
  void read_header(std::string_view line) {
    separator_ = separator_of(line);
    names_ = split_csv(line, separator_);
    while (!names_.empty() && names_.back().empty()) names_.pop_back();
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const std::string& name = names_[i];
      if (name.empty()) continue;
      if (!column_.emplace(name, i).second) file_.fail("each column once, not " + shown(name) + " twice");
      if (std::find(std::begin(known_columns), std::end(known_columns), name) == std::end(known_columns)) {
        frame_.unknown_columns.push_back(name);
      }
    }
    for (const char* name : {"mp_id", "X", "Y", "Z", "u", "v"}) {
      if (!has_column(name))
        file_.fail("a header line with the columns mp_id,X,Y,Z,u,v; '" + std::string(name) + "' is missing");
    }
    const auto given = std::count_if(std::begin(covariance_columns), std::end(covariance_columns),
                                     [this](const char* name) { return has_column(name); });
    if (given != 0 && given != 6) file_.fail("all six columns cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz, or none");
    frame_.has_quality = has_column("desc_dist");
    frame_.has_selection = has_column("selected");
  }

  bool has_column(const char* name) const { return column_.count(name) != 0; }

  // Of a required column.
  const std::string& field(const char* name) const { return fields_[column_.find(name)->second]; }
  double number(const char* name) const { return file_.number(field(name), name); }

  // Of another one, which a file, or a row, may lack.
  bool has_value(const char* name) const { return has_column(name) && !is_missing(field(name)); }
  double number_or(const char* name, double fallback) const { return has_value(name) ? number(name) : fallback; }
  std::int64_t integer_or(const char* name, std::int64_t fallback) const {
    return has_value(name) ? integer(file_, field(name), name) : fallback;
  }

  std::int64_t integer_within(const char* name, std::int64_t low, std::int64_t high,
                              const std::string& expected) const {
    const std::int64_t number = integer_or(name, low);
    if (number < low || number > high) file_.fail(expected);
    return number;
  }

  bool is_true(const char* name) const {
    if (!has_value(name)) return false;
    const std::string text = lower_case(field(name));
    if (text == "true" || text == "false" || text == "t" || text == "f") return text[0] == 't';
    const std::int64_t number = whole_number(text).value_or(-1);
    if (number < 0 || number > 1) file_.fail(std::string("0 or 1 for ") + name + ", not " + shown(field(name)));
    return number == 1;
  }

  void read_fields(std::string_view line) {
    fields_ = split_csv(line, separator_);
    while (fields_.size() > names_.size() && fields_.back().empty()) fields_.pop_back();
    if (fields_.size() == names_.size()) return;
    const bool has_row_name = fields_.size() == names_.size() + 1;
    file_.fail(std::to_string(names_.size()) + " fields as in the header, not " + std::to_string(fields_.size()) +
               (has_row_name ? " (of R: write.csv, or row.names = FALSE)" : ""));
  }

  void read_match(std::string_view line) {
    read_fields(line);
    if (frame_.matches.size() == most_matches) file_.fail("at most a million matches");
    Match match;
    match.keypoint = integer_or("kp", static_cast<std::int64_t>(frame_.matches.size()));
    match.map_point_id = integer(file_, field("mp_id"), "mp_id");
    match.point[0] = number("X");
    match.point[1] = number("Y");
    match.point[2] = number("Z");
    match.u = number("u");
    match.v = number("v");
    match.octave = static_cast<int>(integer_within("octave", 0, 63, "an octave from 0 to 63"));
    match.u_right = number_or("u_right", -1);
    match.inv_sigma2 = number_or("inv_sigma2", 1);
    if (!(match.inv_sigma2 > 0)) file_.fail("a positive inv_sigma2");
    match.desc_dist = number_or("desc_dist", 0);
    match.keyframe = integer_or("keyframe", -1);
    match.is_selected = is_true("selected");
    const auto cameras = static_cast<std::int64_t>(std::max<std::size_t>(frame_.camera.rig.size(), 1));
    match.camera_id = static_cast<std::uint8_t>(
        integer_within("camera", 0, cameras - 1, "a camera from 0 to " + std::to_string(cameras - 1)));
    read_third(match);
    frame_.matches.push_back(match);
    frame_.has_quality = frame_.has_quality && has_value("desc_dist");
    frame_.has_selection = frame_.has_selection && has_value("selected");
    read_covariance();
  }

  void read_third(Match& match) const {
    const FrameCamera& camera = frame_.camera;
    const double depth = number_or("depth", -1);
    if (camera.depth_sigma > 0) match.depth = depth;
    if (!match.is_stereo() || camera.is_pinhole()) return;
    file_.fail("a negative u_right, or no such column, with '# depth_sigma', '# camera' or a rig");
  }

  // The upper triangle, row by row; cov_xx < 0: unknown.
  void read_covariance() {
    if (!has_column(covariance_columns[0])) return;
    const double xx = number_or("cov_xx", -1);
    const bool is_known = xx >= 0;
    const auto other = [&](const char* name) { return is_known ? number(name) : 0; };
    const double xy = other("cov_xy"), xz = other("cov_xz"), yy = other("cov_yy"), yz = other("cov_yz"),
                 zz = other("cov_zz");
    if (is_known && (yy < 0 || zz < 0)) file_.fail("variances cov_yy and cov_zz of 0 or more");
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    covariances_.push_back(is_known ? std::array<double, 9>{xx, xy, xz, xy, yy, yz, xz, yz, zz}
                                    : std::array<double, 9>{unknown});
    has_covariances_ = has_covariances_ || is_known;
  }

  TextFile file_;
  FrameComments comments_;
  std::vector<std::string> names_;  // of the columns
  std::map<std::string, std::size_t, std::less<>> column_;
  char separator_ = ',';
  std::vector<std::string> fields_;  // of a row
  std::vector<std::array<double, 9>> covariances_;
  bool has_covariances_ = false;
  Frame frame_;
};

// Without a size the image is what the matches of all frames of a folder extend over, whatever their unit.
void complete_sizes(std::vector<Frame>& frames) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double left = infinity, top = infinity, right = -infinity, bottom = -infinity;
  for (const Frame& frame : frames) {
    for (const Match& match : frame.matches) {
      left = std::min(left, match.u);
      top = std::min(top, match.v);
      right = std::max(right, match.u);
      bottom = std::max(bottom, match.v);
    }
  }
  for (Frame& frame : frames) {
    if (frame.width > 0 || !(left <= right)) continue;
    frame.left = left;
    frame.top = top;
    frame.width = right - left;
    frame.height = bottom - top;
  }
}

}  // namespace

std::vector<Frame> read_frames(const std::vector<std::string>& files) {
  std::vector<Frame> frames;
  for (const std::string& file : files) frames.push_back(FrameReader(file).read());
  complete_sizes(frames);
  return frames;
}

Frame read_frame(const std::string& file) { return std::move(read_frames(std::vector<std::string>{file}).front()); }

std::vector<Frame> read_frames(const std::string& file_or_folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(file_or_folder, error)) return {read_frame(file_or_folder)};
  return read_frames(files_of(file_or_folder, "frame_", ".csv"));
}

}  // namespace maxlogdet::sim
