// SPDX-License-Identifier: Apache-2.0
// Recordings that give disparities instead of right images.
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using ::testing::Contains, ::testing::ElementsAre, ::testing::HasSubstr;

struct GivenRecording : FolderTest {
  [[nodiscard]] std::unique_ptr<Recording> open(const fs::path& root,
                                                const std::optional<fs::path>& disparities = {}) const {
    return open_recording({{folder / root}, {}, "", disparities});
  }
  /// Disparities 3, 4, … px all over.
  void put_disparities(const fs::path& side, const std::vector<std::string>& names) const {
    fs::create_directories(folder / side);
    for (std::size_t i{0}; i < names.size(); ++i) {
      write_png(folder / side / (names[i] + ".png"),
                Image<std::uint16_t>{small_width_px, small_height_px, static_cast<std::uint16_t>((3 + i) * 256)});
    }
  }
  void put_plain_given() const {
    put_plain(folder.path());
    fs::remove_all(folder / "right");
    put_disparities("disparity", {"a", "b", "c"});
  }
};

TEST_F(GivenRecording, PlainFolderWithDisparities) {
  put_plain_given();
  const auto recording{open("")};
  EXPECT_TRUE(recording->gives_disparities());
  EXPECT_EQ(recording->contents().kind, "plain folder");
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("disparities: given in")));
  EXPECT_TRUE(recording->contents().warnings.empty());
  ASSERT_EQ(recording->size(), 3U);
  const StereoFrame frame{recording->load(1)};
  EXPECT_EQ(frame.left(0, 0), 11);
  EXPECT_TRUE(frame.right.empty());
  EXPECT_EQ(frame.disparity, (Image<float>{small_width_px, small_height_px, 4}));
  EXPECT_EQ(frame.stamp_ns, 100'000'005);
  EXPECT_DOUBLE_EQ(frame.world_from_vehicle->x_m, 1);
  EXPECT_FALSE(finding_if_swapped(frame));
}

TEST_F(GivenRecording, DepthBecomesDisparities) {
  put_plain(folder.path());
  fs::create_directories(folder / "depth");
  for (const char* const name : {"a", "b", "c"}) {
    write_png(folder / "depth" / (std::string{name} + ".png"),
              Image<std::uint16_t>{small_width_px, small_height_px, 5000});
  }
  const auto at = [&](double units_per_m) {
    InputArguments arguments{{folder.path()}, {}, ""};
    arguments.depth = folder / "depth";
    arguments.depth_units_per_m = units_per_m;
    const auto recording{open_recording(arguments)};
    EXPECT_TRUE(recording->gives_disparities());
    const Rig& rig{recording->rig()};
    const float d{recording->load(0).disparity(3, 3)};
    EXPECT_TRUE(recording->load(0).right.empty());
    return rig.focal_px * rig.baseline_m / d;
  };
  EXPECT_NEAR(at(1000), 5, 1e-5);
  EXPECT_NEAR(at(5000), 1, 1e-5);
  fs::remove_all(folder / "right");
  const auto found{open("")};
  EXPECT_NEAR(found->load(0).disparity(0, 0), found->rig().focal_px * found->rig().baseline_m / 5, 1e-5);
}

TEST_F(GivenRecording, DepthInWholeUnitsIsDividedExactly) {
  // as in bags and Python: 1002 times the float 0.001 is another number
  write_png(folder / "depth.png", Image<std::uint16_t>{small_width_px, small_height_px, 1002});
  EXPECT_EQ(read_depth(folder / "depth.png", 1000)(3, 3), 1.002F);
}

TEST_F(GivenRecording, RightImagesComeFirst) {
  put_plain(folder.path());
  put_disparities("disparity", {"a", "b", "c"});
  const auto recording{open("")};
  EXPECT_FALSE(recording->gives_disparities());
  EXPECT_TRUE(recording->load(0).disparity.empty());
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("there are right images (--disparities takes them)")));
  EXPECT_EQ(open("", folder / "disparity")->load(0).disparity(3, 3), 3.0F);
}

TEST_F(GivenRecording, AnyLayoutTakesAFolder) {
  put_odometry(folder / "odometry");
  put_disparities("given", {"000046", "000047", "000048", "000099"});
  const auto with_right{open("odometry", folder / "given")};
  ASSERT_EQ(with_right->size(), 3U) << "a disparity image without a left one is not a frame";
  EXPECT_EQ(with_right->load(2).disparity(0, 0), 5.0F);
  EXPECT_DOUBLE_EQ(with_right->load(2).world_from_vehicle->x_m, 9);
  fs::remove_all(folder / "odometry" / "image_1");
  EXPECT_EQ(open("odometry", folder / "given")->load(0).disparity(0, 0), 3.0F) << "right images are not needed";
  const fs::path left{folder / "odometry" / "image_0" / "000047.png"};
  const auto pair{open_recording({{left, left}, folder / "odometry" / "calib.txt", "", folder / "given"})};
  EXPECT_EQ(pair->load(0).disparity(0, 0), 4.0F);
}

TEST_F(GivenRecording, RightImagesMayComeBesideDisparities) {
  put_odometry(folder / "odometry");
  put_disparities("given", {"000046", "000047", "000048"});
  InputArguments arguments{{folder / "odometry"}, {}, ""};
  arguments.with_right = true;
  expect_error<ConfigError>([&] { return open_recording(arguments); }, {"--with-right needs --disparities"});
  arguments.disparities = folder / "given";
  fs::remove(folder / "odometry" / "image_1" / "000048.png");
  const auto recording{open_recording(arguments)};
  const StereoFrame frame{recording->load(0)};
  EXPECT_EQ(frame.disparity(0, 0), 3.0F);
  EXPECT_EQ(frame.right, open_recording({{folder / "odometry"}, {}, ""})->load(0).right);
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("right images for features")));
  EXPECT_THROW(static_cast<void>(recording->load(2)), InputError) << "its right image is missing";
}

TEST_F(GivenRecording, AMissingOneIsThatFramesError) {
  put_plain_given();
  fs::remove(folder / "disparity" / "b.png");
  const auto recording{open("")};
  ASSERT_EQ(recording->size(), 3U);
  EXPECT_THAT(recording->contents().warnings, ElementsAre(HasSubstr("frame b: the disparity image is missing")));
  expect_error([&] { return recording->load(1); }, {"b.png", "disparity image", "missing"});
  EXPECT_EQ(recording->load(2).disparity(0, 0), 5.0F);
}

TEST_F(GivenRecording, AnotherSizeIsThatFramesError) {
  put_plain_given();
  write_png(folder / "disparity" / "b.png", Image<std::uint16_t>{small_width_px, 32, 512});
  const auto recording{open("")};
  expect_error([&] { return recording->load(1); }, {"b.png", "65×33", "65×32", "same size"});
  EXPECT_EQ(recording->load(0).disparity(0, 0), 3.0F);
}

TEST_F(GivenRecording, FoldersThatCannotBeUsed) {
  put_plain_given();
  expect_error([&] { return open("", folder / "nowhere"); }, {"nowhere", "no such folder"});
  fs::create_directories(folder / "empty");
  expect_error([&] { return open("", folder / "empty"); }, {"empty", "no images", "NPY"});
  put_disparities("others", {"x"});
  expect_error([&] { return open("", folder / "others"); }, {"no left image has a disparity one", "left and others"});
  put(folder / "disparity" / "a.npy", "");
  expect_error([&] { return open(""); }, {"a.", "another image of the same name"});
}

}  // namespace
}  // namespace stereogrid::io::testing
