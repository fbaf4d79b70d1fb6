// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/evaluation/ray_fan.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

// Grids that others make of the same disparities, to compare with. docs/evaluation.md has the sources, and how the
// parameters were chosen. All give P(occupied) over the cells of a grid in the vehicle frame, 0.5 = unknown.

namespace stereogrid::research {

/// Input of every method for a frame: the pipeline's disparities and ground.
struct DisparityFrame {
  Rig rig;  ///< rig of the level images
  Ground ground;
  int disparities{0};          ///< searched: up to this minus one
  View<const float> obstacle;  ///< (H, W) px, 0 = none
  View<const float> road;      ///< (H, W) px, 0 = none
};

/// Probabilities of the states that a method distinguishes.
struct Levels {
  double free{0.02};
  double occupied{0.98};
};

/// Conversion of columns to cells; the same in all methods that work in columns.
struct ColumnGridParameters {
  int bins_per_px{4};            ///< bins of the u-disparity plane
  int left_border_px{6};         ///< bins with u < d + this are unknown: the right camera does not see them
  double sigma_column{2};        ///< px, Gaussian smoothing across columns; 0: none
  double sigma_disparity{0.25};  ///< px
};

/// Nearest obstacle per column, free before, unknown behind (Murray & Little 2000).
struct NearestObstacleParameters {
  ColumnGridParameters grid;
  Levels levels;
  int spike_px{50};          ///< connected surfaces of fewer pixels are spikes and dropped
  double height_min_m{0.2};  ///< pixels between these heights are obstacles
  double height_max_m{1.8};
  double filled_m{0.2};  ///< height that must be filled with pixels of one disparity; 0: a pixel is enough
  bool open_road{true};  ///< a column without obstacle is free as far as its road is seen; false: it is unknown
};
[[nodiscard]] Image<float> nearest_obstacle_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                                 const NearestObstacleParameters& parameters = {});

/// Stochastic occupancy over (column, disparity), then the best boundary by dynamic programming (Badino, Franke, Mester
/// 2007).
struct OccupancyBoundaryParameters {
  ColumnGridParameters grid{.bins_per_px = 2, .sigma_column = 0.5};
  Levels levels{.free = 0.05};
  double height_min_m{0.2};
  double height_max_m{1.8};
  int column_px{1};      ///< width of a column of the stochastic grid
  double sigma_u_px{1};  ///< standard deviation of a measurement
  double sigma_d_px{0.3};
  double peak{0.1};             ///< share of the obstacle's height that is filled: where the background begins
  double no_obstacle_cost{40};  ///< cost of a column without boundary
  double jump_cost{0.5};        ///< per px of disparity between neighbouring columns
  double jump_max_px{2};
};
[[nodiscard]] Image<float> occupancy_boundary_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                                   const OccupancyBoundaryParameters& parameters = {});

/// Free space from a score of each image column's rows, smoothed by dynamic programming: the base of the stixels of
/// Badino, Franke, Pfeiffer 2009.
struct FreeSpaceParameters {
  ColumnGridParameters grid{.bins_per_px = 2};
  Levels levels{.free = 0.05};
  int column_px{3};
  double obstacle_height_m{0.8};  ///< objects above the boundary
  double obstacle_weight{1};
  double road_weight{1};
  double unexplained_px{2};     ///< assumed difference of a row above the obstacle
  double none_px{3};            ///< difference that a pixel without disparity counts for
  double difference_max_px{2};  ///< larger differences count for this
  double jump_cost{0.2};        ///< per row between neighbouring columns
  int jump_max_rows{10};
  int rows_min{90};            ///< rows that an obstacle is scored on where its base lies below the image
  double disparity_min_px{3};  ///< boundaries beyond are no obstacles
};
[[nodiscard]] Image<float> free_space_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                           const FreeSpaceParameters& parameters = {});

/// A part of a stixel column; rows of the image, first is the upper one.
enum class StixelClass { ground, object, sky };
struct Stixel {
  StixelClass kind{StixelClass::ground};
  int first_row{0};
  int last_row{0};
  double disparity{0};  ///< disparity of an object
  double matched{0};    ///< share of the rows that have a disparity
};

/// Columns cut into ground, objects and sky by exact dynamic programming (Pfeiffer & Franke 2011).
struct StixelParameters {
  ColumnGridParameters grid;
  Levels levels;
  double between_free{0.1};  ///< probability where ground is seen behind the first object
  double height_min_m{0.4};  ///< objects that reach into these heights are obstacles
  double height_max_m{1.8};
  int column_px{3};
  int row_px{2};
  double sigma_px{0.5};
  double outlier_ground{0.05};
  double outlier_object{0.3};
  double outlier_sky{0.4};
  double ground_sigma_rad{0.005};  ///< standard deviation of the ground's pitch
  double object_depth_m{0};
  double order{0.3};    ///< probability that an object stands before the one below it
  double gravity{0.1};  ///< prior of an object that floats above the ground
  double below_ground{0.001};
  double gap_m{0.5};  ///< objects nearer to each other than this are hardly ever two
  double cut{2};      ///< cost of each further stixel
};
[[nodiscard]] std::vector<std::vector<Stixel>> stixels(const DisparityFrame& frame,
                                                       const StixelParameters& parameters = {});
[[nodiscard]] Image<float> stixel_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                       const StixelParameters& parameters = {});

/// Point-cloud ray casting: obstacle points are hits, road points free ends, cells on the way are cleared by a grid
/// traversal; a hit outweighs what passes above it.
[[nodiscard]] Image<float> ray_casting_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                            const evaluation::LogOddsParameters& parameters = {});

/// The same over time: the log-odds of all frames summed in the world, which is taken to stand still.
class LogOddsMap {
 public:
  explicit LogOddsMap(double weight_of_frame = 0.8, const evaluation::LogOddsParameters& parameters = {
                                                        .hit = 0.6, .any_pass = 0.5, .lowest = -3, .highest = 4});

  /// Adds a frame and gives the map as it lies under a grid in the vehicle frame.
  [[nodiscard]] Image<float> update(const DisparityFrame& frame, const Pose2& world_from_vehicle,
                                    const GridGeometry& grid);

 private:
  double weight_;
  evaluation::LogOddsParameters parameters_;
  std::unordered_map<std::int64_t, float> cells_;
};

}  // namespace stereogrid::research
