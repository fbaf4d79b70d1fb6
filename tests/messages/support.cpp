// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::messages::test {

std::uint32_t Recorder::add(const Channel& channel) {
  channels.push_back(channel);
  return static_cast<std::uint32_t>(channels.size() - 1);
}

bool Recorder::wants(std::uint32_t channel) const {
  return !unwanted.contains(channels.at(channel).topic);
}

void Recorder::send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) {
  sent.push_back({channels.at(channel).topic, stamp_ns, {cdr.begin(), cdr.end()}});
}

std::size_t Recorder::count(const std::string& topic) const {
  return static_cast<std::size_t>(std::ranges::count(sent, topic, &Sent::topic));
}

std::string Recorder::type_of(const std::string& topic) const {
  const auto found{std::ranges::find(channels, topic, &Channel::topic)};
  return found == channels.end() ? "no such topic" : std::string{found->type};
}

Rig small_rig() {
  return {.width_px = 200,
          .height_px = 100,
          .focal_px = 100,
          .cx_px = 99.5,
          .cy_px = 49.5,
          .baseline_m = 0.5,
          .camera_height_m = 1.5};
}

namespace {

GridLayers nothing_observed(const GridGeometry& geometry) {
  const auto layer = [&](float value) { return Image<float>{geometry.nx, geometry.ny, value}; };
  return {.geometry = geometry,
          .occupancy = layer(0.5f),
          .velocity_x = layer(0),
          .velocity_y = layer(0),
          .age_s = layer(std::numeric_limits<float>::infinity()),
          .velocity_xx = layer(0),
          .velocity_xy = layer(0),
          .velocity_yy = layer(0),
          .moving = layer(0)};
}

}  // namespace

FrameResult small_result() {
  FrameResult result;
  result.vehicle = nothing_observed({0, -1.5, 0.5, 8, 6});
  result.world = nothing_observed({-1, 2, 0.5, 5, 4});
  result.observed = Image<float>{8, 6, 0.5f};
  return result;
}

}  // namespace stereogrid::messages::test
