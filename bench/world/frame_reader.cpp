// SPDX-License-Identifier: MIT
#include "bench/world/frame_reader.hpp"

#include "bench/world/names.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <sstream>
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

constexpr std::size_t most_matches = 1000000;  // of a file that may never end
constexpr std::size_t most_cameras = 256;
constexpr std::int64_t largest_side = 1 << 20;  // of an image, px

using Values = std::vector<std::string>;

// A comment `# NAME (remark): VALUES`, its name without blanks.
struct Comment {
  explicit Comment(std::string_view line) {
    const auto colon = line.rfind(':');
    if (colon == std::string_view::npos) return;
    name = line.substr(1, std::min(colon, line.find('(')) - 1);
    name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
    values = split_at_commas(line.substr(colon + 1));
  }

  std::string name;  // empty without values
  Values values;
};

// The number behind a prefix, as in camera0; camera00 is another name.
std::optional<std::size_t> number_behind(const std::string& prefix, const std::string& name) {
  if (name.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  const std::optional<std::int64_t> number = whole_number(std::string_view(name).substr(prefix.size()));
  if (!number || *number < 0 || prefix + std::to_string(*number) != name) return std::nullopt;
  return static_cast<std::size_t>(*number);
}

class FrameReader {
 public:
  explicit FrameReader(const std::string& file) : file_(file, "frame file") {
    frame_.name = std::filesystem::path(file).stem().string();
  }

  Frame read() {
    while (const auto line = file_.next()) {
      if (line->front() == '#') {
        const Comment comment(*line);
        read_comment(comment.name, comment.values);
      } else if (names_.empty()) {
        read_header(*line);
      } else {
        read_match(*line);
      }
    }
    const bool has_camera = has_comment("fx,fy,cx,cy,bf") || has_comment("camera") || has_comment("camera0");
    if (!has_camera) file_.fail_at_end("a comment '# fx,fy,cx,cy,bf: ...' or '# camera: ...'");
    if (!has_comment("Tcw_prior")) file_.fail_at_end("a comment '# Tcw_prior: ...' with the pose to linearise at");
    if (names_.empty()) file_.fail_at_end("a header line that names the columns, then one row a match");
    if (has_covariances_) frame_.map_covariances = std::move(covariances_);
    return std::move(frame_);
  }

 private:
  // Not with texts that would be made for every match.
  void require(bool holds, const std::string& expected) const {
    if (!holds) file_.fail(expected);
  }

  // Comments: camera, image and poses; others are skipped.

  bool has_comment(const std::string& name) const { return comments_.count(name) != 0; }

  void read_comment(const std::string& name, const Values& values) {
    const auto of_rig = number_behind("camera", name), of_transform = number_behind("T_cb", name);
    const bool decides_rows = name == "depth_sigma" || name == "camera" || of_rig;
    require(names_.empty() || !decides_rows, "the comment '" + name + "' above the header");
    require(!has_comment(name), "one comment '" + name + "', not a second one");
    if (name == "fx,fy,cx,cy,bf") {
      read_pinhole(values);
    } else if (name == "camera") {
      const Camera camera = camera_of(values);
      static_cast<PinholeCamera&>(frame_.camera) = camera.pinhole;
      if (camera.model != CameraModel::pinhole) frame_.camera.rig = {camera};
    } else if (of_rig) {
      require(*of_rig == frame_.camera.rig.size() && *of_rig < most_cameras,
              "the cameras of a rig from 0 on, without gaps, and at most 256");
      frame_.camera.rig.push_back(camera_of(values));
    } else if (of_transform) {
      require(!has_comment("camera") && *of_transform < frame_.camera.rig.size(),
              "the comment 'camera " + std::to_string(*of_transform) + "' before this");
      frame_.camera.rig[*of_transform].T_cb = RigidTransform::row_major(transform_of(values, name).data());
    } else if (name == "imagewidth,height") {
      read_image(values);
    } else if (name == "Tcw_prior") {
      frame_.T_cw_prior = transform_of(values, name);
    } else if (name == "Tcw_true") {
      frame_.T_cw_true = transform_of(values, name);
    } else if (name == "depth_sigma") {
      frame_.camera.depth_sigma = numbers(values, 1, name)[0];
      require(frame_.camera.depth_sigma > 0, "a positive depth_sigma, m");
    } else {
      return;
    }
    comments_.insert(name);
    const bool has_each[] = {has_comment("fx,fy,cx,cy,bf"), has_comment("camera"), has_comment("camera0")};
    require(std::count(std::begin(has_each), std::end(has_each), true) <= 1,
            "one of the comments 'fx,fy,cx,cy,bf', 'camera' and 'camera 0'");
  }

  std::vector<double> numbers(const Values& values, std::size_t count, const std::string& what) const {
    require(values.size() == count, std::to_string(count) + " numbers for " + what);
    std::vector<double> result;
    for (const std::string& value : values) result.push_back(file_.number(value, what));
    return result;
  }

  void read_pinhole(const Values& values) {
    const std::vector<double> v = numbers(values, 5, "fx,fy,cx,cy,bf");
    require(v[0] > 0 && v[1] > 0, "positive fx and fy");
    require(v[4] >= 0, "bf of 0 (monocular) or more");
    static_cast<PinholeCamera&>(frame_.camera) = {v[0], v[1], v[2], v[3], v[4]};
  }

  // MODEL,fx,fy,cx,cy and the model's parameters.
  Camera camera_of(const Values& values) const {
    const std::optional<CameraModel> model = find_named(camera_models, values[0]);
    const std::string models = joined(names_of(camera_models), ", ");
    if (!model) file_.fail("a camera model, one of " + models + ", not " + shown(values[0]));
    const std::string name = to_string(*model);
    const std::size_t count = parameter_count(*model);
    require(values.size() == 5 + count, name + ",fx,fy,cx,cy and " + std::to_string(count) + " parameters");
    const std::vector<double> v = numbers({values.begin() + 1, values.end()}, 4 + count, "a camera's parameter");
    Camera camera(v[0], v[1], v[2], v[3]);
    camera.model = *model;
    std::copy(v.begin() + 4, v.end(), camera.parameters);
    require(camera.pinhole.fx > 0 && camera.pinhole.fy > 0, "positive fx and fy");
    return camera;
  }

  std::array<double, 12> transform_of(const Values& values, const std::string& name) const {
    const std::vector<double> v = numbers(values, 12, name + " (3 x 4 row-major)");
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T(v.data());
    const double error = RigidTransform::row_major(v.data()).rotation_error();
    if (error > 1e-3 || T.leftCols<3>().determinant() < 0) {
      std::ostringstream found;
      found << "a rotation in the first 3 columns of " << name << "; an entry of R R^T - I is " << error;
      file_.fail(found.str() + (error > 1e-3 ? ", above 1e-3" : ", but R is a reflection"));
    }
    std::array<double, 12> rows{};
    std::copy(v.begin(), v.end(), rows.begin());
    return rows;
  }

  void read_image(const Values& values) {
    require(values.size() == 2, "2 integers for image width,height");
    const std::int64_t width = file_.integer(values[0], "image width"),
                       height = file_.integer(values[1], "image height");
    require(std::min(width, height) >= 1 && std::max(width, height) <= largest_side,
            "an image width and height from 1 to 2^20");
    frame_.width = static_cast<double>(width);
    frame_.height = static_cast<double>(height);
  }

  // The header and the rows.

  // Columns without a name are the index of pandas.
  void read_header(std::string_view line) {
    names_ = split_at_commas(line);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const std::string& name = names_[i];
      if (name.empty()) continue;
      require(column_.emplace(name, i).second, "each column once, not " + shown(name) + " twice");
      const bool is_known =
          std::find(std::begin(known_columns), std::end(known_columns), name) != std::end(known_columns);
      if (!is_known) frame_.unknown_columns.push_back(name);
    }
    for (const char* const name : {"mp_id", "X", "Y", "Z", "u", "v"}) {
      require(has_column(name), "a header line with the columns mp_id,X,Y,Z,u,v, between commas and without quotes; '" +
                                    std::string(name) + "' is missing");
    }
    const auto given = std::count_if(std::begin(covariance_columns), std::end(covariance_columns),
                                     [this](const char* name) { return has_column(name); });
    require(given == 0 || given == 6, "all six columns cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz, or none");
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
    return has_value(name) ? file_.integer(field(name), name) : fallback;
  }
  std::int64_t integer_to(const char* name, std::int64_t high, const char* what) const {
    const std::int64_t value = integer_or(name, 0);
    if (value < 0 || value > high) file_.fail(std::string(what) + " from 0 to " + std::to_string(high));
    return value;
  }

  void read_match(std::string_view line) {
    fields_ = split_at_commas(line);
    if (fields_.size() != names_.size()) {
      file_.fail(std::to_string(names_.size()) + " fields as in the header, not " + std::to_string(fields_.size()));
    }
    require(frame_.matches.size() < most_matches, "at most a million matches");
    const FrameCamera& camera = frame_.camera;
    Match match;
    match.keypoint = integer_or("kp", static_cast<std::int64_t>(frame_.matches.size()));
    match.map_point_id = file_.integer(field("mp_id"), "mp_id");
    match.point[0] = number("X");
    match.point[1] = number("Y");
    match.point[2] = number("Z");
    match.u = number("u");
    match.v = number("v");
    match.octave = static_cast<int>(integer_to("octave", 63, "an octave"));
    match.u_right = number_or("u_right", -1);
    match.inv_sigma2 = number_or("inv_sigma2", 1);
    require(match.inv_sigma2 > 0, "a positive inv_sigma2");
    match.desc_dist = number_or("desc_dist", 0);
    match.keyframe = integer_or("keyframe", -1);
    const auto last = static_cast<std::int64_t>(std::max<std::size_t>(camera.rig.size(), 1)) - 1;
    match.camera_id = static_cast<std::uint8_t>(integer_to("camera", last, "a camera"));
    if (has_value("selected")) {
      const std::optional<bool> is_selected = truth(field("selected"));
      if (!is_selected) file_.fail("0 or 1 for selected, not " + shown(field("selected")));
      match.is_selected = *is_selected;
    }
    frame_.has_selection = frame_.has_selection && has_value("selected");
    const double depth = number_or("depth", -1);
    if (camera.depth_sigma > 0) match.depth = depth;
    require(!match.is_stereo() || camera.is_pinhole(),
            "a negative u_right, or no such column, with '# depth_sigma', '# camera' or a rig");
    frame_.matches.push_back(match);
    read_covariance();
  }

  // The upper triangle, row by row; cov_xx < 0: unknown.
  void read_covariance() {
    if (!has_column(covariance_columns[0])) return;
    const double xx = number_or("cov_xx", -1);
    if (xx < 0) {
      covariances_.push_back({std::numeric_limits<double>::quiet_NaN()});
      return;
    }
    has_covariances_ = true;
    const double xy = number("cov_xy"), xz = number("cov_xz"), yy = number("cov_yy"), yz = number("cov_yz"),
                 zz = number("cov_zz");
    require(yy >= 0 && zz >= 0, "variances cov_yy and cov_zz of 0 or more");
    covariances_.push_back({xx, xy, xz, xy, yy, yz, xz, yz, zz});
  }

  TextFile file_;
  std::set<std::string> comments_;
  std::vector<std::string> names_;  // of the columns
  std::map<std::string, std::size_t, std::less<>> column_;
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
