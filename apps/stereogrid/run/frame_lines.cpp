// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/frame_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "run/stages.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

const char* const mend{"Remove the lines from there on, or start the run anew in another folder."};

Json json_of(const Covariance2& covariance) {
  return {covariance.xx, covariance.xy, covariance.yy};
}

Json json_of(const Obstacle& obstacle) {
  return {{"id", obstacle.id},
          {"x_m", obstacle.x_m},
          {"y_m", obstacle.y_m},
          {"vx_mps", obstacle.vx_mps},
          {"vy_mps", obstacle.vy_mps},
          {"length_m", obstacle.length_m},
          {"width_m", obstacle.width_m},
          {"yaw_rad", obstacle.yaw_rad},
          {"age_s", obstacle.age_s},
          {"occupancy", obstacle.occupancy},
          {"confirmed", obstacle.confirmed},
          {"moving", obstacle.moving},
          {"coasting", obstacle.coasting},
          {"unseen_s", obstacle.unseen_s},
          {"position_covariance", json_of(obstacle.position_covariance)},
          {"velocity_covariance", json_of(obstacle.velocity_covariance)}};
}

constexpr std::int64_t largest_id{std::int64_t{1} << 53};
constexpr double farthest{1e9};  // metres and radians: poses of a jumped source, too

// Flags that this version does not know are left out.
std::vector<FrameStatus> status_of(const Json& line) {
  constexpr auto names{names_of(FrameStatus{})};
  std::vector<FrameStatus> status;
  for (const Json& name : line.value("status", Json(Json::array()))) {
    const auto found{std::ranges::find(names, name.get<std::string>())};
    if (found != names.end()) status.push_back(static_cast<FrameStatus>(found - names.begin()));
  }
  return status;
}

FrameSummary summary_of(const Json& line) {
  FrameSummary frame;
  frame.index = static_cast<std::size_t>(io::whole_number(line, "index", 0, largest_index));
  const Json& pose{line.at("pose")};
  frame.world_from_vehicle = {io::number(pose, "x_m", farthest), io::number(pose, "y_m", farthest),
                              io::number(pose, "yaw_rad", farthest)};
  for (const StageField& stage : stage_fields) {
    frame.timing_ms.*stage.milliseconds = line.at("timing_ms").at(stage.name).get<double>();
  }
  frame.warnings = line.at("warnings").get<std::vector<std::string>>();
  frame.status = status_of(line);
  return frame;
}

void take(FinishedFrames& finished, const Json& line) {
  const std::size_t before{finished.frames.empty() ? 0 : finished.frames.back().index + 1};
  finished.frames.push_back(summary_of(line));
  check_order(before, finished.frames.back().index);
  for (const Json& obstacle : line.at("obstacles")) {
    finished.largest_id = std::max(finished.largest_id, io::whole_number(obstacle, "id", 0, largest_id));
  }
}

void cut_off(const fs::path& path, std::size_t size) {
  std::error_code error;
  fs::resize_file(path, size, error);
  if (!error) return;
  throw DeviceError{fmt::format("{}: its torn last line cannot be cut off ({}). Check the permissions.",
                                io::printable_path(path), error.message())};
}

}  // namespace

void check_order(std::size_t least, std::size_t index) {
  if (index >= least) return;
  throw InputError{fmt::format("its index {} is not above that of the line before", index)};
}

std::string frame_line(const StereoFrame& frame, const FrameResult& result) {
  const Ground& ground{result.ground};
  const Pose2& pose{result.world_from_vehicle};
  Json timing;
  for (const StageField& stage : stage_fields) timing[std::string{stage.name}] = result.timing_ms.*stage.milliseconds;
  Json obstacles(Json::array());
  for (const Obstacle& obstacle : result.obstacles) obstacles.push_back(json_of(obstacle));
  Json status(Json::array());
  for (const FrameStatus flag : result.status) status.push_back(names_of(flag)[static_cast<std::size_t>(flag)]);
  const Json line{{"index", frame.index},
                  {"name", frame.name},
                  {"stamp_ns", frame.stamp_ns},
                  {"pose", {{"x_m", pose.x_m}, {"y_m", pose.y_m}, {"yaw_rad", pose.yaw_rad}}},
                  {"ground",
                   {{"height_m", ground.height_m},
                    {"pitch_rad", ground.pitch_rad},
                    {"roll_rad", ground.roll_rad},
                    {"estimated", ground.estimated},
                    {"height_sigma_m", ground.height_sigma_m},
                    {"pitch_sigma_rad", ground.pitch_sigma_rad},
                    {"roll_sigma_rad", ground.roll_sigma_rad}}},
                  {"timing_ms", timing},
                  {"density", {{"obstacle", result.obstacle_density}, {"road", result.road_density}}},
                  {"obstacles", obstacles},
                  {"status", status},
                  {"warnings", result.warnings}};
  return io::json_text(line);
}

FinishedFrames read_frame_lines(const fs::path& path) {
  FinishedFrames finished;
  if (!fs::exists(path)) return finished;
  const std::string text{io::read_text(path, io::largest_bytes::json)};
  const std::size_t last_end{text.rfind('\n')};
  const std::size_t whole{last_end == std::string::npos ? 0 : last_end + 1};
  for (std::size_t begin{0}; begin < whole;) {
    const std::size_t end{text.find('\n', begin)};
    io::read_json<Json>(io::printable_path(path), std::string_view{text}.substr(begin, end - begin),
                        fmt::format("line {} ", finished.frames.size() + 1), mend,
                        [&finished](const Json& line) { take(finished, line); });
    begin = end + 1;
  }
  if (whole < text.size()) cut_off(path, whole);
  return finished;
}

}  // namespace stereogrid::app
