// SPDX-License-Identifier: MIT
#include "bench/world/frame_comments.hpp"

#include "bench/world/csv.hpp"
#include "bench/world/names.hpp"
#include "bench/world/text.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <sstream>
#include <vector>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t max_cameras = 256;
constexpr std::int64_t largest_side = 1 << 20;  // of an image, px

using Values = std::vector<std::string>;

std::vector<double> numbers(const TextFile& file, const Values& values, std::size_t count, const std::string& what) {
  if (values.size() != count) file.fail(std::to_string(count) + " numbers for " + what);
  std::vector<double> result;
  for (const std::string& value : values) result.push_back(file.number(value, what));
  return result;
}

PinholeCamera pinhole(const TextFile& file, const Values& values) {
  const auto v = numbers(file, values, 5, "fx,fy,cx,cy,bf");
  if (!(v[0] > 0) || !(v[1] > 0)) file.fail("positive fx and fy");
  if (!(v[4] >= 0)) file.fail("bf of 0 (monocular) or more");
  return {v[0], v[1], v[2], v[3], v[4]};
}

// MODEL,fx,fy,cx,cy and the model's parameters.
Camera camera_of(const TextFile& file, const Values& values) {
  const std::optional<CameraModel> model = find_named(camera_models, values[0]);
  if (!model)
    file.fail("a camera model, one of " + joined(names_of(camera_models), ", ") + ", not " + shown(values[0]));
  const std::size_t count = parameter_count(*model);
  if (values.size() != 5 + count) {
    file.fail(std::string(to_string(*model)) + ",fx,fy,cx,cy and " + std::to_string(count) + " parameters");
  }
  std::vector<double> v;
  for (std::size_t i = 1; i < values.size(); ++i) v.push_back(file.number(values[i], "a camera's parameter"));
  Camera camera(v[0], v[1], v[2], v[3]);
  camera.model = *model;
  std::copy(v.begin() + 4, v.end(), camera.parameters);
  // The library knows which parameters are in range: it refuses no camera that can make blocks.
  BlockStore none;
  Matches matches;
  const double nothing[3] = {};
  matches.points = nothing;
  if (append_blocks(camera, RigidTransform::identity(), matches, BlockOptions(), none).error != Error::none) {
    file.fail("positive fx and fy, and distortion within the range of " + std::string(to_string(*model)));
  }
  return camera;
}

std::array<double, 12> transform_of(const TextFile& file, const Values& values, const std::string& name) {
  const auto v = numbers(file, values, 12, name + " (3 x 4 row-major)");
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T(v.data());
  const double error = RigidTransform::row_major(v.data()).rotation_error();
  if (error > 1e-3 || T.leftCols<3>().determinant() < 0) {
    std::ostringstream found;
    found << "a rotation in the first 3 columns of " << name << "; an entry of R R^T - I is " << error;
    file.fail(found.str() + (error > 1e-3 ? ", above 1e-3" : ", but R is a reflection"));
  }
  std::array<double, 12> rows{};
  std::copy(v.begin(), v.end(), rows.begin());
  return rows;
}

void read_image(const TextFile& file, const Values& values, Frame& frame) {
  if (values.size() != 2) file.fail("2 integers for image width,height");
  const auto width = integer(file, values[0], "image width");
  const auto height = integer(file, values[1], "image height");
  if (width < 1 || height < 1 || width > largest_side || height > largest_side)
    file.fail("an image width and height from 1 to 2^20");
  frame.width = static_cast<double>(width);
  frame.height = static_cast<double>(height);
}

// The number behind a prefix, as in camera0; camera00 is another name.
std::optional<std::size_t> number_behind(const std::string& prefix, const std::string& name) {
  if (name.compare(0, prefix.size(), prefix) != 0 || name.size() == prefix.size()) return std::nullopt;
  const std::optional<std::int64_t> number = whole_number(std::string_view(name).substr(prefix.size()));
  if (!number || *number < 0 || prefix + std::to_string(*number) != name) return std::nullopt;
  return static_cast<std::size_t>(*number);
}

bool is_known(const std::string& name) {
  for (const char* known : {"fx,fy,cx,cy,bf", "camera", "imagewidth,height", "Tcw_prior", "Tcw_true", "depth_sigma"}) {
    if (name == known) return true;
  }
  return number_behind("camera", name) || number_behind("T_cb", name);
}

}  // namespace

bool is_comment(std::string_view line) {
  const auto first = line.find_first_not_of(" \t\"");
  return first != std::string_view::npos && line[first] == '#' && line.substr(first, 4) != "#N/A";  // a missing value
}

std::optional<Comment> comment_of(std::string_view line) {
  std::string text(line);
  text.erase(std::remove(text.begin(), text.end(), '"'), text.end());
  text.erase(text.find_last_not_of(" \t,;") + 1);  // a spreadsheet makes every line as long as the header
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  Comment comment;
  std::string_view name = std::string_view(text).substr(0, colon);
  name = name.substr(0, name.find('(')).substr(name.find('#') + 1);
  comment.name = joined(split_csv(trimmed(name)), ",");
  comment.name.erase(std::remove(comment.name.begin(), comment.name.end(), ' '), comment.name.end());
  comment.values = split_csv(std::string_view(text).substr(colon + 1));
  return comment;
}

std::int64_t integer(const TextFile& file, std::string_view field, const std::string& what) {
  const std::optional<std::int64_t> value = whole_number(field);
  if (!value) file.fail("an integer for " + what + ", not " + shown(field));
  return *value;
}

bool FrameComments::decides_rows(const std::string& name) {
  return name == "depth_sigma" || name == "camera" || number_behind("camera", name);
}

void FrameComments::read(const Comment& comment, const TextFile& file, Frame& frame) {
  const auto& [name, values] = comment;
  if (!is_known(name)) return;
  if (!seen_.insert(name).second) file.fail("one comment '" + name + "', not a second one");
  if (name == "fx,fy,cx,cy,bf") {
    static_cast<PinholeCamera&>(frame.camera) = pinhole(file, values);
  } else if (name == "imagewidth,height") {
    read_image(file, values, frame);
  } else if (name == "Tcw_prior") {
    frame.T_cw_prior = transform_of(file, values, name);
  } else if (name == "Tcw_true") {
    frame.T_cw_true = transform_of(file, values, name);
  } else if (name == "depth_sigma") {
    frame.camera.depth_sigma = numbers(file, values, 1, name)[0];
    if (!(frame.camera.depth_sigma > 0)) file.fail("a positive depth_sigma, m");
  } else {
    read_camera_of_rig(comment, file, frame);
  }
  const bool is_pinhole = has("fx,fy,cx,cy,bf"), is_single = has("camera"), is_rig = has("camera0");
  if ((is_pinhole && is_single) || (is_pinhole && is_rig) || (is_single && is_rig)) {
    file.fail("one of the comments 'fx,fy,cx,cy,bf', 'camera' and 'camera 0'");
  }
}

void FrameComments::read_camera_of_rig(const Comment& comment, const TextFile& file, Frame& frame) const {
  const auto& [name, values] = comment;
  FrameCamera& camera = frame.camera;
  if (name == "camera") {
    const Camera alone = camera_of(file, values);
    if (alone.model == CameraModel::pinhole) {
      static_cast<PinholeCamera&>(camera) = alone.pinhole;
    } else {
      camera.rig = {alone};
    }
  } else if (const auto added = number_behind("camera", name)) {
    if (*added != camera.rig.size() || *added >= max_cameras) {
      file.fail("the cameras of a rig from 0 on, without gaps, and at most 256");
    }
    camera.rig.push_back(camera_of(file, values));
  } else if (const auto of = number_behind("T_cb", name)) {
    if (has("camera") || *of >= camera.rig.size())
      file.fail("the comment 'camera " + std::to_string(*of) + "' before this");
    camera.rig[*of].T_cb = RigidTransform::row_major(transform_of(file, values, name).data());
  }
}

}  // namespace maxlogdet::sim
