// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>

#include "layouts/layouts.hpp"
#include "stereogrid/error.hpp"
#include "world/numbers.hpp"

namespace stereogrid::scenes {
namespace {

/// One numeric key of the text form: how it is written, its range, and where it goes.
struct Key {
  std::string_view name;
  double minimum;
  double maximum;
  double (*get)(const SceneOptions&);
  void (*set)(SceneOptions&, double);
};

constexpr double degree{pi / 180};

// The seed is apart: a double cannot hold all of its values.
constexpr Key keys[]{
    {"frames", 1, 1e6, [](const SceneOptions& o) { return double(o.frames); },
     [](SceneOptions& o, double x) { o.frames = static_cast<int>(x); }},
    {"width", 16, 8192, [](const SceneOptions& o) { return double(o.width_px); },
     [](SceneOptions& o, double x) { o.width_px = static_cast<int>(x); }},
    {"height", 16, 8192, [](const SceneOptions& o) { return double(o.height_px); },
     [](SceneOptions& o, double x) { o.height_px = static_cast<int>(x); }},
    {"focal", 1, 1e5, [](const SceneOptions& o) { return o.focal_px; },
     [](SceneOptions& o, double x) { o.focal_px = x; }},
    {"baseline", 0.01, 5, [](const SceneOptions& o) { return o.baseline_m; },
     [](SceneOptions& o, double x) { o.baseline_m = x; }},
    {"camera_height", 0.15, 20, [](const SceneOptions& o) { return o.camera_height_m; },
     [](SceneOptions& o, double x) { o.camera_height_m = x; }},
    {"pitch_deg", -30, 30, [](const SceneOptions& o) { return o.camera_pitch_rad / degree; },
     [](SceneOptions& o, double x) { o.camera_pitch_rad = x * degree; }},
    {"roll_deg", -180, 180, [](const SceneOptions& o) { return o.camera_roll_rad / degree; },
     [](SceneOptions& o, double x) { o.camera_roll_rad = x * degree; }},
    {"rate", 0.1, 1000, [](const SceneOptions& o) { return o.rate_hz; },
     [](SceneOptions& o, double x) { o.rate_hz = x; }},
    {"noise", 0, 60, [](const SceneOptions& o) { return o.noise_grey; },
     [](SceneOptions& o, double x) { o.noise_grey = x; }},
    {"gain", 0.2, 5, [](const SceneOptions& o) { return o.gain; }, [](SceneOptions& o, double x) { o.gain = x; }},
    {"pitch_noise_deg", 0, 10, [](const SceneOptions& o) { return o.pitch_noise_rad / degree; },
     [](SceneOptions& o, double x) { o.pitch_noise_rad = x * degree; }},
    {"roll_noise_deg", 0, 10, [](const SceneOptions& o) { return o.roll_noise_rad / degree; },
     [](SceneOptions& o, double x) { o.roll_noise_rad = x * degree; }},
    {"height_noise", 0, 0.2, [](const SceneOptions& o) { return o.height_noise_m; },
     [](SceneOptions& o, double x) { o.height_noise_m = x; }},
    {"edge", 0, 50, [](const SceneOptions& o) { return o.edge_m; }, [](SceneOptions& o, double x) { o.edge_m = x; }},
    {"at", 0, 50, [](const SceneOptions& o) { return o.edge_m; }, [](SceneOptions& o, double x) { o.edge_m = x; }},
    {"rise", -10, 10, [](const SceneOptions& o) { return o.rise_m; }, [](SceneOptions& o, double x) { o.rise_m = x; }},
    {"depth", -10, 10, [](const SceneOptions& o) { return -o.rise_m; },
     [](SceneOptions& o, double x) { o.rise_m = -x; }},
    {"slope_deg", -60, 60, [](const SceneOptions& o) { return o.slope_deg; },
     [](SceneOptions& o, double x) { o.slope_deg = x; }},
    {"span", 0, 50, [](const SceneOptions& o) { return o.span_m; }, [](SceneOptions& o, double x) { o.span_m = x; }},
    {"skew_deg", -60, 60, [](const SceneOptions& o) { return o.skew_deg; },
     [](SceneOptions& o, double x) { o.skew_deg = x; }},
    {"speed", 0, 30, [](const SceneOptions& o) { return o.speed_mps; },
     [](SceneOptions& o, double x) { o.speed_mps = x; }},
    {"incline_deg", 1, 90, [](const SceneOptions& o) { return o.incline_deg; },
     [](SceneOptions& o, double x) { o.incline_deg = x; }},
    {"cameras", 1, 8, [](const SceneOptions& o) { return double(o.cameras); },
     [](SceneOptions& o, double x) { o.cameras = static_cast<int>(x); }},
    {"turn_deg", 0, 180, [](const SceneOptions& o) { return o.turn_deg; },
     [](SceneOptions& o, double x) { o.turn_deg = x; }},
    {"ring", 0, 5, [](const SceneOptions& o) { return o.ring_m; }, [](SceneOptions& o, double x) { o.ring_m = x; }},
    {"steps", 0, 50, [](const SceneOptions& o) { return double(o.steps); },
     [](SceneOptions& o, double x) { o.steps = static_cast<int>(x); }}};

bool is_whole(const Key& key) {
  return key.name == "frames" || key.name == "cameras" || key.name == "width" || key.name == "height" ||
         key.name == "steps";
}

std::string plain(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}

std::string range_of(const Key& key) {
  return std::string{key.name} + " is a " + (is_whole(key) ? "whole number" : "number") + " from " +
         plain(key.minimum) + " to " + plain(key.maximum) + ".";
}

std::string known_keys() {
  std::string text{"Known keys: seed"};
  for (const Key& key : keys) text += ", " + std::string{key.name};
  return text + ", camera, kind.";
}

std::string known_kinds() {
  std::string text{"Known kinds: random"};
  for (const std::string& kind : terrain_kinds()) text += " " + kind;
  return text + ".";
}

void check_words(const SceneOptions& options) {
  const std::string scene{"scene:" + options.name};
  if (options.camera != "car" && options.camera != "robot") {
    throw InputError{scene, "cannot use camera=" + options.camera + ".", "Known cameras: car robot."};
  }
  const auto kinds{terrain_kinds()};
  if (options.kind != "random" && std::ranges::find(kinds, options.kind) == kinds.end()) {
    throw InputError{scene, "cannot use kind=" + options.kind + ".", known_kinds()};
  }
}

std::string known_scenes() {
  std::string text{"Known scenes:"};
  for (const Layout& layout : layouts()) text += " " + std::string{layout.name};
  return text + ".";
}

bool fits(const Key& key, double value) {
  constexpr double slack{1e-9};  // degrees have been to radians and back
  return value >= key.minimum - slack && value <= key.maximum + slack && (!is_whole(key) || value == std::floor(value));
}

template <class Number>
bool read(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

void set(SceneOptions& options, const std::string& scene, std::string_view name, std::string_view value) {
  const std::string given{std::string{name} + "=" + std::string{value}};
  if (name == "seed") {
    if (read(value, options.seed)) return;
    throw InputError{scene, "cannot use " + given + ".", "seed is a whole number from 0 to 18446744073709551615."};
  }
  if (name == "camera" || name == "kind") {
    (name == "kind" ? options.kind : options.camera) = value;
    check_words(options);
    return;
  }
  for (const Key& key : keys) {
    if (key.name != name) continue;
    double number{0};
    if (!read(value, number) || !fits(key, number)) throw InputError{scene, "cannot use " + given + ".", range_of(key)};
    key.set(options, number);
    return;
  }
  throw InputError{scene, "there is no key \"" + std::string{name} + "\".", known_keys()};
}

const Layout& find_layout(const std::string& name) {
  for (const Layout& layout : layouts()) {
    if (layout.name == name) return layout;
  }
  throw InputError{"scene:" + name, "there is no such scene.", known_scenes()};
}

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const Layout& layout : layouts()) names.emplace_back(layout.name);
  return names;
}

SceneOptions parse_scene(std::string_view text) {
  constexpr std::string_view prefix{"scene:"};
  if (text.starts_with(prefix)) text.remove_prefix(prefix.size());
  const std::size_t question{std::min(text.find('?'), text.size())};
  SceneOptions options;
  options.name = text.substr(0, question);
  static_cast<void>(find_layout(options.name));
  text.remove_prefix(std::min(question + 1, text.size()));
  const std::string scene{"scene:" + options.name};
  std::set<std::string_view> given;
  while (!text.empty()) {
    const std::string_view setting{text.substr(0, text.find('&'))};
    const std::size_t equals{setting.find('=')};
    if (equals == std::string_view::npos) {
      throw InputError{scene, "cannot read \"" + std::string{setting} + "\".",
                       "Write settings as key=value, with & between them. " + known_keys()};
    }
    const std::string_view name{setting.substr(0, equals)};
    if (!given.insert(name).second) {
      throw InputError{scene, std::string{name} + " is given twice.", "Leave one of them out."};
    }
    set(options, scene, name, setting.substr(equals + 1));
    text.remove_prefix(std::min(setting.size() + 1, text.size()));
  }
  if (options.camera == "robot" && !given.contains("pitch_deg")) options.camera_pitch_rad = 8 * degree;
  return options;
}

SceneOptions completed(SceneOptions options) {
  const Layout& layout{find_layout(options.name)};
  const bool wide{options.width_px >= 1000};
  const bool robot{options.camera == "robot"};
  if (options.speed_mps < 0) options.speed_mps = options.name == "course" ? (robot ? 1.5 : 8) : (robot ? 0.5 : 2);
  if (options.frames == 0) {
    options.frames = layout.length_m > 0 && options.speed_mps > 0
                         ? static_cast<int>(layout.length_m / options.speed_mps * options.rate_hz)
                         : layout.frames;
  }
  if (options.focal_px == 0) options.focal_px = wide ? 721.5 * options.width_px / 1242 : 410.0 * options.width_px / 512;
  if (options.baseline_m == 0) options.baseline_m = robot ? 0.09 : (wide ? 0.54 : 0.22);
  if (options.camera_height_m == 0) options.camera_height_m = robot ? 0.35 : (wide ? 1.65 : 1.25);
  if (options.turn_deg == 0) options.turn_deg = options.cameras > 2 ? 360.0 / options.cameras : 180;
  check_words(options);
  for (const Key& key : keys) {
    const double value{key.get(options)};
    if (!fits(key, value)) {
      throw InputError{"scene:" + options.name, "cannot use " + std::string{key.name} + "=" + plain(value) + ".",
                       range_of(key)};
    }
  }
  return options;
}

World build_world(const SceneOptions& options) {
  return find_layout(options.name).build(options);
}

}  // namespace stereogrid::scenes
