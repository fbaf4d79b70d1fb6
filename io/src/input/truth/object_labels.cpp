// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/truth.hpp"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

using Json = nlohmann::json;

constexpr double most{1e6};            // m, m/s, rad
constexpr double largest_box_m{1000};  // a side
constexpr std::size_t most_objects{100'000};

const char* const line_mend{"Correct the line, or remove the file: without it obstacles are not scored."};

bool has(const Json& object, const char* key) {
  const auto found{object.find(key)};
  return found != object.end() && !found->is_null();
}

double side(const Json& json, const char* key) {
  const double length{number(json, key, largest_box_m)};
  if (length < 0) throw InputError{fmt::format("'{}' is negative", key)};
  return length;
}

LabelledObject parse_object(const Json& json) {
  LabelledObject object;
  object.id = whole_number(json, "id", 0, std::numeric_limits<std::int32_t>::max());
  object.kind = json.at("kind");
  object.x_m = number(json, "x_m", most);
  object.y_m = number(json, "y_m", most);
  object.length_m = side(json, "length_m");
  object.width_m = side(json, "width_m");
  object.yaw_rad = number(json, "yaw_rad", most);
  if (has(json, "occluded")) object.occluded = static_cast<int>(whole_number(json, "occluded", 0, 3));
  if (has(json, "vx_mps") && has(json, "vy_mps")) {
    object.velocity_mps = Point2{number(json, "vx_mps", most), number(json, "vy_mps", most)};
  }
  if (has(json, "moving")) object.moving = json.at("moving").get<bool>();
  return object;
}

LabelledFrame parse_frame(const Json& json) {
  LabelledFrame frame;
  frame.name = json.at("name");
  const Json& objects = json.at("objects");  // no braces: they would make a list of it
  if (!objects.is_array() || objects.size() > most_objects) {
    throw InputError{fmt::format("'objects' is not a list of at most {} objects", most_objects)};
  }
  std::set<std::int64_t> ids;
  for (const Json& object : objects) {
    frame.objects.push_back(parse_object(object));
    if (!ids.insert(frame.objects.back().id).second) {
      throw InputError{fmt::format("'id' {} stands for two objects", frame.objects.back().id)};
    }
  }
  return frame;
}

}  // namespace

std::vector<LabelledFrame> read_object_labels(const std::filesystem::path& path) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<LabelledFrame> frames;
  std::set<std::string> names;
  for (const std::string_view line : lines_of(text)) {
    read_json<Json>(printable_path(path), line, fmt::format("line {} ", frames.size() + 1), line_mend,
                    [&frames](const Json& json) { frames.push_back(parse_frame(json)); });
    if (names.insert(frames.back().name).second) continue;
    throw InputError{printable_path(path), "names frame " + frames.back().name + " twice.", line_mend};
  }
  return frames;
}

}  // namespace stereogrid::io
