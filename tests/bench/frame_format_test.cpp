// SPDX-License-Identifier: MIT
// Frames of any camera: what docs/frame_format.md allows beyond a rectified pinhole.
#include "bench/world/frame_reader.hpp"

#include "bench/world/image_grid.hpp"
#include "bench/world/names.hpp"
#include "tests/bench/frame_files.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

const std::string pinhole = "# fx,fy,cx,cy,bf: 450,460,376,240,50";
const std::string prior = "# Tcw_prior: 1,0,0,0.5,0,1,0,1,0,0,1,2";
const std::string header = "mp_id,X,Y,Z,u,v";
const std::string row = "7,0.5,0.25,5,100,200";

class FrameFormat : public FrameFiles {
 protected:
  // Errors of the first line.
  void expect_no_camera(const std::vector<std::pair<std::string, std::string>>& cameras_and_errors) const {
    std::vector<BrokenLine> broken;
    for (const auto& [camera, expected] : cameras_and_errors) broken.push_back({1, "# camera: " + camera, expected});
    expect_errors({pinhole, prior, header, row}, broken);
  }
};

TEST_F(FrameFormat, any_model_may_be_the_camera) {
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
    EXPECT_EQ(camera.pinhole.fx, 190);
    EXPECT_EQ(camera.pinhole.fy, 191);
    EXPECT_EQ(camera.pinhole.cx, 376);
    EXPECT_EQ(camera.pinhole.cy, 240);
    EXPECT_EQ(camera.pinhole.bf, 0);
    for (std::size_t i = 0; i < parameter_count(model); ++i) {
      EXPECT_EQ(camera.parameters[i], 0.01 * static_cast<double>(i + 1));
    }
    EXPECT_EQ(frame.camera.depth_cue(), DepthCue::none);
    expect_no_camera({{values + ",1", std::string(to_string(model)) + ",fx,fy,cx,cy and "},
                      {std::string(to_string(model)) + ",1,1,1", "fx,fy,cx,cy and "}});
  }
}

TEST_F(FrameFormat, cameras_that_are_none_are_refused) {
  const std::string range = "distortion within the range of double_sphere";
  expect_no_camera({{"fisheye,190,190,376,240", "a camera model, one of pinhole, "},
                    {"fisheye,190,190,376,240", "not 'fisheye'"},
                    {"", "a camera model, one of "},
                    {"pinhole,0,190,376,240", "positive fx and fy"},
                    {"pinhole,190,-1,376,240", "positive fx and fy"},
                    {"pinhole,190,x,376,240", "a finite number for a camera's parameter, not 'x'"},
                    {"double_sphere,190,190,376,240,0.1,1.5", range},
                    {"double_sphere,190,190,376,240,-1,0.5", range},
                    {"kannala_brandt,190,190,376,240,0,0,0,nan", "a finite number"}});
}

TEST_F(FrameFormat, there_is_exactly_one_camera_or_rig) {
  const std::string camera = "# camera: pinhole,450,460,376,240", first = "# camera 0: pinhole,450,460,376,240";
  for (const auto& [a, b] : {std::pair(pinhole, camera), std::pair(camera, pinhole), std::pair(pinhole, first),
                             std::pair(first, pinhole), std::pair(camera, first)}) {
    expect_error({a, b, prior, header, row}, ":2: ", "one of the comments 'fx,fy,cx,cy,bf', 'camera' and 'camera 0'");
  }
  expect_error({camera, camera, prior, header}, ":2: ", "one comment 'camera'");
  expect_error({first, first, prior, header}, ":2: ", "one comment 'camera0'");
  expect_error({prior, header, row}, ":3: end of file", "'# fx,fy,cx,cy,bf: ...' or '# camera: ...'");
  // Rows depend on it.
  for (const std::string& late : {camera, first, std::string("# depth_sigma: 0.1")}) {
    expect_error({prior, header, late, row}, ":3: ", "above the header");
  }
}

TEST_F(FrameFormat, a_rig_has_cameras_with_transforms) {
  const sim::Frame frame = read({"# camera 0: pinhole,450,460,376,240", "# T_cb 0: 0,-1,0,0.1,1,0,0,0.2,0,0,1,0.3",
                                 "# camera1 (right): double_sphere,190,191,376,240,-0.2,0.6", prior,
                                 "mp_id,X,Y,Z,u,v,camera", "7,0.5,0.25,5,100,200,1", "8,0.5,0.25,5,100,200,0"});
  ASSERT_EQ(frame.camera.rig.size(), 2U);
  EXPECT_FALSE(frame.camera.is_pinhole());
  EXPECT_EQ(frame.camera.rig[0].model, CameraModel::pinhole);
  EXPECT_EQ(frame.camera.rig[0].pinhole.fy, 460);
  EXPECT_EQ(frame.camera.rig[1].model, CameraModel::double_sphere);
  EXPECT_EQ(frame.camera.rig[1].parameters[1], 0.6);
  EXPECT_EQ(frame.camera.rig[0].T_cb.data()[1], -1);
  EXPECT_EQ(frame.camera.rig[0].T_cb.data()[11], 0.3);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(frame.camera.rig[1].T_cb.data()[i], i % 5 == 0 ? 1 : 0) << "the identity";
  EXPECT_EQ(frame.matches[0].camera_id, 1);
  EXPECT_EQ(frame.matches[1].camera_id, 0);
  // Of camera 0: T_cb (T_bw p).
  const auto p = in_camera(frame, frame.matches[1]);
  EXPECT_DOUBLE_EQ(p[0], -1.25 + 0.1);
  EXPECT_DOUBLE_EQ(p[1], 1.0 + 0.2);
  EXPECT_DOUBLE_EQ(p[2], 7 + 0.3);
}

TEST_F(FrameFormat, a_rig_is_numbered_from_zero_without_gaps) {
  const std::string values = "pinhole,450,460,376,240";
  const std::string gap = "the cameras of a rig from 0 on, without gaps, and at most 256";
  expect_error({"# camera 1: " + values, prior, header}, ":1: ", gap);
  expect_error({"# camera 0: " + values, "# camera 2: " + values, prior, header}, ":2: ", gap);
  expect_error({"# T_cb 0: 1,0,0,0,0,1,0,0,0,0,1,0"}, ":1: ", "the comment 'camera 0' before this");
  expect_error({"# camera 0: " + values, "# T_cb 1: 1,0,0,0,0,1,0,0,0,0,1,0"}, ":2: ", "'camera 1' before this");
  expect_error({"# camera: " + values, "# T_cb 0: 1,0,0,0,0,1,0,0,0,0,1,0"}, ":2: ", "'camera 0' before this");
  expect_error({"# camera 0: " + values, "# T_cb 0: 2,0,0,0,0,1,0,0,0,0,1,0"}, ":2: ", "a rotation in the first 3");
  expect_error({"# camera 0: " + values, "# T_cb 0: 1,0,0"}, ":2: ", "12 numbers for T_cb0");
  Lines many;
  for (int i = 0; i <= 256; ++i) many.push_back("# camera " + std::to_string(i) + ": " + values);
  expect_error(many, ":257: ", gap);
  many.back() = prior;
  many.emplace_back("mp_id,X,Y,Z,u,v,camera");
  many.emplace_back("7,0.5,0.25,5,100,200,255");
  EXPECT_EQ(read(many).matches[0].camera_id, 255);
  // Another spelling is another comment: skipped.
  EXPECT_TRUE(read({pinhole, "# camera 00: " + values, "# camera +0: " + values, "# camera -1: " + values,
                    "# T_cb x: 1", prior, header, row})
                  .camera.is_pinhole());
}

TEST_F(FrameFormat, matches_name_a_camera_that_there_is) {
  const Lines lines = {"# camera 0: pinhole,450,460,376,240", "# camera 1: pinhole,450,460,376,240", prior,
                       "mp_id,X,Y,Z,u,v,camera", row + ",1"};
  expect_errors(lines, {{5, row + ",2", "a camera from 0 to 1"},
                        {5, row + ",-1", "a camera from 0 to 1"},
                        {5, row + ",9999999", "a camera from 0 to 1"},
                        {5, row + ",0.5", "an integer for camera, not '0.5'"}});
  expect_error({pinhole, prior, lines[3], row + ",1"}, ":4: ", "a camera from 0 to 0");
  EXPECT_EQ(read({lines[0], lines[1], prior, header, row}).matches[0].camera_id, 0) << "the default";
}

TEST_F(FrameFormat, depths_count_where_their_deviation_is_known) {
  const Lines lines = {pinhole,   "# depth_sigma (m): 0.02", prior, header + ",depth", row + ",4.5", row + ",-1",
                       row + ",0"};
  const sim::Frame frame = read(lines);
  EXPECT_EQ(frame.camera.depth_sigma, 0.02);
  EXPECT_FALSE(frame.camera.is_pinhole());
  EXPECT_EQ(frame.camera.depth_cue(), DepthCue::depth);
  EXPECT_EQ(frame.matches[0].depth, 4.5);
  EXPECT_TRUE(frame.matches[0].has_depth_cue());
  EXPECT_FALSE(frame.matches[1].has_depth_cue());
  EXPECT_FALSE(frame.matches[2].has_depth_cue());
  Lines without = lines;
  without[1] = "# depth: 3";
  const sim::Frame ignored = read(without);
  EXPECT_FALSE(ignored.matches[0].has_depth_cue());
  EXPECT_EQ(ignored.camera.depth_cue(), DepthCue::stereo);
  EXPECT_EQ(read({"# camera: kannala_brandt,190,190,376,240,0,0,0,0", lines[1], prior, lines[3], lines[4]})
                .camera.depth_cue(),
            DepthCue::depth);
  expect_errors(lines, {{2, "# depth_sigma: 0", "a positive depth_sigma, m"},
                        {2, "# depth_sigma: -1", "a positive depth_sigma, m"},
                        {2, "# depth_sigma: 1,2", "1 numbers for depth_sigma"}});
}

TEST_F(FrameFormat, right_columns_are_of_a_pinhole_alone) {
  const std::string stereo = header + ",u_right";
  const std::string expected = "a negative u_right, or no such column";
  for (const std::string& camera :
       {std::string("# camera: kannala_brandt,190,190,376,240,0,0,0,0"),
        std::string("# camera 0: pinhole,450,460,376,240"), pinhole + "\n# depth_sigma: 0.1"}) {
    const int line = camera.find('\n') == std::string::npos ? 4 : 5;
    expect_error({camera, prior, stereo, row + ",90"}, ":" + std::to_string(line) + ": ", expected);
    EXPECT_FALSE(read({camera, prior, stereo, row + ",-1"}).matches[0].is_stereo());
  }
  EXPECT_TRUE(read({pinhole, prior, stereo, row + ",90"}).matches[0].is_stereo());
}

TEST_F(FrameFormat, covariances_are_symmetric_or_unknown) {
  const std::string columns = header + ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz";
  const sim::Frame frame = read({pinhole, prior, columns, row + ",1,0.2,0.3,4,0.5,6", row + ",-1,-1,-1,-1,-1,-1"});
  ASSERT_EQ(frame.map_covariances.size(), 2U);
  EXPECT_EQ(frame.map_covariances[0], (std::array<double, 9>{1, 0.2, 0.3, 0.2, 4, 0.5, 0.3, 0.5, 6}));
  EXPECT_TRUE(std::isnan(frame.map_covariances[1][0])) << "unknown";
  EXPECT_TRUE(read({pinhole, prior, columns, row + ",-1,-1,-1,-1,-1,-1"}).map_covariances.empty()) << "all unknown";
  EXPECT_TRUE(read({pinhole, prior, header, row}).map_covariances.empty());
  sim::Frame filled = frame;
  fill_unknown_covariances(filled, 0.5);
  EXPECT_EQ(filled.map_covariances[0], frame.map_covariances[0]);
  EXPECT_EQ(filled.map_covariances[1], (std::array<double, 9>{0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.25}));
  const std::string variances = "variances cov_yy and cov_zz of 0 or more", all_six = "all six columns cov_xx,";
  expect_errors({pinhole, prior, columns, row + ",1,0,0,1,0,1"},
                {{4, row + ",1,0,0,-4,0,6", variances},
                 {4, row + ",1,0,0,4,0,-6", variances},
                 {4, row + ",1,0,0,4,0", "12 fields"},
                 {4, row + ",1,0,0,nan,0,1", "a finite number for cov_yy"},
                 {3, header + ",cov_xx,cov_xy", all_six},
                 {3, header + ",cov_zz", all_six}});
}

TEST_F(FrameFormat, selections_qualities_keyframes_and_true_poses_are_optional) {
  const sim::Frame plain = read({pinhole, prior, header, row});
  EXPECT_FALSE(plain.has_selection);
  EXPECT_FALSE(plain.has_quality);
  EXPECT_FALSE(plain.T_cw_true);
  EXPECT_EQ(plain.matches[0].keyframe, -1);
  const sim::Frame frame = read({pinhole, prior, "# Tcw_true (3x4): 0,-1,0,1,1,0,0,2,0,0,1,3",
                                 header + ",selected,keyframe,desc_dist", row + ",1,12,30", row + ",0,-1,31"});
  EXPECT_TRUE(frame.has_selection);
  EXPECT_TRUE(frame.has_quality);
  EXPECT_TRUE(frame.matches[0].is_selected);
  EXPECT_FALSE(frame.matches[1].is_selected);
  EXPECT_EQ(frame.matches[0].keyframe, 12);
  EXPECT_EQ(frame.matches[1].keyframe, -1);
  EXPECT_EQ(frame.T_cw_true, (std::array<double, 12>{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3}));
  EXPECT_TRUE(frame.unknown_columns.empty());
  const std::string truth = "# Tcw_true: 1,0,0,0,0,1,0,0,0,0,1,0";
  expect_errors({pinhole, prior, truth, header + ",selected,keyframe", row + ",1,1"},
                {{5, row + ",2,1", "0 or 1 for selected"},
                 {5, row + ",-1,1", "0 or 1 for selected"},
                 {5, row + ",yes,1", "0 or 1 for selected, not 'yes'"},
                 {5, row + ",1,1.5", "an integer for keyframe"},
                 {3, "# Tcw_true: 1,0,0", "12 numbers for Tcw_true"},
                 {3, "# Tcw_true: 2,0,0,0,0,1,0,0,0,0,1,0", "a rotation in the first 3"}});
  expect_error({pinhole, prior, truth, truth}, ":4: ", "one comment 'Tcw_true'");
}

// The cells of an image then divide the extent of the matches of all frames.
TEST_F(FrameFormat, without_a_size_the_matches_of_a_recording_extend_over_the_image) {
  const auto file = [&](const std::string& name, const std::string& u, const std::string& v, bool has_size = false) {
    return write(name, {pinhole, prior, has_size ? "# image width,height: 752,480" : "# no size", header,
                        "1,1,1,1," + u + "," + v, "2,1,1,1,40,40"});
  };
  const std::vector<std::string> files = {file("frame_1.csv", "140", "30"), file("frame_2.csv", "-60", "90"),
                                          file("frame_3.csv", "5000", "90", true)};
  for (const auto& frames : {sim::read_frames(folder_), sim::read_frames(files)}) {
    ASSERT_EQ(frames.size(), 3U);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(frames[i].left, -60);
      EXPECT_EQ(frames[i].top, 30);
      EXPECT_EQ(frames[i].width, 5060);
      EXPECT_EQ(frames[i].height, 60);
    }
    EXPECT_EQ(frames[2].left, 0);
    EXPECT_EQ(frames[2].width, 752);
    EXPECT_EQ(frames[2].height, 480);
  }
  const sim::Frame alone = sim::read_frame(files[0]);
  EXPECT_EQ(alone.width, 100);
  EXPECT_EQ(alone.height, 10);
  const sim::ImageGrid grid{2, 5};
  EXPECT_EQ(grid.cell_of(alone, alone.matches[0]), 1U) << "right, top";
  EXPECT_EQ(grid.cell_of(alone, alone.matches[1]), 8U) << "left, bottom";
  // A single place, or none, is an image of one cell.
  const sim::Frame place = read({pinhole, prior, header, row});
  EXPECT_EQ(grid.cell_of(place, place.matches[0]), 0U);
  EXPECT_TRUE(read({pinhole, prior, header}).matches.empty());
}

}  // namespace
}  // namespace maxlogdet::test
