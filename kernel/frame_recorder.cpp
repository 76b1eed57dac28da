// SPDX-License-Identifier: MIT
// The only unit that does I/O, because a caller has asked for it, and the only one here of C++17, for std::to_chars.
#include <maxlogdet/frame_recorder.hpp>

#include "kernel/blocks/matched_frame.hpp"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace maxlogdet {
namespace {

constexpr unsigned max_frames = 1000000;  // as many as six digits keep in order of name

// to_chars knows no locale. Of a double it writes the fewest digits that read back as the same one.
template <class Number>
void put(std::string& text, Number value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

#if !defined(__cpp_lib_to_chars)  // gcc before 11 has it for integers only; this takes ten times as long
void put(std::string& text, double value) {
  char digits[32];
  for (int precision = 15; precision <= 17; ++precision) {
    std::snprintf(digits, sizeof digits, "%.*g", precision, value);
    if (std::strtod(digits, nullptr) == value) break;
  }
  const std::string point = std::localeconv()->decimal_point;
  const std::size_t start = text.size();
  text += digits;
  const std::size_t found = text.find(point, start);
  if (found != std::string::npos) text.replace(found, point.size(), ".");
}
#endif

// The rest of a line that begins with `name`.
template <class Number>
void put_line(std::string& text, const std::string& name, const Number* values, std::size_t count) {
  text += name;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ',';
    put(text, values[i]);
  }
  text += '\n';
}

double weight_of(const FeatureMatch& match) noexcept { return 1 / (match.sigma * match.sigma); }

// -1, as in a file, for what is not measured.
double measured_or_none(double cue) noexcept { return cue >= 0 && std::isfinite(cue) ? cue : -1; }

bool is_frame_file(std::string_view name) noexcept {
  constexpr std::string_view prefix = "frame_", suffix = ".csv";
  return name.size() >= prefix.size() + suffix.size() && name.substr(0, prefix.size()) == prefix &&
         name.substr(name.size() - suffix.size()) == suffix;
}

// Why the folder cannot take a recording; nullptr if it can. It is created if it is missing.
const char* problem_of(const std::string& folder) noexcept {
  if (mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) {
    return errno == ENOENT ? "the folder above it does not exist" : std::strerror(errno);
  }
  DIR* const entries = opendir(folder.c_str());
  if (entries == nullptr) return std::strerror(errno);
  bool is_used = false;
  while (const dirent* const entry = readdir(entries)) is_used = is_used || is_frame_file(entry->d_name);
  closedir(entries);
  if (is_used) return "it holds frame_*.csv of another recording: choose another folder, or empty it";
  return access(folder.c_str(), W_OK | X_OK) == 0 ? nullptr : std::strerror(errno);
}

// Returns 0, or errno. A file that is there already is never overwritten.
int write_file(const char* path, const std::string& text) noexcept {
  std::FILE* const file = std::fopen(path, "wxe");
  if (file == nullptr) return errno;
  int error = std::fwrite(text.data(), 1, text.size(), file) == text.size() ? 0 : errno;
  if (std::fclose(file) != 0 && error == 0) error = errno;
  if (error != 0) std::remove(path);
  return error;
}

}  // namespace

bool FrameRecorder::open(const char* folder) noexcept try {
  if (folder == nullptr || *folder == '\0') {
    close();
    return false;
  }
  std::string name = folder;
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  if (is_open_ && name == folder_) return true;
  close();
  folder_ = std::move(name);
  number_ = 0;
  const char* const problem = problem_of(folder_);
  if (problem != nullptr) return fail(problem);
  refused_.clear();
  is_open_ = true;
  has_skipped_ = false;
  return true;
} catch (...) {
  return fail("out of memory");
}

void FrameRecorder::close() noexcept { is_open_ = is_started_ = false; }

// Says it once, also to a caller that opens the same folder again and again. Returns false.
bool FrameRecorder::fail(const char* why) noexcept {
  close();
  if (refused_ == folder_) return false;
  std::fprintf(stderr, "maxlogdet: %s: %s; %s\n", folder_.c_str(), why,
               number_ == 0 ? "nothing is recorded" : "the recording ends");
  refused_.swap(folder_);
  return false;
}

void FrameRecorder::skip(const char* why) noexcept {
  is_started_ = false;
  if (is_open_ && !has_skipped_) {
    std::fprintf(stderr, "maxlogdet: %s: a frame is not recorded: %s\n", folder_.c_str(), why);
  }
  has_skipped_ = true;
}

bool FrameRecorder::start(const Camera* cameras, std::size_t count, const RigidTransform& T_bw,
                          const FrameDetails& details) noexcept try {
  is_started_ = false;
  details_ = details;
  camera_count_ = count;
  MatchedFrame frame;
  frame.cameras = cameras;
  frame.camera_count = count;
  frame.T_bw = T_bw;
  frame.depth_cue = details.depth_cue;
  frame.options.depth_sigma = details.depth_sigma;
  if (!is_open_ || check(frame) != Error::none) return false;
  is_rig_ = count > 1 || !is_identity(cameras[0].T_cb);
  if (is_rig_ && details.depth_cue == DepthCue::stereo) {
    return fail("a rig with right columns cannot be written into frame files");
  }
  text_.clear();
  row_count_ = 0;
  put_cameras(cameras);
  shift_of_right_ = cameras[0].pinhole.shift_of_right;
  const int size[2] = {details_.width, details_.height};
  if (size[0] > 0 && size[1] > 0) put_line(text_, "# image width,height: ", size, 2);
  const char* const moved = is_rig_ ? "body" : "camera";
  put_line(text_, std::string("# Tcw_prior (3x4 row-major, world to ") + moved + "): ", T_bw.data(), 12);
  if (is_rigid(details_.T_cw_true)) put_line(text_, "# Tcw_true (3x4 row-major): ", details_.T_cw_true.data(), 12);
  put_names_of_columns();
  is_started_ = true;
  return true;
} catch (...) {
  return fail("out of memory");
}

void FrameRecorder::put_cameras(const Camera* cameras) {
  for (std::size_t c = 0; c < camera_count_; ++c) {
    const Camera& camera = cameras[c];
    const PinholeCamera& pinhole = camera.pinhole;
    const bool is_rectified = !is_rig_ && camera.model == CameraModel::pinhole;
    double numbers[9] = {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy};
    std::size_t filled = 4;
    if (is_rectified) numbers[filled++] = std::isfinite(pinhole.bf) ? std::max(pinhole.bf, 0.0) : 0;
    for (std::size_t p = 0; p < parameter_count(camera.model); ++p) numbers[filled++] = camera.parameters[p];
    const std::string place = is_rig_ ? " " + std::to_string(c) : "";
    const std::string model = "# camera" + place + ": " + to_string(camera.model) + ",";
    put_line(text_, is_rectified ? "# fx,fy,cx,cy,bf: " : model, numbers, filled);
    if (is_rig_) put_line(text_, "# T_cb" + place + ": ", camera.T_cb.data(), 12);
  }
  if (details_.depth_cue == DepthCue::depth) put_line(text_, "# depth_sigma: ", &details_.depth_sigma, 1);
}

void FrameRecorder::put_names_of_columns() {
  text_ += "mp_id,X,Y,Z,u,v,kp";
  if (is_rig_) text_ += ",camera";
  if (details_.depth_cue == DepthCue::stereo) text_ += ",u_right";
  if (details_.depth_cue == DepthCue::depth) text_ += ",depth";
  text_ += ",inv_sigma2";
  if (details_.has_covariances) text_ += ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz";
  if (details_.has_keyframes) text_ += ",keyframe";
  if (details_.has_descriptor_distances) text_ += ",desc_dist";
  text_ += ",selected\n";
}

bool FrameRecorder::is_recordable(const FeatureMatch& match, double descriptor_distance) const noexcept {
  const double weight = weight_of(match);
  const bool is_measured = all_finite(match.point, 3) && all_finite(match.measured, 2) &&
                           match.measured[0] != unmeasured && std::isfinite(weight) && weight > 0 &&
                           std::isfinite(descriptor_distance);
  const double* const covariance = details_.has_covariances ? match.covariance : nullptr;
  const bool is_covariance = covariance == nullptr || (all_finite(covariance, 9) && covariance[0] >= 0 &&
                                                       covariance[4] >= 0 && covariance[8] >= 0);
  return is_measured && is_covariance && match.camera_id < camera_count_;
}

bool FrameRecorder::add(const FeatureMatch& match, bool is_selected, double descriptor_distance) noexcept try {
  if (!is_started_ || !is_recordable(match, descriptor_distance)) return false;
  ++row_count_;
  put_match(match, is_selected, descriptor_distance);
  return true;
} catch (...) {
  return fail("out of memory");
}

void FrameRecorder::put_match(const FeatureMatch& match, bool is_selected, double descriptor_distance) {
  const auto next = [&](auto value) { put(text_ += ',', value); };
  put(text_, match.point_id);
  for (const double coordinate : match.point) next(coordinate);
  for (const double column_or_row : match.measured) next(column_or_row);
  next(match.id);
  if (is_rig_) next(static_cast<unsigned>(match.camera_id));
  if (details_.depth_cue == DepthCue::stereo) {
    const double right = measured_or_none(match.u_right);
    next(right < 0 ? right : measured_or_none(right - shift_of_right_));
  }
  if (details_.depth_cue == DepthCue::depth) next(match.depth == 0 ? -1 : measured_or_none(match.depth));
  next(weight_of(match));
  if (details_.has_covariances) {
    for (const std::size_t entry : {0U, 1U, 2U, 4U, 5U, 8U})
      next(match.covariance == nullptr ? -1 : match.covariance[entry]);
  }
  if (details_.has_keyframes) next(match.keyframe);
  if (details_.has_descriptor_distances) next(descriptor_distance);
  text_ += is_selected ? ",1\n" : ",0\n";
}

bool FrameRecorder::finish() noexcept try {
  if (!is_started_) return false;
  if (row_count_ == 0) return skip("no match of it is measured"), false;
  is_started_ = false;
  if (number_ == max_frames) return fail("a folder takes at most a million frames");
  char name[32];
  std::snprintf(name, sizeof name, "/frame_%06u.csv", number_);
  const int error = write_file((folder_ + name).c_str(), text_);
  if (error != 0) return fail(std::strerror(error));
  ++number_;
  return true;
} catch (...) {
  return fail("out of memory");
}

}  // namespace maxlogdet
