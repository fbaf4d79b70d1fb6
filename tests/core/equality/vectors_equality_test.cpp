// SPDX-License-Identifier: Apache-2.0
//
// Patches, medians of sectors, places in the polar grid and evidence of velocities: vectors on every instruction set of
// this machine against plain loops.
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "ground_scene.hpp"
#include "images/patch.hpp"
#include "support.hpp"
#include "targets.hpp"
#include "terrain/polar_places.hpp"
#include "terrain/samples.hpp"

namespace stereogrid::test {
namespace {

constexpr int width{64};
constexpr int height{40};
// not the width: rows must not be taken for neighbours in memory
constexpr int pitch{71};

struct Random {
  std::mt19937 generator;

  float between(float least, float most) { return std::uniform_real_distribution<float>{least, most}(generator); }
  // on a pixel now and then, in one or both directions
  float place(float most) {
    const float any{between(-3, most + 3)};
    return generator() % 3 == 0 ? std::round(any) : any;
  }
  float shear() { return generator() % 2 == 0 ? 0.0f : between(-0.8f, 0.8f); }
};

Image<std::uint8_t> smooth_noise(Random& random) {
  Image<std::uint8_t> image{pitch, height};
  for (const auto [u, v] : raster(pitch, height)) {
    const double wave{50 * std::sin(0.4 * u + 0.3 * v) + 40 * std::cos(0.5 * v - 0.2 * u)};
    image(u, v) = static_cast<std::uint8_t>(120 + wave + random.between(0, 20));
  }
  return image;
}

View<const std::uint8_t> part_of(const Image<std::uint8_t>& image) {
  return {image.data(), width, height, pitch};
}

void expect_equal(const Template& expected, const Template& actual) {
  EXPECT_EQ(expected.grey, actual.grey);
  EXPECT_EQ(expected.gradient_u, actual.gradient_u);
  EXPECT_EQ(expected.gradient_v, actual.gradient_v);
  EXPECT_EQ(expected.uu, actual.uu);
  EXPECT_EQ(expected.uv, actual.uv);
  EXPECT_EQ(expected.vv, actual.vv);
  EXPECT_EQ(expected.variance, actual.variance);
}

TEST(PatchEquality, OnEveryInstructionSet) {
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    Random random{std::mt19937{7}};
    int cut_out{0};
    int found_again{0};
    const Image<std::uint8_t> image{smooth_noise(random)};
    for (int i{0}; i < 2000; ++i) {
      const Place at{random.place(width), random.place(height)};
      const float shear{random.shear()};
      Template expected;
      Template actual;
      const bool is_inside{plain::cut(part_of(image), at, shear, expected)};
      ASSERT_EQ(is_inside, cut(part_of(image), at, shear, actual)) << at.u << " " << at.v;
      if (!is_inside) continue;
      ++cut_out;
      expect_equal(expected, actual);
      const Place start{at.u + random.between(-2, 2), at.v + random.between(-2, 2)};
      const FindLimits limits{static_cast<int>(random.generator() % 6)};
      const std::optional<Place> there{plain::find(part_of(image), expected, shear, start, limits)};
      const std::optional<Place> found{find(part_of(image), actual, shear, start, limits)};
      ASSERT_EQ(there.has_value(), found.has_value());
      if (!there) continue;
      ++found_again;
      EXPECT_EQ(there->u, found->u);
      EXPECT_EQ(there->v, found->v);
    }
    EXPECT_GT(cut_out, 500);
    EXPECT_GT(found_again, 200);
  }
}

TEST(MediansEquality, OnEveryInstructionSet) {
  std::mt19937 random{5};
  for (const auto& [columns, rows_count] : {std::pair{5, 9}, {8, 1}, {16, 7}, {31, 8}, {64, 33}, {40, 100}}) {
    Image<float> obstacle{columns, rows_count};
    Image<float> road{columns, rows_count};
    for (int i{0}; i < columns * rows_count; ++i) {
      Image<float>& one{random() % 2 == 0 ? obstacle : road};
      if (random() % 3 != 0) one(i % columns, i / columns) = static_cast<float>(1 + random() % 60) / 4;
    }
    const View<const float> obstacles{std::as_const(obstacle).view()};
    const View<const float> roads{std::as_const(road).view()};
    for (int sector{0}; sector < relief_sectors(columns); ++sector) {
      const int column{sector * sector_px};
      const int first_row{static_cast<int>(random() % static_cast<unsigned>(rows_count + 1))};
      const auto rows = static_cast<std::size_t>(rows_count - first_row);
      std::vector<float> expected(rows);
      plain::find_medians(obstacles, roads, column, {first_row, rows_count}, expected.data());
      for (const std::int64_t target : vector_targets()) {
        const ForcedTarget forced{target};
        std::vector<float> actual(rows);
        find_medians(obstacles, roads, column, {first_row, rows_count}, actual.data());
        EXPECT_EQ(expected, actual) << name_of_target(target) << ", " << columns << " px";
      }
    }
  }
}

TEST(PlaneSumsEquality, OnEveryInstructionSet) {
  Random random{std::mt19937{3}};
  const Rig rig{scene_rig()};
  for (const std::size_t count : {0, 1, 8, 255, 256, 257, 2000}) {
    PlaneSamples samples;
    samples.resize(count);
    samples.disparities = 64;
    samples.last_y = static_cast<float>(rig.height_px - rig.cy_px);
    const PlaneHypothesis plane{road_plane(rig, {1.2, 0.2, 0.02}), rig, samples};
    for (std::size_t i{0}; i < count; ++i) {
      samples.x[i] = random.between(-300, 300);
      samples.y[i] = random.between(-100, 200);
      const float beside_px{random.generator() % 3 == 0 ? 20.0f : 1.0f};
      samples.disparity[i] =
          std::max(plane.expected(samples.x[i], samples.y[i]) + random.between(-1, 1) * beside_px, 0.5f);
      samples.weight[i] = random.between(0, 1);
      samples.fit_weight[i] = random.generator() % 4 == 0 ? 0.0f : samples.weight[i];
    }
    const auto support = plain::sum_support(plane, samples);
    const auto equations = plain::sum_equations(plane, samples, samples.fit_weight);
    EXPECT_EQ(support.sums[2] > 0 && equations.sums[3] > 0, count >= 8);
    for (const std::int64_t target : vector_targets()) {
      const ForcedTarget forced{target};
      SCOPED_TRACE(testing::Message() << name_of_target(target) << ", " << count << " samples");
      const auto support_there = sum_support(plane, samples);
      EXPECT_EQ(support.sums, support_there.sums);
      EXPECT_EQ(support.bins, support_there.bins);
      const auto equations_there = sum_equations(plane, samples, samples.fit_weight);
      EXPECT_EQ(equations.sums, equations_there.sums);
      EXPECT_EQ(equations.bins, equations_there.bins);
    }
  }
}

constexpr PolarGeometry camera{410, 123, 256.5F, 512, 63, 0.1F, 1040, 16};

TEST(PolarPlacesEquality, OnEveryInstructionSet) {
  const GridGeometry grid{-4, -12, 0.2, 120, 120};
  for (const double yaw_rad : {0.0, 0.7, -2.9}) {
    const CellPlaces cells{grid_in_vehicle(grid, {0.3, -0.1, yaw_rad}), {0, 0}, 1};
    for (const std::int64_t target : vector_targets()) {
      const ForcedTarget forced{target};
      SCOPED_TRACE(name_of_target(target));
      for (int iy{0}; iy < grid.ny; iy += 7) {
        for (const int step : {1, 5}) {
          PolarPlaces places{};
          find_places(camera, cells, 3, step, iy, places);
          for (int i{0}; i < PolarPlaces::size; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const float x{cells.x_of(3 + step * i, iy)};
            const PolarPlace expected{polar_place(camera, x, cells.y_of(3 + step * i, iy))};
            EXPECT_EQ(places.x[k], x);
            EXPECT_EQ(places.ring[k], expected.ring);
            EXPECT_EQ(places.first[k], expected.first);
            EXPECT_EQ(places.last[k], expected.last);
          }
        }
      }
    }
  }
}

struct World {
  explicit World(int cells, unsigned seed) : config{config_of()}, tables{config}, state{cells, config} {
    layers = grid_layers({0, 0, 0.2, cells, cells});
    std::mt19937 random{seed};
    std::uniform_real_distribution<float> share{0, 1};
    for (float& p : state.occupancy) p = share(random);
    layers.occupancy = state.occupancy;
    for (int i{0}; i < cells * cells; ++i) {
      const int x{i % cells};
      const int y{i / cells};
      state.standing(x, y) = share(random) * state.occupancy(x, y);
    }
    // every second block has masses, which are others than those spread evenly
    for (int block{0}; block < state.blocks.layout().count(); block += 2) state.blocks.want(block);
    allocate_marked_blocks(tables, state);
    for (int block{0}; block < state.blocks.layout().count(); block += 2) {
      for (int i{0}; i < 168 * block_cells; ++i) state.blocks.masses(block / 2)[i] *= 2 * share(random);
    }
  }

  static FilterConfig config_of() {
    FilterConfig config;
    config.model = FilterModel::joint;
    return config;
  }

  FilterConfig config;
  FilterTables tables;
  FilterState state;
  GridLayers layers;
};

// About `percent` of the cells, the last one among them.
std::vector<VelocityEvidence> some_evidence(int cells, unsigned percent, std::mt19937& random) {
  std::uniform_real_distribution<float> unit{-1, 1};
  std::vector<VelocityEvidence> evidence;
  for (int cell{0}; cell < cells * cells; ++cell) {
    if (random() % 100 >= percent && cell + 1 < cells * cells) continue;
    evidence.push_back({cell, 10 * unit(random), 10 * unit(random), 2 + unit(random), unit(random), 2 + unit(random), 0,
                        cell % 3 == 0 ? 1 : 0});
  }
  return evidence;
}

void expect_equal(const World& expected, const World& actual) {
  EXPECT_EQ(actual.state.standing, expected.state.standing);
  for (std::size_t k{0}; k < expected.tables.lattice.size(); ++k) {
    EXPECT_EQ(masses_of(actual.state, k), masses_of(expected.state, k)) << k;
  }
  EXPECT_EQ(actual.layers.moving, expected.layers.moving);
  EXPECT_EQ(actual.layers.velocity_x, expected.layers.velocity_x);
  EXPECT_EQ(actual.layers.velocity_y, expected.layers.velocity_y);
  EXPECT_EQ(actual.layers.velocity_xx, expected.layers.velocity_xx);
  EXPECT_EQ(actual.layers.velocity_xy, expected.layers.velocity_xy);
  EXPECT_EQ(actual.layers.velocity_yy, expected.layers.velocity_yy);
}

void compare_on_random_evidence() {
  std::mt19937 random{11};
  Reference reference;
  for (const int cells : {3, 4, 29}) {
    for (const unsigned percent : {2u, 30u, 100u}) {
      World expected{cells, 5};
      World actual{expected};
      const std::vector<VelocityEvidence> evidence{some_evidence(cells, percent, random)};
      weigh_velocities(reference, evidence, expected.tables, expected.state, expected.layers);
      Cpu cpu{static_cast<int>(1 + percent % 3)};
      WeighingWorkspace space{cells, actual.tables, cpu.threads()};
      weigh_velocities(cpu, evidence, actual.tables, space, actual.state, actual.layers);
      SCOPED_TRACE(testing::Message() << cells << " cells along a side, " << percent << " %");
      expect_equal(expected, actual);
    }
  }
}

TEST(Evidence, CpuEqualsReferenceOnEveryTarget) {
  for (const std::int64_t target : vector_targets()) {
    SCOPED_TRACE(name_of_target(target));
    const ForcedTarget forced{target};
    compare_on_random_evidence();
  }
}

}  // namespace
}  // namespace stereogrid::test
