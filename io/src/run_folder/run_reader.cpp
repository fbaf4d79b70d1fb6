// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/run_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "run_folder/description_json.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double largest_cell_m{1e3};
constexpr double farthest_m{1e9};
constexpr const char* mend{"Give the folder that `stereogrid run --out` has left."};

Rig rig_of_run(const Json& rig) {
  constexpr double most{1e9};
  const auto value = [&rig](const char* key) { return number(rig, key, most); };
  const auto optional = [&](const char* key) { return rig.contains(key) ? value(key) : 0; };
  const auto renamed = [&](const char* key, const char* former) { return value(rig.contains(key) ? key : former); };
  const auto pixels = [&rig](const char* key) { return static_cast<int>(whole_number(rig, key, 1, 100'000)); };
  return {pixels("width_px"),
          pixels("height_px"),
          value("focal_px"),
          renamed("cx_px", "centre_u_px"),
          renamed("cy_px", "centre_v_px"),
          value("baseline_m"),
          value("camera_height_m"),
          value("camera_pitch_rad"),
          value("camera_roll_rad"),
          optional("camera_x_m"),
          optional("camera_y_m"),
          optional("camera_yaw_rad")};
}

/// A frame's grids, as they lie in their file.
class GridFile {
 public:
  GridFile(fs::path path, const GridGeometry& grid) : path_{std::move(path)}, grid_{grid}, arrays_{read_npz(path_)} {}

  [[nodiscard]] const fs::path& path() const { return path_; }
  /// True if the array exists, with as many layers of the grid.
  [[nodiscard]] bool has(const std::string& array, int layers) const {
    const auto found{arrays_.find(array)};
    return found != arrays_.end() && found->second.size() == static_cast<std::size_t>(layers) * cells();
  }
  [[nodiscard]] Image<float> image(const std::string& array, int layer) const {
    const std::vector<float> source{arrays_.at(array).to<float>()};
    Image<float> target{grid_.nx, grid_.ny};
    std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(layer) * cells()), cells(),
                target.begin());
    return target;
  }
  /// Empty without that array.
  [[nodiscard]] Image<CellWitness> witnesses() const {
    if (!has("witness", 1)) return {};
    const std::vector<std::uint8_t> bytes{arrays_.at("witness").to<std::uint8_t>()};
    Image<CellWitness> target{grid_.nx, grid_.ny};
    std::ranges::transform(bytes, target.begin(), [](std::uint8_t byte) { return CellWitness{byte}; });
    return target;
  }

 private:
  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(grid_.nx) * static_cast<std::size_t>(grid_.ny);
  }

  fs::path path_;
  GridGeometry grid_;
  std::map<std::string, NpyArray> arrays_;
};

}  // namespace

RunReader::RunReader(fs::path folder) : folder_{std::move(folder)} {
  if (!is_folder(folder_)) throw InputError{printable_path(folder_), "is not a folder.", mend};
  read_run();
  frames_ = read_run_frames(folder_ / "frames.jsonl");
  check_extrinsics();
  check_grids();
}

void RunReader::read_run() {
  const fs::path file{folder_ / "run.json"};
  if (!is_there(file)) {
    if (!is_there(folder_ / "frames.jsonl")) throw InputError{printable_path(folder_), "is not a run.", mend};
    throw InputError{printable_path(file), "is missing, but there are frames of a run (frames.jsonl).",
                     "Without it their settings are unknown. Put it back, or run again in another folder."};
  }
  read_json<Json>(printable_path(file), read_text(file, largest_bytes::json), "", mend, [this](const Json& run) {
    grid_ = grid_geometry(run.at("grid"));
    if (run.contains("world_grid")) world_cell_size_m_ = number(run.at("world_grid"), "cell_size_m", largest_cell_m);
    rig_ = rig_of_run(run.at("rig"));
    for (const Json& rig : run.value("other_rigs", Json::array())) other_rigs_.push_back(rig_of_run(rig));
    camera_names_ = run.value("camera_names", std::vector<std::string>{});
    for (std::size_t i{camera_names_.size()}; !other_rigs_.empty() && i <= other_rigs_.size(); ++i)
      camera_names_.push_back(fmt::format("camera{}", i));  // run of an older version
    if (!camera_names_.empty()) camera_names_.resize(other_rigs_.size() + 1);
    input_ = run_input_of(run.at("input"));
    preset_ = run.at("preset").get<std::string>();
    predict_s_ = run.value("predict_s", std::vector<double>{});
    compact_ = run.value("compact", false);
    layers_ = run.value("layers", std::vector<std::string>{});
  });
}

// Frames without a ground plane have the extrinsics from before the estimate.
void RunReader::check_extrinsics() {
  for (std::size_t i{frames_.size()}; i-- > 1;) {
    if (has_any(frames_[i - 1].status, {FrameStatus::road_unknown})) frames_[i - 1].extrinsics = frames_[i].extrinsics;
  }
  std::vector<std::string> found{problems(rig_)};
  for (const Rig& other : other_rigs_) {
    if (found.empty()) found = problems(other);
  }
  for (const RunFrame& frame : frames_) {
    if (found.empty()) found = problems(rig_of(frame));
  }
  if (!found.empty()) {
    throw InputError{printable_path(folder_), "is a run whose rig is none: " + found.front(), mend};
  }
}

Rig RunReader::rig_of(const RunFrame& frame) const {
  Rig rig{rig_};
  if (!frame.extrinsics) return rig;
  rig.camera_height_m = frame.extrinsics->camera_height_m;
  rig.camera_pitch_rad = frame.extrinsics->camera_pitch_rad;
  rig.camera_roll_rad = frame.extrinsics->camera_roll_rad;
  return rig;
}

std::vector<Rig> RunReader::rigs_of(const RunFrame& frame) const {
  std::vector<Rig> rigs{rig_of(frame)};
  rigs.insert(rigs.end(), other_rigs_.begin(), other_rigs_.end());
  return rigs;
}

void RunReader::check_grids() const {
  if (frames_.empty()) {
    throw InputError{printable_path(folder_ / "frames.jsonl"), "has no frames.",
                     "Run again, or continue with --resume."};
  }
  if (!is_there(folder_ / "grids")) {
    throw InputError{printable_path(folder_ / "grids"), "is missing: the run has no grids.", "Run again."};
  }
}

void RunReader::report_array(const fs::path& file, const std::string& array) const {
  const std::vector<std::string> written{layers_.empty() ? grid_arrays(compact_) : layers_};
  if (std::ranges::find(written, array) == written.end()) {
    throw InputError{printable_path(folder_),
                     fmt::format("was written without the layer {}, which is needed here; it has {}.", array,
                                 fmt::join(written, ", ")),
                     compact_ ? "Run again, with --layers that name it, or without --compact."
                              : "Run again, with --layers that name it."};
  }
  throw InputError{printable_path(file), fmt::format("the array {} is missing or of another size.", array), mend};
}

RunGrids RunReader::grids(const std::string& name) const {
  const GridFile file{folder_ / "grids" / (name + ".npz"), grid_};
  for (const auto& [array, layers] : {std::pair{"observed", 1}, {"occupancy", 1}, {"velocity", 2}}) {
    if (!file.has(array, layers)) report_array(file.path(), array);
  }
  return {file.image("observed", 0), file.image("occupancy", 0), file.image("velocity", 0), file.image("velocity", 1),
          file.witnesses()};
}

Image<float> RunReader::occupancy(const std::string& name) const {
  const GridFile file{folder_ / "grids" / (name + ".npz"), grid_};
  if (!file.has("occupancy", 1)) report_array(file.path(), "occupancy");
  return file.image("occupancy", 0);
}

RunWorldGrid RunReader::world_grid(const std::string& name) const {
  const fs::path path{folder_ / "grids" / (name + ".npz")};
  std::map<std::string, NpyArray> arrays{read_npz(path)};
  if (!arrays.contains("world_occupancy") && arrays.contains("occupancy")) report_array(path, "world_occupancy");
  const std::vector<double> origin{arrays["world_origin"].to<double>()};
  const auto is_sensible = [](double metres) { return std::abs(metres) <= farthest_m; };  // not NaN
  if (origin.size() != 2 || !std::ranges::all_of(origin, is_sensible) || arrays["world_occupancy"].size() == 0) {
    throw InputError{printable_path(path), "the arrays world_origin and world_occupancy are missing or none.", mend};
  }
  if (!(world_cell_size_m_ > 0)) {
    throw InputError{printable_path(folder_ / "run.json"), "does not say how large the cells of 'world_grid' are.",
                     "Run again: this run is of an older version, or damaged."};
  }
  Image<float> occupancy{arrays["world_occupancy"].to_image<float>()};
  const GridGeometry geometry{origin[0], origin[1], world_cell_size_m_, occupancy.width(), occupancy.height()};
  return {geometry, std::move(occupancy)};
}

}  // namespace stereogrid::io
