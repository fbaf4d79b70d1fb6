// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Times of the stages after matching, on one thread: counting and projecting to the vehicle grid and to the
// world-aligned window, by bins (eqs. 8–16) and by rays. The disparities are those of a built-in scene. All sizes take
// turns in one run. The doublings show the scaling.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "backend/cpu.hpp"
#include "filter/filter.hpp"
#include "machine.hpp"
#include "observation/projection/projection.hpp"
#include "observation/rays/rays.hpp"
#include "observation/u_disparity/u_disparity.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr int rounds{51};
constexpr int calls{3};           // one after the other: the first finds the caches full of the others' images
constexpr std::size_t frames{3};  // until the road is found
constexpr std::size_t first_frame{8};
constexpr double heading_rad{0.3};  // yaw of the vehicle in the world

double now_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Timed {
  double least_ms;
  double median_ms;
};

std::vector<Timed> time_in_turns(const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size());
  for (int round{0}; round < rounds; ++round) {
    for (std::size_t i{0}; i < works.size(); ++i) {
      for (int call{0}; call < calls; ++call) {
        const double start{now_ms()};
        works[i]();
        times[i].push_back(now_ms() - start);
      }
    }
  }
  std::vector<Timed> timed;
  for (std::vector<double>& all : times) {
    std::sort(all.begin(), all.end());
    timed.push_back({all.front(), all[all.size() / 2]});
  }
  return timed;
}

// The stages of one frame, as FramePipeline calls them.
class GridStages {
 public:
  GridStages(const FrameSource& source, int disparities, int cells_ahead, int cells_across)
      : config_{config_of(disparities, cells_ahead, cells_across)},
        rig_{source.rig()},
        pipeline_{config_, rig_, {.threads = 1}},
        matches_{rig_.width_px, rig_.height_px},
        tables_{{config_.u_disparity, config_.paper}, rig_.height_px, pipeline_.config().matching.window_px},
        space_{rig_.width_px, rig_.height_px, disparities, 1},
        projection_{rig_.width_px, disparities},
        rays_{rig_.width_px, rig_.height_px, disparities},
        observed_{pipeline_.vehicle_grid().nx, pipeline_.vehicle_grid().ny},
        observed_world_{pipeline_.world_grid().nx, pipeline_.world_grid().ny} {
    const std::size_t first{source.size() >= first_frame + frames ? first_frame : 0};
    for (std::size_t i{first}; i < std::min(first + frames, source.size()); ++i) {
      const FrameResult& result{pipeline_.process(source.load(i))};
      ground_ = result.ground;
      stages_ = result.stages;
    }
    projection_.plan(BinGeometry{rig_}, {pipeline_.vehicle_grid()});
    matches_.obstacle = stages_.obstacle_disparity;
    matches_.road = stages_.road_disparity;
    matches_.confidence = stages_.match_confidence;
  }

  void run_count() { count(cpu_, matches_, rig_, ground_, tables_, space_, stages_); }
  void run_count_rays() { count_rays(cpu_, matches_, rig_, ground_, config_.u_disparity, rays_); }
  void run_project_rays() { project_rays_to(pipeline_.vehicle_grid(), {}, observed_); }
  void run_project_rays_world() {
    const Pose2 pose{0, 0, heading_rad};
    project_rays_to(Window{pipeline_.vehicle_grid()}.at(pose), inverse(pose), observed_world_);
  }
  void run_project() { project_to(pipeline_.vehicle_grid(), {}, observed_); }
  void run_project_world() {
    const Pose2 pose{0, 0, heading_rad};
    project_to(Window{pipeline_.vehicle_grid()}.at(pose), inverse(pose), observed_world_);
  }

 private:
  static Config config_of(int disparities, int cells_ahead, int cells_across) {
    Config config;
    config.matching.disparities = disparities;
    config.grid.length_m = cells_ahead * config.grid.cell_size_m;
    config.grid.width_m = cells_across * config.grid.cell_size_m;
    return config;
  }

  void project_to(const GridGeometry& grid, const Pose2& vehicle_from_grid, Image<float>& cells) {
    const GridInVehicle placed{grid_in_vehicle(grid, vehicle_from_grid)};
    project(cpu_, stages_.occupancy_smooth.view(), BinGeometry{rig_}, placed, projection_, cells.view());
  }

  void project_rays_to(const GridGeometry& grid, const Pose2& vehicle_from_grid, Image<float>& cells) {
    project_rays(cpu_, rays_, BinGeometry{rig_}, grid_in_vehicle(grid, vehicle_from_grid), cells.view());
  }

  Config config_;
  Rig rig_;
  Pipeline pipeline_;
  Cpu cpu_{1};
  Matches matches_;
  UDisparityTables tables_;
  UDisparitySpace space_;
  ProjectionSpace projection_;
  RaySpace rays_;
  Image<float> observed_;
  Image<float> observed_world_;
  Ground ground_;
  StageImages stages_;
};

struct Case {
  const char* what;
  const char* scene;  // its focal length stays when the image is doubled
  int disparities;
  int cells_ahead;
  int cells_across;
  double aim_count_ms;  // 0: none
  double aim_project_ms;
};

constexpr Case cases[]{
    {"512 × 320 × 64, 100 × 100", "street?width=512&height=320&focal=410", 64, 100, 100, 0.20, 0.15},
    {"W doubled", "street?width=1024&height=320&focal=410&baseline=0.22&camera_height=1.25", 64, 100, 100, 0, 0},
    {"H doubled", "street?width=512&height=640&focal=410", 64, 100, 100, 0, 0},
    {"D doubled", "street?width=512&height=320&focal=410", 128, 100, 100, 0, 0},
    {"cells doubled", "street?width=512&height=320&focal=410", 64, 200, 100, 0, 0},
    {"1242 × 375 × 128, 150 × 100", "street?width=1242&height=375", 128, 150, 100, 0.80, 0.40},
};

void print_row(const std::string& what, const Timed& time, double aim_ms, double base_ms) {
  std::printf("| %s | %.3f | %.3f |", what.c_str(), time.least_ms, time.median_ms);
  if (aim_ms > 0) {
    std::printf(" %.2f | %.2f |", aim_ms, time.least_ms / aim_ms);
  } else {
    std::printf(" | |");
  }
  if (base_ms > 0) {
    std::printf(" %.2f |\n", time.least_ms / base_ms);
  } else {
    std::printf(" |\n");
  }
}

void compare(std::vector<std::unique_ptr<GridStages>>& stages) {
  std::vector<std::function<void()>> works;
  for (const auto& of_case : stages) {
    works.emplace_back([&] { of_case->run_count(); });
    works.emplace_back([&] { of_case->run_project(); });
    works.emplace_back([&] { of_case->run_project_world(); });
    works.emplace_back([&] { of_case->run_count_rays(); });
    works.emplace_back([&] { of_case->run_project_rays(); });
    works.emplace_back([&] { of_case->run_project_rays_world(); });
  }
  const std::vector<Timed> times{time_in_turns(works)};
  std::printf("| stage, image × disparities, cells | least ms | median ms | aim ms | ratio | to the first size |\n");
  std::printf("|---|---|---|---|---|---|\n");
  const char* const names[]{"count bins", "largest bin to the vehicle grid", "largest bin to the window",
                            "count rays", "rays to the vehicle grid",        "rays to the window"};
  constexpr std::size_t stage_count{std::size(names)};
  for (std::size_t stage{0}; stage < stage_count; ++stage) {
    for (std::size_t i{0}; i < stages.size(); ++i) {
      const double aims[stage_count]{cases[i].aim_count_ms, cases[i].aim_project_ms};
      print_row(std::string{names[stage]} + ", " + cases[i].what, times[stage_count * i + stage], aims[stage],
                i > 0 ? times[stage].least_ms : 0);
    }
  }
}

void run() {
  std::vector<std::unique_ptr<GridStages>> stages;
  for (const Case& one : cases) {
    const scenes::Scene scene{scenes::parse_scene(one.scene)};
    stages.push_back(std::make_unique<GridStages>(scene, one.disparities, one.cells_ahead, one.cells_across));
  }
  compare(stages);
}

}  // namespace

int main() {
  try {
    print_machine();
    run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_grid_stages: %s\n", error.what());
    return 65;
  }
  return 0;
}
