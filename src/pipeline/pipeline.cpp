// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pipeline.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "held_bytes.hpp"
#include "matching/correlation/correlate_simd.hpp"
#include "pipeline/implementation.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

std::string_view name_of(BackEnd back_end) {
  return back_end == BackEnd::cuda ? "cuda" : back_end == BackEnd::reference ? "reference" : "cpu";
}

// Of all that must be the same for a saved state to be loaded.
std::uint64_t settings_of(const Config& config, const Rig& rig, const PipelineOptions& options) {
  std::string text{version()};
  text += name_of(options.back_end);
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    const std::string key{std::string{group} + "." + std::string{parameter.name}};
    text += "\n" + key + "=" + get(config, key);
  });
  text += options.extrinsics_given ? "\nextrinsics given" : "";
  StateWriter numbers;
  Rig same{rig};
  Image<std::uint8_t> mask{options.mask};
  numbers(same, mask);
  return checksum_of(numbers.bytes()) ^ checksum_of(std::as_bytes(std::span{text}));
}

}  // namespace

static_assert(Pipeline::in_flight_max == FramesInFlight::frames_max);

Pipeline::Pipeline(const Config& config, const Rig& rig, const PipelineOptions& options) {
  check(config, rig, options);
  implementation_ = std::make_unique<Implementation>(config, rig, options);
}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

Pipeline::Implementation& Pipeline::implementation() const {
  if (!implementation_) throw std::logic_error{"This Pipeline has been moved from: its work goes on in another one."};
  return *implementation_;
}

Pipeline::Implementation& Pipeline::at_rest() const {
  if (in_flight() > 0) throw std::logic_error{"Frames are in flight: collect() them first."};
  return implementation();
}

const FrameResult& Pipeline::process(const StereoFrame& frame) {
  Implementation& self{at_rest()};
  self.process(frame, self.result);
  return self.result;
}

void Pipeline::process(const StereoFrame& frame, FrameResult& into) {
  at_rest().process(frame, into);
}

void Pipeline::submit(StereoFrame frame) {
  Implementation& self{implementation()};
  if (in_flight() == in_flight_max) throw std::logic_error{"Two frames are in flight: collect() is due."};
  if (!self.in_flight) {
    self.in_flight.emplace([&self](const StereoFrame& one, FrameResult& into) { self.process(one, into); });
  }
  self.in_flight->submit(std::move(frame));
}

const FrameResult& Pipeline::collect() {
  if (in_flight() == 0) throw std::logic_error{"No frame is in flight: submit() one first."};
  return implementation().in_flight->collect();
}

int Pipeline::in_flight() const {
  const Implementation& self{implementation()};
  return self.in_flight ? static_cast<int>(self.in_flight->size()) : 0;
}

void Pipeline::reset() {
  Implementation& self{at_rest()};
  self.clock.reset();
  self.forget();
}

const Config& Pipeline::config() const {
  return implementation().config;
}
const Rig& Pipeline::rig() const {
  return at_rest().rig;
}
const Rig& Pipeline::level_rig() const {
  return at_rest().levelling.level_rig();
}
GridGeometry Pipeline::vehicle_grid() const {
  return vehicle_grid_of(implementation().config.grid);
}
GridGeometry Pipeline::world_grid() const {
  return at_rest().window;
}
int Pipeline::threads() const {
  return at_rest().processor->stages().threads();
}
MemoryUse Pipeline::memory_use() const {
  const Implementation& self{at_rest()};
  MemoryUse use{self.processor->memory_use()};
  use.host_bytes += sizeof self + held_bytes_of(self.options.mask, self.result, self.unwanted_stages, self.level_left,
                                                self.level_right, self.level_disparity);
  if (self.in_flight) use.host_bytes += self.in_flight->held_bytes();
  return use;
}
BackEnd Pipeline::back_end() const {
  return implementation().options.back_end;
}
const std::string& Pipeline::why_not_cuda() const {
  return implementation().why_not_cuda;
}
std::vector<std::byte> Pipeline::save_state() const {
  Implementation& self{at_rest()};
  StateWriter state;
  state(self);
  return sealed(state.bytes(), settings_of(self.config, self.calibrated_rig, self.options));
}
void Pipeline::load_state(std::span<const std::byte> saved) {
  Implementation& self{at_rest()};
  StateReader state{unsealed(saved, settings_of(self.config, self.calibrated_rig, self.options))};
  state(self);
  if (state.fits()) return;
  reset();  // what was read so far makes no sense
  throw InputError{"saved state", "does not fit this pipeline.", "Begin without it."};
}

std::string_view simd_target() {
  return correlate_target();
}

}  // namespace stereogrid
