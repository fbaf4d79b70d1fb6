// SPDX-License-Identifier: Apache-2.0
//
// stereogrid-baselines RUN OUT METHOD...: makes the grids of other methods from the disparities of a run with
// --save-stages. Writes the folder of a run for each method, OUT/METHOD, which `stereogrid evaluate` scores. Grids of a
// single frame and over time are the same array.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "baselines/baselines.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"

namespace stereogrid::research {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Points = std::vector<evaluation::CameraPoint>;

/// Input of every method for a frame.
struct Frame {
  DisparityFrame disparities;
  Pose2 world_from_vehicle;
  Points sweep;  ///< lidar returns in the left camera's frame; empty: none
  evaluation::CameraPoint lidar;
  double lidar_road_m{0};  ///< start of the search for the lidar's road
};

/// Returns an empty image for a frame that the method has no grid of.
using Method = std::function<Image<float>(const Frame&, const GridGeometry&)>;

/// Ternary grid of the paper's figure 6 (c): the largest disparity of a column decides. Gaussian, probabilities and
/// volume are those of the paper's own grid, which has no left border.
NearestObstacleParameters paper_nearest_obstacle(int disparities) {
  const Config paper{preset("paper")};
  return {.grid = {.bins_per_px = 1,
                   .left_border_px = -disparities,
                   .sigma_column = paper.paper.sigma_column,
                   .sigma_disparity = paper.paper.sigma_disparity},
          .levels = {.free = paper.paper.false_negative, .occupied = 1 - paper.paper.false_positive},
          .height_min_m = paper.u_disparity.obstacle_min_height_m,
          .height_max_m = paper.u_disparity.obstacle_height_m,
          .filled_m = 0,
          .open_road = false};
}

Image<float> lidar_grid(const Frame& f, const GridGeometry& grid) {
  if (f.sweep.empty()) return {};
  return evaluation::lidar_grid(f.sweep, f.lidar, f.disparities.rig, grid, f.lidar_road_m);
}

std::map<std::string, Method> all_methods() {
  const auto map{std::make_shared<LogOddsMap>()};
  return {
      {"nearest_obstacle", [](const Frame& f, const auto& grid) { return nearest_obstacle_grid(f.disparities, grid); }},
      {"nearest_obstacle_paper",
       [](const Frame& f, const auto& grid) {
         return nearest_obstacle_grid(f.disparities, grid, paper_nearest_obstacle(f.disparities.disparities));
       }},
      {"occupancy_boundary",
       [](const Frame& f, const auto& grid) { return occupancy_boundary_grid(f.disparities, grid); }},
      {"free_space", [](const Frame& f, const auto& grid) { return free_space_grid(f.disparities, grid); }},
      {"stixels", [](const Frame& f, const auto& grid) { return stixel_grid(f.disparities, grid); }},
      {"ray_casting", [](const Frame& f, const auto& grid) { return ray_casting_grid(f.disparities, grid); }},
      {"ray_casting_map",
       [map](const Frame& f, const auto& grid) { return map->update(f.disparities, f.world_from_vehicle, grid); }},
      {"lidar", &lidar_grid},
  };
}

/// The sweeps of the run's drive; none: it has none.
class Sweeps {
 public:
  explicit Sweeps(const io::RunInput& input) {
    if (!input.kind.starts_with("KITTI")) return;
    io::InputArguments arguments;
    arguments.paths = {input.paths.front()};
    if (!input.calibration.empty()) arguments.calibration = input.calibration;
    arguments.poses = "none";
    recording_ = io::open_recording(arguments);
    if (!recording_->contents().calibration.camera_from_velodyne) recording_.reset();
  }

  void add_to(Frame& frame, std::size_t index) const {
    if (!recording_ || recording_->contents().frames.at(index).scan.empty()) return;
    const io::Transform& t{*recording_->contents().calibration.camera_from_velodyne};
    frame.lidar = {t[3], t[7], t[11]};
    for (const io::ScanPoint& s : recording_->load_scan(index)) {
      const double x{s.x_m};
      const double y{s.y_m};
      const double z{s.z_m};
      frame.sweep.push_back({t[0] * x + t[1] * y + t[2] * z + t[3], t[4] * x + t[5] * y + t[6] * z + t[7],
                             t[8] * x + t[9] * y + t[10] * z + t[11]});
    }
  }

 private:
  std::unique_ptr<io::Recording> recording_;
};

/// A run with the disparities of its frames.
class StageRun {
 public:
  explicit StageRun(const fs::path& folder) : run_{folder}, sweeps_{run_.input()} {
    std::ifstream description{folder / "run.json"};
    disparities_ = Json::parse(description).at("config").at("matching").at("disparities").get<int>();
    std::ifstream lines{folder / "frames.jsonl"};
    for (std::string line; std::getline(lines, line);) lines_.push_back(Json::parse(line));
  }

  [[nodiscard]] const io::RunReader& run() const { return run_; }

  /// Passes every frame, with its line of frames.jsonl, to `use`.
  void for_each(const std::function<void(const Frame&, const Json& line)>& use) const {
    for (std::size_t i{0}; i < lines_.size(); ++i) {
      const io::RunFrame& read{run_.frames().at(i)};
      const auto stages{io::read_npz(run_.folder() / "stages" / (read.name + ".npz"))};
      const Image<float> obstacle{stages.at("obstacle_disparity").to_image<float>()};
      const Image<float> road{stages.at("road_disparity").to_image<float>()};
      const Json& ground{lines_[i].at("ground")};
      const Rig rig{run_.rig_of(read)};
      Frame frame;
      frame.disparities = {rig,
                           {.height_m = ground.at("height_m").get<double>(),
                            .pitch_rad = ground.at("pitch_rad").get<double>(),
                            .roll_rad = ground.at("roll_rad").get<double>()},
                           disparities_,
                           obstacle.view(),
                           road.view()};
      frame.world_from_vehicle = read.world_from_vehicle;
      frame.lidar_road_m = rig == run_.rig() ? evaluation::kitti_camera_height_m : rig.camera_height_m;
      sweeps_.add_to(frame, read.index);
      use(frame, lines_[i]);
    }
  }

 private:
  io::RunReader run_;
  Sweeps sweeps_;
  int disparities_{0};
  std::vector<Json> lines_;
};

/// Writes the folder of a run with the grids of one method.
class MethodWriter {
 public:
  MethodWriter(fs::path folder, const io::RunReader& run, Method method)
      : folder_{std::move(folder)}, grid_{run.grid()}, method_{std::move(method)} {
    fs::create_directories(folder_ / "grids");
    fs::copy_file(run.folder() / "run.json", folder_ / "run.json", fs::copy_options::overwrite_existing);
    lines_.open(folder_ / "frames.jsonl");
  }

  void add(const Frame& frame, Json line) {
    const Image<float> grid{method_(frame, grid_)};
    if (grid.empty()) return;
    const Image<float> standstill{grid.width(), grid.height(), 0};
    const std::vector<io::NpzArray> arrays{{"observed", grid},
                                           {"occupancy", grid},
                                           {"velocity", std::vector{std::cref(standstill), std::cref(standstill)}}};
    io::write_npz(folder_ / "grids" / (line.at("name").get<std::string>() + ".npz"), arrays);
    // obstacles are those of stereogrid, not of this method
    line["obstacles"] = Json::array();
    lines_ << line.dump() << '\n';
  }

 private:
  fs::path folder_;
  GridGeometry grid_;
  Method method_;
  std::ofstream lines_;
};

void make_grids(const fs::path& run_folder, const fs::path& out, const std::vector<std::string>& names) {
  const std::map<std::string, Method> methods{all_methods()};
  const StageRun run{run_folder};
  std::vector<MethodWriter> writers;
  for (const std::string& name : names) {
    if (!methods.contains(name)) throw ConfigError{name + ": unknown method. docs/evaluation.md has their names."};
    writers.emplace_back(out / name, run.run(), methods.at(name));
  }
  run.for_each([&](const Frame& frame, const Json& line) {
    for (MethodWriter& writer : writers) writer.add(frame, line);
  });
}

}  // namespace
}  // namespace stereogrid::research

int main(int count, char** arguments) {
  if (count < 4) {
    std::fputs("usage: stereogrid-baselines RUN OUT METHOD...\n", stderr);
    return 64;
  }
  try {
    stereogrid::research::make_grids(arguments[1], arguments[2], {arguments + 3, arguments + count});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stereogrid-baselines: %s\n", error.what());
    return 65;
  }
}
