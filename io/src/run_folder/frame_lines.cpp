// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/frame_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Numbers as they are, or, of compact lines, rounded: to a step, which has to divide 1, or to significant digits.
class Numbers {
 public:
  explicit Numbers(bool compact) : compact_{compact} {}

  [[nodiscard]] double to_centimetres(double metres) const { return stepped(metres, 100); }
  [[nodiscard]] double to_thousandths(double value) const { return stepped(value, 1000); }
  [[nodiscard]] double to_ten_thousandths(double value) const { return stepped(value, 10'000); }
  [[nodiscard]] double stepped(double value, double steps) const {
    return compact_ ? std::round(value * steps) / steps + 0.0 : value;  // + 0.0: of -0.0 too
  }
  [[nodiscard]] double to_four_digits(double value) const {
    if (!compact_) return value;
    std::array<char, 32> text{};
    const auto end{std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, 3).ptr};
    std::from_chars(text.data(), end, value);
    return value;
  }

 private:
  bool compact_;
};

Json json_of(const Covariance2& covariance, const Numbers& numbers) {
  return {numbers.to_four_digits(covariance.xx), numbers.to_four_digits(covariance.xy),
          numbers.to_four_digits(covariance.yy)};
}

Json json_of(const Outline& outline, const Numbers& numbers) {
  Json points(Json::array());
  for (const Point2& point : outline) {
    points.push_back({numbers.to_centimetres(point.x), numbers.to_centimetres(point.y)});
  }
  return points;
}

/// Writes the fields of an obstacle into an object.
class ObstacleWriter {
 public:
  ObstacleWriter(Json& object, const Numbers& numbers) : object_{object}, numbers_{numbers} {}

  template <class Value>
  void operator()(const ObstacleField& field, const Value& value) const {
    object_[field.name] = value;
  }
  // JSON has no infinity.
  void operator()(const ObstacleField& field, const double& value) const {
    object_[field.name] = std::isfinite(value) ? Json(numbers_.stepped(value, field.steps)) : Json();
  }
  void operator()(const ObstacleField& field, const ObstacleKind& kind) const {
    object_[field.name] = names_of(kind)[static_cast<std::size_t>(kind)];
  }
  void operator()(const ObstacleField& field, const Covariance2& covariance) const {
    object_[field.name] = json_of(covariance, numbers_);
  }
  void operator()(const ObstacleField& field, const Outline& outline) const {
    object_[field.name] = json_of(outline, numbers_);
  }

 private:
  Json& object_;
  const Numbers& numbers_;
};

Json json_of(const Obstacle& obstacle, const Numbers& numbers) {
  Json object(Json::object());
  visit_fields(obstacle, ObstacleWriter{object, numbers});
  return object;
}

std::int64_t id_of(const Json& obstacle) {
  return whole_number(obstacle, "id", 0, std::int64_t{1} << 53);
}

constexpr double farthest{1e9};  // metres and radians of poses: those of a source that jumped, too
constexpr double most{1e6};      // metres, m/s …: of what a street holds

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

// A reason that this version does not name is as good as none.
void read_speed_limit(const Json& line, RunFrame& frame) {
  constexpr auto names{names_of(SpeedReason{})};
  const Json limit(line.value("speed_limit", Json{}));
  if (limit.is_null()) return;
  const auto found{std::ranges::find(names, limit.at("reason").get<std::string>())};
  if (found == names.end()) return;
  frame.speed_limit_mps = number(limit, "mps", most);
  frame.speed_limit_reason = static_cast<SpeedReason>(found - names.begin());
}

Pose2 pose_of(const Json& line) {
  const Json& pose(line.at("pose"));
  return {number(pose, "x_m", farthest), number(pose, "y_m", farthest), number(pose, "yaw_rad", farthest)};
}

// Lines have texts alone. Those of the statuses come first, in the order of these; the exposure's may be among them.
void set_warnings(FrameSummary& frame, const std::vector<std::string>& texts) {
  auto status{frame.status.begin()};
  for (const std::string& text : texts) {
    Warning& warning{frame.warnings.emplace_back(Warning{text})};
    if (text.find(exposure_remedy) != std::string::npos) {
      frame.exposure_warning = text;
    } else if (status != frame.status.end()) {
      warning.status = *status++;
    }
  }
}

FrameSummary summary_of(const Json& line) {
  FrameSummary frame;
  frame.index = static_cast<std::size_t>(whole_number(line, "index", 0, largest_index));
  static_cast<void>(pose_of(line));
  for (const StageField& stage : stage_fields) {
    frame.timing_ms.*stage.milliseconds = line.at("timing_ms").at(stage.name).get<double>();
  }
  frame.status = status_of(line);
  set_warnings(frame, line.at("warnings").get<std::vector<std::string>>());
  frame.name = line.value("name", "");
  const Json& ground(line.at("ground"));
  frame.ground = {number(ground, "height_m", most), number(ground, "pitch_rad", most), number(ground, "roll_rad", most),
                  ground.at("estimated").get<bool>()};
  frame.is_known = !has_any(frame.status, {FrameStatus::few_matches, FrameStatus::road_unknown});  // without its grids
  for (const Json& obstacle : line.at("obstacles")) static_cast<void>(id_of(obstacle));
  return frame;
}

/// Reads the fields of an obstacle from an object.
class ObstacleReader {
 public:
  explicit ObstacleReader(const Json& object) : object_{object} {}

  void operator()(const ObstacleField& /*field*/, std::int64_t& id) const { id = id_of(object_); }
  // null: the infinity that is its default
  void operator()(const ObstacleField& field, double& value) const {
    if (is_missing(field) || (std::isinf(value) && object_.at(field.name).is_null())) return;
    value = number(object_, field.name, field.largest);
  }
  void operator()(const ObstacleField& field, bool& value) const {
    if (!is_missing(field)) value = object_.at(field.name).get<bool>();
  }
  // "thing" and "extended": former names. Unknown kinds are objects.
  void operator()(const ObstacleField& field, ObstacleKind& kind) const {
    const std::string name{object_.value(field.name, "object")};
    kind = name == "drop"                             ? ObstacleKind::drop
           : name == "boundary" || name == "extended" ? ObstacleKind::boundary
                                                      : ObstacleKind::object;
  }
  void operator()(const ObstacleField& field, Covariance2& covariance) const;
  void operator()(const ObstacleField& field, Outline& outline) const;

 private:
  [[nodiscard]] bool is_missing(const ObstacleField& field) const {
    return !field.is_required && !object_.contains(field.name);
  }

  const Json& object_;
};

void ObstacleReader::operator()(const ObstacleField& field, Covariance2& covariance) const {
  constexpr double largest{1e12};
  if (is_missing(field)) return;
  const Json& values(object_.at(field.name));
  const auto value = [&](std::size_t i) { return number_of(values.at(i), field.name, largest); };
  covariance = {value(0), value(1), value(2)};
}

void ObstacleReader::operator()(const ObstacleField& field, Outline& outline) const {
  if (is_missing(field) || object_.at(field.name).is_null()) return;
  const Json& points(object_.at(field.name));
  if (!points.is_array() || points.size() > Outline::points_max) {
    throw InputError{fmt::format("'{}' is not a list of at most {} points", field.name, Outline::points_max)};
  }
  for (const Json& point : points) {
    outline.push_back({number_of(point.at(0), field.name, most), number_of(point.at(1), field.name, most)});
  }
}

Obstacle obstacle_of(const Json& object) {
  Obstacle obstacle;
  visit_fields(obstacle, ObstacleReader{object});
  return obstacle;
}

StageTimes timing_of(const Json& line) {
  StageTimes timing;
  const Json& stages(line.at("timing_ms"));
  for (const StageField& stage : stage_fields) timing.*stage.milliseconds = stages.value(stage.name, 0.0);
  return timing;
}

RunFrame frame_of(const Json& line) {
  RunFrame frame;
  frame.index = static_cast<std::size_t>(whole_number(line, "index", 0, largest_index));
  frame.name = line.at("name").get<std::string>();
  frame.stamp_ns = whole_number(line, "stamp_ns", -largest_stamp_ns, largest_stamp_ns);
  frame.world_from_vehicle = pose_of(line);
  frame.timing_ms = timing_of(line);
  if (frame.name.empty() || frame.name.find('/') != std::string::npos) throw InputError{"'name' is not a frame's name"};
  for (const Json& o : line.at("obstacles")) {
    frame.obstacles.push_back(obstacle_of(o));
  }
  frame.status = status_of(line);
  read_speed_limit(line, frame);
  if (line.contains("mount")) {
    const Json& mount(line.at("mount"));
    frame.extrinsics = {number(mount, "camera_height_m", most), number(mount, "camera_pitch_rad", most),
                        number(mount, "camera_roll_rad", most)};
  }
  return frame;
}

/// Hands every line of frames.jsonl to `take`, in the order of their indices.
template <class Take>
void read_lines(const fs::path& path, std::string_view text, const char* mend, Take take) {
  std::int64_t next{0};
  for (int number{1}; !text.empty(); ++number) {
    const std::string_view line_text{text.substr(0, text.find('\n'))};
    text.remove_prefix(std::min(line_text.size() + 1, text.size()));
    const auto read{[&](const Json& line) {
      const std::int64_t index{whole_number(line, "index", 0, largest_index)};
      if (index < next) {
        throw InputError{fmt::format("its index {} is not above that of the line before", index)};
      }
      next = index + 1;
      take(line);
    }};
    read_json<Json>(printable_path(path), line_text, fmt::format("line {} ", number), mend, read);
  }
}

// The last `bytes` of the file: where its text begins it may have a mark of the byte order.
void cut_off(const fs::path& path, std::size_t bytes) {
  std::error_code error;
  const std::uintmax_t size{fs::file_size(path, error)};
  if (!error) fs::resize_file(path, size - bytes, error);
  if (!error) return;
  throw DeviceError{fmt::format("{}: its torn last line cannot be cut off ({}). Check the permissions.",
                                printable_path(path), error.message())};
}

}  // namespace

std::string frame_line(const StereoFrame& frame, const FrameResult& result, const Rig& rig, bool compact) {
  const Numbers numbers{compact};
  const Ground& ground{result.ground};
  const Pose2& pose{result.world_from_vehicle};
  Json timing;
  for (const StageField& stage : stage_fields) {
    timing[std::string{stage.name}] = numbers.to_thousandths(result.timing_ms.*stage.milliseconds);
  }
  Json obstacles(Json::array());
  for (const Obstacle& obstacle : result.obstacles) obstacles.push_back(json_of(obstacle, numbers));
  Json status(Json::array());
  for (const FrameStatus flag : result.status) status.push_back(names_of(flag)[static_cast<std::size_t>(flag)]);
  Json warnings(Json::array());
  for (const Warning& warning : result.warnings) warnings.push_back(warning.text);
  Json speed_limit;
  if (result.speed_limit_reason != SpeedReason::none) {
    speed_limit = {{"mps", numbers.to_thousandths(result.speed_limit_mps)},
                   {"reason", names_of(SpeedReason{})[static_cast<std::size_t>(result.speed_limit_reason)]}};
  }
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
                  {"mount",
                   {{"camera_height_m", rig.camera_height_m},
                    {"camera_pitch_rad", rig.camera_pitch_rad},
                    {"camera_roll_rad", rig.camera_roll_rad}}},
                  {"timing_ms", timing},
                  {"density",
                   {{"obstacle", numbers.to_ten_thousandths(result.obstacle_density)},
                    {"road", numbers.to_ten_thousandths(result.road_density)}}},
                  {"speed_limit", speed_limit},
                  {"obstacles", obstacles},
                  {"status", status},
                  {"warnings", warnings}};
  return json_text(line);
}

FrameSummary summary_of(const StereoFrame& frame, const FrameResult& result) {
  const bool is_known{std::ranges::any_of(result.observed, [](float occupancy) { return occupancy != 0.5F; })};
  return {static_cast<std::size_t>(frame.index),
          result.timing_ms,
          result.warnings,
          result.status,
          frame.name,
          result.ground,
          is_known,
          is_unequal(result.exposure) ? std::optional{text_of(result.exposure)} : std::nullopt};
}

std::vector<FrameSummary> take_finished_frames(const fs::path& path) {
  if (!is_there(path)) return {};
  const std::string text{read_text(path, largest_bytes::json)};
  const std::size_t whole{text.rfind('\n') + 1};  // no end of line: 0
  std::vector<FrameSummary> frames;
  read_lines(path, std::string_view{text}.substr(0, whole),
             "Remove the lines from there on, or start the run anew in another folder.",
             [&frames](const Json& line) { frames.push_back(summary_of(line)); });
  if (whole < text.size()) cut_off(path, text.size() - whole);
  return frames;
}

std::vector<RunFrame> read_run_frames(const fs::path& path) {
  const std::string text{read_text(path, largest_bytes::json)};
  std::vector<RunFrame> frames;
  std::set<std::string> names;
  read_lines(path, text, "Remove what does not belong there, or run again in another folder.", [&](const Json& line) {
    frames.push_back(frame_of(line));
    if (!names.insert(frames.back().name).second) throw InputError{"its 'name' stands in an earlier line, too"};
  });
  return frames;
}

}  // namespace stereogrid::io
