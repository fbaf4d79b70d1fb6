// SPDX-License-Identifier: Apache-2.0
//
// Several stereo pairs on one vehicle: one grid, one filter, one list of obstacles.
#include <cmath>
#include <set>

#include "chain_run.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/points.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* four_cameras{"around?cameras=4&width=256&height=160&focal=128&frames=45"};
constexpr double wall_m{9};

Config grid_around() {
  Config config{preset("default")};
  config.grid.length_m = config.grid.rear_m = 10;
  return config;
}

/// Without the frame of a camera.
StereoFrame without(StereoFrame frame, int camera) {
  std::erase_if(frame.others, [camera](const StereoFrame& other) { return other.camera == camera; });
  if (frame.camera != camera) return frame;
  StereoFrame first{std::move(frame.others.front())};
  first.others.assign(std::make_move_iterator(frame.others.begin() + 1), std::make_move_iterator(frame.others.end()));
  return first;
}

struct SeveralCameras : ::testing::Test {
  const Scene scene{four_cameras};
  Pipeline pipeline{grid_around(), scene.rigs(), {.threads = 2}};
};

void expect_equal(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.observed, b.observed);
  EXPECT_EQ(a.vehicle.occupancy, b.vehicle.occupancy);
  EXPECT_EQ(a.world_terrain, b.world_terrain);
  EXPECT_EQ(a.obstacles.size(), b.obstacles.size());
}

TEST_F(SeveralCameras, FillOneGridAroundTheVehicle) {
  for (std::size_t i{0}; i < 4; ++i) pipeline.process(scene.load(i));
  const FrameResult& result{pipeline.process(scene.load(4))};
  EXPECT_TRUE(result.status.empty());
  ASSERT_EQ(result.cameras.size(), 4u);
  const GridGeometry& grid{result.vehicle.geometry};
  EXPECT_EQ(grid.x_min_m, -10);
  for (std::size_t camera{0}; camera < 4; ++camera) {
    const Point2 wall{camera_place(scene.rigs()[camera]) * Point2{wall_m - 0.5, 0}};
    const Point2 ground{camera_place(scene.rigs()[camera]) * Point2{2.5, 0.5}};
    EXPECT_GT(highest_near(result.vehicle.occupancy, grid, wall), 0.9) << camera;
    EXPECT_LT(result.vehicle.occupancy(grid.cell_at(ground)->ix, grid.cell_at(ground)->iy), 0.2) << camera;
    EXPECT_GT(highest_near(result.cameras[camera].observed, grid, wall), 0.9) << camera;
    EXPECT_EQ(highest_near(result.cameras[(camera + 2) % 4].observed, grid, wall), 0.5f) << camera;
    EXPECT_TRUE(result.cameras[camera].ground.estimated);
    EXPECT_FALSE((camera == 0 ? result : result.cameras[camera]).stages.obstacle_disparity.empty());
  }
}

// Also a camera alone may stand anywhere.
TEST_F(SeveralCameras, OneCameraMayLookBehind) {
  const Scene two{"around?cameras=2&width=256&height=160&focal=128&frames=3"};
  Pipeline of_two{grid_around(), two.rigs()[1], {.threads = 2}};
  for (std::size_t i{0}; i < 2; ++i) {
    StereoFrame frame{without(two.load(i), 0)};
    frame.camera = 0;
    const FrameResult& result{of_two.process(frame)};
    EXPECT_TRUE(result.cameras.empty());
    EXPECT_GT(highest_near(result.observed, result.vehicle.geometry, {-wall_m, 0}), 0.9);
    EXPECT_EQ(highest_near(result.observed, result.vehicle.geometry, {wall_m, 0}), 0.5f);
  }
}

TEST_F(SeveralCameras, ACameraWithoutFrameObservesNothing) {
  for (const int missing : {0, 2}) {
    pipeline.reset();
    for (std::size_t i{0}; i < 4; ++i) pipeline.process(scene.load(i));
    const FrameResult& result{pipeline.process(without(scene.load(4), missing))};
    const auto camera = static_cast<std::size_t>(missing);
    EXPECT_FALSE(result.cameras[camera].has_images);
    EXPECT_TRUE(result.cameras[camera].status.empty());
    const Point2 wall{camera_place(scene.rigs()[camera]) * Point2{wall_m - 0.5, 0}};
    EXPECT_EQ(highest_near(result.observed, result.vehicle.geometry, wall), 0.5f) << "observed by no camera";
    EXPECT_GT(highest_near(result.vehicle.occupancy, result.vehicle.geometry, wall), 0.8) << "remembered";
    const Point2 other{camera_place(scene.rigs()[1]) * Point2{wall_m - 0.5, 0}};
    EXPECT_GT(highest_near(result.observed, result.vehicle.geometry, other), 0.9);
    EXPECT_FALSE(pipeline.process(scene.load(5)).cameras[camera].observed.empty());
    EXPECT_TRUE(pipeline.process(scene.load(6)).cameras[camera].has_images);
  }
}

// The frames of a vehicle that drives 1 m between two cameras' exposures.
TEST_F(SeveralCameras, MotionBetweenStampsIsCompensated) {
  StereoFrame frame{scene.load(0)};
  StereoFrame late{scene.load(0, Pose2{1, 0, 0})};
  frame.others[1] = std::move(late.others[1]);  // camera at the back
  frame.others[1].stamp_ns += 50'000'000;
  const FrameResult& result{pipeline.process(frame)};
  EXPECT_NEAR(result.world_from_vehicle.x_m, 0, 1e-9) << "the world begins at the newest frame";
  EXPECT_GT(highest_near(result.observed, result.vehicle.geometry, {wall_m - 1, 0.5}), 0.9) << "seen 1 m earlier";
  EXPECT_GT(highest_near(result.observed, result.vehicle.geometry, {0, wall_m - 0.5}), 0.5) << "at the side";
}

TEST_F(SeveralCameras, EachHasAClock) {
  Pipeline named{grid_around(), scene.rigs(), {.threads = 2, .camera_names = {"front", "left", "rear", "right"}}};
  const auto messages_of = [&](std::size_t frame, std::int64_t late_ns) {
    StereoFrame next{scene.load(frame)};
    next.others[1].stamp_ns -= late_ns;
    const FrameResult& result{named.process(next)};
    std::string messages;
    for (const Warning& warning : result.warnings) messages += warning.text + "\n";
    for (const FrameStatus status : result.status)
      messages += std::string{names_of(status)[static_cast<std::size_t>(status)]};
    return messages;
  };
  EXPECT_EQ(messages_of(0, 0), "");
  EXPECT_EQ(messages_of(1, 0), "");
  const std::string back{messages_of(2, 3'000'000'000)};
  EXPECT_THAT(back, ::testing::HasSubstr("rear: the clock has stepped back by 2.9"));
  EXPECT_THAT(back, ::testing::HasSubstr("clock_stepped_back"));
  EXPECT_THAT(messages_of(3, 3'000'000'000), ::testing::StartsWith("rear: its frame is 3.000 s older than the newest"));
  named.reset();
  EXPECT_EQ(messages_of(4, 10'000'000'000), "") << "a first frame";
  EXPECT_THAT(messages_of(5, 0), ::testing::HasSubstr("rear: 10.1"));
}

TEST_F(SeveralCameras, OneRejectedCameraLeavesTheOthers) {
  StereoFrame frame{scene.load(0)};
  frame.others[0].right.fill(3);
  const FrameResult& result{pipeline.process(frame)};
  EXPECT_TRUE(result.status.empty()) << "not a condition of all cameras";
  EXPECT_EQ(result.cameras[1].status, std::vector<FrameStatus>{FrameStatus::few_matches});
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_TRUE(result.warnings.front().text.starts_with("camera1: ")) << result.warnings.front().text;
  EXPECT_GT(highest_near(result.observed, result.vehicle.geometry, {wall_m - 0.5, 0}), 0.9);
  EXPECT_EQ(highest_near(result.observed, result.vehicle.geometry, {0, wall_m - 0.5}), 0.5f);
}

// On another number of threads, which cameras share.
TEST_F(SeveralCameras, ASavedStateContinues) {
  for (std::size_t i{0}; i < 3; ++i) pipeline.process(scene.load(i));
  Pipeline second{grid_around(), scene.rigs(), {.threads = 1}};
  second.load_state(pipeline.save_state());
  for (std::size_t i{3}; i < 5; ++i) expect_equal(second.process(scene.load(i)), pipeline.process(scene.load(i)));
  Pipeline fewer{grid_around(), scene.rigs().first(2), {.threads = 2}};
  EXPECT_THROW(fewer.load_state(pipeline.save_state()), InputError);
  second.reset();
  Pipeline fresh{grid_around(), scene.rigs(), {.threads = 2}};
  expect_equal(second.process(scene.load(0)), fresh.process(scene.load(0)));
}

TEST_F(SeveralCameras, FramesMustBeOfTheirCameras) {
  Pipeline two{grid_around(), scene.rigs().first(2), {.threads = 2}};
  EXPECT_THROW(two.process(scene.load(0)), InputError) << "four frames for two cameras";
  Pipeline one{grid_around(), scene.rig(), {.threads = 2}};
  EXPECT_TRUE(one.process(scene.load(0)).cameras.empty()) << "the others are ignored";
  StereoFrame frame{without(without(scene.load(0), 3), 2)};
  frame.others[0].camera = 2;
  EXPECT_THROW(two.process(frame), InputError) << "no such camera";
  frame.others[0].camera = 0;
  EXPECT_THROW(two.process(frame), InputError) << "two of a camera";
  frame.others[0].camera = 1;
  EXPECT_NO_THROW(two.process(frame));
  EXPECT_THROW(two.process(frame), InputError) << "the same stamps again";
  frame.name.clear();
  frame.index = 7;
  EXPECT_THAT(error_text_of<InputError>([&] { two.process(frame); }), ::testing::StartsWith("frame 7: "));
  EXPECT_THROW(Pipeline(grid_around(), std::span<const Rig>{}), ConfigError);
}

TEST_F(SeveralCameras, AGridWithoutTheirViewsIsReportedOnce) {
  const Scene narrow{"around?cameras=4&width=256&height=160&focal=256&frames=3"};
  const auto warned_cameras = [&](const Config& config, std::span<const Rig> rigs) {
    Pipeline of_narrow{config, rigs, {.threads = 2}};
    std::string cameras;
    for (std::size_t i{0}; i < 2; ++i) {
      for (const Warning& warning : of_narrow.process(narrow.load(i)).warnings) {
        EXPECT_TRUE(warning.text.find("camera's view lie outside of the grid") != std::string::npos) << warning.text;
        if (warning.text.starts_with("camera")) cameras += warning.text[6];
        EXPECT_EQ(i, 0u);
      }
    }
    return cameras;
  };
  EXPECT_EQ(warned_cameras(grid_around(), narrow.rigs()), "");
  EXPECT_EQ(warned_cameras(preset("default"), narrow.rigs()), "123") << "half of the views to the sides is behind";
  Config behind{preset("default")};
  behind.grid.rear_m = 5;
  EXPECT_EQ(warned_cameras(behind, narrow.rigs()), "");
}

// A walker of 1.5 m/s on a circle of 4 m crosses the border of two views, at 45°, in frame 21.
TEST_F(SeveralCameras, APersonKeepsItsIdFromViewToView) {
  std::set<std::int64_t> ids;
  int lost{0};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const std::vector<Obstacle>& obstacles{pipeline.process(scene.load(i)).obstacles};
    const Point2 walker{Pose2{0, 0, 1.5 / 4 * 0.1 * static_cast<double>(i)} * Point2{4, 0}};
    const auto distance_m = [&](const Obstacle& o) { return std::hypot(o.x_m - walker.x, o.y_m - walker.y); };
    const auto nearest = std::ranges::min_element(obstacles, {}, distance_m);
    const bool is_tracked{nearest != obstacles.end() && nearest->confirmed && distance_m(*nearest) < 1};
    is_tracked ? void(ids.insert(nearest->id)) : void(++lost);
  }
  EXPECT_EQ(ids.size(), 1u);
  EXPECT_LE(lost, 5) << "until it is confirmed";
}

/// True: the place lies in the camera's horizontal field of view.
bool sees(const Rig& rig, Point2 place) {
  const Point2 seen{inverse(camera_place(rig)) * place};
  return seen.x > 0 && seen.y < seen.x * rig.cx_px / rig.focal_px &&
         -seen.y < seen.x * (rig.width_px - rig.cx_px) / rig.focal_px;
}

// The camera at the back has no frames for 2 s.
TEST_F(SeveralCameras, AnUnpluggedCameraLeavesTheOthersCells) {
  Pipeline part{grid_around(), scene.rigs(), {.threads = 2}};
  constexpr int unplugged{2};
  double change{0};
  int cells{0};
  for (std::size_t i{0}; i < 28; ++i) {
    const bool is_unplugged{i >= 4 && i < 24};
    const StereoFrame frame{scene.load(i)};
    const FrameResult& expected{pipeline.process(frame)};
    const FrameResult& result{part.process(is_unplugged ? without(frame, unplugged) : frame)};
    const GridGeometry& grid{result.vehicle.geometry};
    for (int iy{0}; iy < grid.ny; ++iy) {
      for (int ix{0}; ix < grid.nx; ++ix) {
        if (sees(scene.rigs()[unplugged], grid.centre(ix, iy))) continue;
        change += std::abs(result.vehicle.occupancy(ix, iy) - expected.vehicle.occupancy(ix, iy));
        ++cells;
      }
    }
    const auto is_moving = [](const Obstacle& obstacle) { return obstacle.confirmed && obstacle.moving; };
    EXPECT_EQ(std::ranges::count_if(result.obstacles, is_moving), std::ranges::count_if(expected.obstacles, is_moving))
        << i;
  }
  EXPECT_GT(cells, 100'000);
  EXPECT_LT(change / cells, 1e-4);
}

// The first frame may have no images: the other cameras' are used.
TEST_F(SeveralCameras, TheFirstMayHaveNoImages) {
  Pipeline same{grid_around(), scene.rigs(), {.threads = 2}};
  StereoFrame frame{scene.load(0)};
  const FrameResult& expected{same.process(without(frame, 0))};
  frame.left = frame.right = {};
  const FrameResult& result{pipeline.process(frame)};
  expect_equal(result, expected);
  EXPECT_FALSE(result.cameras[0].has_images);
  frame.others.clear();
  frame.stamp_ns += 100'000'000;
  EXPECT_THROW(pipeline.process(frame), InputError) << "no images at all";
}

TEST_F(SeveralCameras, HaveNamesInWarningsAndResults) {
  const std::vector<std::string> names{"front", "left", "rear", "right"};
  Pipeline named{grid_around(), scene.rigs(), {.threads = 2, .camera_names = names}};
  StereoFrame frame{scene.load(0)};
  for (StereoFrame& other : frame.others) other.right.fill(3);
  const FrameResult& result{named.process(frame)};
  EXPECT_EQ(named.camera_names(), names);
  std::set<std::string> warned;
  for (const Warning& warning : result.warnings) warned.insert(warning.text.substr(0, warning.text.find(':')));
  EXPECT_EQ(warned, (std::set<std::string>{"left", "rear", "right"}));
  for (std::size_t i{0}; i < 4; ++i) EXPECT_EQ(result.cameras[i].camera_name, names[i]);
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"front"}, {"a", "a", "b", "c"}, {"a", "b", "c", "1d"}, {"a", "b", "c", "d/e"}}) {
    EXPECT_THROW(Pipeline(grid_around(), scene.rigs(), {.camera_names = wrong}), ConfigError);
  }
}

// The lower half of the second camera's image is the vehicle itself.
TEST_F(SeveralCameras, HaveMasksOfTheirOwn) {
  Image<std::uint8_t> mask{256, 160};
  mask.fill(255);
  for (int v{80}; v < 160; ++v) std::fill_n(mask.row(v), 256, std::uint8_t{0});
  Pipeline masked{grid_around(), scene.rigs(), {.threads = 2, .other_masks = {mask}}};
  const FrameResult& expected{pipeline.process(scene.load(0))};
  const FrameResult& result{masked.process(scene.load(0))};
  const Image<float>& road{expected.cameras[1].stages.road_disparity};
  EXPECT_GT(std::count_if(road.row(80), road.row(159), [](float disparity) { return disparity > 0; }), 1000);
  for (int v{80}; v < 160; ++v) {
    for (int u{0}; u < 256; ++u) {
      ASSERT_EQ(result.cameras[1].stages.road_disparity(u, v), 0);
      ASSERT_EQ(result.cameras[1].stages.obstacle_disparity(u, v), 0);
    }
  }
  EXPECT_EQ(result.stages.road_disparity, expected.stages.road_disparity);
  EXPECT_EQ(result.cameras[2].stages.road_disparity, expected.cameras[2].stages.road_disparity);
  EXPECT_THROW(pipeline.load_state(masked.save_state()), InputError);
  const Image<std::uint8_t> small{8, 8};
  EXPECT_THROW(Pipeline(grid_around(), scene.rigs(), {.other_masks = {mask, small}}), ConfigError);
  EXPECT_THROW(Pipeline(grid_around(), scene.rigs().first(1), {.other_masks = {mask}}), ConfigError);
}

TEST_F(SeveralCameras, TheSlowestLimitCounts) {
  StereoFrame frame{scene.load(0)};
  frame.others[1].right.fill(3);
  const FrameResult& result{pipeline.process(frame)};
  EXPECT_GT(result.cameras[0].speed_limit_mps, 1);
  EXPECT_EQ(result.cameras[2].speed_limit_mps, 0);
  EXPECT_EQ(result.speed_limit_mps, 0);
  EXPECT_EQ(result.speed_limit_reason, SpeedReason::frame);
  const FrameResult& next{pipeline.process(scene.load(1))};
  EXPECT_GT(next.speed_limit_mps, 1);
  for (const FrameResult& camera : next.cameras) EXPECT_GE(camera.speed_limit_mps, next.speed_limit_mps);
}

// v·t + v²/(2a) is the same range with t longer by the age of the last frame; a rejected one has none.
TEST_F(SeveralCameras, ACameraWithoutAFrameSlowsTheVehicleByTheAgeOfItsLast) {
  const Config config{grid_around()};
  const auto range_m = [&config](double limit_mps, double age_s) {
    return limit_mps * (config.vehicle.reaction_s + age_s) +
           limit_mps * limit_mps / (2 * config.vehicle.deceleration_mps2);
  };
  const double before_mps{pipeline.process(scene.load(0)).cameras[2].speed_limit_mps};
  StereoFrame frame{scene.load(1)};
  const double age_s{1e-9 * static_cast<double>(frame.stamp_ns - scene.load(0).stamp_ns)};
  std::erase_if(frame.others, [](const StereoFrame& other) { return other.camera == 2; });
  const double limit_mps{pipeline.process(frame).cameras[2].speed_limit_mps};
  EXPECT_LT(limit_mps, before_mps);
  EXPECT_NEAR(range_m(limit_mps, age_s), range_m(before_mps, 0), 1e-9);

  pipeline.reset();
  EXPECT_EQ(pipeline.process(frame).cameras[2].speed_limit_mps, 0);
}

// Wall and ground in the direction of each camera.
TEST_F(SeveralCameras, PointsAreThoseOfAllOfThem) {
  const FrameResult& result{pipeline.process(scene.load(0))};
  const std::vector<LabelledPoint> points{points_of(result, result.level_rig)};
  for (const Rig& rig : rigs_of(result)) {
    const Point2 wall{camera_place(rig) * Point2{wall_m - 0.5, 0}};
    EXPECT_TRUE(std::ranges::any_of(points, [&](const LabelledPoint& point) {
      return point.label == PointLabel::obstacle &&
             std::hypot(static_cast<double>(point.x_m) - wall.x, static_cast<double>(point.y_m) - wall.y) < 1;
    })) << rig.camera_yaw_rad;
  }
}

TEST_F(SeveralCameras, ReportTheirGridsBeforeTheObstacles) {
  const Scene two{"around?cameras=2&width=256&height=160&focal=128&frames=3"};
  std::vector<FrameResult> early;
  const PipelineOptions options{.threads = 2,
                                .on_grids = [&early](const FrameResult& grids) { early.push_back(grids); }};
  Pipeline of_two{grid_around(), two.rigs(), options};
  for (std::size_t i{0}; i < 3; ++i) {
    StereoFrame frame{two.load(i)};
    if (i == 1) frame.others.front().right.fill(7);  // nothing matches
    if (i == 2) frame.others.clear();
    const FrameResult& result{of_two.process(frame)};
    ASSERT_EQ(early.size(), i + 1);
    EXPECT_EQ(early.back().vehicle.occupancy, result.vehicle.occupancy);
    EXPECT_EQ(early.back().status, result.status);
    EXPECT_EQ(early.back().warnings, result.warnings);
    EXPECT_EQ(early.back().stages.obstacle_disparity, result.stages.obstacle_disparity);
    for (std::size_t camera{0}; camera < 2; ++camera) {
      EXPECT_EQ(early.back().cameras[camera].observed, result.cameras[camera].observed);
      EXPECT_EQ(early.back().cameras[camera].status, result.cameras[camera].status);
      EXPECT_EQ(early.back().cameras[camera].stages.road_disparity, result.cameras[camera].stages.road_disparity);
    }
    EXPECT_EQ(result.cameras[1].status.empty(), i != 1) << "the case is none";
  }
}

// Each camera finds its own extrinsics.
TEST_F(SeveralCameras, ExtrinsicsAreFoundPerCamera) {
  const Scene two{"around?cameras=2&width=256&height=160&focal=128&frames=8"};
  std::vector<Rig> assumed(two.rigs().begin(), two.rigs().end());
  assumed[1].camera_height_m += 0.35;
  Pipeline of_two{grid_around(), assumed, {.threads = 2, .extrinsics_given = false}};
  for (std::size_t i{0}; i < 6; ++i) of_two.process(two.load(i));
  EXPECT_NEAR(of_two.next_rig(0).camera_height_m, two.rigs()[0].camera_height_m, 0.05);
  EXPECT_NEAR(of_two.next_rig(1).camera_height_m, two.rigs()[1].camera_height_m, 0.05);
  EXPECT_EQ(of_two.next_rig(1).camera_yaw_rad, assumed[1].camera_yaw_rad);
}

}  // namespace
}  // namespace stereogrid::test
