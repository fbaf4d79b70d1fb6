// SPDX-License-Identifier: Apache-2.0
//
// Grids that a camera has computed, in a bag: a source for --fuse.
#include "bag_drive.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::app::testing {
namespace {

using messages::nav_msgs::GridCells;
using messages::nav_msgs::OccupancyGrid;
using messages::tf2_msgs::TFMessage;

constexpr std::int8_t unknown{-1};

class BagGrids : public Bags {
 protected:
  /// 4 × 2 m from 3 m on, in cells of 0.1 m: occupied in the first metre, free in the second, then unknown.
  static OccupancyGrid occupancy(std::size_t frame) {
    OccupancyGrid grid;
    grid.header = header(stamp_of(frame));
    grid.header.frame_id = "camera_link";
    grid.info.resolution = 0.1F;
    grid.info.width = 40;
    grid.info.height = 20;
    grid.info.origin.position = {3, -1, 0};
    grid.info.origin.orientation = {0, 0, 0, 1};
    for (int i{0}; i < 800; ++i)
      grid.data.push_back(static_cast<std::int8_t>(i % 40 < 10 ? 100 : i % 40 < 20 ? 0 : unknown));
    return grid;
  }
  /// The drive's images with these grids, and the camera 0.2 m ahead of camera_link.
  static std::vector<Entry> with_grids(const std::function<void(std::vector<Entry>&, std::size_t frame)>& add) {
    std::vector<Entry> all{entries({})};
    all.push_back(
        entry("/tf_static", start_ns, TFMessage{{transform("camera_link", "left_optical", {0.2, 0, 0}, ahead)}}));
    for (Entry& one : all) name_frame(one);
    for (std::size_t i{0}; i < frames; ++i) add(all, i);
    return all;
  }
  static void name_frame(Entry& one) {
    if (one.type != messages::sensor_msgs::Image::type_name) return;
    messages::sensor_msgs::Image image;
    messages::decode(one.data, image);
    image.header.frame_id = "left_optical";
    one = entry(one.topic, one.log_ns, image);
  }
  static void add_occupancy(std::vector<Entry>& all, std::size_t frame) {
    all.push_back(entry("/camera/occupancy", start_ns + stamp_of(frame), occupancy(frame)));
  }
  /// Observed straight ahead.
  static double observed(double x_m) { return value_at(out(), "000002", "observed", x_m, 0); }
  static Outcome run_fused(const std::vector<Entry>& content, const Words& more = {}) {
    write_mcap(bag(), content);
    return run_bag(bag(), joined({"--poses", "none", "--fuse", "grids"}, more));
  }
};

TEST_F(BagGrids, AreFusedWhereTfPutsThem) {
  const Outcome run{run_fused(with_grids(add_occupancy))};
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(json_of(out() / "run.json").at("fuse").at("source"), "grids");
  EXPECT_GT(observed(3.3), 0.6);  // 0.2 m nearer than in the grid's own frame
  EXPECT_LT(observed(4.3), 0.4);
  EXPECT_THAT(run.errors, Not(HasSubstr("stereo alone")));
  EXPECT_THAT(run_tool({"info", bag()}).output, HasSubstr("/camera/occupancy in 'camera_link'"));
}

TEST_F(BagGrids, LieInTheVehicleOfPlacedCameras) {
  std::vector<Entry> all{with_grids(add_occupancy)};
  for (Entry& one : all) {
    if (one.topic.starts_with("/left/") || one.topic.starts_with("/right/")) one.topic = "/front" + one.topic;
  }
  all.push_back(entry("/tf_static", start_ns, TFMessage{{transform("base_link", "camera_link", {1, 0, 1.65})}}));
  const Outcome run{run_fused(all, {"--cameras", "/front"})};
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("1.20 m ahead, 0.00 m and 0.0° to the left in base_link"));
  EXPECT_GT(observed(4.3), 0.6);
  EXPECT_LT(observed(5.3), 0.4);
}

TEST_F(BagGrids, HaveTheConfidenceOfTheirCertainty) {
  ASSERT_EQ(run_fused(with_grids(add_occupancy)).exit_code, 0);
  const double binary{observed(3.3)};
  const auto with_certainty = [](std::int8_t percent) {
    return with_grids([percent](std::vector<Entry>& all, std::size_t frame) {
      add_occupancy(all, frame);
      OccupancyGrid graded{occupancy(frame)};
      std::ranges::fill(graded.data, percent);
      all.push_back(entry("/camera/occupancy_certainty", start_ns + stamp_of(frame), graded));
    });
  };
  ASSERT_EQ(run_fused(with_certainty(99)).exit_code, 0);
  EXPECT_GT(observed(3.3), binary);
  ASSERT_EQ(run_fused(with_certainty(20)).exit_code, 0);
  EXPECT_LT(observed(3.3), binary);
  EXPECT_THAT(run_tool({"info", bag()}).output, HasSubstr("/camera/occupancy with /camera/occupancy_certainty"));
}

TEST_F(BagGrids, CellsOfGridCellsAreOccupiedAndOthersUnknown) {
  const auto add = [](std::vector<Entry>& all, std::size_t frame) {
    GridCells cells;
    cells.header = header(stamp_of(frame));
    cells.header.frame_id = "camera_link";
    cells.cell_width = cells.cell_height = 0.05F;
    for (int i{0}; i < 40; ++i) cells.cells.push_back({3.425, -1 + 0.05 * i, 0});
    all.push_back(entry("/camera/occupancy", start_ns + stamp_of(frame), cells));
  };
  write_mcap(bag(), with_grids(add));
  ASSERT_EQ(run_bag(bag(), {"--poses", "none"}).exit_code, 0);
  const double beside{observed(4.3)};
  const Outcome run{run_fused(with_grids(add))};
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_GT(observed(3.3), 0.6);
  EXPECT_NEAR(observed(4.3), beside, 0.05);
}

TEST_F(BagGrids, InAFixedFrameWithoutItsPosesAreRefused) {
  const Outcome run{run_fused(with_grids([](std::vector<Entry>& all, std::size_t frame) {
    OccupancyGrid grid{occupancy(frame)};
    grid.header.frame_id = "map";
    all.push_back(entry("/map", start_ns + stamp_of(frame), grid));
  }))};
  EXPECT_EQ(run.exit_code, 65);
  EXPECT_THAT(run.errors, HasSubstr("has grids in 'map' on /map, but no poses in that frame"));
}

TEST_F(BagGrids, OneOfSeveralTopicsIsNamed) {
  const std::vector<Entry> content{with_grids([](std::vector<Entry>& all, std::size_t frame) {
    for (const char* topic : {"/local_costmap", "/map"}) {
      all.push_back(entry(topic, start_ns + stamp_of(frame), occupancy(frame)));
    }
  })};
  const Outcome run{run_fused(content)};
  EXPECT_EQ(run.exit_code, 65);
  EXPECT_THAT(run.errors,
              HasSubstr("has grids on more than one topic (/local_costmap, /map); name one with --grid-topic"));
  EXPECT_EQ(run_fused(content, {"--grid-topic", "/local_costmap"}).exit_code, 0);
  EXPECT_THAT(run_fused(content, {"--grid-topic", "/other"}).errors, HasSubstr("has no grids on /other"));
}

TEST_F(BagGrids, FramesWithoutAGridSaySo) {
  const Outcome run{run_fused(with_grids([](std::vector<Entry>& all, std::size_t frame) {
    OccupancyGrid grid{occupancy(frame)};
    if (frame == 1) grid.data.pop_back();
    if (frame < 2) all.push_back(entry("/camera/occupancy", start_ns + stamp_of(frame), grid));
  }))};
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto warnings = [](std::size_t frame) { return lines_of(out()).at(frame).at("warnings").dump(); };
  EXPECT_THAT(warnings(0), Not(HasSubstr("stereo alone")));
  EXPECT_THAT(warnings(1), HasSubstr("stereo alone: "));
  EXPECT_THAT(warnings(1), HasSubstr("has 40 × 20 cells and 799 values"));
  EXPECT_THAT(warnings(3), HasSubstr("stereo alone: no grid within 0.1 s"));
}

TEST(PlacedGrid, FineCellsThatAreOccupiedAreNotLost) {
  Image<float> occupancy{10, 10};
  occupancy(3, 4) = 1;
  const io::PlacedGrid grid{{{0, 0, 0.1, 10, 10}, std::move(occupancy)}, {2, 1, std::numbers::pi / 2}};
  const ObservedGrid made{io::resampled(grid, {0, 0, 0.5, 8, 8})};
  // (0.35, 0.45) m of the grid is (2 − 0.45, 1 + 0.35) m
  EXPECT_EQ(made.occupancy(3, 2), 1);
  EXPECT_EQ(made.occupancy(2, 2), 0);
  EXPECT_EQ(made.confidence(2, 2), 1);
  EXPECT_EQ(made.confidence(6, 2), 0);
  EXPECT_EQ(made.occupancy(6, 2), 0.5F);
}

}  // namespace
}  // namespace stereogrid::app::testing
