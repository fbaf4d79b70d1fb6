// SPDX-License-Identifier: Apache-2.0
//
// Rigs that no camera has: refused, or at least wondered at.
#include "hostile_run.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

using ::testing::AllOf, ::testing::Contains, ::testing::HasSubstr, ::testing::IsEmpty;

constexpr double infinity{std::numeric_limits<double>::infinity()};
constexpr double nan{std::numeric_limits<double>::quiet_NaN()};

const std::vector<double Rig::*> numbers{&Rig::focal_px,       &Rig::cx_px,           &Rig::cy_px,
                                         &Rig::baseline_m,     &Rig::camera_height_m, &Rig::camera_pitch_rad,
                                         &Rig::camera_roll_rad};

Rig with(double Rig::*member, double value) {
  Rig rig{small_rig()};
  rig.*member = value;
  return rig;
}

// Empty: it can.
std::string why_no_pipeline(const Rig& rig) {
  return error_text_of<ConfigError>([&] { Pipeline{small_config(), rig, {.threads = 1}}; });
}

TEST(RigProblems, ARigThatIsTakenDoesNotCrash) {
  for (double Rig::*const member : numbers) {
    for (const double value : {nan, infinity, 0.0, -0.7, 1e-300, 2e-4, 0.7, 9.9, 99.0, 999e3, 1e300}) {
      const Rig rig{with(member, value)};
      const bool is_refused{!why_no_pipeline(rig).empty()};
      EXPECT_EQ(is_refused, !problems(rig).empty()) << value;
      if (is_refused) continue;
      for (const BackEnd back_end : back_ends()) {
        Wall wall{back_end, small_config(), rig};
        for (int i{0}; i < 2; ++i) static_cast<void>(wall.step(100'000'000 * i));
      }
    }
  }
}

TEST(RigProblems, NoNumberIsRefused) {
  for (double Rig::*const member : numbers) {
    for (const double value : {nan, infinity, -infinity}) {
      EXPECT_THAT(why_no_pipeline(with(member, value)), HasSubstr("rig: A number is not finite"));
    }
  }
}

TEST(RigProblems, WrongUnitsAreNamed) {
  EXPECT_THAT(problems(with(&Rig::baseline_m, 537)), Contains(HasSubstr("millimetres")));
  EXPECT_THAT(problems(with(&Rig::baseline_m, 1e-5)), Contains(HasSubstr("metres")));
  EXPECT_THAT(problems(with(&Rig::focal_px, 0.001)), Contains(AllOf(HasSubstr("0.001"), HasSubstr("in pixels"))));
  EXPECT_THAT(problems(with(&Rig::camera_height_m, 165)), Contains(HasSubstr("centimetres")));
  EXPECT_THAT(problems(with(&Rig::camera_roll_rad, 3)), Contains(AllOf(HasSubstr("roll"), HasSubstr("degrees"))));
  EXPECT_THAT(problems(with(&Rig::camera_pitch_rad, 20)), Contains(AllOf(HasSubstr("pitch"), HasSubstr("degrees"))));
  EXPECT_THAT(problems(with(&Rig::camera_pitch_rad, 1.2)), Contains(HasSubstr("over 45°, which is not supported")));
  EXPECT_THAT(problems(with(&Rig::cx_px, 1e6)), Contains(HasSubstr("outside the image")));
}

TEST(RigProblems, AllAreReportedAtOnceTogetherWithTheConfiguration) {
  Rig rig{with(&Rig::baseline_m, -1)};
  rig.camera_height_m = 0;
  Config config{small_config()};
  config.matching.window_px = 12;
  EXPECT_THAT(error_text_of<ConfigError>([&] {
                Pipeline{config, rig};
              }),
              AllOf(HasSubstr("window_px is 12"), HasSubstr("baseline is negative"), HasSubstr("camera height is 0")));
}

TEST(RigProblems, SizesThatAreNone) {
  for (const int size : {0, -1, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()}) {
    Rig rig{small_rig()};
    rig.width_px = size;
    EXPECT_NE(why_no_pipeline(rig), "") << size;
    rig = small_rig();
    rig.height_px = size;
    EXPECT_NE(why_no_pipeline(rig), "") << size;
  }
}

TEST(RigOddities, AreReportedButNotRefused) {
  const auto expect_odd = [](double Rig::*member, double value, const char* what) {
    const Rig rig{with(member, value)};
    EXPECT_THAT(oddities(rig), Contains(HasSubstr(what))) << value;
    EXPECT_THAT(problems(rig), IsEmpty()) << value;
  };
  expect_odd(&Rig::baseline_m, 2e-4, "baseline");
  expect_odd(&Rig::baseline_m, 5.37, "baseline");
  expect_odd(&Rig::focal_px, 4, "focal length");
  expect_odd(&Rig::focal_px, 20000, "focal length");
  expect_odd(&Rig::camera_height_m, 0.0165, "camera height");
  expect_odd(&Rig::camera_height_m, 16.5, "camera height");
}

TEST(RigOddities, RigsThatPeopleHaveAreNotWonderedAt) {
  for (const int width : {64, 640, 1242, 4096, 16384}) {
    for (const double focal_px : {100.0, 700.0, 10000.0}) {
      for (const double baseline_m : {0.05, 0.537, 2.0}) {
        for (const double height_m : {0.2, 1.65, 4.0}) {
          const Rig rig{width, 64, focal_px, width / 2.0, 30, baseline_m, height_m, 0.3, -0.1};
          EXPECT_THAT(problems(rig), IsEmpty());
          EXPECT_THAT(oddities(rig), IsEmpty());
        }
      }
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
