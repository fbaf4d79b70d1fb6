// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/run_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "run_folder/description_json.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* mend{"Give the folder that `stereogrid run --out` has left."};
int pixels_of(const Json& rig, const char* key) {
  return static_cast<int>(whole_number(rig, key, 1, 100'000));
}

}  // namespace

RunReader::RunReader(fs::path folder) : folder_{std::move(folder)} {
  if (!fs::is_directory(folder_)) throw InputError{printable_path(folder_), "is not a folder.", mend};
  read_run();
  frames_ = read_run_frames(folder_ / "frames.jsonl");
  check_grids();
}

void RunReader::read_run() {
  const fs::path file{folder_ / "run.json"};
  if (!fs::exists(file) && fs::exists(folder_ / "frames.jsonl")) {
    throw InputError{printable_path(file), "is missing, but there are frames of a run (frames.jsonl).",
                     "Without it nobody knows how they were made. Put it back, or run again in another folder."};
  }
  read_json<Json>(printable_path(file), read_text(file, largest_bytes::json), "", mend, [this](const Json& run) {
    grid_ = grid_geometry(run.at("grid"));
    width_px_ = pixels_of(run.at("rig"), "width_px");
    height_px_ = pixels_of(run.at("rig"), "height_px");
    input_ = run_input_of(run.at("input"));
    preset_ = run.at("preset").get<std::string>();
  });
}

void RunReader::check_grids() const {
  if (frames_.empty()) {
    throw InputError{printable_path(folder_ / "frames.jsonl"), "has no frames.", "Run again, or go on with --resume."};
  }
  if (!fs::exists(folder_ / "grids")) {
    throw InputError{printable_path(folder_ / "grids"), "is missing: the run has no grids.", "Run again."};
  }
}

RunGrids RunReader::grids(const std::string& name) const {
  const fs::path path{folder_ / "grids" / (name + ".npz")};
  const std::map<std::string, NpyArray> arrays{read_npz(path)};
  const auto values = [&](const char* array, std::size_t layers) {
    const auto found{arrays.find(array)};
    const std::size_t cells{static_cast<std::size_t>(grid_.nx) * static_cast<std::size_t>(grid_.ny)};
    if (found == arrays.end() || found->second.size() != layers * cells) {
      throw InputError{printable_path(path), fmt::format("the array {} is missing or of another size.", array), mend};
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

}  // namespace stereogrid::io
