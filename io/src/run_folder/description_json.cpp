// SPDX-License-Identifier: Apache-2.0
#include "run_folder/description_json.hpp"

#include "stereogrid/error.hpp"
#include "stereogrid/io/config_file.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::io {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* scene{"scene"};

Json json_of(const RunInput& input) {
  if (input.kind == scene) {
    return {{"kind", input.kind}, {"paths", input.paths}, {"poses", input.poses}, {"mask", input.mask}};
  }
  Json json{{"kind", input.kind},
            {"paths", input.paths},
            {"calibration", input.calibration},
            {"poses", input.poses},
            {"disparities", input.disparities},
            {"mask", input.mask}};
  if (!input.cameras.empty()) json["cameras"] = input.cameras;
  return json;
}

}  // namespace

Json rig_json(const Rig& rig) {
  Json json{{"focal_px", rig.focal_px},
            {"cx_px", rig.cx_px},
            {"cy_px", rig.cy_px},
            {"baseline_m", rig.baseline_m},
            {"width_px", rig.width_px},
            {"height_px", rig.height_px},
            {"camera_height_m", rig.camera_height_m},
            {"camera_pitch_rad", rig.camera_pitch_rad},
            {"camera_roll_rad", rig.camera_roll_rad}};
  if (camera_place(rig) == Pose2{}) return json;
  json["camera_x_m"] = rig.camera_x_m;
  json["camera_y_m"] = rig.camera_y_m;
  json["camera_yaw_rad"] = rig.camera_yaw_rad;
  return json;
}

Json settings_json(const RunDescription& run) {
  Json settings{{"version", version()},
                {"preset", run.preset},
                {"config", Json::parse(to_json(run.config))},
                {"input", json_of(run.input)},
                {"matcher", run.matcher},
                {"predict_s", run.predict_s},
                {"fuse", {{"source", run.fuse_source}}},
                {"device", run.device},
                {"compact", run.compact},
                {"every", run.every},
                {"layers", run.layers},
                {"warm_up", run.warm_up},
                {"rig", rig_json(run.rig)},
                {"grid",
                 {{"x_min_m", run.grid.x_min_m},
                  {"y_min_m", run.grid.y_min_m},
                  {"cell_size_m", run.grid.cell_size_m},
                  {"nx", run.grid.nx},
                  {"ny", run.grid.ny}}},
                {"world_grid",
                 {{"cell_size_m", run.world_grid.cell_size_m}, {"nx", run.world_grid.nx}, {"ny", run.world_grid.ny}}}};
  for (const Rig& other : run.other_rigs) settings["other_rigs"].push_back(rig_json(other));
  if (!run.camera_names.empty()) settings["camera_names"] = run.camera_names;
  return settings;
}

RunInput run_input_of(const Json& input) {
  RunInput made_from;
  made_from.kind = input.at("kind").get<std::string>();
  made_from.paths = input.at("paths").get<std::vector<std::string>>();
  if (made_from.paths.empty() || made_from.paths.size() > 2) throw InputError{"'paths' names no input"};
  made_from.poses = input.value("poses", "");
  made_from.calibration = input.value("calibration", "");
  made_from.disparities = input.value("disparities", "");
  made_from.mask = input.value("mask", "");
  made_from.cameras = input.value("cameras", std::vector<std::string>{});
  return made_from;
}

}  // namespace stereogrid::io
