// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/config.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <initializer_list>

#include "stereogrid/error.hpp"
#include "stereogrid/printable.hpp"

namespace stereogrid {
namespace {

constexpr int cells_max{4000};  // along a side
constexpr double velocities_max{1000};
constexpr double lattice_bytes_max{64.0 * (1 << 30)};

// Velocities of the filter's lattice.
double lattice_size(const FilterConfig& config) {
  const double side{2 * static_cast<double>(config.speeds_mps.size()) + 1};
  return side * side;
}

// Bytes of a number for each cell of the window and each velocity, in two states.
double lattice_bytes(const Config& config) {
  const double length_m{config.grid.length_m + config.grid.rear_m};
  const double side{std::hypot(length_m, config.grid.width_m) / config.grid.cell_size_m};
  return 2 * sizeof(float) * lattice_size(config.filter) * side * side;
}

// "a is 1, b is 5"
std::string values_of(const Config& config, std::initializer_list<std::string_view> keys) {
  std::string text;
  for (const std::string_view key : keys) {
    text += (text.empty() ? "" : ", ") + std::string{key} + " is " + get(config, key);
  }
  return text;
}

/// Adds to `found` a message for each size that parameters give together and that cannot be used, such as the number of
/// cells. Parameters with a message of their own in `found` are left out.
void add_problems_of_sizes(const Config& config, std::vector<std::string>& found) {
  const auto has_problem = [own = found](std::string_view key) {
    return std::ranges::any_of(own, [key](const std::string& problem) { return problem.starts_with(key); });
  };
  const auto require = [&](bool is_fine, std::initializer_list<std::string_view> keys, const std::string& problem) {
    if (!is_fine && std::ranges::none_of(keys, has_problem)) found.push_back(values_of(config, keys) + ": " + problem);
  };
  const auto require_cells = [&](std::string_view key, double side_m) {
    const double cells{std::round(side_m / config.grid.cell_size_m)};
    require(cells >= 1 && cells <= cells_max, {key, "grid.cell_size_m"},
            (cells < 1 ? "no cell" : "more than " + std::to_string(cells_max) + " cells") +
                " along that side (allowed 1 … " + std::to_string(cells_max) + "). Take " +
                (cells < 1 ? "smaller cells or a larger grid." : "larger cells or a smaller grid."));
  };
  require_cells("grid.length_m", config.grid.length_m + config.grid.rear_m);
  require_cells("grid.width_m", config.grid.width_m);
  require(config.u_disparity.obstacle_min_height_m < config.u_disparity.obstacle_height_m,
          {"u_disparity.obstacle_min_height_m", "u_disparity.obstacle_height_m"},
          "no height is left for obstacles. Take a minimum height below the other.");
  require(config.vehicle.step_max_m < config.vehicle.height_m, {"vehicle.step_max_m", "vehicle.height_m"},
          "no height is left for obstacles. Take a step below the vehicle's height.");
  if (lattice_size(config.filter) > velocities_max) {
    found.emplace_back("filter.speeds_mps: more than 1000 velocities. Take fewer speeds.");
    return;
  }
  require(lattice_bytes(config) <= lattice_bytes_max,
          {"grid.length_m", "grid.rear_m", "grid.width_m", "grid.cell_size_m", "filter.speeds_mps"},
          "the window's cells times the velocities take more than 64 GiB. Take larger cells, a smaller grid or fewer "
          "speeds.");
}

using List = std::vector<double>;

template <class T>
constexpr bool is_choice = std::is_enum_v<T>;

template <class T>
bool is_one_of_its_choices(T value) {
  return static_cast<int>(value) >= 0 && static_cast<int>(value) < static_cast<int>(names_of(T{}).size());
}

template <class T>
std::string names_of_choices() {
  std::string all;
  for (const std::string_view name : names_of(T{})) all += " " + std::string{name};
  return all;
}

std::string key_of(std::string_view group, const Parameter& parameter) {
  return std::string{group} + "." + std::string{parameter.name};
}

std::string text_of(double number) {
  std::array<char, 32> buffer{};
  const auto end{std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr};
  return {buffer.data(), end};
}

template <class T>
std::string text_of_value(const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (is_choice<T>) {
    if (!is_one_of_its_choices(value)) return std::to_string(static_cast<int>(value));
    return std::string{names_of(T{})[static_cast<std::size_t>(value)]};
  } else if constexpr (std::is_same_v<T, List>) {
    if (value.empty()) return "none";
    std::string text;
    for (const double number : value) text += (text.empty() ? "" : ",") + text_of(number);
    return text;
  } else if constexpr (std::is_integral_v<T>) {
    return std::to_string(value);
  } else {
    return text_of(value);
  }
}

void parse(bool& value, std::string_view text, const std::string& key) {
  if (text == "true" || text == "on" || text == "yes" || text == "1") {
    value = true;
  } else if (text == "false" || text == "off" || text == "no" || text == "0") {
    value = false;
  } else {
    throw ConfigError{key + " is true or false, not '" + std::string{text} + "'."};
  }
}

template <class T>
requires std::is_arithmetic_v<T>
void parse(T& value, std::string_view text, const std::string& key) {
  T parsed{};
  const auto [end, error]{std::from_chars(text.data(), text.data() + text.size(), parsed)};
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw ConfigError{key + " is " + (std::is_integral_v<T> ? "a whole number" : "a number") + ", not '" +
                      std::string{text} + "'."};
  }
  value = parsed;
}

// "1.25,2.5", blanks may follow a comma; or "none".
void parse(List& value, std::string_view text, const std::string& key) {
  List parsed;
  while (text != "none") {
    const std::size_t comma{text.find(',')};
    parse(parsed.emplace_back(), text.substr(0, comma), key + " is a list (a,b,c), each of which");
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  }
  value = std::move(parsed);
}

template <class T>
requires is_choice<T>
void parse(T& value, std::string_view text, const std::string& key) {
  const auto names{names_of(T{})};
  const auto found{std::find(names.begin(), names.end(), text)};
  if (found == names.end()) {
    throw ConfigError{key + " is not '" + std::string{text} + "' but one of:" + names_of_choices<T>() + "."};
  }
  value = static_cast<T>(found - names.begin());
}

bool is_parameter(std::string_view key) {
  bool found{false};
  const Config config;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    found = found || key_of(group, parameter) == key;
  });
  return found;
}

/// The parameters of a group, "group.name" each; empty: there is no such group.
std::string members_of(std::string_view wanted) {
  std::string members;
  const Config config;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    if (group == wanted) members += (members.empty() ? "" : ", ") + key_of(group, parameter);
  });
  return members;
}

[[noreturn]] void throw_unknown_key(std::string_view key) {
  if (key.empty()) throw ConfigError{"A parameter has no name: it is group.name, such as grid.length_m."};
  if (const std::string members{members_of(key)}; !members.empty()) {
    throw ConfigError{"'" + std::string{key} + "' is a group of parameters, not one of them: name " + members + "."};
  }
  std::string nearest;
  std::size_t smallest{1000};
  const Config config;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    const std::string known{key_of(group, parameter)};
    const std::size_t distance{std::min(edit_distance(key, known), edit_distance(key, parameter.name))};
    if (distance < smallest) {
      smallest = distance;
      nearest = known;
    }
  });
  throw ConfigError{"There is no parameter '" + std::string{key} + "'. Nearest: '" + nearest +
                    "'. `stereogrid config` lists them all."};
}

// Differences of the paper's method from the default; docs/paper.md has the reasons.
Config paper_preset() {
  Config config;
  config.ground.model = GroundModel::plane;
  config.matching.align_rows = false;
  config.matching.thin_tops = false;
  config.matching.window_px = 21;
  config.matching.uniqueness = 0.02;
  config.matching.texture = 1;
  config.matching.cost_limit = 1;
  config.matching.left_right_px = 1;
  config.matching.speckle_px = config.matching.road_speckle_px = 60;
  config.matching.subpixel = false;
  config.u_disparity.obstacle_min_height_m = 0;
  config.u_disparity.follow_roll = false;
  config.paper.tau_obstacle = 0.1;
  config.paper.sigma_column = 1.5;
  config.paper.road_rays = RoadRays::none;
  config.paper.small_count_guard = 0;
  config.paper.left_border = false;
  config.projection.model = ProjectionModel::bins;
  config.filter.model = FilterModel::tay2008;
  config.filter.speeds_mps = {2, 4, 6, 8, 10};
  config.filter.decay_time_in_view_s = 2;
  config.filter.velocity_noise = 0.05;
  config.filter.likelihood_exponent = 1;
  config.filter.static_prior = 0;
  config.filter.scene_flow = false;
  return config;
}

// A small robot among people.
Config robot_preset() {
  Config config;
  config.grid = {6, 6, 0.05};
  config.vehicle.step_max_m = 0.03;
  config.vehicle.height_m = 0.5;
  config.u_disparity.obstacle_min_height_m = 0.1;
  config.u_disparity.obstacle_height_m = 0.5;
  config.filter.speeds_mps = {0.3, 0.65, 1.1, 1.6, 2.3};
  return config;
}

}  // namespace

Config preset(std::string_view name) {
  if (name == "default") return {};
  if (name == "robot") return robot_preset();
  if (name == "paper") return paper_preset();
  throw ConfigError{"There is no preset '" + std::string{name} + "'. There are: default, robot, paper."};
}

std::vector<std::string> preset_names() {
  return {"default", "robot", "paper"};
}

void set(Config& config, std::string_view key, std::string_view text) {
  constexpr std::array<std::array<std::string_view, 2>, 4> former{{
      {"filter.forgetting_s", "filter.decay_time_s"},
      {"filter.forgetting_in_view_s", "filter.decay_time_in_view_s"},
      {"matching.given_sigma_px", "matching.external_sigma_px"},
      {"motion.notice_jumps", "motion.detect_jumps"},
  }};
  for (const auto& [before, now] : former) {
    if (key == before) return set(config, now, text);
  }
  if (key == "matching.method") {
    if (text == "correlation") return;  // the former default
    throw ConfigError{"matching.method: " + std::string{text} + " (allowed: correlation, the only method). Remove it."};
  }
  // former group of the parameters of `paper`
  const std::string_view before{"u_disparity."};
  if (key.starts_with(before) && !is_parameter(key)) {
    if (const std::string now{"paper." + std::string{key.substr(before.size())}}; is_parameter(now)) {
      return set(config, now, text);
    }
  }
  bool found{false};
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, auto& value) {
    const std::string known{key_of(group, parameter)};
    if (known != key) return;
    found = true;
    if (text.empty()) throw ConfigError{known + " has no value: give one, such as " + text_of_value(value) + "."};
    parse(value, text, known);
  });
  if (!found) throw_unknown_key(key);
}

std::string get(const Config& config, std::string_view key) {
  std::string text;
  bool found{false};
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
    if (key_of(group, parameter) != key) return;
    found = true;
    text = text_of_value(value);
  });
  if (!found) throw_unknown_key(key);
  return text;
}

std::vector<std::string> problems(const Config& config) {
  std::vector<std::string> found;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
    using T = std::remove_cvref_t<decltype(value)>;
    const auto check_range = [&](double number) {
      if (number >= parameter.minimum && number <= parameter.maximum) return;
      found.push_back(key_of(group, parameter) + " is " + text_of(number) + " and must lie in " +
                      text_of(parameter.minimum) + " … " + text_of(parameter.maximum) + ".");
    };
    if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      check_range(static_cast<double>(value));
    } else if constexpr (std::is_same_v<T, List>) {
      std::ranges::for_each(value, check_range);
      if (std::ranges::adjacent_find(value, std::greater_equal{}) == value.end()) return;
      found.push_back(key_of(group, parameter) + " is " + text_of_value(value) +
                      " and must grow from one to the next.");
    } else if constexpr (is_choice<T>) {
      if (is_one_of_its_choices(value)) return;
      found.push_back(key_of(group, parameter) + " is " + text_of_value(value) +
                      " and must be one of:" + names_of_choices<T>() + ".");
    }
  });
  if (config.matching.window_px % 2 == 0) {
    found.push_back("matching.window_px is " + std::to_string(config.matching.window_px) + " and must be odd.");
  }
  add_problems_of_sizes(config, found);
  return found;
}

}  // namespace stereogrid
