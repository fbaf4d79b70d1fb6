// SPDX-License-Identifier: Apache-2.0
//
// CameraInfo of bags: on a topic for each camera, on one of both, or not there.
#include "bag_drive.hpp"

namespace stereogrid::app::testing {
namespace {

class BagInfos : public Bags {
 protected:
  static std::vector<Entry> images() {
    return entries({.left = "/stereo/image_left", .right = "/stereo/image_right", .has_infos = false});
  }
  static void add(std::vector<Entry>& all, const std::string& topic, CameraInfo message, const char* frame) {
    message.header.frame_id = frame;
    all.push_back(entry(topic, start_ns + static_cast<std::int64_t>(all.size()), message));
  }
};

TEST_F(BagInfos, OfBothCamerasMayBeOnOneTopic) {
  for (const bool is_right_first : {false, true}) {
    for (const char* const frame : {"left", "right"}) {  // one frame_id for both, too
      std::vector<Entry> all{images()};
      for (const bool is_right : {is_right_first, !is_right_first, is_right_first}) {
        add(all, "/stereo/camera_info", info(is_right), is_right ? frame : "left");
      }
      EXPECT_THAT(expect_plain(all), HasSubstr("CameraInfo of both cameras on /stereo/camera_info"));
    }
  }
}

TEST_F(BagInfos, MayBeCalledAfterTheImages) {
  std::vector<Entry> all{images()};
  add(all, "/stereo/camera_info_left", info(false), "left");
  add(all, "/stereo/camera_info_right", info(true), "right");
  expect_plain(all);
}

TEST_F(BagInfos, WithoutBaselineTakeThatOfTf) {
  std::vector<Entry> all{entries({.has_infos = false})};
  CameraInfo right{info(true)};
  const double baseline_m{-right.p[3] / right.p[0]};
  right.p[3] = 0;
  add(all, "/left/camera_info", info(false), "left_optical");
  add(all, "/right/camera_info", right, "right_optical");
  all.push_back(entry("/tf_static", start_ns,
                      messages::tf2_msgs::TFMessage{{transform("left_optical", "right_optical", {baseline_m, 0, 0})}}));
  EXPECT_THAT(expect_plain(all), HasSubstr("from left_optical to right_optical on /tf_static"));
}

TEST_F(BagInfos, CamerasHaveManyNames) {
  using Names = std::pair<const char*, const char*>;
  for (const auto& [left, right] :
       {Names{"/cam_0/image_rect", "/cam_1/image_rect"}, Names{"/camera1/image_rect", "/camera2/image_rect"},
        Names{"/stereo/L/image_rect", "/stereo/R/image_rect"}, Names{"/camera_l/image_rect", "/camera_r/image_rect"},
        Names{"/Left/image_rect", "/Right/image_rect"}}) {
    expect_plain(entries({.left = left, .right = right}));
  }
}

TEST_F(BagInfos, WithoutKArePOfRectifiedImages) {
  expect_plain(entries({.left = "/left/image_mono",
                        .right = "/right/image_mono",
                        .spoil_infos = [](CameraInfo& left, CameraInfo& right) {
                          for (CameraInfo* info : {&left, &right}) {
                            info->k = {};
                            info->r = {};
                          }
                        }}));
}

TEST_F(BagInfos, OfBinnedAndCroppedImages) {
  expect_plain(entries({.spoil_infos = [](CameraInfo& left, CameraInfo& right) {
    for (CameraInfo* info : {&left, &right}) {  // 380×240 px, of which 320×200 from (20, 10), binned 2 × 2
      info->width = 380;
      info->height = 240;
      info->binning_x = info->binning_y = 2;
      info->roi.x_offset = 20;
      info->roi.y_offset = 10;
      info->roi.width = 320;
      info->roi.height = 200;
      for (const std::size_t i : {0, 3, 5}) info->p.at(i) *= 2;
      info->p[2] = 2 * info->p[2] + 0.5 + 20;
      info->p[6] = 2 * info->p[6] + 0.5 + 10;
    }
  }}));
}

TEST_F(BagInfos, MayHaveCentresThatDiffer) {
  write_mcap(bag(), entries({.spoil_infos = [](CameraInfo&, CameraInfo& right) { right.p[2] += 5; }}));
  const Outcome outcome{run_bag(bag())};  // images of equal centres: all is nearer by 5 px
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("the right image is shifted"));
  const Json rig(json_of(out() / "run.json")["rig"]);
  const Json same(json_of(plain() / "run.json")["rig"]);
  for (const char* const key : {"focal_px", "cx_px", "baseline_m"}) {
    EXPECT_NEAR(rig[key].get<double>(), same[key].get<double>(), 1e-9) << key;
  }
}

TEST_F(BagInfos, OfOneCameraAreNotTakenForBoth) {
  std::vector<Entry> all{images()};
  add(all, "/stereo/camera_info", info(false), "left");
  expect_error(all, "/stereo/camera_info: has the CameraInfo of one camera, but /stereo/image_left and");
  all = entries({.has_infos = false});
  add(all, "/left/camera_info", info(false), "left");
  expect_error(all, "are images of two; /right/camera_info is missing");
  EXPECT_THAT(run_tool({"info", bag()}).errors, Not(HasSubstr("the baseline is zero")));
}

TEST_F(BagInfos, OfThreeCamerasAreRefused) {
  std::vector<Entry> all{images()};
  add(all, "/stereo/camera_info", info(false), "left");
  add(all, "/stereo/camera_info", info(true), "right");
  add(all, "/stereo/camera_info", info(true), "rear");
  expect_error(all, "/stereo/camera_info: has the CameraInfo of more than two cameras");
}

TEST_F(BagInfos, ElsewhereAreNamed) {
  std::vector<Entry> all{images()};
  add(all, "/calibration/first", info(false), "left");
  add(all, "/calibration/second", info(true), "right");
  expect_error(all,
               "/stereo/camera_info: there is no CameraInfo for /stereo/image_left. CameraInfo is on "
               "/calibration/first, /calibration/second.");
}

TEST_F(BagInfos, ThatCannotBeDecodedAreSkipped) {
  std::vector<Entry> all{entries({})};
  for (Entry& one : all) {
    if (one.topic == "/left/camera_info" && one.log_ns == start_ns) one.data.resize(20);
  }
  write_mcap(bag(), all);
  EXPECT_EQ(run_bag(bag()).exit_code, 0);
  for (Entry& one : all) {
    if (one.topic == "/left/camera_info") one.data.resize(20);
  }
  expect_error(all, "/left/camera_info: no message can be decoded.");
}

TEST_F(BagInfos, AreWhatTheCalibrationIs) {
  write_mcap(bag(), entries({}));
  EXPECT_THAT(run_tool({"info", bag()}).output,
              AllOf(HasSubstr("calibration  CameraInfo of /left/camera_info and /right/camera_info"),
                    Not(HasSubstr("none (CameraInfo"))));
}

TEST_F(BagInfos, WithoutImagesOfACameraSayThat) {
  std::vector<Entry> all{entries({})};
  for (Entry& one : all) {
    if (one.topic == "/left/image_rect") one.data.resize(6);
  }
  expect_error(all, "all 4 messages on /left/image_rect are damaged");
  std::erase_if(all, [](const Entry& one) { return one.type != CameraInfo::type_name; });
  expect_error(all, "holds no images", {"--left-topic", "/left/image_rect"});
}

}  // namespace
}  // namespace stereogrid::app::testing
