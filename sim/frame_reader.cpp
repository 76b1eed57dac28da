// SPDX-License-Identifier: MIT
#include "sim/frame_reader.hpp"

#include "sim/text.hpp"
#include "sim/text_file.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string_view>

namespace maxlogdet::sim {
namespace {

// All columns of docs/frame_format.md; other readers use those that are ignored here.
constexpr std::string_view known_columns[] = {"kp",         "mp_id",      "X",         "Y",           "Z",
                                              "u",          "v",          "octave",    "u_right",     "depth",
                                              "inv_sigma2", "desc_dist",  "src",       "n_obs",       "found_ratio",
                                              "response",   "chi2_prior", "chi2_post", "outlier_post"};

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
    require(has_camera_, "a comment '# fx,fy,cx,cy,bf: ...'");
    require(has_image_, "a comment '# image width,height: ...'");
    require(has_pose_, "a comment '# Tcw_prior: ...' with the pose to linearise at");
    require(!names_.empty(), "a header line that names the columns, then one row a match");
    return std::move(frame_);
  }

 private:
  void require(bool condition, const std::string& expected) const {
    if (!condition) file_.fail_at_end(expected);
  }

  std::int64_t integer(std::string_view field, const std::string& what) const {
    const std::optional<std::int64_t> value = whole_number(field);
    if (!value) file_.fail("an integer for " + what + ", not " + shown(field));
    return *value;
  }

  std::vector<double> numbers(std::string_view text, std::size_t count, const std::string& what) const {
    const auto fields = split_at_commas(text);
    if (fields.size() != count) file_.fail(std::to_string(count) + " numbers for " + what);
    std::vector<double> values;
    for (const auto field : fields) values.push_back(file_.number(field, what));
    return values;
  }

  // The name of '# name (remark): values' without blanks.
  static std::string comment_name(std::string_view text) {
    std::string name;
    for (const char c : text.substr(0, text.find('('))) {
      if (c != ' ' && c != '\t') name += c;
    }
    return name;
  }

  // Comments with other names are skipped.
  void read_comment(std::string_view text) {
    const auto colon = text.rfind(':');
    if (colon == std::string_view::npos) return;
    const std::string name = comment_name(text.substr(0, colon));
    const std::string_view values = text.substr(colon + 1);
    const auto is_new = [&](bool& was_seen) {
      if (was_seen) file_.fail("one comment '" + name + "', not a second one");
      was_seen = true;
    };
    if (name == "fx,fy,cx,cy,bf") {
      is_new(has_camera_);
      const auto v = numbers(values, 5, "fx,fy,cx,cy,bf");
      if (!(v[0] > 0) || !(v[1] > 0)) file_.fail("positive fx and fy");
      if (!(v[4] >= 0)) file_.fail("bf of 0 (monocular) or more");
      frame_.camera = {v[0], v[1], v[2], v[3], v[4]};
    } else if (name == "imagewidth,height") {
      is_new(has_image_);
      const auto fields = split_at_commas(values);
      if (fields.size() != 2) file_.fail("2 integers for image width,height");
      const auto width = integer(fields[0], "image width");
      const auto height = integer(fields[1], "image height");
      constexpr std::int64_t largest = 1 << 20;
      if (width < 1 || height < 1 || width > largest || height > largest)
        file_.fail("an image width and height from 1 to 2^20");
      frame_.width = static_cast<int>(width);
      frame_.height = static_cast<int>(height);
    } else if (name == "Tcw_prior") {
      is_new(has_pose_);
      const auto v = numbers(values, 12, "Tcw_prior (3 x 4 row-major)");
      const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T_cw(v.data());
      const Eigen::Matrix3d R = T_cw.leftCols<3>();
      if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0)
        file_.fail("a rotation in the first 3 columns of Tcw_prior");
      std::copy(v.begin(), v.end(), frame_.T_cw_prior.begin());
    }
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
      if (column_.count(name) == 0)
        file_.fail("a header line with the columns mp_id,X,Y,Z,u,v; '" + std::string(name) + "' is missing");
    }
  }

  void read_match(std::string_view text) {
    const auto fields = split_at_commas(text);
    if (fields.size() != names_.size()) {
      file_.fail(std::to_string(names_.size()) + " fields as in the header, not " + std::to_string(fields.size()));
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < fields.size(); ++i) values.push_back(file_.number(fields[i], names_[i]));
    const auto value = [&](const std::string& name, double fallback) {
      const auto column = column_.find(name);
      return column == column_.end() ? fallback : values[column->second];
    };
    const auto whole = [&](const std::string& name, std::int64_t fallback) {
      const auto column = column_.find(name);
      return column == column_.end() ? fallback : integer(fields[column->second], name);
    };

    Match match;
    match.keypoint = whole("kp", static_cast<std::int64_t>(frame_.matches.size()));
    match.map_point_id = whole("mp_id", 0);
    match.point[0] = value("X", 0);
    match.point[1] = value("Y", 0);
    match.point[2] = value("Z", 0);
    match.u = value("u", 0);
    match.v = value("v", 0);
    const std::int64_t octave = whole("octave", 0);
    if (octave < 0 || octave > 63) file_.fail("an octave from 0 to 63");
    match.octave = static_cast<int>(octave);
    match.u_right = value("u_right", -1);
    match.inv_sigma2 = value("inv_sigma2", 1);
    if (!(match.inv_sigma2 > 0)) file_.fail("a positive inv_sigma2");
    match.desc_dist = value("desc_dist", 0);
    frame_.matches.push_back(match);
  }

  TextFile file_;
  std::vector<std::string> names_;  // of the columns
  std::map<std::string, std::size_t, std::less<>> column_;
  bool has_camera_ = false;
  bool has_image_ = false;
  bool has_pose_ = false;
  Frame frame_;
};

}  // namespace

Frame read_frame(const std::string& file) { return FrameReader(file).read(); }

std::vector<Frame> read_frames(const std::string& file_or_folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(file_or_folder, error)) return {read_frame(file_or_folder)};
  std::vector<Frame> frames;
  for (const auto& file : files_of(file_or_folder, "frame_", ".csv")) frames.push_back(read_frame(file));
  return frames;
}

}  // namespace maxlogdet::sim
