// SPDX-License-Identifier: Apache-2.0
//
// Output of nav2-params; tests/messages/planners_test.cpp applies Nav2's rules to it.
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

TEST(Nav2Params, AreThoseOfTheRunOrOfItsCalibration) {
  const TemporaryFolder folder;
  const std::vector<std::string> settings{"--preset", "robot", "--set", "grid.length_m=4"};
  std::vector<std::string> run{"run", small_scene("corridor", "&frames=2"), "--out", folder / "run", "--predict", "1"};
  run.insert(run.end(), settings.begin(), settings.end());
  run_well(run);
  const std::string of_run{run_well({"nav2-params", folder / "run"}).output};
  EXPECT_THAT(of_run, AllOf(HasSubstr("map_topic: /stereo_grid/planning_grid\n"), HasSubstr(" width: 10\n")))
      << "4 m ahead and 3 m aside are 5 m away";
  run_well({"simulate", small_scene("corridor", "&frames=1"), "--out", folder / "drive"});
  std::vector<std::string> rig{"nav2-params", folder / "drive" / "calibration.yaml", "--predict", "1"};
  rig.insert(rig.end(), settings.begin(), settings.end());
  EXPECT_EQ(run_well(rig).output, of_run);
  rig.insert(rig.end(), {"--source", "scan", "--ros2-node", "a/b", "--frames", "map,base"});
  EXPECT_THAT(run_well(rig).output, AllOf(HasSubstr(" topic: /a/b/scan\n"), HasSubstr(" global_frame: map\n"),
                                          HasSubstr(" robot_base_frame: base\n")));
}

TEST(Nav2Params, OfARunTakeNoSettings) {
  const TemporaryFolder folder;
  run_well({"run", small_scene("corridor", "&frames=1"), "--out", folder / "run"});
  EXPECT_THAT(run_well({"nav2-params", folder / "run"}).output, HasSubstr("/stereo_grid/occupancy_grid\n"));
  EXPECT_THAT(run_well({"nav2-params", folder / "run", "--source", "layer"}).output,
              AllOf(HasSubstr(" plugin: stereogrid_nav2::GridLayer\n"), Not(HasSubstr("prediction_topic"))));
  for (const auto& setting : {std::array{"--preset", "robot"}, {"--set", "grid.length_m=4"}, {"--predict", "1"}}) {
    EXPECT_THAT(errors_of(64, {"nav2-params", folder / "run", setting[0], setting[1]}),
                HasSubstr("A run has its own settings"));
  }
  EXPECT_THAT(errors_of(65, {"nav2-params", folder / "none.yaml"}), HasSubstr("none.yaml"));
}

}  // namespace
}  // namespace stereogrid::app::testing
