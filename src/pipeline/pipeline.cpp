// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pipeline.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "backend/cpu.hpp"
#include "images/levelling.hpp"
#include "matching/correlation/correlate_simd.hpp"
#include "motion/ego_motion.hpp"
#include "pipeline/checks.hpp"
#include "pipeline/cuda_library.hpp"
#include "pipeline/frame_clock.hpp"
#include "pipeline/frame_processor.hpp"
#include "pipeline/results.hpp"
#include "pipeline/saved_state.hpp"
#include "pipeline/stopwatch.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr int disparities_min{64};
constexpr int disparities_step{16};

Config resolved(Config config, const Rig& rig) {
  if (config.matching.disparities == 0) {
    const int tenth{(rig.width_px / 10 + disparities_step - 1) / disparities_step * disparities_step};
    config.matching.disparities = std::clamp(std::max(tenth, config.matching.min_disparity + 2), disparities_min, 256);
  }
  return config;
}

std::string_view name_of(BackEnd back_end) {
  return back_end == BackEnd::cuda ? "cuda" : back_end == BackEnd::reference ? "reference" : "cpu";
}

// Of all that must be the same for a saved state to be loaded.
std::uint64_t settings_of(const Config& config, const Rig& rig, BackEnd back_end) {
  std::string text{version()};
  text += name_of(back_end);
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    const std::string key{std::string{group} + "." + std::string{parameter.name}};
    text += "\n" + key + "=" + get(config, key);
  });
  StateWriter numbers;
  Rig same{rig};
  numbers(same);
  return checksum_of(numbers.bytes()) ^ checksum_of(std::as_bytes(std::span{text}));
}

}  // namespace

struct Pipeline::Implementation {
  Implementation(const Config& parameters, const Rig& given_rig, BackEnd back_end, int threads)
      : config{resolved(parameters, given_rig)},
        rig{given_rig},
        levelling{rig},
        cpu{threads},
        used{back_end},
        processor{config, levelling.level_rig(), start(threads)},
        level_left{rig.width_px, rig.height_px},
        level_right{rig.width_px, rig.height_px},
        level_disparity{rig.width_px, rig.height_px} {
    result = empty_result(config, levelling.level_rig());
  }

  // Sets `used` where it was left open.
  std::unique_ptr<Stages> start(int threads) {
    const Rig& level_rig{levelling.level_rig()};
    if (used == BackEnd::reference) return reference_stages(config, level_rig);
    if (used == BackEnd::cuda) return cuda_stages(config, level_rig);
    if (used == BackEnd::automatic) {
      try {
        std::unique_ptr<Stages> on_gpu{cuda_stages(config, level_rig)};
        used = BackEnd::cuda;
        return on_gpu;
      } catch (const DeviceError& error) {  // also: a configuration that only the CPU can do
        why_not_cuda = error.what();
        used = BackEnd::cpu;
      }
    }
    return cpu_stages(config, level_rig, threads);
  }

  void check_frame(const StereoFrame& frame) const {
    check(frame, rig);
    if (clock.stands_still(frame.stamp_ns)) {
      throw InputError{"frame " + frame.name, "its stamp is that of the frame before.",
                       "Every frame needs a stamp of its own."};
    }
  }

  // What is remembered is of another time.
  void forget() {
    ego_motion.restart();
    processor.forget();
  }

  // Seconds since the frame before; 0: this is a first one.
  double tick(const StereoFrame& frame) {
    result.status.clear();
    result.warnings.clear();
    FrameClock::Tick tick{clock.tick(frame.stamp_ns)};
    if (!tick.leap) return tick.dt_s;
    forget();
    result.status.push_back(*tick.leap);
    result.warnings.push_back(std::move(tick.warning));
    return 0;
  }

  // World is the vehicle frame of the first frame.
  Pose2 place(const StereoFrame& frame, double dt_s) {
    EgoMotion::Placing placing{ego_motion.place(frame.world_from_vehicle, dt_s)};
    if (!placing.warning.empty()) result.warnings.push_back(std::move(placing.warning));
    if (placing.status) result.status.push_back(*placing.status);
    return placing.world_from_vehicle;
  }

  // What the stages take: level images.
  LevelFrame input_of(const StereoFrame& frame) {
    const double dt_s{tick(frame)};
    if (!levelling.is_needed()) {
      return {frame.left.view(), frame.right.view(), frame.disparity.view(), place(frame, dt_s), dt_s,
              frame.other_grids};
    }
    levelling.apply(cpu, frame.left.view(), level_left.view());
    if (!frame.right.empty()) levelling.apply(cpu, frame.right.view(), level_right.view());
    if (!frame.disparity.empty()) levelling.apply(cpu, frame.disparity.view(), level_disparity.view());
    return {level_left.view(),
            level_right.view(),
            frame.disparity.empty() ? View<const float>{} : level_disparity.view(),
            place(frame, dt_s),
            dt_s,
            frame.other_grids};
  }

  template <class State>
  void exchange(State& state) {
    state(clock, ego_motion);
    if constexpr (std::is_same_v<State, StateWriter>) {
      processor.save(state);
    } else {
      processor.load(state);
    }
  }

  Config config;
  Rig rig;
  Levelling levelling;
  Cpu cpu;
  BackEnd used;
  std::string why_not_cuda;
  FrameProcessor processor;
  Image<std::uint8_t> level_left;
  Image<std::uint8_t> level_right;
  Image<float> level_disparity;
  FrameResult result;
  bool are_stages_wanted{true};
  std::optional<StageImages> unwanted_stages;  // between two frames; the stages work in their images
  FrameClock clock{config.motion.gap_max_s};
  EgoMotion ego_motion{config.motion};
};

Pipeline::Pipeline(const Config& config, const Rig& rig, BackEnd back_end, int threads) {
  check(config, rig, back_end, threads);
  implementation_ = std::make_unique<Implementation>(config, rig, back_end, threads);
}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

Pipeline::Implementation& Pipeline::implementation() const {
  if (!implementation_) throw std::logic_error{"This Pipeline has been moved from: its work goes on in another one."};
  return *implementation_;
}

const FrameResult& Pipeline::process(const StereoFrame& frame) {
  Implementation& self{implementation()};
  self.check_frame(frame);
  Stopwatch watch;
  FrameResult& result{self.result};
  const LevelFrame input{self.input_of(frame)};
  if (self.unwanted_stages) result.stages = *std::exchange(self.unwanted_stages, std::nullopt);
  self.processor.run(input, result);
  if (!result.predictions.empty()) self.processor.stages().predict(input.world_from_vehicle, result);
  result.world_from_vehicle = input.world_from_vehicle;
  if (!self.are_stages_wanted) self.unwanted_stages = std::exchange(result.stages, {});
  result.timing_ms.total = watch.lap();
  return result;
}

void Pipeline::reset() {
  Implementation& self{implementation()};
  self.clock.reset();
  self.forget();
}

const Config& Pipeline::config() const {
  return implementation().config;
}
const Rig& Pipeline::rig() const {
  return implementation().rig;
}
GridGeometry Pipeline::vehicle_grid() const {
  return implementation().result.vehicle.geometry;
}
GridGeometry Pipeline::world_grid() const {
  return implementation().result.world.geometry;
}
int Pipeline::threads() const {
  return implementation().processor.stages().threads();
}
MemoryUse Pipeline::memory_use() const {
  const Implementation& self{implementation()};
  MemoryUse use{self.processor.memory_use()};
  use.host_bytes += sizeof self + held_bytes_of(self.result, self.level_left, self.level_right, self.level_disparity);
  if (self.unwanted_stages) use.host_bytes += held_bytes(*self.unwanted_stages);
  return use;
}
BackEnd Pipeline::back_end() const {
  return implementation().used;
}
const std::string& Pipeline::why_not_cuda() const {
  return implementation().why_not_cuda;
}
const Rig& Pipeline::level_rig() const {
  return implementation().levelling.level_rig();
}
void Pipeline::fetch_stages(bool wanted) {
  Implementation& self{implementation()};
  self.are_stages_wanted = wanted;
  self.processor.stages().fetch_stages(wanted);
}
void Pipeline::start_at(const Pose2& world_from_vehicle) {
  Implementation& self{implementation()};
  if (!is_place(world_from_vehicle)) {
    throw ConfigError{"The vehicle's place at the start must be finite, and within 1e9 m of the world's origin."};
  }
  self.ego_motion.start_at(world_from_vehicle);
}
void Pipeline::predict_at(const std::vector<double>& horizons_s) {
  Implementation& self{implementation()};
  check_horizons(horizons_s);
  std::vector<Prediction> predictions;
  for (const double horizon_s : horizons_s) {
    const GridGeometry& window{self.result.world.geometry};
    predictions.push_back({horizon_s, Image<float>{self.result.vehicle.geometry.nx, self.result.vehicle.geometry.ny},
                           Image<float>{window.nx, window.ny}});
  }
  if (!predictions.empty() && self.used == BackEnd::cuda) {
    throw ConfigError{"The CUDA back end does not predict. Take the CPU (--device cpu)."};
  }
  if (!predictions.empty()) self.processor.stages().make_room_for_predictions();
  self.result.predictions = std::move(predictions);
}
std::vector<std::byte> Pipeline::save_state() const {
  Implementation& self{implementation()};
  StateWriter state;
  state(self);
  return sealed(state.bytes(), settings_of(self.config, self.rig, self.used));
}
void Pipeline::load_state(std::span<const std::byte> saved) {
  Implementation& self{implementation()};
  StateReader state{unsealed(saved, settings_of(self.config, self.rig, self.used))};
  state(self);
  if (state.fits()) return;
  reset();  // what was read so far makes no sense
  throw InputError{"saved state", "does not fit this pipeline.", "Begin without it."};
}

std::string_view simd_target() {
  return correlate_target();
}

}  // namespace stereogrid
