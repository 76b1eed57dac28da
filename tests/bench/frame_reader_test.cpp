// SPDX-License-Identifier: MIT
// What docs/frame_format.md promises: files, generated with the frame that they hold, and errors with file and line.
// The last three tests are of frames that are read.
#include "bench/world/frame_reader.hpp"

#include "bench/world/latency.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

using Fields = std::vector<std::string>;

std::string printed(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

template <class Values>
std::string listed(const Values& values) {
  std::string text;
  for (const double value : values) text += "," + printed("%.17g", value);
  return text.substr(1);
}

std::string joined(const Fields& fields) {
  std::string text;
  for (const std::string& field : fields) text += "," + field;
  return text.substr(1);
}

const Fields required = {"mp_id", "X", "Y", "Z", "u", "v"};
const Fields covariance = {"cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"};
const Fields optional = {"kp",     "octave",   "u_right",  "inv_sigma2", "desc_dist", "depth",
                         "camera", "keyframe", "selected", "n_obs",      "image"};
const Fields missing = {"", "NA", "NaN", "nan", "null"};

// A frame, and a file of it.
class GeneratedFile {
 public:
  explicit GeneratedFile(Random& random)
      : random_(random),
        is_spaced_(random.chance(0.3)),
        has_index_(random.chance(0.5)),
        line_end_(one_of({"\n", "\r\n"})) {
    text = random.chance(0.3) ? "\xEF\xBB\xBF" : "";
    frame.name = "frame_007";
    write_comments();
    write_header();
    for (int i = random.integer(0, 20); i > 0; --i) write_match();
    if (has_column("selected") && !lacks_selection_) frame.has_selection = true;
    const bool knows_none = std::all_of(frame.map_covariances.begin(), frame.map_covariances.end(),
                                        [](const auto& of_match) { return std::isnan(of_match[0]); });
    if (knows_none) frame.map_covariances.clear();
  }

  sim::Frame frame;
  std::string text;

 private:
  std::string one_of(const Fields& texts) { return texts[random_.index(texts.size())]; }
  bool has_column(const std::string& name) const { return std::count(names_.begin(), names_.end(), name) > 0; }
  std::string spaces() { return is_spaced_ ? std::string(random_.index(3), ' ') : ""; }

  void write_comment(const std::string& comment) {
    if (random_.chance(0.2)) text += one_of({"# a remark", "#", " ", "# Tcw_post: 1,2"}) + line_end_;
    text += spaces() + comment + spaces() + line_end_;
  }

  std::array<double, 12> random_rows() {
    const RigidTransform T(random_isometry(random_, 9, 3).matrix());
    std::array<double, 12> rows{};
    std::copy_n(T.data(), 12, rows.begin());
    return rows;
  }

  void write_comments() {
    const double fx = random_.uniform(100, 900), fy = random_.uniform(100, 900), cx = random_.uniform(0, 700),
                 cy = random_.uniform(0, 500), bf = random_.uniform(0, 60);
    sim::FrameCamera& camera = frame.camera;
    const int kind = random_.integer(0, 3);
    if (kind == 0) {
      camera = {fx, fy, cx, cy, bf};
      write_comment("# fx,fy,cx,cy,bf: " + listed(std::array<double, 5>{fx, fy, cx, cy, bf}));
    }
    for (int i = 0; i < (kind == 3 ? 3 : kind > 0 ? 1 : 0); ++i) {
      Camera one(fx + i, fy, cx, cy);
      one.model = camera_models[random_.index(std::size(camera_models))];
      std::vector<double> values = {fx + i, fy, cx, cy};
      for (std::size_t p = 0; p < parameter_count(one.model); ++p) {
        values.push_back(one.parameters[p] = random_.uniform(0.001, 0.02));
      }
      const std::string text_of_camera = std::string(to_string(one.model)) + "," + listed(values);
      write_comment((kind == 3 ? "# camera " + std::to_string(i) : "# camera (as calibrated)") + ": " + text_of_camera);
      if (kind == 3 && random_.chance(0.7)) {
        const std::array<double, 12> rows = random_rows();
        one.T_cb = RigidTransform::row_major(rows.data());
        write_comment("# T_cb " + std::to_string(i) + ": " + listed(rows));
      }
      if (kind == 3 || one.model != CameraModel::pinhole) camera.rig.push_back(one);
      if (kind != 3) static_cast<PinholeCamera&>(camera) = one.pinhole;
    }
    if (random_.chance(0.3)) {
      camera.depth_sigma = random_.uniform(0.01, 0.1);
      text += "# depth_sigma (m): " + printed("%.17g", camera.depth_sigma) + line_end_;
    }
    frame.width = 752;
    frame.height = 480;
    write_comment("# image width,height: 752,480");
    frame.T_cw_prior = random_rows();
    write_comment("# Tcw_prior (3x4 row-major, world to camera): " + listed(frame.T_cw_prior));
    if (!random_.chance(0.5)) return;
    frame.T_cw_true = random_rows();
    write_comment("# Tcw_true: " + listed(*frame.T_cw_true));
  }

  void write_line(Fields fields, const std::string& index) {
    if (has_index_) fields.insert(fields.begin(), index);
    for (std::string& field : fields) field = spaces() + field + spaces();
    text += joined(fields) + line_end_;
  }

  void write_header() {
    names_ = required;
    for (const std::string& name : optional) {
      if (random_.chance(0.7)) names_.push_back(name);
    }
    if (random_.chance(0.6)) names_.insert(names_.end(), covariance.begin(), covariance.end());
    for (std::size_t i = names_.size(); i > 1; --i) std::swap(names_[i - 1], names_[random_.index(i)]);
    if (has_column("image")) frame.unknown_columns = {"image"};
    write_line(names_, "");
  }

  std::string real(double value) { return printed(one_of({"%.17g", "%.17e", "%.18g", "%+.17g"}).c_str(), value); }
  std::string whole(std::int64_t value) {
    return one_of({std::to_string(value), std::to_string(value) + ".0", printed("%.6e", static_cast<double>(value))});
  }

  // A value of an optional column, or none.
  template <class Number>
  void perhaps(const std::string& name, double value, Number& member) {
    if (!has_column(name)) return;
    row_[name] = one_of(missing);
    if (random_.chance(0.2)) return;
    member = static_cast<Number>(value);
    row_[name] = std::is_integral<Number>::value ? whole(static_cast<std::int64_t>(value)) : real(value);
  }

  void write_match() {
    sim::Match match;
    row_ = {{"n_obs", "x"}, {"image", "a b.png"}};
    row_["mp_id"] = whole(match.map_point_id = random_.integer(-100, 100000));
    double* const reals[] = {&match.point[0], &match.point[1], &match.point[2], &match.u, &match.v};
    for (std::size_t i = 0; i < 5; ++i) {
      row_[required[i + 1]] = real(*reals[i] = random_.uniform(-1, 1) * std::exp2(random_.integer(-30, 30)));
    }
    match.keypoint = static_cast<std::int64_t>(frame.matches.size());
    perhaps("kp", random_.integer(0, 5000), match.keypoint);
    perhaps("octave", random_.integer(0, 63), match.octave);
    perhaps("u_right", frame.camera.is_pinhole() ? random_.uniform(-1, 700) : -1, match.u_right);
    perhaps("inv_sigma2", random_.uniform(0.1, 1), match.inv_sigma2);
    perhaps("desc_dist", random_.uniform(0, 100), match.desc_dist);
    perhaps("depth", random_.uniform(-1, 20), match.depth);
    if (!(frame.camera.depth_sigma > 0)) match.depth = -1;
    perhaps("camera", frame.camera.rig.empty() ? 0 : random_.integer(0, static_cast<int>(frame.camera.rig.size()) - 1),
            match.camera_id);
    perhaps("keyframe", random_.integer(-1, 50), match.keyframe);
    if (random_.chance(0.98) && has_column("selected")) {
      match.is_selected = random_.chance(0.5);
      row_["selected"] = match.is_selected ? one_of({"1", "True", "true"}) : one_of({"0", "False", "false"});
    } else {
      lacks_selection_ = true;
    }
    if (has_column("cov_xx")) frame.map_covariances.push_back(random_covariance_fields());
    frame.matches.push_back(match);
    Fields fields;
    for (const std::string& name : names_) fields.push_back(row_[name]);
    if (random_.chance(0.1)) text += "# one, with, some, commas" + line_end_;
    write_line(fields, one_of({"r1", "12", ""}));
  }

  std::array<double, 9> random_covariance_fields() {
    std::array<double, 9> entries{nan};
    const int kind = random_.integer(0, 2);
    for (std::size_t i = 0; i < 6; ++i) row_[covariance[i]] = kind == 0 ? "-1" : one_of(missing);
    if (kind < 2) return entries;
    const Eigen::Vector3d root = random_vector(random_, 9);
    Eigen::Map<Eigen::Matrix3d> of_point(entries.data());
    of_point = root * root.transpose();
    const std::size_t upper[] = {0, 1, 2, 4, 5, 8};
    for (std::size_t i = 0; i < 6; ++i) row_[covariance[i]] = real(entries[upper[i]]);
    return entries;
  }

  Random& random_;
  bool is_spaced_, has_index_;
  std::string line_end_;
  Fields names_;  // of the columns
  std::map<std::string, std::string> row_;
  bool lacks_selection_ = false;  // a row
};

// All numbers of a frame, with infinity for NaN, so that those of equal frames are equal.
std::vector<double> numbers_of(const sim::Frame& frame) {
  std::vector<double> numbers = {frame.camera.bf, frame.camera.depth_sigma,     frame.left, frame.top, frame.width,
                                 frame.height,    frame.has_selection ? 1.0 : 0};
  const auto add = [&](const double* entries, std::size_t count) {
    numbers.insert(numbers.end(), entries, entries + count);
  };
  const auto add_camera = [&](const Camera& camera) {
    const PinholeCamera& p = camera.pinhole;
    numbers.insert(numbers.end(), {p.fx, p.fy, p.cx, p.cy, static_cast<double>(camera.model)});
    add(camera.parameters, parameter_count(camera.model));
    add(camera.T_cb.data(), 12);
  };
  add_camera(frame.camera);
  for (const Camera& camera : frame.camera.rig) add_camera(camera);
  add(frame.T_cw_prior.data(), 12);
  add(frame.T_cw_true ? frame.T_cw_true->data() : nullptr, frame.T_cw_true ? 12 : 0);
  for (const sim::Match& m : frame.matches) {
    add(m.point, 3);
    numbers.insert(numbers.end(), {m.u, m.v, m.u_right, m.depth, m.inv_sigma2, m.desc_dist});
    for (const std::int64_t integer : {m.map_point_id, m.keypoint, m.keyframe, std::int64_t{m.octave},
                                       std::int64_t{m.camera_id}, std::int64_t{m.is_selected}}) {
      numbers.push_back(static_cast<double>(integer));
    }
  }
  for (const auto& entries : frame.map_covariances) add(entries.data(), std::isnan(entries[0]) ? 1 : 9);
  std::replace_if(
      numbers.begin(), numbers.end(), [](double x) { return std::isnan(x); }, infinity);
  return numbers;
}

class FrameReader : public TextFolder {
 protected:
  std::string write_text(const std::string& text) const {
    std::ofstream(path("frame_007.csv"), std::ios::binary) << text;
    return path("frame_007.csv");
  }
  sim::Frame read(const Lines& lines) const { return sim::read_frame(write("frame_007.csv", lines)); }
  // The message must name file, line and what was expected.
  void expect_error(const Lines& lines, const std::string& place, const std::string& expected) const {
    const std::string file = write("frame_007.csv", lines);
    expect_input_error([&] { sim::read_frame(file); }, file + place, expected);
  }
  void expect_errors(const Lines& good, const std::vector<BrokenLine>& broken) const {
    expect_every_one_refused("frame_007.csv", good, broken, [&] { sim::read_frame(path("frame_007.csv")); });
  }

  const std::string pinhole = "# fx,fy,cx,cy,bf: 450.5,460,376,240.25,50.5",
                    size = "# image width,height: 1048576,1048576",
                    prior = "# Tcw_prior (3x4 row-major, world to camera): 0,-1,0,0.5,1,0,0,1,0,0,1,2",
                    first = "# camera 0: pinhole,450,460,376,240", identity = ": 1,0,0,0,0,1,0,0,0,0,1,0",
                    header = "mp_id,X,Y,Z,u,v", row = "7,0.5,0.25,5,100,200";
};

TEST_F(FrameReader, reads_the_frame_that_was_written_bit_for_bit) {
  for (std::size_t repetition = trials(400); repetition > 0; --repetition) {
    TracedRandom random(repetition);
    const GeneratedFile generated(random);
    SCOPED_TRACE(generated.text);
    sim::Frame read;
    ASSERT_NO_THROW(read = sim::read_frame(write_text(generated.text)));
    EXPECT_EQ(read.name, generated.frame.name);
    EXPECT_EQ(read.unknown_columns, generated.frame.unknown_columns);
    ASSERT_EQ(numbers_of(read), numbers_of(generated.frame));
  }
}

TEST_F(FrameReader, keeps_integers_that_no_double_holds) {
  EXPECT_EQ(read({pinhole, prior, header, "9007199254740993,1,2,3,4,5"}).matches[0].map_point_id, 9007199254740993);
  EXPECT_EQ(read({pinhole, prior, header, "-0.5e1,1,2,3,4,5"}).matches[0].map_point_id, -5);
}

TEST_F(FrameReader, names_file_line_and_column_of_every_field_that_it_cannot_read) {
  Fields names = required;
  names.insert(names.end(), optional.begin(), optional.end());
  names.insert(names.end(), covariance.begin(), covariance.end());
  const Lines good = {pinhole, "# depth_sigma: 1", prior, joined(names)};
  const std::set<std::string> integers = {"mp_id", "kp", "octave", "camera", "keyframe"};
  const std::set<std::string> texts = {"n_obs", "image", "selected"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (texts.count(names[i]) > 0) continue;
    const bool is_integer = integers.count(names[i]) > 0;
    Fields bad = is_integer ? Fields{"1.5", "1e300", "9007199254740993.0", "0x10", "True", "x"}
                            : Fields{"abc", "1e999", "inf", "1.5x", "\"1.5\"", "#REF!"};
    const bool may_be_missing = i >= required.size() && (names[i].rfind("cov", 0) != 0 || names[i] == "cov_xx");
    if (!may_be_missing) bad.insert(bad.end(), missing.begin(), missing.end());
    for (const std::string& field : bad) {
      Fields values(names.size(), "0");
      values[8] = "-1";  // u_right, as depths have a deviation
      values[9] = "1";   // inv_sigma2
      values[i] = field;
      Lines lines = good;
      lines.push_back(joined(values));
      expect_error(lines, ":5: ", (is_integer ? "an integer for " : "a finite number for ") + names[i] + ", not '");
    }
  }
}

TEST_F(FrameReader, names_what_it_expected_of_rows_and_headers) {
  const std::string all = header + ",octave,inv_sigma2,selected,camera,u_right";
  const Lines good = {pinhole, prior, all, row + ",63,1,1,0,5"};
  EXPECT_EQ(read(good).matches[0].octave, 63);
  expect_errors(good, {{4, row, "11 fields as in the header, not 6"},
                       {4, row + ",63,1,1,0,5,7", "11 fields as in the header, not 12"},
                       {4, row + ",64,1,1,0,5", "an octave from 0 to 63"},
                       {4, row + ",0,0,1,0,5", "a positive inv_sigma2"},
                       {4, row + ",0,1,yes,0,5", "0 or 1 for selected, not 'yes'"},
                       {4, row + ",0,1,1,1,5", "a camera from 0 to 0"},
                       {4, row + ",0,1,1,-1,5", "a camera from 0 to 0"},
                       {3, header + ",X", "'X' twice"},
                       {3, "mp_id;X;Y;Z;u;v", "between commas and without quotes; 'mp_id' is missing"},
                       {3, "mp_id,X,Y,u,v", "'Z' is missing"},
                       {3, header + ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz", "all six columns cov_xx,"}});
  expect_errors({pinhole, prior, header + "," + joined(covariance), row + ",1,0,0,1,0,1"},
                {{4, row + ",1,0,0,-4,0,6", "variances cov_yy and cov_zz of 0 or more"},
                 {4, row + ",1,0,0,4,0,-6", "variances cov_yy and cov_zz of 0 or more"}});
  for (const Lines& camera : {Lines{"# camera: kannala_brandt,190,190,376,240,0,0,0,0"}, Lines{first},
                              Lines{pinhole, "# depth_sigma: 0.1"}}) {
    Lines lines = camera;
    lines.insert(lines.end(), {prior, header + ",u_right", row + ",90"});
    expect_error(lines, ":" + std::to_string(lines.size()) + ": ", "a negative u_right, or no such column");
  }
}

TEST_F(FrameReader, names_what_it_expected_of_comments) {
  const std::string camera = "# camera: ", sides = "width and height from 1 to 2^20";
  const std::string one = "one of the comments 'fx,fy,cx,cy,bf', 'camera' and 'camera 0'";
  const Lines good = {pinhole, size, prior, "# Tcw_true" + identity, header, row};
  EXPECT_EQ(read(good).width, 1048576);
  expect_errors(good, {{1, "# fx,fy,cx,cy,bf: 458,457,367,248", "5 numbers"},
                       {1, "# fx,fy,cx,cy,bf: 0,457,367,248,50", "positive fx and fy"},
                       {1, "# fx,fy,cx,cy,bf: 458,457,367,248,-50", "bf of 0 (monocular) or more"},
                       {2, "# image width,height: 0,480", sides},
                       {2, "# image width,height: 1048577,480", sides},
                       {2, "# image width,height: 752,480,3", "2 integers"},
                       {3, "# Tcw_prior: 2,0,0,0,0,1,0,0,0,0,1,0", "rotation"},
                       {3, "# Tcw_prior: -1,0,0,0,0,-1,0,0,0,0,-1,0", "R is a reflection"},
                       {4, prior, "one comment 'Tcw_prior'"},
                       {2, "# depth_sigma: 0", "a positive depth_sigma, m"},
                       {2, first, one},
                       {2, camera + "pinhole,450,460,376,240", one},
                       {6, "# depth_sigma: 0.1", "above the header"},
                       {1, camera + "fisheye,190,190,376,240", "a camera model, one of pinhole, "},
                       {1, camera + "kannala_brandt,1,1,1", "kannala_brandt,fx,fy,cx,cy and 4 parameters"},
                       {1, camera + "kannala_brandt,-190,190,376,240,0.1,0,0,0", "positive fx and fy"}});
  const std::string gap = "the cameras of a rig from 0 on, without gaps, and at most 256";
  expect_errors({first, "# T_cb 0" + identity, prior, header, row},
                {{1, "# camera 1: pinhole,450,460,376,240", gap},
                 {2, "# T_cb 1" + identity, "the comment 'camera 1' before this"},
                 {2, "# T_cb 0: 1,0,0", "12 numbers for T_cb0"}});
  Lines many;
  for (int i = 0; i <= 256; ++i) many.push_back("# camera " + std::to_string(i) + ": pinhole,450,460,376,240");
  expect_error(many, ":257: ", gap);
  expect_error({prior, header, row}, ":3: end of file", "'# fx,fy,cx,cy,bf: ...' or '# camera: ...'");
  expect_error({pinhole, header, row}, ":3: end of file", "Tcw_prior");
  expect_error({pinhole, prior}, ":2: end of file", "header line");
  expect_error({}, ":0: end of file", "fx,fy,cx,cy,bf");
}

TEST_F(FrameReader, refuses_what_is_no_text_or_never_ends) {
  std::string utf16 = "\xFF\xFE";
  for (const char c : std::string("# fx\n")) utf16 += std::string{c, '\0'};
  const std::string binary = write_text(utf16);
  expect_input_error([&] { sim::read_frame(binary); }, binary + ":1: ", "UTF-16 or binary data; save as UTF-8");
  for (const std::string& text : {std::string(70000, 'x'), std::string(70000, ' ') + "\n"}) {
    const std::string file = write_text("\n" + text);
    expect_input_error([&] { sim::read_frame(file); }, file + ":2: ", "a line of at most 65536 bytes");
  }
  expect_input_error([] { sim::read_frame("/dev/zero"); }, "/dev/zero:1: ", "a line of at most 65536 bytes");
}

TEST_F(FrameReader, reads_a_folder_in_order_and_nothing_else_in_it) {
  EXPECT_THROW(sim::read_frames(folder_), sim::InputError) << "an empty folder";
  EXPECT_THROW(sim::read_frame(folder_), sim::InputError) << "a folder is no frame";
  EXPECT_THROW(sim::read_frames(folder_ + "/nowhere.csv"), sim::InputError);
  for (const char* const name : {"frame_002.csv", "frame_010.csv", "frame_001.csv"}) {
    const std::string sizes = name == std::string("frame_010.csv") ? "# image width,height: 752,480" : "# no size";
    write(name, {pinhole, prior, sizes, header, "1,1,1,1," + std::string(name, 6, 3) + ",30", "2,1,1,1,40,90"});
  }
  for (const char* const name : {"ground_truth_T_cw.csv", "frame_003.txt"}) write(name, {"not a frame"});
  const auto frames = sim::read_frames(folder_);
  ASSERT_EQ(frames.size(), 3U);
  const char* const names[] = {"frame_001", "frame_002", "frame_010"};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i].name, names[i]);
    // The extent of the matches of all frames, so that cells of the image are the same in all of them.
    EXPECT_EQ((std::array<double, 4>{frames[i].left, frames[i].top, frames[i].width, frames[i].height}),
              i == 2 ? (std::array<double, 4>{0, 0, 752, 480}) : (std::array<double, 4>{1, 30, 39, 60}));
  }
}

TEST(Frame, gives_matches_the_measurement_that_is_asked_for_and_the_covariances_that_are_known) {
  sim::Frame frame;
  frame.matches.resize(2);
  frame.matches[0].inv_sigma2 = 0.25;
  frame.matches[0].u_right = 90;
  frame.matches[0].depth = 3;
  frame.matches[1].camera_id = 7;
  frame.map_covariances = {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {nan}};
  for (const DepthCue cue : {DepthCue::none, DepthCue::stereo, DepthCue::depth}) {
    const std::vector<FeatureMatch> matches = feature_matches(frame, cue);
    EXPECT_EQ(matches[0].sigma, 2);
    EXPECT_EQ(matches[0].u_right, cue == DepthCue::stereo ? 90 : unmeasured);
    EXPECT_EQ(matches[0].depth, cue == DepthCue::depth ? 3 : unmeasured);
    EXPECT_EQ(matches[0].covariance, frame.map_covariances[0].data());
    EXPECT_EQ(matches[1].camera_id, 7);
    EXPECT_EQ(matches[1].covariance, nullptr);
  }
  frame.map_covariances.clear();
  EXPECT_EQ(feature_matches(frame, DepthCue::none)[0].covariance, nullptr);
}

TEST(ImageGrid, numbers_cells_row_by_row_and_clamps_pixels_to_the_image) {
  sim::Frame frame;
  frame.left = -60;
  frame.top = 30;
  frame.width = 752;
  frame.height = 480;
  const auto cell_of = [&](double u, double v) {
    sim::Match match;
    match.u = frame.left + u;
    match.v = frame.top + v;
    return sim::ImageGrid{10, 8}.cell_of(frame, match);
  };
  const std::vector<std::uint32_t> cells = {cell_of(0, 0),         cell_of(75.19, 59.99),     cell_of(75.21, 59.99),
                                            cell_of(75.19, 60.01), cell_of(751.99, 479.99),   cell_of(752, 480),
                                            cell_of(1e300, -5),    cell_of(-1e300, infinity), cell_of(nan, 61)};
  EXPECT_EQ(cells, (std::vector<std::uint32_t>{0, 0, 1, 10, 79, 79, 9, 70, 10}));
  frame.width = frame.height = 0;
  EXPECT_LT(cell_of(0, 0), 80U) << "an image of unknown size";
}

TEST(Latency, is_the_nearest_rank) {
  std::vector<double> times(200);
  std::iota(times.rbegin(), times.rend(), 1.0);
  const sim::Latency latency = sim::latency_of(times);
  EXPECT_EQ((std::array<double, 3>{latency.median, latency.p99, latency.max}), (std::array<double, 3>{100, 198, 200}));
  EXPECT_EQ(sim::latency_of({7}).p99, 7);
  int calls = 0;
  sim::measure_latency("test", 5, [&] { ++calls; });
  EXPECT_EQ(calls, 6) << "one to warm up";
}

}  // namespace
}  // namespace maxlogdet::test
