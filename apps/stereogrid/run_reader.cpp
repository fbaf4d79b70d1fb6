// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* mend{"Give the folder that `stereogrid run --out` has left."};

GridGeometry grid_of(const Json& grid) {
  return {grid.at("x_min_m").get<double>(), grid.at("y_min_m").get<double>(), grid.at("cell_size_m").get<double>(),
          grid.at("nx").get<int>(), grid.at("ny").get<int>()};
}

InputOptions input_of(const Json& input) {
  InputOptions options;
  options.paths = input.at("paths").get<std::vector<std::string>>();
  options.calibration = input.value("calibration", "");
  options.disparities = input.value("disparities", "");
  // the run's own poses stand in its frames; where the input's are does not matter any more
  if (input.at("kind") != "scene") options.poses = "none";
  return options;
}

RunFrame frame_of(const Json& line) {
  RunFrame frame{line.at("name").get<std::string>(), line.at("stamp_ns").get<std::int64_t>(), {}};
  for (const Json& o : line.at("obstacles")) {
    const auto number = [&o](const char* key) { return o.at(key).get<double>(); };
    frame.obstacles.push_back({o.at("id").get<std::int64_t>(),
                               number("x_m"),
                               number("y_m"),
                               number("vx_mps"),
                               number("vy_mps"),
                               number("length_m"),
                               number("width_m"),
                               number("yaw_rad"),
                               number("occupancy"),
                               number("age_s"),
                               o.at("confirmed").get<bool>(),
                               o.value("moving", false),
                               o.value("coasting", false),
                               o.value("unseen_s", 0.0),
                               {},
                               {}});
  }
  return frame;
}

}  // namespace

RunReader::RunReader(fs::path folder) : folder_{std::move(folder)} {
  if (!fs::is_directory(folder_)) throw InputError{folder_.string(), "is not a folder.", mend};
  std::string file{"run.json"};
  try {
    const Json run(Json::parse(io::read_file(folder_ / file)));
    grid_ = grid_of(run.at("grid"));
    width_px_ = run.at("rig").at("width_px").get<int>();
    height_px_ = run.at("rig").at("height_px").get<int>();
    input_ = input_of(run.at("input"));
    preset_ = run.at("preset").get<std::string>();
    file = "frames.jsonl";
    std::istringstream lines{io::read_file(folder_ / file)};
    for (std::string line; std::getline(lines, line);) frames_.push_back(frame_of(Json::parse(line)));
  } catch (const nlohmann::json::exception& error) {
    throw InputError{(folder_ / file).string(), fmt::format("cannot be understood ({}).", error.what()), mend};
  }
  check_grids();
}

void RunReader::check_grids() const {
  if (frames_.empty()) {
    throw InputError{(folder_ / "frames.jsonl").string(), "has no frames.", "Run again, or go on with --resume."};
  }
  if (!fs::exists(folder_ / "grids")) {
    throw InputError{(folder_ / "grids").string(), "is missing: the run has no grids.", "Run again."};
  }
}

RunGrids RunReader::grids(const std::string& name) const {
  const fs::path path{folder_ / "grids" / (name + ".npz")};
  const std::map<std::string, io::NpyArray> arrays{io::read_npz(path)};
  const auto values = [&](const char* array, std::size_t layers) {
    const auto found{arrays.find(array)};
    const std::size_t cells{static_cast<std::size_t>(grid_.nx) * static_cast<std::size_t>(grid_.ny)};
    if (found == arrays.end() || found->second.size() != layers * cells) {
      throw InputError{path.string(), fmt::format("the array {} is missing or of another size.", array), mend};
    }
    return found->second.to<float>();
  };
  const auto image = [&](const std::vector<float>& source, std::size_t layer) {
    Image<float> target{grid_.nx, grid_.ny};
    std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(layer * target.size()), target.size(), target.begin());
    return target;
  };
  const std::vector<float> velocity{values("velocity", 2)};
  return {image(values("observed", 1), 0), image(values("occupancy", 1), 0), image(velocity, 0), image(velocity, 1)};
}

}  // namespace stereogrid::app
