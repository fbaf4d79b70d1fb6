// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run_reader.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"

namespace stereogrid::app {
namespace {

using Json = nlohmann::json;

constexpr const char* mend{"Give the folder that `stereogrid run --out` has left."};

GridGeometry grid_of(const Json& grid) {
  return {grid.at("x_min_m").get<double>(), grid.at("y_min_m").get<double>(), grid.at("cell_size_m").get<double>(),
          grid.at("nx").get<int>(), grid.at("ny").get<int>()};
}

RunFrame frame_of(const Json& line) {
  RunFrame frame{line.at("name").get<std::string>(), line.at("stamp_ns").get<std::int64_t>(), {}};
  for (const Json& o : line.at("obstacles")) {
    const auto number = [&o](const char* key) { return o.at(key).get<double>(); };
    frame.obstacles.push_back({o.at("id").get<std::int64_t>(), number("x_m"), number("y_m"), number("vx_mps"),
                               number("vy_mps"), number("length_m"), number("width_m"), number("yaw_rad"),
                               number("occupancy"), number("age_s"), o.at("confirmed").get<bool>()});
  }
  return frame;
}

}  // namespace

RunReader::RunReader(std::filesystem::path folder) : folder_{std::move(folder)} {
  std::string file{"run.json"};
  try {
    grid_ = grid_of(Json::parse(io::read_file(folder_ / file)).at("grid"));
    file = "frames.jsonl";
    std::istringstream lines{io::read_file(folder_ / file)};
    for (std::string line; std::getline(lines, line);) frames_.push_back(frame_of(Json::parse(line)));
  } catch (const nlohmann::json::exception& error) {
    throw InputError{(folder_ / file).string(), fmt::format("cannot be understood ({}).", error.what()), mend};
  }
}

RunGrids RunReader::grids(const std::string& name) const {
  const std::filesystem::path path{folder_ / "grids" / (name + ".npz")};
  const std::map<std::string, io::NpyArray> arrays{io::read_npz(path)};
  const auto values = [&](const char* array, std::size_t size) {
    const auto found{arrays.find(array)};
    if (found == arrays.end() || found->second.size() != size) {
      throw InputError{path.string(), fmt::format("the array {} is missing or of another size.", array), mend};
    }
    return found->second.to<float>();
  };
  RunGrids grids{{grid_.nx, grid_.ny}, {grid_.nx, grid_.ny}, {grid_.nx, grid_.ny}};
  const std::size_t cells{grids.observed.size()};
  const std::vector<float> observed{values("observed", cells)};
  const std::vector<float> occupancy{values("occupancy", cells)};
  const std::vector<float> velocity{values("velocity", 2 * cells)};
  for (std::size_t i{0}; i < cells; ++i) {
    grids.observed.data()[i] = observed[i];
    grids.occupancy.data()[i] = occupancy[i];
    grids.speed_mps.data()[i] = std::hypot(velocity[i], velocity[cells + i]);
  }
  return grids;
}

}  // namespace stereogrid::app
