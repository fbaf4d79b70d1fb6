// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/run_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "run/frame_lines.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* mend{"Give the folder that `stereogrid run --out` has left."};
constexpr const char* mend_lines{"Remove what does not belong there, or run again in another folder."};

constexpr double most{1e6};        // metres, m/s …: of what a street holds
constexpr double longest_s{1e10};  // between any two stamps

int pixels_of(const Json& rig, const char* key) {
  return static_cast<int>(io::whole_number(rig, key, 1, 100'000));
}

InputOptions input_of(const Json& input) {
  InputOptions options;
  options.paths = input.at("paths").get<std::vector<std::string>>();
  if (options.paths.empty() || options.paths.size() > 2) throw InputError{"'paths' names no input"};
  options.calibration = input.value("calibration", "");
  options.disparities = input.value("disparities", "");
  // the run's own poses stand in its frames; where the input's are does not matter any more
  if (input.at("kind") != "scene") options.poses = "none";
  return options;
}

RunFrame frame_of(const Json& line) {
  RunFrame frame{line.at("name").get<std::string>(),
                 io::whole_number(line, "stamp_ns", -io::largest_stamp_ns, io::largest_stamp_ns),
                 {}};
  if (frame.name.empty() || frame.name.find('/') != std::string::npos) throw InputError{"'name' is no frame's name"};
  for (const Json& o : line.at("obstacles")) {
    const auto number = [&o](const char* key) { return io::number(o, key, most); };
    frame.obstacles.push_back({io::whole_number(o, "id", 0, std::numeric_limits<std::int64_t>::max()),
                               number("x_m"),
                               number("y_m"),
                               number("vx_mps"),
                               number("vy_mps"),
                               number("length_m"),
                               number("width_m"),
                               number("yaw_rad"),
                               number("occupancy"),
                               io::number(o, "age_s", longest_s),
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
  if (!fs::is_directory(folder_)) throw InputError{io::printable_path(folder_), "is not a folder.", mend};
  read_run();
  read_frames();
  check_grids();
}

void RunReader::read_run() {
  const fs::path file{folder_ / "run.json"};
  if (!fs::exists(file) && fs::exists(folder_ / "frames.jsonl")) {
    throw InputError{io::printable_path(file), "is missing, but there are frames of a run (frames.jsonl).",
                     "Without it nobody knows how they were made. Put it back, or run again in another folder."};
  }
  io::read_json<Json>(io::printable_path(file), io::read_text(file, io::largest_bytes::json), "", mend,
                      [this](const Json& run) {
                        grid_ = io::grid_geometry(run.at("grid"));
                        width_px_ = pixels_of(run.at("rig"), "width_px");
                        height_px_ = pixels_of(run.at("rig"), "height_px");
                        input_ = input_of(run.at("input"));
                        preset_ = run.at("preset").get<std::string>();
                      });
}

void RunReader::read_frames() {
  const fs::path file{folder_ / "frames.jsonl"};
  std::istringstream lines{io::read_text(file, io::largest_bytes::json)};
  std::set<std::string> names;
  std::size_t next{0};
  for (std::string text; std::getline(lines, text);) {
    const auto take{[&](const Json& line) {
      const std::int64_t index{io::whole_number(line, "index", 0, largest_index)};
      check_order(next, static_cast<std::size_t>(index));
      next = static_cast<std::size_t>(index) + 1;
      frames_.push_back(frame_of(line));
      if (!names.insert(frames_.back().name).second) throw InputError{"its 'name' stands in an earlier line, too"};
    }};
    io::read_json<Json>(io::printable_path(file), text, fmt::format("line {} ", frames_.size() + 1), mend_lines, take);
  }
}

void RunReader::check_grids() const {
  if (frames_.empty()) {
    throw InputError{io::printable_path(folder_ / "frames.jsonl"), "has no frames.",
                     "Run again, or go on with --resume."};
  }
  if (!fs::exists(folder_ / "grids")) {
    throw InputError{io::printable_path(folder_ / "grids"), "is missing: the run has no grids.", "Run again."};
  }
}

RunGrids RunReader::grids(const std::string& name) const {
  const fs::path path{folder_ / "grids" / (name + ".npz")};
  const std::map<std::string, io::NpyArray> arrays{io::read_npz(path)};
  const auto values = [&](const char* array, std::size_t layers) {
    const auto found{arrays.find(array)};
    const std::size_t cells{static_cast<std::size_t>(grid_.nx) * static_cast<std::size_t>(grid_.ny)};
    if (found == arrays.end() || found->second.size() != layers * cells) {
      throw InputError{io::printable_path(path), fmt::format("the array {} is missing or of another size.", array),
                       mend};
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
