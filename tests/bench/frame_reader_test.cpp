// SPDX-License-Identifier: MIT
// What docs/frame_format.md promises: every field, every kind of camera, and errors with file and line. All but the
// last four tests are of the reader; csv_dialects_test.cpp has other ways to write a file.
#include "bench/world/frame_reader.hpp"

#include "bench/world/image_grid.hpp"
#include "bench/world/latency.hpp"
#include "bench/world/names.hpp"
#include "tests/bench/frame_files.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace maxlogdet::test {
namespace {

const std::string pinhole = "# fx,fy,cx,cy,bf: 450.5,460,376,240.25,50.5";
const std::string alone = "# camera: pinhole,450,460,376,240";
const std::string first = "# camera 0: pinhole,450,460,376,240";
const std::string fisheye = "# camera: kannala_brandt,190,190,376,240,0,0,0,0";
const std::string identity = ": 1,0,0,0,0,1,0,0,0,0,1,0";
const std::string prior = "# Tcw_prior (3x4 row-major, world to camera): 0,-1,0,0.5,1,0,0,1,0,0,1,2";
const std::string header = "mp_id,X,Y,Z,u,v";
const std::string row = "7,0.5,0.25,5,100,200";
const std::string covariance_header = header + ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz";

class FrameReader : public FrameFiles {};

TEST_F(FrameReader, reads_every_field) {
  const sim::Frame frame = read({"# a frame", pinhole, "", "# image width,height: 752,480", "# Tcw_pred" + identity,
                                 "# Tcw_prior_gt" + identity, "# Tcw_prior_covariance: 1,2,3", prior,
                                 "# Tcw_true (3x4): 0,-1,0,1,1,0,0,2,0,0,1,3",
                                 "kp,mp_id,X,Y,Z,u,v,octave,uR,u_right,depth,inv_sigma2,desc_dist,selected,keyframe",
                                 "3,14,12.35,-1.26,25.45,962,148,0,,945.9,23.6,1,30,1,12",
                                 "33,26,11.93,-0.5,35.14,850,174,2,,-1,-1,0.48225,39,0,-1"});
  EXPECT_EQ(frame.name, "frame_007");
  EXPECT_EQ(frame.camera.fx, 450.5);
  EXPECT_EQ(frame.camera.fy, 460);
  EXPECT_EQ(frame.camera.cx, 376);
  EXPECT_EQ(frame.camera.cy, 240.25);
  EXPECT_EQ(frame.camera.bf, 50.5);
  EXPECT_EQ(frame.width, 752);
  EXPECT_EQ(frame.height, 480);
  EXPECT_EQ(frame.T_cw_prior, (std::array<double, 12>{0, -1, 0, 0.5, 1, 0, 0, 1, 0, 0, 1, 2}));
  EXPECT_EQ(frame.T_cw_true, (std::array<double, 12>{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3}));
  EXPECT_EQ(frame.unknown_columns, (std::vector<std::string>{"uR"}));
  EXPECT_TRUE(frame.has_selection);
  EXPECT_TRUE(frame.has_quality);
  ASSERT_EQ(frame.matches.size(), 2U);
  const sim::Match &stereo = frame.matches[0], &other = frame.matches[1];
  EXPECT_EQ(stereo.keypoint, 3);
  EXPECT_EQ(stereo.map_point_id, 14);
  const double point[3] = {12.35, -1.26, 25.45};
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(stereo.point[axis], point[axis]);
  EXPECT_EQ(stereo.u, 962);
  EXPECT_EQ(stereo.v, 148);
  EXPECT_EQ(stereo.u_right, 945.9);
  EXPECT_TRUE(stereo.is_stereo());
  EXPECT_TRUE(stereo.is_selected);
  EXPECT_EQ(stereo.keyframe, 12);
  EXPECT_FALSE(other.is_stereo());
  EXPECT_EQ(other.octave, 2);
  EXPECT_EQ(other.inv_sigma2, 0.48225);
  EXPECT_EQ(other.desc_dist, 39);
  EXPECT_FALSE(other.is_selected);
  EXPECT_EQ(other.keyframe, -1);
}

TEST_F(FrameReader, columns_that_are_missing_have_defaults) {
  const sim::Frame frame = read({pinhole, prior, header, row, row});
  EXPECT_FALSE(frame.has_selection);
  EXPECT_FALSE(frame.has_quality);
  EXPECT_FALSE(frame.T_cw_true);
  EXPECT_TRUE(frame.map_covariances.empty());
  EXPECT_TRUE(frame.unknown_columns.empty());
  const sim::Match& match = frame.matches.at(1);
  EXPECT_EQ(match.keypoint, 1);
  EXPECT_EQ(match.octave, 0);
  EXPECT_FALSE(match.is_stereo());
  EXPECT_FALSE(match.has_depth_cue());
  EXPECT_EQ(match.inv_sigma2, 1);
  EXPECT_EQ(match.keyframe, -1);
  EXPECT_EQ(match.camera_id, 0);
  EXPECT_TRUE(read({pinhole, prior, header}).matches.empty());
}

TEST_F(FrameReader, names_the_line_and_what_it_expected) {
  const std::string camera = "# fx,fy,cx,cy,bf: ", size = "# image width,height: ", pose = "# Tcw_prior: ";
  const std::string size_range = "width and height from 1 to 2^20";
  const Lines good = {pinhole,
                      size + "1048576,1048576",
                      prior,
                      "# Tcw_true" + identity,
                      "mp_id,X,Y,Z,u,v,depth,octave,inv_sigma2,selected,keyframe",
                      row + ",1,63,1,1,1"};
  EXPECT_EQ(read(good).width, 1048576);
  expect_errors(good, {{6, row, "11 fields"},
                       {6, row + ",1,0,1,1,1,5", "11 fields"},
                       {6, "7,abc,1,5,1,2,1,0,1,1,1", "a finite number for X, not 'abc'"},
                       {6, "7,,1,5,1,2,1,0,1,1,1", "number for X"},
                       {6, "7,nan,1,5,1,2,1,0,1,1,1", "finite number for X"},
                       {6, "7,1,1e999,5,1,2,1,0,1,1,1", "finite number for Y"},
                       {6, "7,1,1.5x,5,1,2,1,0,1,1,1", "number for Y"},
                       {6, "1.5,1,1,5,1,2,1,0,1,1,1", "an integer for mp_id"},
                       {6, row + ",inf,0,1,1,1", "number for depth"},
                       {6, row + ",1,-1,1,1,1", "octave from 0"},
                       {6, row + ",1,64,1,1,1", "octave from 0 to 63"},
                       {6, row + ",1,0,0,1,1", "positive inv_sigma2"},
                       {6, row + ",1,0,1,2,1", "0 or 1 for selected"},
                       {6, row + ",1,0,1,-1,1", "0 or 1 for selected"},
                       {6, row + ",1,0,1,yes,1", "0 or 1 for selected, not 'yes'"},
                       {6, row + ",1,0,1,1,1.5", "an integer for keyframe"},
                       {5, "kp,mp_id,X,Y,u,v", "'Z' is missing"},
                       {5, "kp,mp_id,X,Y,Z,u,v,X", "'X' twice"},
                       {1, camera + "458.654,457.296,367.215,248.375", "5 numbers"},
                       {1, camera + "0,457.296,367.215,248.375,50", "positive fx and fy"},
                       {1, camera + "400,457.296,367.215,248.375,-50", "bf"},
                       {2, size + "0,480", size_range},
                       {2, size + "752,0", size_range},
                       {2, size + "-752,480", size_range},
                       {2, size + "1048577,480", size_range},
                       {2, size + "752,1048577", size_range},
                       {2, size + "752,480,3", "2 integers"},
                       {3, pose + "1,0,0,0,0,1,0,0,0,0,1", "12 numbers"},
                       {3, pose + "2,0,0,0,0,1,0,0,0,0,1,0", "rotation"},
                       {3, pose + "-1,0,0,0,0,-1,0,0,0,0,-1,0", "rotation"},
                       {4, "# Tcw_true: 1,0,0", "12 numbers for Tcw_true"},
                       {4, "# Tcw_true: 2,0,0,0,0,1,0,0,0,0,1,0", "a rotation in the first 3"},
                       {2, pinhole, "one comment 'fx,fy,cx,cy,bf'"},
                       {3, size + "752,480", "one comment 'imagewidth,height'"},
                       {4, prior, "one comment 'Tcw_prior'"}});
  const std::string truth = "# Tcw_true" + identity;
  expect_error({pinhole, prior, truth, truth}, ":4: ", "one comment 'Tcw_true'");
  expect_error({prior, header, row}, ":3: end of file", "'# fx,fy,cx,cy,bf: ...' or '# camera: ...'");
  expect_error({pinhole, header, row}, ":3: end of file", "Tcw_prior");
  expect_error({pinhole, prior}, ":2: end of file", "header line");
  expect_error({}, ":0: end of file", "fx,fy,cx,cy,bf");
}

TEST_F(FrameReader, reads_a_folder_in_order_and_nothing_else_in_it) {
  EXPECT_THROW(sim::read_frames(folder_), sim::InputError) << "an empty folder";
  EXPECT_THROW(sim::read_frame(folder_), sim::InputError) << "a folder is no frame";
  EXPECT_THROW(sim::read_frames(folder_ + "/nowhere.csv"), sim::InputError);
  for (const char* const name : {"frame_002.csv", "frame_010.csv", "frame_001.csv"}) {
    write(name, {pinhole, prior, header, row});
  }
  for (const char* const name : {"ground_truth_T_cw.csv", "frame_003.txt"}) write(name, {"not a frame"});
  const auto frames = sim::read_frames(folder_);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].name, "frame_001");
  EXPECT_EQ(frames[1].name, "frame_002");
  EXPECT_EQ(frames[2].name, "frame_010");
}

TEST_F(FrameReader, any_model_may_be_the_camera) {
  for (const CameraModel model : camera_models) {
    std::string values = to_string(model);
    for (const char* const value : {"190", "191", "376", "240"}) values += std::string(",") + value;
    for (std::size_t i = 0; i < parameter_count(model); ++i) values += ", 0.0" + std::to_string(i + 1);
    const sim::Frame frame = read({"# camera (as calibrated): " + values, prior, header, row});
    const bool is_pinhole = model == CameraModel::pinhole;
    EXPECT_EQ(frame.camera.is_pinhole(), is_pinhole);
    EXPECT_EQ(frame.camera.rig.size(), is_pinhole ? 0U : 1U);
    const Camera camera = is_pinhole ? Camera(frame.camera) : frame.camera.rig[0];
    EXPECT_EQ(camera.model, model);
    const PinholeCamera& p = camera.pinhole;
    EXPECT_EQ((std::array<double, 5>{p.fx, p.fy, p.cx, p.cy, p.bf}), (std::array<double, 5>{190, 191, 376, 240, 0}));
    for (std::size_t i = 0; i < parameter_count(model); ++i) {
      EXPECT_EQ(camera.parameters[i], 0.01 * static_cast<double>(i + 1));
    }
    EXPECT_EQ(frame.camera.depth_cue(), DepthCue::none);
    expect_errors({pinhole, prior, header, row},
                  {{1, "# camera: " + values + ",1", std::string(to_string(model)) + ",fx,fy,cx,cy and "},
                   {1, "# camera: " + std::string(to_string(model)) + ",1,1,1", "fx,fy,cx,cy and "}});
  }
}

TEST_F(FrameReader, cameras_that_are_none_are_refused) {
  const std::string range = "distortion within the range of double_sphere";
  expect_errors({pinhole, prior, header, row},
                {{1, "# camera: fisheye,190,190,376,240", "a camera model, one of pinhole, "},
                 {1, "# camera: fisheye,190,190,376,240", "not 'fisheye'"},
                 {1, "# camera: ", "a camera model, one of "},
                 {1, "# camera: pinhole,0,190,376,240", "positive fx and fy"},
                 {1, "# camera: pinhole,190,-1,376,240", "positive fx and fy"},
                 {1, "# camera: pinhole,190,x,376,240", "a finite number for a camera's parameter, not 'x'"},
                 {1, "# camera: double_sphere,190,190,376,240,0.1,1.5", range},
                 {1, "# camera: double_sphere,190,190,376,240,-1,0.5", range},
                 {1, "# camera: kannala_brandt,190,190,376,240,0,0,0,nan", "a finite number"}});
}

TEST_F(FrameReader, there_is_exactly_one_camera_or_rig_above_the_header) {
  for (const auto& [a, b] : {std::pair(pinhole, alone), std::pair(alone, pinhole), std::pair(pinhole, first),
                             std::pair(first, pinhole), std::pair(alone, first)}) {
    expect_error({a, b, prior, header, row}, ":2: ", "one of the comments 'fx,fy,cx,cy,bf', 'camera' and 'camera 0'");
  }
  expect_error({alone, alone, prior, header}, ":2: ", "one comment 'camera'");
  expect_error({first, first, prior, header}, ":2: ", "one comment 'camera0'");
  for (const std::string& late : {alone, first, std::string("# depth_sigma: 0.1")}) {
    expect_error({prior, header, late, row}, ":3: ", "above the header");  // rows depend on it
  }
}

TEST_F(FrameReader, a_rig_has_cameras_with_transforms) {
  const std::string rig_header = header + ",camera";
  const Lines lines = {first,
                       "# T_cb 0: 0,-1,0,0.1,1,0,0,0.2,0,0,1,0.3",
                       "# camera1 (right): double_sphere,190,191,376,240,-0.2,0.6",
                       prior,
                       rig_header,
                       row + ",1",
                       row + ",0"};
  const sim::Frame frame = read(lines);
  ASSERT_EQ(frame.camera.rig.size(), 2U);
  const Camera &left = frame.camera.rig[0], &right = frame.camera.rig[1];
  EXPECT_FALSE(frame.camera.is_pinhole());
  EXPECT_EQ(left.model, CameraModel::pinhole);
  EXPECT_EQ(left.pinhole.fy, 460);
  EXPECT_EQ(right.model, CameraModel::double_sphere);
  EXPECT_EQ(right.parameters[1], 0.6);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(right.T_cb.data()[i], i % 5 == 0 ? 1 : 0) << "the identity";
  EXPECT_EQ(frame.matches[0].camera_id, 1);
  EXPECT_EQ(frame.matches[1].camera_id, 0);
  // Of camera 0: T_cb (T_bw p), where T_bw p is (0.25, 1.5, 7).
  const auto p = in_camera(frame, frame.matches[1]);
  EXPECT_DOUBLE_EQ(p[0], -1.5 + 0.1);
  EXPECT_DOUBLE_EQ(p[1], 0.25 + 0.2);
  EXPECT_DOUBLE_EQ(p[2], 7 + 0.3);
  expect_errors(lines, {{7, row + ",2", "a camera from 0 to 1"},
                        {7, row + ",-1", "a camera from 0 to 1"},
                        {7, row + ",9999999", "a camera from 0 to 1"},
                        {7, row + ",0.5", "an integer for camera, not '0.5'"}});
  expect_error({pinhole, prior, rig_header, row + ",1"}, ":4: ", "a camera from 0 to 0");
}

TEST_F(FrameReader, a_rig_is_numbered_from_zero_without_gaps) {
  const std::string values = "pinhole,450,460,376,240";
  const std::string gap = "the cameras of a rig from 0 on, without gaps, and at most 256";
  expect_error({"# camera 1: " + values, prior, header}, ":1: ", gap);
  expect_error({first, "# camera 2: " + values, prior, header}, ":2: ", gap);
  expect_error({"# T_cb 0" + identity}, ":1: ", "the comment 'camera 0' before this");
  expect_error({first, "# T_cb 1" + identity}, ":2: ", "'camera 1' before this");
  expect_error({alone, "# T_cb 0" + identity}, ":2: ", "'camera 0' before this");
  expect_error({first, "# T_cb 0: 2,0,0,0,0,1,0,0,0,0,1,0"}, ":2: ", "a rotation in the first 3");
  expect_error({first, "# T_cb 0: 1,0,0"}, ":2: ", "12 numbers for T_cb0");
  Lines many;
  for (int i = 0; i <= 256; ++i) many.push_back("# camera " + std::to_string(i) + ": " + values);
  expect_error(many, ":257: ", gap);
  many.back() = prior;
  many.push_back(header + ",camera");
  many.push_back(row + ",255");
  EXPECT_EQ(read(many).matches[0].camera_id, 255);
  // Another spelling is another comment: skipped.
  EXPECT_TRUE(read({pinhole, "# camera 00: " + values, "# camera +0: " + values, "# camera -1: " + values,
                    "# T_cb x: 1", prior, header, row})
                  .camera.is_pinhole());
}

TEST_F(FrameReader, depths_count_where_their_deviation_is_known) {
  Lines lines = {pinhole, "# depth_sigma (m): 0.02", prior, header + ",depth", row + ",4.5", row + ",-1", row + ",0"};
  const sim::Frame frame = read(lines);
  EXPECT_EQ(frame.camera.depth_sigma, 0.02);
  EXPECT_EQ(frame.camera.depth_cue(), DepthCue::depth);
  EXPECT_EQ(frame.matches[0].depth, 4.5);
  EXPECT_TRUE(frame.matches[0].has_depth_cue());
  EXPECT_FALSE(frame.matches[1].has_depth_cue());
  EXPECT_FALSE(frame.matches[2].has_depth_cue());
  EXPECT_EQ(read({fisheye, lines[1], prior, lines[3], lines[4]}).camera.depth_cue(), DepthCue::depth);
  expect_errors(lines, {{2, "# depth_sigma: 0", "a positive depth_sigma, m"},
                        {2, "# depth_sigma: -1", "a positive depth_sigma, m"},
                        {2, "# depth_sigma: 1,2", "1 numbers for depth_sigma"}});
  lines[1] = "# depth: 3";
  const sim::Frame ignored = read(lines);
  EXPECT_FALSE(ignored.matches[0].has_depth_cue());
  EXPECT_EQ(ignored.camera.depth_cue(), DepthCue::stereo);
}

TEST_F(FrameReader, right_columns_are_of_a_pinhole_alone) {
  const std::string stereo = header + ",u_right";
  for (const Lines& camera : {Lines{fisheye}, Lines{first}, Lines{pinhole, "# depth_sigma: 0.1"}}) {
    Lines lines = camera;
    lines.insert(lines.end(), {prior, stereo, row + ",-1"});
    EXPECT_FALSE(read(lines).matches[0].is_stereo());
    expect_errors(lines, {{lines.size(), row + ",90", "a negative u_right, or no such column"}});
  }
}

TEST_F(FrameReader, covariances_are_symmetric_or_unknown) {
  const std::string unknown = row + ",-1,-1,-1,-1,-1,-1";
  const sim::Frame frame = read({pinhole, prior, covariance_header, row + ",1,0.2,0.3,4,0.5,6", unknown});
  ASSERT_EQ(frame.map_covariances.size(), 2U);
  EXPECT_EQ(frame.map_covariances[0], (std::array<double, 9>{1, 0.2, 0.3, 0.2, 4, 0.5, 0.3, 0.5, 6}));
  EXPECT_TRUE(std::isnan(frame.map_covariances[1][0])) << "unknown";
  EXPECT_TRUE(read({pinhole, prior, covariance_header, unknown}).map_covariances.empty()) << "all unknown";
  sim::Frame filled = frame;
  fill_unknown_covariances(filled, 0.5);
  EXPECT_EQ(filled.map_covariances[0], frame.map_covariances[0]);
  EXPECT_EQ(filled.map_covariances[1], (std::array<double, 9>{0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.25}));
  const std::string variances = "variances cov_yy and cov_zz of 0 or more", all_six = "all six columns cov_xx,";
  expect_errors({pinhole, prior, covariance_header, row + ",1,0,0,1,0,1"},
                {{4, row + ",1,0,0,-4,0,6", variances},
                 {4, row + ",1,0,0,4,0,-6", variances},
                 {4, row + ",1,0,0,4,0", "12 fields"},
                 {4, row + ",1,0,0,nan,0,1", "a finite number for cov_yy"},
                 {3, header + ",cov_xx,cov_xy", all_six},
                 {3, header + ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz", all_six},
                 {3, header + ",cov_zz", all_six}});
}

// The cells of an image then divide the extent of the matches of all frames.
TEST_F(FrameReader, without_a_size_the_matches_of_a_recording_extend_over_the_image) {
  const auto file = [&](const std::string& name, const std::string& u, const std::string& v, bool has_size = false) {
    return write(name, {pinhole, prior, has_size ? "# image width,height: 752,480" : "# no size", header,
                        "1,1,1,1," + u + "," + v, "2,1,1,1,40,40"});
  };
  const std::vector<std::string> files = {file("frame_1.csv", "140", "30"), file("frame_2.csv", "-60", "90"),
                                          file("frame_3.csv", "5000", "90", true)};
  const auto expect_image = [](const sim::Frame& of, double left, double top, double width, double height) {
    EXPECT_EQ((std::array<double, 4>{of.left, of.top, of.width, of.height}),
              (std::array<double, 4>{left, top, width, height}));
  };
  for (const auto& frames : {sim::read_frames(folder_), sim::read_frames(files)}) {
    ASSERT_EQ(frames.size(), 3U);
    for (const std::size_t i : {0U, 1U}) expect_image(frames[i], -60, 30, 5060, 60);
    expect_image(frames[2], 0, 0, 752, 480);
  }
  const sim::Frame one = sim::read_frame(files[0]);
  expect_image(one, 40, 30, 100, 10);
  const sim::ImageGrid grid{2, 5};
  EXPECT_EQ(grid.cell_of(one, one.matches[0]), 1U) << "right, top";
  EXPECT_EQ(grid.cell_of(one, one.matches[1]), 8U) << "left, bottom";
  const sim::Frame place = read({pinhole, prior, header, row});
  EXPECT_EQ(grid.cell_of(place, place.matches[0]), 0U) << "a single place is an image of one cell";
}

TEST(ImageGrid, numbers_cells_row_by_row_and_clamps_pixels_to_the_image) {
  sim::Frame frame;
  frame.width = 752;
  frame.height = 480;
  const sim::ImageGrid grid{10, 8};
  EXPECT_EQ(grid.cells(), 80U);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const struct {
    double u, v;
    std::uint32_t cell;
  } pixels[] = {{0, 0, 0},      {75.19, 59.99, 0}, {75.21, 59.99, 1},      {75.19, 60.01, 10},    {751.99, 479.99, 79},
                {752, 480, 79}, {1e300, -5, 9},    {-1e300, infinity, 70}, {std::nan(""), 61, 10}};
  for (const auto& [u, v, cell] : pixels) {
    sim::Match match;
    match.u = u;
    match.v = v;
    EXPECT_EQ(grid.cell_of(frame, match), cell) << u << ' ' << v;
  }
  frame.width = frame.height = 0;
  sim::Match anywhere;
  anywhere.u = 300;
  EXPECT_LT(grid.cell_of(frame, anywhere), 80U) << "an image of unknown size";
}

TEST(MatchArrays, hold_what_the_frame_holds) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 100, 5);
  const sim::MatchArrays arrays(frame);
  const Matches view = arrays.view();
  ASSERT_EQ(view.size, 100U);
  const auto* const points = static_cast<const double*>(view.points.data());
  int stereo = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_NEAR(view.sigmas[i] * view.sigmas[i] * frame.matches[i].inv_sigma2, 1, 1e-12);
    for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(points[3 * i + j], frame.matches[i].point[j]);
    EXPECT_EQ(view.has_depth_cue[i] != 0, frame.matches[i].is_stereo());
    stereo += view.has_depth_cue[i];
  }
  EXPECT_GT(stereo, 0);
  EXPECT_LT(stereo, 100);
}

TEST(Latency, is_the_nearest_rank) {
  std::vector<double> times;
  for (int i = 200; i >= 1; --i) times.push_back(i);
  const sim::Latency latency = sim::latency_of(times);
  EXPECT_EQ(latency.median, 100);
  EXPECT_EQ(latency.p99, 198);
  EXPECT_EQ(latency.max, 200);
  EXPECT_EQ(sim::latency_of({7}).p99, 7);
  int calls = 0;
  sim::measure_latency("test", 5, [&] { ++calls; });
  EXPECT_EQ(calls, 6) << "one to warm up";
}

TEST(Scene, is_the_same_for_the_same_arguments_and_in_front_of_the_camera) {
  for (const sim::Scene scene : sim::scenes) {
    const sim::Frame frame = make_scene(scene, 500, 3);
    EXPECT_EQ(make_scene(scene, 500, 3).matches[499].u, frame.matches[499].u);
    EXPECT_NE(make_scene(scene, 500, 4).matches[499].u, frame.matches[499].u);
    ASSERT_EQ(frame.matches.size(), 500U);
    std::set<int> octaves;
    for (const sim::Match& match : frame.matches) {
      const auto p = in_camera(frame, match);
      EXPECT_GT(p[2], 0);
      EXPECT_NEAR(frame.camera.fx * p[0] / p[2] + frame.camera.cx, match.u, 1e-8);
      EXPECT_NEAR(frame.camera.fy * p[1] / p[2] + frame.camera.cy, match.v, 1e-8);
      EXPECT_GE(match.u, 0);
      EXPECT_LE(match.u, frame.width);
      EXPECT_NEAR(match.inv_sigma2, std::pow(1.2, -2 * match.octave), 1e-12);
      if (match.is_stereo()) {
        EXPECT_NEAR(match.u - match.u_right, frame.camera.bf / p[2], 1e-8);
      }
      octaves.insert(match.octave);
    }
    EXPECT_EQ(octaves.size(), 8U);
  }
}

}  // namespace
}  // namespace maxlogdet::test
