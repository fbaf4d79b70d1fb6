// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "backend/cpu.hpp"
#include "ground/mounting_search.hpp"
#include "images/levelling.hpp"
#include "motion/ego_motion.hpp"
#include "pipeline/checks.hpp"
#include "pipeline/cuda_library.hpp"
#include "pipeline/frame_clock.hpp"
#include "pipeline/frame_processor.hpp"
#include "pipeline/frames_in_flight.hpp"
#include "pipeline/mounting.hpp"
#include "pipeline/results.hpp"
#include "pipeline/saved_state.hpp"
#include "pipeline/stopwatch.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid {

/// Enough disparities for a tenth of the image's width, and for the nearest road that the image shows.
inline int automatic_disparities(const Config& config, const Rig& level_rig) {
  constexpr int disparities_min{64};
  constexpr int disparities_max{256};
  constexpr int disparities_step{16};
  const RoadPlane road{road_plane(level_rig, calibrated_ground(level_rig, config.ground))};
  const int last_row{level_rig.height_px - 1};
  const double nearest_px{std::max(road.disparity(0, last_row), road.disparity(level_rig.width_px - 1, last_row))};
  const int wanted{std::max({level_rig.width_px / 10, config.matching.min_disparity + 2,
                             clamped_to_int(std::clamp(nearest_px, 0.0, 1.0 * disparities_max)) + 2})};
  return std::clamp((wanted + disparities_step - 1) / disparities_step * disparities_step, disparities_min,
                    disparities_max);
}

/// With every "automatic" value.
inline Config resolved(Config config, const Rig& level_rig) {
  if (config.matching.disparities == 0) config.matching.disparities = automatic_disparities(config, level_rig);
  return config;
}

/// A pipeline's threads, for stages that have none.
class OwnThreads final : public HostThreads {
 public:
  explicit OwnThreads(Cpu& cpu) : cpu_{cpu} {}

  [[nodiscard]] int count() const override { return cpu_.threads(); }
  void for_ranges(int count, const std::function<void(int, int)>& work) override { cpu_.for_ranges(count, 8, work); }
  void together(const std::function<void()>& first, const std::function<void()>& second) override {
    cpu_.together(first, second);
  }

 private:
  Cpu& cpu_;
};

/// What lies behind a Pipeline: what its frames need besides the stages, and how a frame goes to them.
struct Pipeline::Implementation {
  Implementation(const Config& parameters, const Rig& given_rig, const PipelineOptions& asked)
      : config{resolved(parameters, LevelMapping{given_rig}.level_rig())},
        calibrated_rig{given_rig},
        rig{given_rig},
        options{asked},
        levelling{rig},
        cpu{options.threads},
        processor{make_processor()} {
    make_level_images();
    make_room(config.grid, options.horizons_s, result);
    make_room(config, levelling.level_rig(), options.stages ? result.stages : unwanted_stages);
    window = result.world.geometry;
    ego_motion.start_at(options.start);
  }

  struct Started {
    const StereoFrame* frame{nullptr};
    LevelFrame input;
  };

  void make_level_images() {
    const Rig& level_rig{levelling.level_rig()};
    level_left = level_right = Image<std::uint8_t>{level_rig.width_px, level_rig.height_px};
    level_disparity = Image<float>{level_rig.width_px, level_rig.height_px};
  }

  std::unique_ptr<FrameProcessor> make_processor() {
    const Rig& level_rig{levelling.level_rig()};
    auto made{std::make_unique<FrameProcessor>(
        config, level_rig, start(), rig.camera_pitch_rad - level_rig.camera_pitch_rad, options.extrinsics_given)};
    made->stages().fetch_stages(options.stages);
    made->stages().keep(result);
    made->take_mask(PixelMask{options.mask, LevelMapping{rig}});
    if (!options.horizons_s.empty()) made->stages().make_room_for_predictions();
    return made;
  }

  // As if this rig had been given; the world goes on. All stages are built anew.
  void mount(const Rig& mounted) {
    const Rig before{rig};
    ahead = nullptr;
    try {
      rig = mounted;
      levelling = Levelling{rig};
      std::unique_ptr<FrameProcessor> made{make_processor()};
      made->follow_on(*processor);
      make_level_images();
      processor = std::move(made);
    } catch (...) {
      rig = before;
      levelling = Levelling{rig};
      make_level_images();
      throw;
    }
  }

  void take_mounting(FrameResult& into) {
    const std::optional<Ground> found{processor->found_mounting()};
    if (!found) return;
    const Rig& level_rig{levelling.level_rig()};
    mount(as_written(mounted_as(rig, seen_from(*found, rig.camera_pitch_rad - level_rig.camera_pitch_rad))));
    into.warnings.push_back(sentence_of_mounting(rig));
  }

  // Sets `back_end` where it was left open.
  std::unique_ptr<Stages> start() {
    const Rig& level_rig{levelling.level_rig()};
    BackEnd& used{options.back_end};
    if (used == BackEnd::reference) return reference_stages(config, level_rig);
    if (used == BackEnd::cuda) return start_on_gpu();
    if (used == BackEnd::automatic) {
      try {
        std::unique_ptr<Stages> on_gpu{start_on_gpu()};
        used = BackEnd::cuda;
        return on_gpu;
      } catch (const DeviceError& error) {  // also: predictions, which only the CPU can make
        why_not_cuda = error.what();
        used = BackEnd::cpu;
      }
    }
    return cpu_stages(config, level_rig, options.threads);
  }

  [[nodiscard]] std::unique_ptr<Stages> start_on_gpu() {
    if (!options.horizons_s.empty()) throw DeviceError{"Predictions are supported on the CPU only."};
    std::unique_ptr<Stages> stages{cuda_stages(config, levelling.level_rig(), options.device)};
    stages->lend(own_threads);
    return stages;
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
    processor->forget();
  }

  // Seconds since the frame before; 0: this is a first one.
  double tick(const StereoFrame& frame, FrameResult& into) {
    into.status.clear();
    into.warnings.clear();
    FrameClock::Tick tick{clock.tick(frame.stamp_ns)};
    if (!tick.leap) return tick.dt_s;
    forget();
    into.status.push_back(*tick.leap);
    into.warnings.push_back(std::move(tick.warning));
    return 0;
  }

  // World is the vehicle frame of the first frame.
  Pose2 place(const StereoFrame& frame, double dt_s, FrameResult& into) {
    EgoMotion::Placing placing{ego_motion.place(frame.world_from_vehicle, dt_s)};
    if (!placing.warning.empty()) into.warnings.push_back(std::move(placing.warning));
    if (placing.status) into.status.push_back(*placing.status);
    return placing.world_from_vehicle;
  }

  // What the stages take: level images.
  LevelFrame input_of(const StereoFrame& frame, bool is_ahead, FrameResult& into) {
    const double dt_s{tick(frame, into)};
    const Pose2 before{ego_motion.world_from_vehicle()};
    const Pose2 world_from_vehicle{place(frame, dt_s, into)};
    const double travelled_m{dt_s > 0 && frame.world_from_vehicle
                                 ? std::hypot(world_from_vehicle.x_m - before.x_m, world_from_vehicle.y_m - before.y_m)
                                 : std::numeric_limits<double>::infinity()};
    const double focal_baseline_pxm{rig.focal_px * rig.baseline_m};
    const CameraView view{world_from_vehicle, rig.centre_u_px / rig.focal_px,
                          (rig.width_px - rig.centre_u_px) / rig.focal_px, focal_baseline_pxm * travelled_m,
                          focal_baseline_pxm};
    if (!levelling.is_needed()) {
      return {frame.left.view(),
              frame.right.view(),
              frame.disparity.view(),
              world_from_vehicle,
              dt_s,
              frame.other_grids,
              view,
              is_ahead};
    }
    if (!is_ahead) level(frame);
    return {level_left.view(),
            level_right.view(),
            frame.disparity.empty() ? View<const float>{} : level_disparity.view(),
            world_from_vehicle,
            dt_s,
            frame.other_grids,
            view,
            is_ahead};
  }

  void level(const StereoFrame& frame) {
    levelling.apply(cpu, frame.left.view(), level_left.view());
    if (!frame.right.empty()) levelling.apply(cpu, frame.right.view(), level_right.view());
    if (!frame.disparity.empty()) levelling.apply(cpu, frame.disparity.view(), level_disparity.view());
  }

  // Those of the frame behind the one in work go to the device.
  void take_next_images() {
    const auto next = next_frame();
    if (!next || !next->frame.disparity.empty()) return;
    if (levelling.is_needed()) {
      level(next->frame);
      processor->stages().take_ahead(level_left.view(), level_right.view());
    } else {
      processor->stages().take_ahead(next->frame.left.view(), next->frame.right.view());
    }
    ahead = &next->frame;
  }

  // The device matches the frame behind the one in work, unless that one must be done with first.
  void start_next() {
    const auto next = next_frame();
    if (!next || processor->found_mounting() || FrameClock{clock}.tick(next->frame.stamp_ns).leap) return;
    const FrameClock clock_before{clock};
    const EgoMotion motion_before{ego_motion};
    try {
      const bool is_ahead{std::exchange(ahead, nullptr) == &next->frame};
      started = {&next->frame, input_of(next->frame, is_ahead, next->result)};
      processor->start(started.input, next->result);
    } catch (...) {  // told when it is its turn
      started = {};
      clock = clock_before;
      ego_motion = motion_before;
    }
  }

  // The one behind the frame in work, if it is there and can be used.
  [[nodiscard]] std::optional<FramesInFlight::Waiting> next_frame() {
    auto next = in_flight ? in_flight->next() : std::nullopt;
    try {
      if (next) check_frame(next->frame);
    } catch (const InputError&) {  // told when it is its turn
      return std::nullopt;
    }
    return next;
  }

  template <class State>
  void exchange(State& state) {
    state(clock, ego_motion);
    Rig mounted{rig};
    state(mounted);
    if constexpr (std::is_same_v<State, StateWriter>) {
      processor->save(state);
    } else {
      const bool is_rig{problems(mounted).empty() && mounted_as(rig, mounting_of(mounted)) == mounted};
      state.require(is_rig && (mounted == rig || !options.extrinsics_given));
      if (is_rig && mounted != rig) mount(mounted);
      processor->load(state);
    }
  }

  // The result's stages are the pipeline's own where nobody wants them: the stages work in them.
  void process(const StereoFrame& frame, FrameResult& into) {
    const Started begun{std::exchange(started, {})};
    const bool is_begun{begun.frame == &frame};
    const bool is_ahead{std::exchange(ahead, nullptr) == &frame};
    if (!is_begun) check_frame(frame);
    Stopwatch watch;
    make_room(config.grid, options.horizons_s, into);
    if (!options.stages) into.stages = std::exchange(unwanted_stages, {});
    make_room(config, levelling.level_rig(), into.stages);
    const LevelFrame input{is_begun ? begun.input : input_of(frame, is_ahead, into)};
    if (!is_begun) processor->start(input, into);
    processor->finish(input, into, {[this] { take_next_images(); }, [this] { start_next(); }});
    if (!into.predictions.empty()) processor->stages().predict(input.world_from_vehicle, into);
    if (!options.stages) unwanted_stages = std::exchange(into.stages, {});
    into.world_from_vehicle = input.world_from_vehicle;
    window = into.world.geometry;
    take_mounting(into);
    into.timing_ms.total = watch.lap();
  }

  Config config;
  Rig calibrated_rig;
  Rig rig;  // with the mounting that was found, if the calibration's did not fit
  PipelineOptions options;
  Levelling levelling;
  Cpu cpu;
  OwnThreads own_threads{cpu};
  std::string why_not_cuda;
  std::unique_ptr<FrameProcessor> processor;
  const StereoFrame* ahead{nullptr};  // whose images the stages have, of frames in flight
  Started started;                    // the frame in flight that the processor has started
  Image<std::uint8_t> level_left;
  Image<std::uint8_t> level_right;
  Image<float> level_disparity;
  FrameResult result;
  StageImages unwanted_stages;
  GridGeometry window;  // where it lay in the last frame
  FrameClock clock{config.motion.gap_max_s};
  EgoMotion ego_motion{config.motion, options.in_world_of_poses};
  std::optional<FramesInFlight> in_flight;  // from the first submit() on; last, as its thread works with all the rest
};

}  // namespace stereogrid
