// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "backend/cpu.hpp"
#include "cuda_library.hpp"
#include "ego_motion/ego_motion.hpp"
#include "journey.hpp"
#include "levelling/levelling.hpp"
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

void check(const Config& config, const Rig& rig) {
  std::vector<std::string> found{problems(config)};
  const auto require = [&](bool fine, const char* problem) {
    if (!fine) found.emplace_back(problem);
  };
  require(rig.width_px > 0 && rig.height_px > 0, "rig: the image size must be positive.");
  require(std::max(rig.width_px, rig.height_px) <= 16384, "rig: images of up to 16384 × 16384 can be matched.");
  require(rig.height_px <= 2047 || !config.u_disparity.confidence_weights,
          "u_disparity.confidence_weights can count in images of up to 2047 rows.");
  require(rig.focal_px > 0, "rig: focal_px must be positive.");
  require(rig.baseline_m > 0, "rig: baseline_m must be positive (left camera minus right camera, in metres).");
  require(rig.camera_height_m > 0, "rig: camera_height_m must be positive.");
  require(std::abs(rig.camera_pitch_rad) < 0.8, "rig: camera_pitch_rad must be within ±0.8 (45°).");
  require(config.matching.disparities != 1, "matching.disparities must be 0 (automatic) or at least 2.");
  require(config.matching.disparities < 2 || config.matching.min_disparity <= config.matching.disparities - 2,
          "matching.min_disparity must be at least 2 below matching.disparities.");
  if (found.empty()) return;
  std::string message;
  for (const std::string& problem : found) message += (message.empty() ? "" : "\n") + problem;
  throw ConfigError{message};
}

void check_grid(const ObservedGrid& grid, const std::string& frame_name) {
  const GridGeometry& geometry{grid.geometry};
  const auto fits = [&](const auto& image) { return image.width() == geometry.nx && image.height() == geometry.ny; };
  const auto are_shares = [](const auto& image) {
    return std::all_of(image.begin(), image.end(), [](float p) { return p >= 0 && p <= 1; });
  };
  const auto require = [&](bool fine, const char* problem, const char* remedy) {
    if (!fine) throw InputError{"frame " + frame_name, problem, remedy};
  };
  require(std::isfinite(geometry.x_min_m) && std::isfinite(geometry.y_min_m) && std::isfinite(geometry.cell_size_m) &&
              geometry.cell_size_m > 0,
          "another source's grid has no place.", "Its origin and cell size must be finite, cells larger than 0.");
  require(fits(grid.occupancy) && (grid.confidence.empty() || fits(grid.confidence)),
          "another source's grid does not have its geometry's size.",
          "Occupancy and confidence must be nx × ny cells; confidence may be left empty.");
  require(are_shares(grid.occupancy) && are_shares(grid.confidence),
          "another source's grid has values that are no probabilities.",
          "Occupancy and confidence must lie in 0 … 1; unknown is 0.5.");
}

}  // namespace

struct Pipeline::Implementation {
  Implementation(const Config& parameters, const Rig& given_rig, BackEnd back_end, int threads)
      : config{resolved(parameters, given_rig)},
        rig{given_rig},
        levelling{rig},
        cpu{threads},
        used{back_end},
        journey{start(threads)},
        level_left{rig.width_px, rig.height_px},
        level_right{rig.width_px, rig.height_px},
        level_disparity{rig.width_px, rig.height_px} {
    result = empty_result(config, levelling.level_rig());
  }

  // Sets `used` where it was left open.
  std::unique_ptr<Journey> start(int threads) {
    const Rig& level_rig{levelling.level_rig()};
    if (used == BackEnd::reference) return reference_journey(config, level_rig);
    if (used == BackEnd::cuda) return cuda_journey(config, level_rig);
    if (used == BackEnd::automatic) {
      try {
        std::unique_ptr<Journey> on_gpu{cuda_journey(config, level_rig)};
        used = BackEnd::cuda;
        return on_gpu;
      } catch (const DeviceError& error) {  // also: a configuration that only the CPU can do
        why_not_cuda = error.what();
        used = BackEnd::cpu;
      }
    }
    return cpu_journey(config, level_rig, threads);
  }

  void check_frame(const StereoFrame& frame) const {
    if (frame.right.empty() == frame.disparity.empty()) {
      throw InputError{"frame " + frame.name,
                       frame.right.empty() ? "has neither a right image nor disparities."
                                           : "has both a right image and disparities.",
                       "Give one of them."};
    }
    const auto fits = [&](const auto& image) {
      return image.empty() || (image.width() == rig.width_px && image.height() == rig.height_px);
    };
    if (frame.left.empty() || !fits(frame.left) || !fits(frame.right) || !fits(frame.disparity)) {
      throw InputError{"frame " + frame.name, "the images do not have the calibration's size.",
                       "Both must be " + std::to_string(rig.width_px) + " × " + std::to_string(rig.height_px) + "."};
    }
    if (last_stamp_ns && frame.stamp_ns <= *last_stamp_ns) {
      throw InputError{"frame " + frame.name, "its stamp is not after that of the frame before.",
                       "Frames must come in the order of their stamps."};
    }
    const Pose2 pose{frame.world_from_vehicle.value_or(Pose2{})};
    if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !std::isfinite(pose.yaw_rad)) {
      throw InputError{"frame " + frame.name, "its pose is not finite.", "Give numbers, or leave the pose out."};
    }
    for (const ObservedGrid& grid : frame.other_grids) check_grid(grid, frame.name);
  }

  // World is the vehicle frame of the first frame.
  Pose2 place(const StereoFrame& frame, double dt_s) {
    result.warnings.clear();
    result.status.clear();
    EgoMotion::Placing placing{ego_motion.place(frame.world_from_vehicle, dt_s)};
    if (!placing.warning.empty()) result.warnings.push_back(std::move(placing.warning));
    return placing.world_from_vehicle;
  }

  // What the stages take: level images.
  JourneyInput input_of(const StereoFrame& frame) {
    const double dt_s{last_stamp_ns ? static_cast<double>(frame.stamp_ns - *last_stamp_ns) * 1e-9 : 0.0};
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

  Config config;
  Rig rig;
  Levelling levelling;
  Cpu cpu;
  BackEnd used;
  std::string why_not_cuda;
  std::unique_ptr<Journey> journey;
  Image<std::uint8_t> level_left;
  Image<std::uint8_t> level_right;
  Image<float> level_disparity;
  FrameResult result;
  bool are_stages_wanted{true};
  std::optional<StageImages> unwanted_stages;  // between two frames; the stages work in their images
  std::optional<std::int64_t> last_stamp_ns;
  EgoMotion ego_motion{config.motion};
};

Pipeline::Pipeline(const Config& config, const Rig& rig, BackEnd back_end, int threads) {
  check(config, rig);
  implementation_ = std::make_unique<Implementation>(config, rig, back_end, threads);
}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

const FrameResult& Pipeline::process(const StereoFrame& frame) {
  Implementation& self{*implementation_};
  self.check_frame(frame);
  Stopwatch watch;
  FrameResult& result{self.result};
  const JourneyInput input{self.input_of(frame)};
  self.last_stamp_ns = frame.stamp_ns;
  if (self.unwanted_stages) result.stages = *std::exchange(self.unwanted_stages, std::nullopt);
  self.journey->run(input, result);
  if (!result.predictions.empty()) self.journey->predict(input.world_from_vehicle, result);
  result.world_from_vehicle = input.world_from_vehicle;
  if (!self.are_stages_wanted) self.unwanted_stages = std::exchange(result.stages, {});
  result.timing_ms.total = watch.lap();
  return result;
}

const Config& Pipeline::config() const {
  return implementation_->config;
}
const Rig& Pipeline::rig() const {
  return implementation_->rig;
}
GridGeometry Pipeline::vehicle_grid() const {
  return implementation_->result.vehicle_grid;
}
GridGeometry Pipeline::world_grid() const {
  return implementation_->result.world.geometry;
}
int Pipeline::threads() const {
  return implementation_->journey->threads();
}
BackEnd Pipeline::back_end() const {
  return implementation_->used;
}
const std::string& Pipeline::why_not_cuda() const {
  return implementation_->why_not_cuda;
}
void Pipeline::fetch_stages(bool wanted) {
  implementation_->are_stages_wanted = wanted;
  implementation_->journey->fetch_stages(wanted);
}
void Pipeline::start_at(const Pose2& world_from_vehicle) {
  implementation_->ego_motion.start_at(world_from_vehicle);
}
void Pipeline::predict_at(const std::vector<double>& horizons_s) {
  Implementation& self{*implementation_};
  std::vector<Prediction> predictions;
  for (const double horizon_s : horizons_s) {
    if (!(horizon_s > 0) || !std::isfinite(horizon_s)) {
      throw ConfigError{"Predictions need horizons in seconds, more than 0, as in 0.5,1,2."};
    }
    const GridGeometry& window{self.result.world.geometry};
    predictions.push_back({horizon_s, Image<float>{self.result.vehicle_grid.nx, self.result.vehicle_grid.ny},
                           Image<float>{window.nx, window.ny}});
  }
  if (!predictions.empty() && self.used == BackEnd::cuda) {
    throw ConfigError{"The CUDA back end does not predict. Take the CPU (--device cpu)."};
  }
  self.result.predictions = std::move(predictions);
}
void Pipeline::start_ids_at(std::int64_t first_id) {
  implementation_->journey->start_ids_at(first_id);
}

}  // namespace stereogrid
