// SPDX-License-Identifier: MIT
// The only unit that does I/O, because a caller has asked for it, and the only one here of C++17, for std::to_chars.
#include "kernel/frame_recorder.hpp"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <locale>
#include <sstream>
#include <string_view>
#include <utility>

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

#if !defined(__cpp_lib_to_chars)  // gcc before 11 has it for integers only; this takes longer, and writes more digits
void put(std::string& text, double value) {
  std::ostringstream digits;
  digits.imbue(std::locale::classic());
  digits.precision(17);
  digits << value;
  text += digits.str();
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

// A frame's columns, besides those that all frames have.
struct Columns {
  explicit Columns(const MatchedFrame& frame) noexcept
      : is_rig(frame.camera_count > 1 || !is_identity(frame.cameras[0].T_cb)),
        has_covariances(frame.has_covariances),
        depth_cue(frame.depth_cue) {
    for (std::size_t i = 0; i < frame.size; ++i) has_keyframes = has_keyframes || frame.matches[i].keyframe >= 0;
  }

  bool is_rig, has_covariances, has_keyframes = false;
  DepthCue depth_cue;
};

void put_cameras(std::string& text, const MatchedFrame& frame, const Columns& columns) {
  for (std::size_t c = 0; c < frame.camera_count; ++c) {
    const Camera& camera = frame.cameras[c];
    const PinholeCamera& pinhole = camera.pinhole;
    const bool is_rectified = !columns.is_rig && camera.model == CameraModel::pinhole;
    double numbers[9] = {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy};
    std::size_t filled = 4;
    if (is_rectified) numbers[filled++] = is_positive(pinhole.bf) ? pinhole.bf : 0;
    for (std::size_t p = 0; p < parameter_count(camera.model); ++p) numbers[filled++] = camera.parameters[p];
    const std::string place = columns.is_rig ? " " + std::to_string(c) : "";
    const std::string model = "# camera" + place + ": " + to_string(camera.model) + ",";
    put_line(text, is_rectified ? "# fx,fy,cx,cy,bf: " : model, numbers, filled);
    if (columns.is_rig) put_line(text, "# T_cb" + place + ": ", camera.T_cb.data(), 12);
  }
}

void put_names_of(std::string& text, const Columns& columns) {
  text += "mp_id,X,Y,Z,u,v,kp";
  if (columns.is_rig) text += ",camera";
  if (columns.depth_cue == DepthCue::stereo) text += ",u_right";
  if (columns.depth_cue == DepthCue::depth) text += ",depth";
  text += ",inv_sigma2";
  if (columns.has_covariances) text += ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz";
  if (columns.has_keyframes) text += ",keyframe";
  text += ",selected\n";
}

bool is_recordable(const FeatureMatch& match) noexcept {
  const double* const covariance = match.covariance;
  return is_measured(match) && (covariance == nullptr || (all_finite(covariance, 9) && covariance[0] >= 0 &&
                                                          covariance[4] >= 0 && covariance[8] >= 0));
}

// -1 for what is not measured. Right columns are those of an image that has the cx of the left one.
void put_match(std::string& text, const FeatureMatch& match, const Columns& columns, double shift_of_right) {
  const auto next = [&](auto value) { put(text += ',', value); };
  put(text, match.point_id);
  for (const double coordinate : match.point) next(coordinate);
  for (const double column_or_row : match.measured) next(column_or_row);
  next(match.id);
  if (columns.is_rig) next(static_cast<unsigned>(match.camera_id));
  if (columns.depth_cue == DepthCue::stereo) {
    const double right = has_right(match) ? match.u_right - shift_of_right : -1;
    next(right >= 0 ? right : -1);
  }
  if (columns.depth_cue == DepthCue::depth) next(has_depth(match) ? match.depth : -1);
  next(1 / (match.sigma * match.sigma));
  if (columns.has_covariances) {
    for (const std::size_t entry : {0U, 1U, 2U, 4U, 5U, 8U})
      next(match.covariance == nullptr ? -1 : match.covariance[entry]);
  }
  if (columns.has_keyframes) next(match.keyframe);
}

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
    is_open_ = false;
    return false;
  }
  std::string name = folder;
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  if (is_open_ && name == folder_) return true;
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

// Says it once, also to a caller that opens the same folder again and again. Returns false.
bool FrameRecorder::fail(const char* why) noexcept {
  is_open_ = false;
  if (refused_ == folder_) return false;
  std::fprintf(stderr, "maxlogdet: %s: %s; %s\n", folder_.c_str(), why,
               number_ == 0 ? "nothing is recorded" : "the recording ends");
  refused_.swap(folder_);
  return false;
}

bool FrameRecorder::skip(const char* why) noexcept {
  if (is_open_ && !has_skipped_) {
    std::fprintf(stderr, "maxlogdet: %s: a frame is not recorded: %s\n", folder_.c_str(), why);
  }
  has_skipped_ = true;
  return false;
}

bool FrameRecorder::write(const MatchedFrame& frame, const unsigned char* selected) noexcept try {
  if (!is_open_) return false;
  const Columns columns(frame);
  if (columns.is_rig && columns.depth_cue == DepthCue::stereo) {
    return fail("a rig with right columns cannot be written into frame files");
  }
  text_.clear();
  put_cameras(text_, frame, columns);
  if (columns.depth_cue == DepthCue::depth) put_line(text_, "# depth_sigma: ", &frame.options.depth_sigma, 1);
  const char* const moved = columns.is_rig ? "body" : "camera";
  put_line(text_, std::string("# Tcw_prior (3x4 row-major, world to ") + moved + "): ", frame.T_bw.data(), 12);
  put_names_of(text_, columns);
  const std::size_t without_matches = text_.size();
  for (std::size_t i = 0; i < frame.size; ++i) {
    if ((frame.usable != nullptr && frame.usable[i] == 0) || !is_recordable(frame.matches[i])) continue;
    put_match(text_, frame.matches[i], columns, frame.cameras[0].pinhole.shift_of_right);
    text_ += selected[i] != 0 ? ",1\n" : ",0\n";
  }
  if (text_.size() == without_matches) return skip("no match of it is measured");
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
