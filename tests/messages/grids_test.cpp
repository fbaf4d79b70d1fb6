// SPDX-License-Identifier: Apache-2.0
//
// Occupancy grids and the grid map: which value lands where, seen as a reader does.
#include "stereogrid/error.hpp"
#include "stereogrid/messages/foxglove_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using nav_msgs::OccupancyGrid;

TEST(OccupancyGridMessage, HasTheWorldsCellsInTheirOrder) {
  FrameResult result{small_result()};
  result.world.occupancy(3, 1) = 0.9f;
  result.world.occupancy(0, 2) = 0.1f;
  const auto grid{sent_on<OccupancyGrid>("/stereo_grid/occupancy_grid", result, {.stamp_ns = 1'500'000'007})};
  EXPECT_EQ(grid.header.frame_id, "odom");
  EXPECT_EQ(grid.header.stamp.sec, 1);
  EXPECT_EQ(grid.header.stamp.nanosec, 500'000'007u);
  EXPECT_EQ(grid.info.width, 5u);
  EXPECT_EQ(grid.info.height, 4u);
  EXPECT_EQ(grid.info.origin.position.x, -1);
  EXPECT_EQ(grid.info.origin.position.y, 2);
  EXPECT_EQ(grid.info.origin.orientation.w, 1);
  ASSERT_EQ(grid.data.size(), 20u);
  EXPECT_EQ(grid.data[1 * 5 + 3], 90);
  EXPECT_EQ(grid.data[2 * 5 + 0], 10);
  EXPECT_EQ(grid.data[0], -1);
}

// Far from the origin 0.2f and 0.2 are cells apart in the edges that a reader computes, or the corner does not lie on a
// whole cell: Nav2 warns of that.
TEST(OccupancyGridMessage, LiesOnWholeCellsOfThePublishedSize) {
  for (const double cell_size_m : {0.05, 0.1, 0.2, 0.3, 1.0 / 3}) {
    for (const int first : {-70'000, -1, 0, 3, 12'345, 1'000'000}) {
      FrameResult result{small_result()};
      result.world.geometry = {first * cell_size_m, -first * cell_size_m, cell_size_m, 5, 4};
      const auto grid{sent_on<OccupancyGrid>("/stereo_grid/occupancy_grid", result)};
      const double resolution_m{static_cast<double>(grid.info.resolution)};
      EXPECT_EQ(grid.info.origin.position.x, first * resolution_m);
      EXPECT_EQ(grid.info.origin.position.y, -first * resolution_m);
      EXPECT_NEAR(grid.info.origin.position.x, result.world.geometry.x_min_m,
                  1e-7 * std::abs(result.world.geometry.x_min_m));
    }
  }
}

TEST(OccupancyGridMessage, OfThisFrameIsInTheVehiclesFrame) {
  FrameResult result{small_result()};
  result.observed(7, 5) = 1;
  const auto grid{sent_on<OccupancyGrid>("/stereo_grid/observed_grid", result)};
  EXPECT_EQ(grid.header.frame_id, "base_link");
  EXPECT_EQ(grid.info.origin.position.y, -1.5);
  EXPECT_EQ(grid.info.width, 8u);
  ASSERT_EQ(grid.data.size(), 48u);
  EXPECT_EQ(grid.data[47], 100);
  EXPECT_EQ(grid.data[46], -1);
}

TEST(OccupancyGridMessage, TakesTheScale) {
  FrameResult result{small_result()};
  result.world.occupancy(0, 0) = 0.4f;
  for (const OccupancyScale scale :
       {OccupancyScale::percent, OccupancyScale::trinary, OccupancyScale::nav2, OccupancyScale::autoware}) {
    const auto grid{sent_on<OccupancyGrid>("/stereo_grid/occupancy_grid", result, {}, {.scale = scale})};
    EXPECT_EQ(grid.data[0], occupancy_value(0.4f, scale));
    EXPECT_EQ(grid.data[1], occupancy_value(0.5f, scale));
  }
}

TEST(OccupancyGridMessage, OfEachPredictionHasATopic) {
  FrameResult result{small_result()};
  for (const double horizon_s : {0.5, 2.0}) {
    result.predictions.push_back({horizon_s, Image<float>{8, 6, 0.5f}, Image<float>{5, 4, 0.5f}});
    result.predictions.back().world_occupancy(1, 0) = horizon_s < 1 ? 0.8f : 0.2f;
  }
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  messages.send(result, {});
  std::swap(result.predictions[0], result.predictions[1]);
  messages.send(result, {});
  EXPECT_EQ(recorder.count("/stereo_grid/predicted_grid_0_5"), 2u);
  EXPECT_EQ(recorder.last<OccupancyGrid>("/stereo_grid/predicted_grid_0_5").data[1], 80);
  EXPECT_EQ(recorder.last<OccupancyGrid>("/stereo_grid/predicted_grid_2").data[1], 20);
  EXPECT_EQ(recorder.last<OccupancyGrid>("/stereo_grid/predicted_grid_2").header.frame_id, "odom");
}

TEST(OccupancyGridMessage, ForPlanningHasTheHighestOfPresentAndPredictions) {
  FrameResult result{small_result()};
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  messages.send(result, {});
  EXPECT_EQ(recorder.count("/stereo_grid/planning_grid"), 0u) << "without predictions it is occupancy_grid";
  struct Case {
    float present, sooner, later;
    int expected;
  };
  const std::array<Case, 6> cases{{{0.9f, 0.1f, 0.5f, 90},
                                   {0.1f, 0.8f, 0.2f, 80},
                                   {0.1f, 0.5f, 0.5f, 10},
                                   {0.5f, 0.2f, 0.3f, -1},
                                   {0.5f, 0.2f, 0.7f, 70},
                                   {0.1f, 0.2f, 0.3f, 30}}};
  result.predictions = {{0.5, Image<float>{8, 6, 0.5f}, Image<float>{5, 4, 0.5f}},
                        {1, Image<float>{8, 6, 0.5f}, Image<float>{5, 4, 0.5f}}};
  for (std::size_t i{0}; i < cases.size(); ++i) {
    result.world.occupancy.data()[i] = cases[i].present;
    result.predictions[0].world_occupancy.data()[i] = cases[i].sooner;
    result.predictions[1].world_occupancy.data()[i] = cases[i].later;
  }
  messages.send(result, {});
  const auto grid{recorder.last<OccupancyGrid>("/stereo_grid/planning_grid")};
  EXPECT_EQ(grid.header.frame_id, "odom");
  ASSERT_EQ(grid.data.size(), 20u);
  for (std::size_t i{0}; i < cases.size(); ++i) EXPECT_EQ(grid.data[i], cases[i].expected) << i;
}

/// A vehicle that has turned to the left, with an elevation, class and witness in one cell.
FrameResult raised_result() {
  FrameResult result{small_result()};
  result.world_from_vehicle = {0.5, 1, std::numbers::pi / 2};
  for (Image<float>* const layer : {&result.world_elevation_m, &result.world_elevation_sigma_m}) {
    *layer = Image<float>{5, 4, std::numeric_limits<float>::quiet_NaN()};
  }
  result.world_terrain = Image<TerrainClass>{5, 4};
  // cell (4, 3) of the vehicle's grid: 2.25 m ahead, 0.25 m to the left; (0.25, 3.25) in the world: cell (2, 2)
  result.world_elevation_m(2, 2) = -0.125f;
  result.world_elevation_sigma_m(2, 2) = 0.03125f;
  result.world_terrain(2, 2) = TerrainClass::drop;
  result.witness = Image<CellWitness>{8, 6};
  result.witness(4, 3) = CellWitness::of(Witness::memory, 0.9f);
  return result;
}

TEST(OccupancyGridMessage, OfNoPipelineIsRefused) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  EXPECT_THROW(messages.send({}, {}), InputError);
  FrameResult result{small_result()};
  result.world.moving = Image<float>{5, 3};
  EXPECT_THROW(messages.send(result, {}), InputError);
  result = raised_result();
  result.world_elevation_sigma_m = {};
  EXPECT_THROW(messages.send(result, {}), InputError);
  EXPECT_TRUE(recorder.sent.empty());
}

// Reads a message like GridMap's library: element (row, column) of a layer, and its position.
struct GridMapReader {
  const grid_map_msgs::GridMap& map;

  [[nodiscard]] float at(std::size_t layer, std::uint32_t row, std::uint32_t column) const {
    const std_msgs::Float32MultiArray& array{map.data.at(layer)};
    EXPECT_EQ(array.layout.dim.at(0).label, "column_index");
    EXPECT_EQ(array.layout.dim.at(1).label, "row_index");
    EXPECT_EQ(array.layout.dim.at(0).stride, array.data.size());
    return array.data.at(array.layout.data_offset + column * array.layout.dim.at(1).stride + row);
  }
  [[nodiscard]] Point2 centre(std::uint32_t row, std::uint32_t column) const {
    return {map.info.pose.position.x + map.info.length_x / 2 - (row + 0.5) * map.info.resolution,
            map.info.pose.position.y + map.info.length_y / 2 - (column + 0.5) * map.info.resolution};
  }
};

TEST(GridMapMessage, HasEachCellWhereItLies) {
  FrameResult result{small_result()};
  const GridGeometry& geometry{result.world.geometry};
  for (const auto [ix, iy] : raster(geometry.nx, geometry.ny)) {
    result.world.occupancy(ix, iy) = static_cast<float>(10 * ix + iy);
    result.world.age_s(ix, iy) = 0.25f;
  }
  const auto map{sent_on<grid_map_msgs::GridMap>("/stereo_grid/grid_map", result)};
  const GridMapReader reader{map};
  ASSERT_EQ(map.data.at(0).layout.dim.at(0).size, 4u);  // columns lie along y
  ASSERT_EQ(map.data.at(0).layout.dim.at(1).size, 5u);  // rows lie along x
  for (std::uint32_t row{0}; row < 5; ++row) {
    for (std::uint32_t column{0}; column < 4; ++column) {
      const auto cell{geometry.cell_at(reader.centre(row, column))};
      ASSERT_TRUE(cell);
      EXPECT_EQ(reader.at(0, row, column), static_cast<float>(10 * cell->ix + cell->iy));
    }
  }
  EXPECT_EQ(map.header.frame_id, "odom");
  EXPECT_EQ(map.outer_start_index, 0u);
  EXPECT_EQ(map.inner_start_index, 0u);
}

TEST(GridMapMessage, HasItsLayersAndNoNumbersWhereNothingWasSeen) {
  FrameResult result{small_result()};
  result.world.age_s(4, 3) = 1.5f;
  result.world.occupancy(4, 3) = 0.75f;
  result.world.velocity_x(4, 3) = 3;
  result.world.velocity_y(4, 3) = -4;
  result.world.moving(4, 3) = 0.625f;
  const auto map{sent_on<grid_map_msgs::GridMap>("/stereo_grid/grid_map", result)};
  EXPECT_THAT(map.layers, testing::ElementsAre("occupancy", "velocity_x", "velocity_y", "moving", "age"));
  EXPECT_THAT(map.basic_layers, testing::ElementsAre("occupancy"));
  const std::vector<float> expected{0.75f, 3, -4, 0.625f, 1.5f};
  for (std::size_t layer{0}; layer < 5; ++layer) {
    EXPECT_EQ(GridMapReader{map}.at(layer, 0, 0), expected[layer]);
    EXPECT_TRUE(std::isnan(GridMapReader{map}.at(layer, 1, 0)));
  }
}

TEST(GridMapMessage, HasElevationsClassesAndWitnesses) {
  const FrameResult result{raised_result()};
  const auto map{sent_on<grid_map_msgs::GridMap>("/stereo_grid/grid_map", result)};
  EXPECT_THAT(map.layers, testing::ElementsAre("occupancy", "velocity_x", "velocity_y", "moving", "age", "elevation",
                                               "elevation_sigma", "terrain", "witness"));
  const GridMapReader reader{map};
  for (std::uint32_t row{0}; row < 5; ++row) {
    for (std::uint32_t column{0}; column < 4; ++column) {
      const auto cell{result.world.geometry.cell_at(reader.centre(row, column))};
      const bool is_raised{cell == CellIndex{2, 2}};
      EXPECT_EQ(std::isnan(reader.at(5, row, column)), !is_raised);
      EXPECT_EQ(std::isnan(reader.at(6, row, column)), !is_raised);
      EXPECT_TRUE(std::isnan(reader.at(0, row, column)));  // not observed by the filter
      EXPECT_EQ(reader.at(7, row, column), is_raised ? 3 : 0);
      EXPECT_EQ(reader.at(8, row, column), is_raised ? 0x43 : 0);
      if (!is_raised) continue;
      EXPECT_EQ(reader.at(5, row, column), -0.125f);
      EXPECT_EQ(reader.at(6, row, column), 0.03125f);
    }
  }
}

/// A field of a packed grid's cell, as a reader finds it by its name.
int packed(const foxglove_msgs::Grid& grid, const std::string& name, std::size_t ix, std::size_t iy) {
  const auto field{std::ranges::find(grid.fields, name, &foxglove_msgs::PackedElementField::name)};
  EXPECT_NE(field, grid.fields.end()) << name;
  const std::size_t at{iy * grid.row_stride + ix * grid.cell_stride + field->offset};
  if (field->type == 1) return grid.data.at(at);
  EXPECT_EQ(field->type, 4);
  return static_cast<std::int16_t>(grid.data.at(at) | grid.data.at(at + 1) << 8);
}

TEST(PackedGridMessage, HasEachLayerOfEachCell) {
  FrameResult result{small_result()};
  result.world.age_s(3, 2) = 1.46f;
  result.world.occupancy(3, 2) = 0.75f;
  result.world.velocity_x(3, 2) = 3.004f;
  result.world.velocity_y(3, 2) = -12.5f;
  result.world.moving(3, 2) = 1;
  const auto grid{sent_on<foxglove_msgs::Grid>("/stereo_grid/packed_grid", result, {.stamp_ns = 2'000'000'001})};
  EXPECT_EQ(grid.timestamp.sec, 2);
  EXPECT_EQ(grid.timestamp.nanosec, 1u);
  EXPECT_EQ(grid.frame_id, "odom");
  EXPECT_EQ(grid.pose.position.x, result.world.geometry.x_min_m);
  EXPECT_EQ(grid.pose.position.y, result.world.geometry.y_min_m);
  EXPECT_EQ(grid.cell_size.x, result.world.geometry.cell_size_m);
  EXPECT_EQ(grid.column_count, 5u);
  EXPECT_EQ(grid.data.size(), 4u * grid.row_stride);
  EXPECT_EQ(packed(grid, "occupancy_255ths", 3, 2), 191);
  EXPECT_EQ(packed(grid, "moving_255ths", 3, 2), 255);
  EXPECT_EQ(packed(grid, "velocity_x_cm_s", 3, 2), 300);
  EXPECT_EQ(packed(grid, "velocity_y_cm_s", 3, 2), -1250);
  EXPECT_EQ(packed(grid, "age_ds", 3, 2), 15);
  EXPECT_EQ(packed(grid, "age_ds", 2, 3), 255);
}

TEST(PackedGridMessage, HasElevationsIfTheResultHasThem) {
  FrameResult result{raised_result()};
  result.world_elevation_m(1, 2) = 500;
  const auto grid{sent_on<foxglove_msgs::Grid>("/stereo_grid/packed_grid", result)};
  EXPECT_EQ(grid.cell_stride, 11u);
  EXPECT_EQ(grid.data.size(), 4u * 5u * 11u);
  for (std::size_t iy{0}; iy < 4; ++iy) {
    for (std::size_t ix{0}; ix < 5; ++ix) {
      const bool is_high{iy == 2 && ix == 1};
      EXPECT_EQ(packed(grid, "elevation_cm", ix, iy), iy == 2 && ix == 2 ? -13 : is_high ? 32767 : -32768);
      EXPECT_EQ(packed(grid, "witness", ix, iy), iy == 2 && ix == 2 ? 0x43 : 0);
      EXPECT_EQ(packed(grid, "terrain", ix, iy), iy == 2 && ix == 2 ? 3 : 0);
      EXPECT_EQ(packed(grid, "age_ds", ix, iy), 255);
    }
  }
  const auto flat{sent_on<foxglove_msgs::Grid>("/stereo_grid/packed_grid", small_result())};
  EXPECT_EQ(flat.cell_stride, 7u);
  EXPECT_EQ(flat.fields.back().name, "age_ds");
}

TEST(PackedGridMessage, KeepsWhatDoesNotFitAtItsEnds) {
  FrameResult result{small_result()};
  result.world.velocity_x(0, 0) = 1e9f;
  result.world.velocity_y(0, 0) = -1e9f;
  result.world.age_s(0, 0) = 3600;
  const auto grid{sent_on<foxglove_msgs::Grid>("/stereo_grid/packed_grid", result)};
  EXPECT_EQ(packed(grid, "velocity_x_cm_s", 0, 0), 32767);
  EXPECT_EQ(packed(grid, "velocity_y_cm_s", 0, 0), -32767);
  EXPECT_EQ(packed(grid, "age_ds", 0, 0), 254);
}

}  // namespace
}  // namespace stereogrid::messages::test
