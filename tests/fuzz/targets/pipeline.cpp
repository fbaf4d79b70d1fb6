// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/pipeline.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

constexpr int largest_width_px{96};
constexpr int largest_height_px{64};

double mostly(Choices& choices, double least, double most) {
  return choices.once_in(16) ? choices.any_number() : choices.number(least, most);
}

int choose_size(Choices& choices, int largest) {
  return choices.once_in(32) ? choices.between(-1, 0) : largest - choices.between(0, largest - 1);
}

template <class T>
void change(Choices& choices, const Parameter& parameter, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = choices.yes();
  } else if constexpr (std::is_enum_v<T>) {
    const int count{static_cast<int>(names_of(T{}).size())};
    value = static_cast<T>(choices.once_in(16) ? choices.between(-1, count) : choices.between(0, count - 1));
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    value.resize(static_cast<std::size_t>(choices.between(0, 4)));
    for (double& number : value) number = mostly(choices, parameter.minimum, parameter.maximum);
    if (!choices.once_in(16)) std::ranges::sort(value);
  } else if constexpr (std::is_integral_v<T>) {
    const auto least{static_cast<T>(parameter.minimum)};
    const auto most{static_cast<T>(parameter.maximum)};
    value = choices.once_in(16) ? static_cast<T>(choices.any_integer()) : choices.between(least, most);
  } else {
    value = mostly(choices, parameter.minimum, parameter.maximum);
  }
}

void change_some(Choices& choices, Config& config) {
  int count{0};
  visit_parameters(config, [&count](std::string_view, const Parameter&, auto&) { ++count; });
  for (int changes{choices.between(0, 12)}; changes > 0; --changes) {
    int left{choices.between(0, count - 1)};
    visit_parameters(config, [&](std::string_view, const Parameter& parameter, auto& value) {
      if (left-- == 0) change(choices, parameter, value);
    });
  }
}

void fill(Choices& choices, Image<std::uint8_t>& image) {
  const int kind{choices.between(0, 3)};
  std::uint32_t state{choices.byte() + 1U};
  for (int v{0}; v < image.height(); ++v) {
    for (int u{0}; u < image.width(); ++u) {
      state = state * 1664525U + 1013904223U;
      const auto noise{static_cast<std::uint8_t>(state >> 24)};
      const int checks{(u / 5 + v / 3) % 2 * 160 + noise / 8};
      image(u, v) = kind == 0   ? noise
                    : kind == 1 ? static_cast<std::uint8_t>(checks)
                    : kind == 2 ? static_cast<std::uint8_t>(u * 7 + v * v)
                                : static_cast<std::uint8_t>(state == 0);
    }
  }
}

/// As another camera would see it: farther right by a disparity that grows downwards from `horizon`.
Image<std::uint8_t> shifted(const Image<std::uint8_t>& image, int disparity_px, int horizon, int rows_down) {
  Image<std::uint8_t> moved{image};
  for (int v{0}; v < image.height(); ++v) {
    const int from_v{std::clamp(v - rows_down, 0, image.height() - 1)};
    const int shift{disparity_px + std::max(0, v - horizon) / 2};
    for (int u{0}; u < image.width(); ++u) {
      moved(u, v) = image(std::clamp(u + shift, 0, image.width() - 1), from_v);
    }
  }
  return moved;
}

Image<float> choose_disparities(Choices& choices, int width, int height) {
  Image<float> image{width, height};
  const int kind{choices.between(0, 3)};
  const auto first{static_cast<float>(mostly(choices, 0, 40))};
  const auto second{static_cast<float>(mostly(choices, 0, 2))};
  for (int v{0}; v < height; ++v) {
    for (int u{0}; u < width; ++u) {
      image(u, v) = kind == 0   ? first
                    : kind == 1 ? second * static_cast<float>(v)
                    : kind == 2 ? ((u + v) % 3 == 0 ? first : second)
                                : (u * 3 > width && u * 2 < width ? first : second * static_cast<float>(v));
    }
  }
  return image;
}

Image<float> choose_shares(Choices& choices, int nx, int ny) {
  Image<float> image{nx, ny, static_cast<float>(mostly(choices, 0, 1))};
  if (!image.empty()) *(image.end() - 1) = static_cast<float>(mostly(choices, 0, 1));
  return image;
}

ObservedGrid choose_grid(Choices& choices) {
  ObservedGrid grid;
  grid.geometry = {mostly(choices, -10, 10), mostly(choices, -10, 10), mostly(choices, 0.05, 2), choices.between(0, 30),
                   choices.between(0, 30)};
  const int more{choices.once_in(16) ? 1 : 0};
  grid.occupancy = choose_shares(choices, grid.geometry.nx + more, grid.geometry.ny);
  if (choices.yes()) grid.confidence = choose_shares(choices, grid.geometry.nx, grid.geometry.ny);
  return grid;
}

std::int64_t choose_stamp(Choices& choices, std::int64_t last_ns) {
  if (choices.once_in(8)) return choices.any_integer();
  const std::int64_t step_ns{1'000'000LL * choices.between(1, 256)};
  return last_ns > std::numeric_limits<std::int64_t>::max() - step_ns ? last_ns : last_ns + step_ns;
}

/// Small images, mostly of a camera that could be.
Rig choose_rig(Choices& choices) {
  Rig rig;
  rig.width_px = choose_size(choices, largest_width_px);
  rig.height_px = choose_size(choices, largest_height_px);
  rig.focal_px = mostly(choices, 20, 150);
  rig.cx_px = choices.yes() ? rig.width_px / 2.0 : mostly(choices, -20, 120);
  rig.cy_px = choices.yes() ? rig.height_px / 2.0 : mostly(choices, -20, 120);
  rig.baseline_m = mostly(choices, 0.05, 2);
  rig.camera_height_m = mostly(choices, 0.2, 3);
  if (choices.yes()) rig.camera_pitch_rad = mostly(choices, -0.8, 0.8);
  if (choices.yes()) rig.camera_roll_rad = mostly(choices, -0.8, 0.8);
  return rig;
}

/// A preset with some parameters changed, mostly within their ranges.
Config choose_config(Choices& choices) {
  Config config{preset(choices.once_in(4) ? "paper" : "default")};
  config.grid = {6, 4, 0.4};
  config.filter.speeds_mps = {2.5, 5};
  change_some(choices, config);
  return config;
}

/// True: it takes no more memory and time than a try may.
bool is_small(const Config& config) {
  const double cells{
      std::hypot(config.grid.length_m + config.grid.rear_m, config.grid.width_m) / config.grid.cell_size_m + 4};
  const double side{2 * static_cast<double>(config.filter.speeds_mps.size()) + 1};
  return !problems(config).empty() || cells * cells * side * side < 200'000;
}

Pose2 choose_pose(Choices& choices) {
  return {mostly(choices, -3, 3), mostly(choices, -3, 3), mostly(choices, -0.5, 0.5)};
}

/// Mostly one that fits the rig and comes after `last_stamp_ns`.
StereoFrame choose_frame(Choices& choices, const Rig& rig, std::int64_t last_stamp_ns) {
  StereoFrame frame;
  frame.name = "000000";
  frame.stamp_ns = choose_stamp(choices, last_stamp_ns);
  const int more{choices.once_in(32) ? 1 : 0};
  frame.left = Image<std::uint8_t>{rig.width_px, rig.height_px + more};
  fill(choices, frame.left);
  if (choices.once_in(4)) {
    frame.disparity = choose_disparities(choices, rig.width_px, rig.height_px);
  } else if (choices.once_in(8)) {
    frame.right = Image<std::uint8_t>{rig.width_px, rig.height_px};
    fill(choices, frame.right);
  } else {
    const int disparity_px{choices.between(0, 40)};
    const int horizon{choices.between(0, largest_height_px)};
    frame.right = shifted(frame.left, disparity_px, horizon, choices.between(-3, 3));
  }
  if (choices.yes()) frame.world_from_vehicle = choose_pose(choices);
  for (int grids{choices.once_in(4) ? choices.between(1, 2) : 0}; grids > 0; --grids) {
    frame.other_grids.push_back(choose_grid(choices));
  }
  return frame;
}

template <class Values, class Condition>
void require_all(const Values& values, const std::string& name, const char* what, Condition fine) {
  for (const auto value : values) {
    if (!fine(value)) throw Finding{name + " holds " + std::to_string(value) + ", which is not " + what};
  }
}

void check_probabilities(const Image<float>& image, const std::string& name) {
  require_all(image, name, "within 0 … 1", [](float p) { return p >= 0 && p <= 1; });
}

void check_finite(const Image<float>& image, const std::string& name) {
  require_all(image, name, "finite", [](float x) { return std::isfinite(x); });
}

void check_not_negative(const Image<float>& image, const std::string& name) {
  require_all(image, name, "a size", [](float x) { return x >= 0; });
}

void check_layers(const GridLayers& layers, const std::string& name) {
  check_probabilities(layers.occupancy, name + ".occupancy");
  check_probabilities(layers.moving, name + ".moving");
  check_not_negative(layers.age_s, name + ".age_s");
  check_finite(layers.velocity_x, name + ".velocity_x");
  check_finite(layers.velocity_y, name + ".velocity_y");
  check_finite(layers.velocity_xy, name + ".velocity_xy");
  for (const auto* variance : {&layers.velocity_xx, &layers.velocity_yy}) {
    check_finite(*variance, name + "'s velocity variance");
    check_not_negative(*variance, name + "'s velocity variance");
  }
  const GridGeometry& geometry{layers.geometry};
  require(std::isfinite(geometry.x_min_m) && std::isfinite(geometry.y_min_m), name + " is nowhere");
}

void check_obstacle(const Obstacle& o) {
  const std::vector<double> numbers{o.x_m,
                                    o.y_m,
                                    o.vx_mps,
                                    o.vy_mps,
                                    o.length_m,
                                    o.width_m,
                                    o.yaw_rad,
                                    o.occupancy,
                                    o.age_s,
                                    o.unseen_s,
                                    o.position_covariance.xx,
                                    o.position_covariance.xy,
                                    o.position_covariance.yy,
                                    o.velocity_covariance.xx,
                                    o.velocity_covariance.xy,
                                    o.velocity_covariance.yy};
  require_all(numbers, "an obstacle", "finite", [](double x) { return std::isfinite(x); });
  require(o.occupancy >= 0 && o.occupancy <= 1, "an obstacle's occupancy is not a probability");
  require(o.length_m >= 0 && o.width_m >= 0 && o.age_s >= 0 && o.unseen_s >= 0, "an obstacle has a negative size");
}

void check_ground(const Ground& ground) {
  const std::vector<double> numbers{ground.height_m,       ground.pitch_rad,       ground.roll_rad,
                                    ground.height_sigma_m, ground.pitch_sigma_rad, ground.roll_sigma_rad};
  require_all(numbers, "the ground", "finite", [](double x) { return std::isfinite(x); });
  require(ground.height_m > 0, "the camera is under the ground");
}

void check_stages(const StageImages& stages) {
  for (const auto* disparity : {&stages.obstacle_disparity, &stages.road_disparity}) {
    check_finite(*disparity, "a disparity");
    check_not_negative(*disparity, "a disparity");
  }
  check_probabilities(stages.match_confidence, "match_confidence");
  check_probabilities(stages.visibility, "visibility");
  check_probabilities(stages.obstacle_confidence, "obstacle_confidence");
  check_probabilities(stages.road_confidence, "road_confidence");
  check_probabilities(stages.occupancy, "stages.occupancy");
  check_probabilities(stages.occupancy_smooth, "stages.occupancy_smooth");
}

/// Throws Finding where a number is not what its name promises: no probability, not finite, …
void check_result(const FrameResult& result) {
  check_ground(result.ground);
  const Pose2& pose{result.world_from_vehicle};
  require(std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad), "a pose is not finite");
  require(result.obstacle_density >= 0 && result.obstacle_density <= 1, "a density is not a share");
  require(result.road_density >= 0 && result.road_density <= 1, "a density is not a share");
  check_probabilities(result.observed, "observed");
  check_layers(result.vehicle, "vehicle");
  check_layers(result.world, "world");
  for (const Prediction& prediction : result.predictions) {
    check_probabilities(prediction.occupancy, "a prediction");
    check_probabilities(prediction.world_occupancy, "a prediction");
  }
  std::ranges::for_each(result.obstacles, check_obstacle);
  check_stages(result.stages);
  require(std::ranges::is_sorted(result.status), "the status is out of order");
}

PipelineOptions choose_options(Choices& choices, BackEnd back_end) {
  PipelineOptions options{.back_end = back_end, .threads = 1, .stages = choices.yes()};
  if (choices.once_in(4)) {
    for (int count{choices.between(0, 3)}; count > 0; --count) {
      options.horizons_s.push_back(choices.once_in(4) ? choices.any_number() : choices.number(0.1, 3));
    }
  }
  if (choices.once_in(8)) options.start = choose_pose(choices);
  return options;
}

void drive(Choices& choices, Pipeline& pipeline) {
  if (choices.once_in(8) && choices.between(0, 1000) > 500) pipeline.reset();
  FrameResult kept;
  std::int64_t stamp_ns{choices.once_in(8) ? choices.any_integer() : 0};
  for (int frames{choices.between(1, 5)}; frames > 0; --frames) {
    const StereoFrame frame{choose_frame(choices, pipeline.rig(), stamp_ns)};
    const bool used{accepts([&] {
      if (!choices.once_in(4)) return check_result(pipeline.process(frame));
      pipeline.process(frame, kept);
      check_result(kept);
    })};
    if (used) stamp_ns = frame.stamp_ns;
  }
}

}  // namespace

/// Decisions.
FUZZ_TARGET(pipeline) {
  Choices choices{input};
  const BackEnd back_end{choices.once_in(3) ? BackEnd::reference : BackEnd::cpu};
  Rig rig{choose_rig(choices)};
  if (back_end == BackEnd::reference) {  // it compares every pixel of every window
    rig.width_px = std::min(rig.width_px, 24);
    rig.height_px = std::min(rig.height_px, 16);
  }
  const Config config{choose_config(choices)};
  if (!is_small(config)) return;
  const PipelineOptions options{choose_options(choices, back_end)};
  std::optional<Pipeline> pipeline;
  if (!accepts([&] { pipeline.emplace(config, rig, options); })) return;
  drive(choices, *pipeline);
}

}  // namespace stereogrid::fuzz
