// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/poses.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

struct PoseFile : FolderTest {
  [[nodiscard]] std::vector<Pose2> kitti(const std::string& text, std::size_t expected) const {
    put(folder / "poses.txt", text);
    return read_kitti_poses(folder / "poses.txt", expected);
  }
  [[nodiscard]] std::vector<NamedPose> csv(const std::string& text) const {
    put(folder / "poses.csv", text);
    return read_poses_csv(folder / "poses.csv");
  }
};

constexpr const char* still{"1 0 0 0 0 1 0 0 0 0 1 0\n"};
constexpr const char* head{"name,stamp_ns,x_m,y_m,yaw_rad\n"};

TEST_F(PoseFile, KittiAxesBecomeVehicleAxes) {
  const auto poses{kitti("1 0 0 2 0 1 0 -0.1 0 0 1 5\n", 1)};
  EXPECT_DOUBLE_EQ(poses[0].x_m, 5) << "5 m ahead";
  EXPECT_DOUBLE_EQ(poses[0].y_m, -2) << "2 m to the right";
  EXPECT_DOUBLE_EQ(poses[0].yaw_rad, 0);
}

TEST_F(PoseFile, KittiTurnToTheLeftIsPositive) {
  // after a turn to the left the optical axis points to the world camera's −x
  const auto poses{kitti("0.9553365 0 -0.2955202 0 0 1 0 0 0.2955202 0 0.9553365 0\n", 1)};
  EXPECT_NEAR(poses[0].yaw_rad, 0.3, 1e-6);
}

TEST_F(PoseFile, KittiIsNotMovedToTheFirstFrame) {
  const auto poses{kitti("1 0 0 0 0 1 0 0 0 0 1 100\n1 0 0 0 0 1 0 0 0 0 1 101\n", 2)};
  EXPECT_DOUBLE_EQ(poses[0].x_m, 100);
}

TEST_F(PoseFile, KittiLinesMayEndAnyWay) {
  EXPECT_EQ(kitti("1 0 0 0 0 1 0 0 0 0 1 1\r\n1 0 0 0 0 1 0 0 0 0 1 2", 2)[1].x_m, 2);
}

TEST_F(PoseFile, KittiMayHaveTheLastRowOfTheMatrix) {
  EXPECT_EQ(kitti("1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1\n", 1)[0].x_m, 2);
  expect_error([&] { return kitti("1 0 0 0 0 1 0 0 0 0 1 2 0 0 1 1\n", 1); }, {"16 numbers, not 12"});
}

TEST_F(PoseFile, KittiErrors) {
  const std::string one{still};
  expect_error([&] { return kitti(one + one, 3); }, {"poses.txt", "2 poses", "3 frames", "--poses none"});
  expect_error([&] { return kitti(one + one, 1); }, {"2 poses", "1 frames"});
  expect_error([&] { return kitti(one + "1 0 0 nan 0 1 0 0 0 0 1 0\n", 2); }, {"line 2", "not finite"});
  expect_error([&] { return kitti(one + "1 0 0 inf 0 1 0 0 0 0 1 0\n", 2); }, {"line 2", "not finite"});
  expect_error([&] { return kitti("1 0 0\n", 1); }, {"line 1", "3 numbers, not 12"});
  expect_error([&] { return kitti("1 0 0 0 0 1 0 0 0 0 1 x\n", 1); }, {"line 1", "not a number"});
  expect_error([&] { return kitti("2 0 0 0 0 1 0 0 0 0 1 0\n", 1); }, {"line 1", "not a rotation"});
  expect_error([&] { return kitti("1 0 0 0 0 1 0 0 0 0 -1 0\n", 1); }, {"not a rotation"});
  expect_error([&] { return read_kitti_poses(folder / "none.txt", 1); }, {"none.txt"});
}

TEST_F(PoseFile, CsvRoundTrips) {
  const std::vector<NamedPose> poses{{"a", -5, {1.25, -2.5, 0.125}}, {"b", 1'700'000'000'000'000'000, {3, 4, -3}}};
  write_poses_csv(folder / "poses.csv", poses);
  const auto read{read_poses_csv(folder / "poses.csv")};
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i{0}; i < 2; ++i) {
    EXPECT_EQ(read[i].name, poses[i].name);
    EXPECT_EQ(read[i].stamp_ns, poses[i].stamp_ns);
    EXPECT_EQ(read[i].world_from_vehicle, poses[i].world_from_vehicle);
  }
}

TEST_F(PoseFile, CsvErrors) {
  const std::string top{head};
  expect_error([&] { return csv("a,0,0,0,0\n"); }, {"poses.csv", "line 1", "name,stamp_ns"});
  expect_error([&] { return csv(""); }, {"line 1"});
  expect_error([&] { return csv(top + "a,0,0,0\n"); }, {"line 2", "4 fields"});
  expect_error([&] { return csv(top + "a,0,nan,0,0\n"); }, {"line 2", "not finite"});
  expect_error([&] { return csv(top + "a,0,0,0,0\nb,1,0,-inf,0\n"); }, {"line 3", "not finite"});
  expect_error([&] { return csv(top + "a,0.5,0,0,0\n"); }, {"line 2", "whole number"});
  expect_error([&] { return csv(top + "a,0,x,0,0\n"); }, {"line 2", "three numbers"});
  expect_error([&] { return csv(top + "a,0,0,0,0\na,1,0,0,0\n"); }, {"line 3", "a second time"});
  expect_error([&] { return csv(top + "a,5,0,0,0\nb,5,0,0,0\n"); }, {"line 3", "not later"});
  expect_error([&] { return csv(top + ",5,0,0,0\n"); }, {"line 2", "no name"});
}

TEST_F(PoseFile, CsvWithoutNames) {
  const auto poses{csv("stamp_ns,x_m,y_m,yaw_rad\n-5,1,2,0.5\n7,3,4,-0.5\n")};
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].name, "");
  EXPECT_EQ(poses[1].stamp_ns, 7);
  EXPECT_EQ(poses[1].world_from_vehicle, (Pose2{3, 4, -0.5}));
  expect_error([&] { return csv("stamp_ns,x_m,y_m,yaw_rad\na,-5,1,2,0.5\n"); }, {"line 2", "5 fields, not 4"});
}

TEST(UnitQuaternion, IsNormalisedWithinOnePercent) {
  for (const double length : {0.991, 1.0, 1.009}) {
    const auto unit{unit_quaternion({0, 0, 0.6 * length, 0.8 * length})};
    ASSERT_TRUE(unit) << length;
    EXPECT_NEAR((*unit)[2], 0.6, 1e-12);
    EXPECT_NEAR((*unit)[3], 0.8, 1e-12);
  }
  for (const double length : {0.0, 0.5, 0.989, 1.011, 2.0, 1e200, std::nan(""), -HUGE_VAL}) {
    EXPECT_FALSE(unit_quaternion({0, 0, 0, length})) << length;
  }
}

constexpr std::int64_t second_ns{1'000'000'000};

TEST(Interpolation, IsLinearInPositionAndTakesTheShorterArc) {
  const std::vector<StampedPose> poses{{0, {0, 0, 3.0}}, {2 * second_ns, {4, -2, -3.0}}, {3 * second_ns, {4, 2, -2.8}}};
  const std::vector<std::int64_t> stamps{0, second_ns / 2, second_ns, 2 * second_ns, 5 * second_ns / 2, 3 * second_ns};
  const auto found{interpolate_poses("log", poses, stamps)};
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(found[0], poses[0].world_from_vehicle);
  EXPECT_NEAR(found[1].x_m, 1, 1e-12);
  EXPECT_NEAR(found[1].y_m, -0.5, 1e-12);
  const double arc{2 * std::numbers::pi - 6};  // from 3 through π to −3
  EXPECT_NEAR(found[1].yaw_rad, 3 + arc / 4, 1e-12);
  EXPECT_NEAR(std::abs(found[2].yaw_rad), std::numbers::pi, 1e-12);
  EXPECT_NEAR(found[3].x_m, 4, 1e-12);
  EXPECT_NEAR(found[3].yaw_rad, -3, 1e-12);
  EXPECT_NEAR(found[4].y_m, 0, 1e-12);
  EXPECT_NEAR(found[4].yaw_rad, -2.9, 1e-12);
  EXPECT_NEAR(found[5].y_m, 2, 1e-12);
}

TEST(Interpolation, CarriesTheMotionOnForOneInterval) {
  const std::vector<StampedPose> poses{{0, {0, 0, 0}}, {second_ns, {1, 0, 0.1}}, {2 * second_ns, {3, 0, 0.3}}};
  const std::vector<std::int64_t> stamps{-second_ns, 5 * second_ns / 2};
  const auto found{interpolate_poses("log", poses, stamps)};
  EXPECT_NEAR(found[0].x_m, -1, 1e-12);
  EXPECT_NEAR(found[1].x_m, 4, 1e-12);
  EXPECT_NEAR(found[1].yaw_rad, 0.4, 1e-12);
}

TEST(Interpolation, Findings) {
  const auto at = [](std::vector<StampedPose> poses, std::int64_t stamp_ns) {
    static_cast<void>(interpolate_poses("log", poses, std::vector{stamp_ns}));
  };
  const std::vector<StampedPose> poses{{0, {}}, {second_ns, {}}, {2 * second_ns, {}}};
  expect_error([&] { at(poses, -second_ns - 1); }, {"log", "1.000 s before the first pose", "same clock"});
  expect_error([&] { at(poses, 7 * second_ns / 2); }, {"image of 3.500 s", "1.500 s after", "--poses odometry"});
  expect_error([&] { at({poses[0]}, 0); }, {"has 1 poses"});
  expect_error([&] { at({}, 0); }, {"has 0 poses"});
}

TEST_F(PoseFile, OrderOfChoice) {
  EXPECT_FALSE(find_poses(folder.path()));
  for (const char* const name :
       {"poses_zz.txt", "poses_aa.txt", "poses_vo.txt", "poses.txt", "poses_gt.txt", "poses.csv"}) {
    put(folder / name, "");
    const auto choice{find_poses(folder.path())};
    ASSERT_TRUE(choice);
    EXPECT_EQ(choice->file.filename(), name);
  }
  EXPECT_EQ(find_poses(folder.path())->others.size(), 5U);
}

constexpr double degree{std::numbers::pi / 180};

std::string oxts(double latitude_deg, double longitude_deg, double yaw_rad) {
  return std::to_string(latitude_deg) + " " + std::to_string(longitude_deg) + " 110 0 0 " + std::to_string(yaw_rad) +
         " 0 0 0\n";
}

TEST_F(PoseFile, OxtsOfTheImu) {
  put(folder / "data" / "0.txt", oxts(49, 8.4, 1.5));
  put(folder / "data" / "1.txt", oxts(49.001, 8.4, 1.5));
  put(folder / "data" / "2.txt", oxts(49, 8.401, 1.5));
  const std::vector<std::string> names{"0", "1", "2"};
  const auto poses{read_oxts(folder / "data", names, folder.path())};
  EXPECT_FALSE(poses.of_camera);
  const auto& p{poses.world_from_vehicle};
  EXPECT_NEAR(p[0].yaw_rad, 1.5, 1e-9);
  // a thousandth of a degree: 111.3 m of latitude, cos 49° of it for longitude
  EXPECT_NEAR(p[1].y_m - p[0].y_m, 6378137 * degree * 0.001, 0.05);
  EXPECT_NEAR(p[1].x_m - p[0].x_m, 0, 1e-6);
  EXPECT_NEAR(p[2].x_m - p[0].x_m, 6378137 * degree * 0.001 * std::cos(49 * degree), 0.05);
}

TEST_F(PoseFile, OxtsMovedToTheCamera) {
  // the velodyne 0.8 m behind… the IMU's origin lies at (−0.8, 0.3) of the velodyne's frame; the camera 0.27 m ahead of
  // the velodyne: 1.07 m ahead and 0.3 m right of the IMU
  put(folder / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
  put(folder / "calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\n");
  put(folder / "calib_cam_to_cam.txt", "R_rect_00: 1 0 0 0 1 0 0 0 1\n");
  put(folder / "data" / "0.txt", oxts(49, 8.4, std::numbers::pi / 2));
  const std::vector<std::string> names{"0"};
  const auto camera{read_oxts(folder / "data", names, folder.path())};
  const auto imu{read_oxts(folder / "data", names, folder / "elsewhere")};
  ASSERT_TRUE(camera.of_camera);
  EXPECT_NEAR(camera.world_from_vehicle[0].yaw_rad, std::numbers::pi / 2, 1e-6);
  // heading north: ahead is +y, right is +x
  EXPECT_NEAR(camera.world_from_vehicle[0].y_m - imu.world_from_vehicle[0].y_m, 1.07, 1e-5);
  EXPECT_NEAR(camera.world_from_vehicle[0].x_m - imu.world_from_vehicle[0].x_m, 0.3, 1e-5);
}

TEST_F(PoseFile, OxtsWithARotationThatIsNone) {
  put(folder / "calib_imu_to_velo.txt", "R: 2 0 0 0 2 0 0 0 2\nT: 0 0 0\n");
  put(folder / "calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n");
  put(folder / "calib_cam_to_cam.txt", "R_rect_00: 1 0 0 0 1 0 0 0 1\n");
  put(folder / "data" / "0.txt", oxts(49, 8.4, 0));
  const std::vector<std::string> names{"0"};
  expect_error([&] { return read_oxts(folder / "data", names, folder.path()); },
               {"calib_imu_to_velo.txt", "not a rotation matrix"});
}

TEST_F(PoseFile, OxtsTimes) {
  const fs::path data{folder / "oxts" / "data"};
  for (const char* const name : {"0000000010", "0000000000", "0000000002"}) {
    put(data / (std::string{name} + ".txt"), oxts(49, 8.4, 0));
  }
  EXPECT_TRUE(read_oxts_times(data).names.empty()) << "no timestamps.txt";
  std::string lines;
  for (int i{10}; i <= 20; ++i) lines += "2011-09-26 13:02:" + std::to_string(i) + ".5\n";
  put(folder / "oxts" / "timestamps.txt", lines);
  const OxtsTimes times{read_oxts_times(data)};
  EXPECT_THAT(times.names, ::testing::ElementsAre("0000000000", "0000000002", "0000000010"));
  ASSERT_EQ(times.stamps_ns.size(), 3U);
  EXPECT_EQ(times.stamps_ns[1] - times.stamps_ns[0], 2'000'000'000);
  EXPECT_EQ(times.stamps_ns[2] - times.stamps_ns[0], 10'000'000'000);
  put(folder / "oxts" / "timestamps.txt", "2011-09-26 13:02:25.5\n");
  expect_error([&] { return read_oxts_times(data); }, {"1 stamps, none for record 0000000002"});
  put(folder / "oxts" / "timestamps.txt", "2011-09-26 13:02:25.5\n2011-09-26 13:02:25.4\n");
  expect_error([&] { return read_oxts_times(data); }, {"line 2", "not later", "of the same name"});
}

TEST_F(PoseFile, OxtsErrors) {
  const std::vector<std::string> names{"0", "1"};
  put(folder / "data" / "0.txt", oxts(49, 8.4, 0));
  expect_error([&] { return read_oxts(folder / "data", names, folder.path()); },
               {"1.txt", "record of frame 1 is missing"});
  put(folder / "data" / "1.txt", "49 8.4 nan 0 0 0\n");
  expect_error([&] { return read_oxts(folder / "data", names, folder.path()); }, {"1.txt", "not finite"});
  put(folder / "data" / "1.txt", oxts(49, 8.4, 90));
  expect_error([&] { return read_oxts(folder / "data", names, folder.path()); },
               {"1.txt", "an angle of 90 rad", "radians"});
  put(folder / "data" / "1.txt", "49 8.4\n");
  expect_error([&] { return read_oxts(folder / "data", names, folder.path()); }, {"lat lon alt"});
}

TEST_F(PoseFile, TumIsInTheAxesOfTheFirstCamera) {
  // z up: the camera faces along the world's y, and moves 2 m ahead and 1 m to the left
  put(folder / "t.txt",
      "# timestamp tx ty tz qx qy qz qw\n1500000000.123456789 5 7 1 -0.70710678 0 0 0.70710678\n"
      "1500000000.2 4 9 1 -0.70710678 0 0 0.70710678\n");
  ASSERT_TRUE(is_trajectory(folder / "t.txt"));
  const auto poses{read_trajectory(folder / "t.txt").poses};
  ASSERT_EQ(poses.size(), 2);
  EXPECT_EQ(poses[0].stamp_ns, 1500000000123456789);
  EXPECT_NEAR(poses[0].world_from_vehicle.x_m, 0, 1e-9);
  EXPECT_NEAR(poses[1].world_from_vehicle.x_m, 2, 1e-6);
  EXPECT_NEAR(poses[1].world_from_vehicle.y_m, 1, 1e-6);
  EXPECT_NEAR(poses[1].world_from_vehicle.yaw_rad, 0, 1e-6);
}

TEST_F(PoseFile, TumOfABodyMovesAlongX) {
  put(folder / "t.txt", "1.5,5,7,1,0,0,0.70710678,0.70710678\n1.6,4,9,1,0,0,0.70710678,0.70710678\n");
  const Trajectory found{read_trajectory(folder / "t.txt")};
  ASSERT_EQ(found.poses.size(), 2);
  EXPECT_FALSE(Trajectory{}.are_of_body);
  EXPECT_TRUE(found.are_of_body);
  EXPECT_NEAR(found.poses[1].world_from_vehicle.x_m, 2, 1e-6);
  EXPECT_NEAR(found.poses[1].world_from_vehicle.y_m, 1, 1e-6);
}

TEST_F(PoseFile, TumErrors) {
  const auto refused{[&](const char* text, std::initializer_list<std::string_view> parts) {
    put(folder / "t.txt", text);
    expect_error([&] { return read_trajectory(folder / "t.txt"); }, parts);
  }};
  refused("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", {"t.txt", "line 2", "not later"});
  refused("0 0 0 0 0 0 0 2\n", {"line 1", "quaternion"});
  refused("0 0 0 nan 0 0 0 1\n", {"line 1", "not finite"});
  refused("0 0 0 0 0 0 0 1\n1 2 3\n", {"line 2", "timestamp tx ty tz"});
  refused("1500000000000000000 0 0 0 0 0 0 1\n", {"t.txt", "seconds"});
}

TEST_F(PoseFile, StampsInAnyUnit) {
  for (const auto& [first, second] :
       {std::array{"1500000000.1", "1500000000.2"}, std::array{"1500000000100", "1500000000200"},
        std::array{"1500000000100000", "1500000000200000"},
        std::array{"1500000000100000000.0", "1500000000200000000.0"}}) {
    put(folder / "t.txt", std::string{first} + " 0 0 0 0 0 0 1\n" + second + " 0 0 0 0 0 0 1\n");
    const Trajectory found{read_trajectory(folder / "t.txt")};
    EXPECT_EQ(found.poses[0].stamp_ns, 1500000000100000000) << first;
    EXPECT_EQ(found.poses[1].stamp_ns, 1500000000200000000) << first;
    EXPECT_EQ(found.note.empty(), first == std::string{"1500000000.1"}) << first;
  }
  put(folder / "t.txt", "1 0 0 0 0 0 0 1\n1.000001 0 0 0 0 0 0 1\n");
  expect_error([&] { return read_trajectory(folder / "t.txt"); }, {"t.txt", "no other unit"});
}

TEST_F(PoseFile, EurocIsOfTheBody) {
  put(folder / "data.csv",
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m "
      "s^-1]\n"
      "1403636579713555584,1,2,3,1,0,0,0,9\n1403636579813555584,1,3,3,1,0,0,0,9\n");
  // camera: z along the body's y, x along its x
  const Transform body_from_camera{1, 0, 0, 0.5, 0, 0, 1, 0, 0, -1, 0, 0};
  const Trajectory found{read_trajectory(folder / "data.csv", body_from_camera)};
  ASSERT_EQ(found.poses.size(), 2);
  EXPECT_EQ(found.poses[0].stamp_ns, 1403636579713555584);
  EXPECT_NEAR(found.poses[1].world_from_vehicle.x_m, 1, 1e-9);
  EXPECT_NEAR(found.poses[1].world_from_vehicle.y_m, 0, 1e-9);
}

TEST_F(PoseFile, SimulatorsHaveYToTheRight) {
  const double half{std::sqrt(0.5)};
  put(folder / "pose_left.txt", fmt::format("5 -2 -1 0 0 0 1\n6 -1 -1 0 0 {} {}\n", half, half));
  put(folder / "airsim_rec.txt",
      fmt::format("VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"
                  "Car\t1573551234567\t5\t-2\t-1\t1\t0\t0\t0\ta.png;b.png\n"
                  "Car\t1573551234667\t6\t-1\t-1\t{}\t0\t0\t{}\tc.png;d.png\n",
                  half, half));
  for (const char* const name : {"pose_left.txt", "airsim_rec.txt"}) {
    const Trajectory found{read_trajectory(folder / name)};
    ASSERT_EQ(found.poses.size(), 2) << name;
    const Pose2& pose{found.poses[1].world_from_vehicle};
    EXPECT_NEAR(pose.x_m, 1, 1e-9) << name;
    EXPECT_NEAR(pose.y_m, -1, 1e-9) << name;
    EXPECT_NEAR(pose.yaw_rad, -std::numbers::pi / 2, 1e-6) << name;
  }
  EXPECT_FALSE(read_trajectory(folder / "pose_left.txt").have_stamps);
  EXPECT_EQ(read_trajectory(folder / "airsim_rec.txt").poses[1].stamp_ns, 1573551234667000000);
}

TEST_F(PoseFile, Kitti360NumbersItsFrames) {
  put(folder / "cam0_to_world.txt", "1 1 0 0 7 0 1 0 0 0 0 1 5 0 0 0 1\n4 1 0 0 7 0 1 0 0 0 0 1 8 0 0 0 1\n");
  const Trajectory found{read_trajectory(folder / "cam0_to_world.txt")};
  EXPECT_EQ(found.frames, (std::vector<std::int64_t>{1, 4}));
  EXPECT_NEAR(found.poses[1].world_from_vehicle.x_m, 3, 1e-9);
}

}  // namespace
}  // namespace stereogrid::io::testing
