// SPDX-License-Identifier: Apache-2.0
//
// Never observed cells and cells without rays are skipped (docs/method.md §8.7), with the results of the plain loops.
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "observation/rays/rays.hpp"
#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

constexpr int cells{150};
constexpr GridGeometry window{-3, 5, 0.2, cells, cells};

// A patch of the window that has been looked at; something goes through it and out of it.
Image<float> patch(int step, std::mt19937& generator) {
  Image<float> observed{cells, cells, 0.5f};
  for (const auto [x, y] : raster(30, 80, 40, 70)) observed(x, y) = uniform(generator, 0, 1) < 0.2 ? 0.5f : 0.1f;
  for (int y{50}; y < 58; ++y) std::fill_n(&observed(50 + 2 * step, y), 6, 0.95f);
  observed(20, 20) = 0.52f;  // known of, though not observed as is_known says
  return observed;
}

// The CPU's step as in the pipeline, with layers that keep unobserved cells.
struct KeptRun {
  KeptRun(Cpu& back_end, const FilterConfig& parameters) : cpu{back_end}, run{cpu, parameters, window} {
    kinds.resize(run.now.kinds.size());
  }

  void step(const Image<float>& observed, const GridGeometry& geometry) {
    std::swap(run.now, run.before);
    const FilterInput input{run.config, run.tables, geometry, 0.1, {}, &kinds};
    filter(cpu, input, observed.view(), run.before, run.now, run.layers);
    kinds = run.now.kinds;
  }
  void weigh(std::span<const VelocityEvidence> evidence) {
    weigh_velocities(cpu, evidence, run.tables, space, run.now, run.layers);
    kinds = run.now.kinds;
  }
  [[nodiscard]] auto blocks(BlockKind kind) const { return std::count(kinds.begin(), kinds.end(), kind); }

  Cpu& cpu;
  FilterRun<Cpu> run;
  WeighingWorkspace space{cells, run.tables, 2};
  std::vector<BlockKind> kinds;
};

TEST(UnseenCells, ArePassedOverToTheBit) {
  std::mt19937 generator{29};
  Reference reference;
  Cpu cpu{2};
  const FilterConfig config;
  FilterRun slow{reference, config, window};
  KeptRun fast{cpu, config};
  GridGeometry geometry{window};
  const int moves[][2]{{0, 0}, {3, 0}, {16, 8}, {-5, 2}, {0, -9}, {60, 0}, {1, 1}, {-200, 0}, {2, 0}, {0, 0}};
  int step{0};
  for (const auto& move : moves) {
    SCOPED_TRACE(step);
    geometry.x_min_m += 0.2 * move[0];
    geometry.y_min_m += 0.2 * move[1];
    const Image<float> observed{patch(step++, generator)};
    slow.step(observed, 0.1, geometry);
    fast.step(observed, geometry);
    // one of the points lies where nothing has been seen
    const std::vector<VelocityEvidence> evidence{{52 * cells + 52, 4, 0, 2, 0, 2}, {130 * cells + 130, 0, 5, 2, 0, 2}};
    weigh_velocities(reference, evidence, slow.tables, slow.now, slow.layers);
    fast.weigh(evidence);
    expect_equal(slow.layers, fast.run.layers);
    for (const std::size_t k : {0U, 60U, 84U, 100U}) {
      EXPECT_TRUE(have_equal_bits(masses_of(slow.now, k), masses_of(fast.run.now, k))) << k;
    }
    EXPECT_GT(fast.blocks(BlockKind::unseen), fast.run.now.blocks.layout().count() / 3) << "or this test says nothing";
  }
}

TEST(UnseenCells, StayAsTheyAreBesideWhatMoves) {
  std::mt19937 generator{31};
  Cpu cpu{1};
  FilterRun run{cpu, FilterConfig{}, window};
  for (int step{0}; step < 8; ++step) run.step(patch(step, generator));
  for (const CellIndex at : {CellIndex{5, 120}, {100, 10}, {29, 39}}) {
    EXPECT_EQ(run.layers.occupancy(at.ix, at.iy), 0.5f);
    EXPECT_EQ(run.layers.age_s(at.ix, at.iy), std::numeric_limits<float>::infinity());
  }
  EXPECT_NE(run.layers.occupancy(20, 20), 0.5f) << "little is known, but something";
}

// Most by which a never observed cell is more likely than ½ or than the motion in it. A car that is seen to move enters
// ground that no frame has observed; beside it, features that stand are measured there in every frame.
template <class BackEndType>
float excess_of_never_observed(BackEndType& back_end, bool& has_car) {
  std::mt19937 generator{31};
  FilterRun run{back_end, FilterConfig{}, window};
  float excess{0};
  for (int step{0}; step < 20; ++step) {
    Image<float> observed{patch(step, generator)};
    observed(20, 20) = 0.5f;
    for (int y{62}; y < 66; ++y) std::fill_n(&observed(74, y), 4, 0.95f);  // stands at the border of the patch
    run.step(observed);
    std::vector<VelocityEvidence> evidence;
    for (const auto [x, y] : raster(54 + 2 * step, std::min(60 + 2 * step, 80), 50, 58)) {
      evidence.push_back({y * cells + x, 4, 0, 2, 0, 2, 0, 1});
    }
    for (const auto [x, y] : raster(80, 84, 60, 68)) evidence.push_back({y * cells + x, 0, 0, 2, 0, 2, 0, 0, 1});
    std::ranges::sort(evidence, {}, &VelocityEvidence::cell);
    weigh_velocities(back_end, evidence, run.tables, run.now, run.layers);
    for (std::size_t i{0}; i < run.layers.age_s.size(); ++i) {
      if (run.layers.age_s.data()[i] < std::numeric_limits<float>::infinity()) continue;
      const float occupancy{run.layers.occupancy.data()[i]};
      excess = std::max(excess, occupancy - std::max(0.5f, run.layers.moving.data()[i]));
      has_car = has_car || occupancy > 0.6f;
    }
  }
  return excess;
}

TEST(UnseenCells, AreNoMoreLikelyThanWhatMovesIntoThem) {
  Reference reference;
  bool has_car{false};
  EXPECT_LT(excess_of_never_observed(reference, has_car), 0.02f) << "static mass of one step's decay";
  EXPECT_TRUE(has_car) << "it drives on";
}

// Frames that say little of a cell say the same again and again.
TEST(UnseenCells, StayUnknownWhileNoFrameObservesThem) {
  Cpu cpu{1};
  for (const float p : {0.46f, 0.54f}) {
    FilterRun run{cpu, FilterConfig{}, window};
    for (int step{0}; step < 40; ++step) run.step(Image<float>{cells, cells, p});
    for (const float occupancy : run.layers.occupancy) ASSERT_NEAR(occupancy, p, 0.02) << p;
  }
}

// Far ahead, motion is not measured, and most new mass is an error of matching.
class FarCells : public ::testing::Test {
 protected:
  static constexpr GridGeometry far_window_{0, -40, 0.4, 200, 200};

  [[nodiscard]] FilterStep step(const CameraView& view) const {
    return step_of({config_, tables_, far_window_, 0.1, view});
  }
  [[nodiscard]] CellIndex cell_at(double x_m) const { return *far_window_.cell_at({x_m, 0.1}); }

  FilterConfig config_;
  FilterTables tables_{config_};
  CameraView view_{{0, 0, 0}, 1, 1, std::numeric_limits<double>::infinity(), 90};
};

TEST_F(FarCells, DoNotCountAsMoving) {
  FilterState state{200, config_};
  state.occupancy.fill(0.9f);
  state.standing.fill(0.1f);
  const auto move_at = [&](const CameraView& view, double x_m, Scroll scroll) {
    const CellIndex cell{cell_at(x_m)};
    return !state.moving_cells(step(view), scroll, state.blocks.layout().block_of(cell.ix, cell.iy)).is_empty();
  };
  EXPECT_TRUE(move_at(view_, 40, {}));
  EXPECT_FALSE(move_at(view_, 50, {}));
  EXPECT_TRUE(move_at(view_, 50, {20, 0})) << "the window has moved on by 8 m, the camera is where it was in it";
  EXPECT_FALSE(move_at(view_, 40, {-20, 0}));
  EXPECT_TRUE(move_at({}, 79, {})) << "nothing is known of the camera";
  config_.scene_flow = false;
  EXPECT_TRUE(move_at(view_, 79, {})) << "the filter has to find out by itself";
}

TEST_F(FarCells, AppearAsNewThingsDo) {
  const auto moving_at = [&](const CameraView& view, double x_m) {
    const Likelihood likelihood{likelihood_of(tables_.likelihood.data(), 0.9f)};
    const CellIndex cell{cell_at(x_m)};
    FilterStep step_now{step(view)};
    step_now.sharp_squares = std::numeric_limits<float>::infinity();  // decay by depth brings mass of its own
    return joint_update(step_now, 0.1f, 0.0f, 0.0f, likelihood, view_of(step_now, cell.ix, cell.iy)).birth_moving;
  };
  EXPECT_GT(moving_at(view_, 30), 2 * moving_at(view_, 40)) << "a pixel of disparity is 25 cells in depth, and 44";
  EXPECT_EQ(moving_at({}, 30), moving_at({}, 40)) << "nothing is known of the camera";
}

FrameResult empty_result_of(const GridGeometry& grid) {
  FrameResult result{};
  result.world = grid_layers(window);
  result.vehicle = grid_layers(grid);
  return result;
}

TEST(Resample, OfTheCpuIsThatOfThePlainLoopsOnEveryInstructionSet) {
  std::mt19937 generator{37};
  for (const double yaw_rad : {0.0, 0.3, 1.7, -2.9}) {
    FrameResult slow{empty_result_of({0, -7, 0.3, 45, 51})};
    for (const auto layer :
         {&GridLayers::occupancy, &GridLayers::velocity_x, &GridLayers::velocity_y, &GridLayers::velocity_xx,
          &GridLayers::velocity_xy, &GridLayers::velocity_yy, &GridLayers::moving, &GridLayers::age_s}) {
      for (float& value : slow.world.*layer) value = static_cast<float>(uniform(generator, 0, 1));
    }
    FrameResult fast{slow};
    const Pose2 pose{4, 17, yaw_rad};  // partly outside of the window
    resample(pose, slow);
    for (const std::int64_t target : vector_targets()) {
      const ForcedTarget forced{target};
      resample_rows(pose, 0, 51, {}, fast);
      SCOPED_TRACE(name_of_target(target));
      expect_equal(slow.vehicle, fast.vehicle);
    }
  }
}

// Parts that stay unseen are passed over, in even ones nothing is written of what stays 0.
TEST(Resample, UsesWhatIsKnownOfBlocks) {
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    SCOPED_TRACE(name_of_target(target));
    std::mt19937 generator{41};
    Cpu cpu{1};
    KeptRun run{cpu, FilterConfig{}};
    FrameResult slow{empty_result_of({0, -10, 0.2, 70, 70})};
    FrameResult fast{slow};
    std::vector<BlockKind> parts(static_cast<std::size_t>(70 * resampled_parts(70)));
    std::array<int, 3> resampled{};  // parts, of each kind
    for (int step{0}; step < 8; ++step) {
      SCOPED_TRACE(step);
      run.step(patch(step, generator), window);
      slow.world = fast.world = run.run.layers;
      const Pose2 pose{6 + 0.37 * step, 19, 0.1 - 0.4 * step};
      resample(pose, slow);
      resample_rows(pose, 0, 70, {&run.run.now.kinds, &parts}, fast);
      expect_equal(slow.vehicle, fast.vehicle);
      for (const BlockKind kind : parts) ++resampled[static_cast<std::size_t>(kind)];
    }
    EXPECT_GT(*std::min_element(resampled.begin(), resampled.end()), 100) << "or this test says nothing";
  }
}

// A wall 8 m ahead hides the cells behind it, and none beside it.
TEST(HiddenCellsOfRays, AreUnknown) {
  constexpr int disparities{40};
  const Rig rig{201, 200, 300, 100, 50, 0.5, 1.5, 0, 0};
  Matches matches{201, 200};
  for (int v{0}; v < 200; ++v) {
    const double road_px{std::max((v - 50) * rig.baseline_m / rig.camera_height_m, 0.0)};
    for (int u{0}; u < 201; ++u) {
      const bool is_wall{u < 120 && road_px < 19};
      (is_wall ? matches.obstacle : matches.road)(u, v) = is_wall ? 18.75f : static_cast<float>(road_px);
    }
  }
  Cpu cpu{2};
  RayWorkspace space{201, 200, disparities};
  count_rays(cpu, matches, rig, {1.5, 0, 0, true}, UDisparityConfig{}, space);
  const RaySums<Host> sums{std::as_const(space.sums).view()};
  const BinGeometry geometry{rig};
  int hidden_tiles{0};
  for (const double yaw_rad : {0.0, 0.4, -1.2, 3.0}) {
    const GridInVehicle grid{grid_in_vehicle({-2, -12, 0.25, 120, 96}, {1, 0.5, yaw_rad})};
    const HiddenCells hidden{sums, geometry, grid};
    const CellsInView in_view{geometry, grid, 0.5f};
    for (int y{0}; y < 96; y += 8) {
      for (int x{0}; x < 120; x += 12) {
        if (!hidden.are_hidden(x, y, x + 11, y + 7)) continue;
        ++hidden_tiles;
        for (int i{0}; i < 96; ++i) {
          const int ix{x + i % 12};
          const int iy{y + i / 12};
          EXPECT_EQ(occupancy_at(sums, columns_max(200), in_view, ix, iy), 0.5f) << ix << " " << iy;
        }
      }
    }
  }
  EXPECT_GT(hidden_tiles, 100) << "or this test says nothing";
  const HiddenCells ahead{sums, geometry, {{-2, -12, 0.25, 120, 96}}};
  EXPECT_TRUE(ahead.are_hidden(60, 48, 70, 52)) << "13 m ahead, behind the wall";
  EXPECT_FALSE(ahead.are_hidden(36, 48, 40, 52)) << "in front of the wall";
  EXPECT_FALSE(ahead.are_hidden(60, 40, 70, 43)) << "beside it";
  EXPECT_TRUE(ahead.are_hidden(0, 0, 4, 95)) << "behind the camera";
}

}  // namespace
}  // namespace stereogrid::test
