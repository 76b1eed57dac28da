// SPDX-License-Identifier: MIT
#include "bench/world/frame_reader.hpp"

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

constexpr const char* covariance_columns[] = {"cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"};

class FrameReader {
 public:
  explicit FrameReader(const std::string& file) : file_(file, "frame file") {
    frame_.name = std::filesystem::path(file).stem().string();
  }

  Frame read() {
    while (const auto text = file_.next()) {
      if (text->front() == '#') {
        read_comment(text->substr(1));
      } else if (names_.empty()) {
        read_header(*text);
      } else {
        read_match(*text);
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

  // Comments with other names are skipped.
  void read_comment(std::string_view text) {
    const auto colon = text.rfind(':');
    if (colon == std::string_view::npos) return;
    const std::string name = comment_name(text.substr(0, colon));
    if (!names_.empty() && FrameComments::decides_rows(name)) file_.fail("the comment '" + name + "' above the header");
    comments_.read(name, text.substr(colon + 1), file_, frame_);
  }

  void read_header(std::string_view text) {
    const auto names = split_at_commas(text);
    names_.assign(names.begin(), names.end());
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!column_.emplace(names[i], i).second) file_.fail("each column once, not " + shown(names[i]) + " twice");
      if (std::find(std::begin(known_columns), std::end(known_columns), names[i]) == std::end(known_columns)) {
        frame_.unknown_columns.emplace_back(names[i]);
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

  double value(const char* name, double fallback) const {
    const auto column = column_.find(name);
    return column == column_.end() ? fallback : values_[column->second];
  }

  std::int64_t whole(const char* name, std::int64_t fallback) const {
    const auto column = column_.find(name);
    return column == column_.end() ? fallback : integer(file_, fields_[column->second], name);
  }

  std::int64_t whole_within(const char* name, std::int64_t low, std::int64_t high, const std::string& expected) const {
    const std::int64_t number = whole(name, low);
    if (number < low || number > high) file_.fail(expected);
    return number;
  }

  void read_match(std::string_view text) {
    fields_ = split_at_commas(text);
    if (fields_.size() != names_.size()) {
      file_.fail(std::to_string(names_.size()) + " fields as in the header, not " + std::to_string(fields_.size()));
    }
    values_.clear();
    for (std::size_t i = 0; i < fields_.size(); ++i) values_.push_back(file_.number(fields_[i], names_[i]));

    Match match;
    match.keypoint = whole("kp", static_cast<std::int64_t>(frame_.matches.size()));
    match.map_point_id = whole("mp_id", 0);
    match.point[0] = value("X", 0);
    match.point[1] = value("Y", 0);
    match.point[2] = value("Z", 0);
    match.u = value("u", 0);
    match.v = value("v", 0);
    match.octave = static_cast<int>(whole_within("octave", 0, 63, "an octave from 0 to 63"));
    match.u_right = value("u_right", -1);
    match.inv_sigma2 = value("inv_sigma2", 1);
    if (!(match.inv_sigma2 > 0)) file_.fail("a positive inv_sigma2");
    match.desc_dist = value("desc_dist", 0);
    match.keyframe = whole("keyframe", -1);
    match.is_selected = whole_within("selected", 0, 1, "0 or 1 for selected") == 1;
    const auto cameras = static_cast<std::int64_t>(std::max<std::size_t>(frame_.camera.rig.size(), 1));
    match.camera_id = static_cast<std::uint8_t>(
        whole_within("camera", 0, cameras - 1, "a camera from 0 to " + std::to_string(cameras - 1)));
    read_third(match);
    frame_.matches.push_back(match);
    read_covariance();
  }

  void read_third(Match& match) const {
    const FrameCamera& camera = frame_.camera;
    if (camera.depth_sigma > 0) match.depth = value("depth", -1);
    if (!match.is_stereo() || camera.is_pinhole()) return;
    file_.fail("a negative u_right, or no such column, with '# depth_sigma', '# camera' or a rig");
  }

  // The upper triangle, row by row; cov_xx < 0: unknown.
  void read_covariance() {
    if (!has_column(covariance_columns[0])) return;
    const double xx = value("cov_xx", -1), xy = value("cov_xy", 0), xz = value("cov_xz", 0), yy = value("cov_yy", 0),
                 yz = value("cov_yz", 0), zz = value("cov_zz", 0);
    const bool is_known = xx >= 0;
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
  std::vector<std::string_view> fields_;  // of a row
  std::vector<double> values_;
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
