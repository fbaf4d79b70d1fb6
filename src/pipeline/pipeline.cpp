// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pipeline.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "backend/cpu.hpp"
#include "matching/correlation/simd.hpp"
#include "memory_bytes.hpp"
#include "pipeline/cuda_library.hpp"
#include "pipeline/frame_input.hpp"
#include "pipeline/frame_pipeline.hpp"
#include "pipeline/results.hpp"
#include "pipeline/saved_state.hpp"
#include "pipeline/stages.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

// Enough disparities for a tenth of the image's width, and for the nearest road that the image shows.
int automatic_disparities(const Rig& level_rig, bool extrinsics_given) {
  const int disparities_min{extrinsics_given ? 64 : 128};  // ground of unknown extrinsics may be near
  constexpr int disparities_max{256};
  constexpr int disparities_step{16};
  const RoadPlane road{road_plane(level_rig, extrinsics_of(level_rig))};
  const int last_row{level_rig.height_px - 1};
  const double nearest_px{std::max(road.disparity(0, last_row), road.disparity(level_rig.width_px - 1, last_row))};
  const int wanted{
      std::max(level_rig.width_px / 10, clamped_to_int(std::clamp(nearest_px, 0.0, 1.0 * disparities_max)) + 2)};
  return std::clamp((wanted + disparities_step - 1) / disparities_step * disparities_step, disparities_min,
                    disparities_max);
}

// With every "automatic" value. A depth z = f·b/d has the standard deviation z²·σ_d/(f·b).
Config resolved(Config config, const Rig& level_rig, bool extrinsics_given) {
  MatchingConfig& matching{config.matching};
  if (matching.disparities == 0) matching.disparities = automatic_disparities(level_rig, extrinsics_given);
  if (matching.external_sigma_per_m > 0) {
    const double sigma_px{matching.external_sigma_per_m * level_rig.focal_px * level_rig.baseline_m};
    matching.external_sigma_px = std::min(sigma_px, 10.0);
  }
  return config;
}

std::string_view name_of(BackEnd back_end) {
  return back_end == BackEnd::cuda ? "cuda" : back_end == BackEnd::reference ? "reference" : "cpu";
}

// Checksum of all that must be equal for a saved state to be loaded.
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

// Throws std::logic_error where another thread holds the flag.
class Exclusive {
 public:
  explicit Exclusive(std::atomic_flag& flag) : flag_{flag} {
    if (flag.test_and_set(std::memory_order_acquire)) {
      throw std::logic_error{"This Pipeline is in use by another thread. Give each thread a pipeline of its own."};
    }
  }
  Exclusive(const Exclusive&) = delete;
  Exclusive& operator=(const Exclusive&) = delete;
  ~Exclusive() { flag_.clear(std::memory_order_release); }

 private:
  std::atomic_flag& flag_;
};

}  // namespace

/// Behind a Pipeline: input conversion, the frame pipeline and its result.
struct Pipeline::Implementation {
  Implementation(const Config& parameters, const Rig& given, const PipelineOptions& asked)
      : given_rig{given},
        config{resolved(parameters, LevelMapping{given}.level_rig(), asked.extrinsics_given)},
        options{asked},
        is_automatic{asked.back_end == BackEnd::automatic},
        cpu{options.back_end == BackEnd::reference ? 1 : options.threads},
        input{config.motion, given, options},
        frames{make_frames(given, false)} {
    make_room(config, options.horizons_s, result);
    make_room(config, input.level_rig(), options.stages ? result.stages : unwanted_stages);
    window = result.world.geometry;
  }

  std::unique_ptr<FramePipeline> make_frames(const Rig& rig, bool is_estimated) {
    const LevelMapping mapping{rig};
    const Rig& level_rig{mapping.level_rig()};
    return std::make_unique<FramePipeline>(config, level_rig, cpu,
                                           make_stages(level_rig, PixelMask{options.mask, mapping}),
                                           rig.camera_pitch_rad - level_rig.camera_pitch_rad, mode(is_estimated));
  }

  [[nodiscard]] GroundMode mode(bool is_estimated) const {
    if (options.extrinsics_given) return GroundMode::given;
    return is_estimated ? GroundMode::found : GroundMode::assumed;
  }

  // Sets options.back_end where it is automatic.
  std::unique_ptr<Stages> make_stages(const Rig& level_rig, PixelMask mask) {
    const StagesOptions wanted{options.stages, !options.horizons_s.empty(), &result, std::move(mask)};
    BackEnd& used{options.back_end};
    if (used == BackEnd::cuda) return make_cuda_stages(level_rig, wanted);
    if (used == BackEnd::automatic) {
      try {
        std::unique_ptr<Stages> on_gpu{make_cuda_stages(level_rig, wanted)};
        used = BackEnd::cuda;
        return on_gpu;
      } catch (const DeviceError& error) {  // also: predictions, which only the CPU makes
        why_not_cuda = error.what();
        used = BackEnd::cpu;
      }
    }
    return used == BackEnd::reference ? reference_stages(config, level_rig, cpu, wanted)
                                      : cpu_stages(config, level_rig, cpu, wanted);
  }

  [[nodiscard]] std::unique_ptr<Stages> make_cuda_stages(const Rig& level_rig, const StagesOptions& wanted) const {
    if (wanted.predictions) throw DeviceError{"Predictions are supported on the CPU only."};
    return cuda_stages(config, level_rig, options.device, wanted);
  }

  // Without StagesOptions::stage_images the stages work in images of the pipeline's own.
  void process(const StereoFrame& frame, const FrameImages& images, FrameResult& into) {
    input.check(frame, images);
    if (is_unfinished) reset();
    const FrameInput::Moment before{input.moment()};
    Stopwatch watch;
    try {
      if (const std::optional<Ground> found{process_anywhere(frame, images, into, before)}) {
        std::string message{use_extrinsics(*found)};
        input.rewind(before);  // the frame gets a grid, too
        static_cast<void>(process_anywhere(frame, images, into, before));
        into.warnings.push_back({std::move(message)});
      }
    } catch (...) {
      input.rewind(before);  // the frame may be given again
      throw;
    }
    is_unfinished = false;
    into.timing_ms.total = watch.lap();
  }

  // A GPU that is lost, or whose driver fails: `automatic` continues on the CPU.
  std::optional<Ground> process_anywhere(const StereoFrame& frame, const FrameImages& images, FrameResult& into,
                                         const FrameInput::Moment& before) {
    try {
      return process_on_rig(frame, images, into);
    } catch (const DeviceError& error) {
      if (!is_automatic || options.back_end != BackEnd::cuda) throw;
      why_not_cuda = error.what();
    }
    input.rewind(before);
    options.back_end = BackEnd::cpu;
    set_rig(Rig{input.rig()}, has_estimate);
    const std::optional<Ground> found{process_on_rig(frame, images, into)};
    into.add(FrameStatus::gpu_lost,
             "the GPU has failed: " + why_not_cuda + " The CPU continues, with the state reset.");
    return found;
  }

  // Returns extrinsics that replace the rig's.
  std::optional<Ground> process_on_rig(const StereoFrame& frame, const FrameImages& images, FrameResult& into) {
    make_room(config, options.horizons_s, into);
    if (!options.stages) into.stages = std::exchange(unwanted_stages, {});
    make_room(config, input.level_rig(), into.stages);
    into.status.clear();
    into.warnings.clear();
    into.rig = input.rig();
    into.level_rig = input.level_rig();

    const LevelFrame converted{input.convert(frame, images, cpu, into)};
    set_mask(frame.labels);
    is_unfinished = true;
    const std::optional<Ground> found{frames->process(converted, into)};

    if (!options.stages) unwanted_stages = std::exchange(into.stages, {});
    into.world_from_vehicle = converted.world_from_vehicle;
    window = into.world.geometry;
    return found;
  }

  // Pixels to ignore are masked in one frame, beside those of the vehicle itself.
  void set_mask(const Image<std::uint8_t>& labels) {
    const auto is_ignored = [](std::uint8_t label) { return label == static_cast<std::uint8_t>(PixelLabel::ignore); };
    const bool ignores{std::ranges::any_of(labels, is_ignored)};
    if (!ignores && !is_mask_of_frame) return;
    Image<std::uint8_t> mask{options.mask};
    if (ignores && mask.empty()) {
      mask = Image<std::uint8_t>{labels.width(), labels.height()};
      mask.fill(255);
    }
    for (std::size_t i{0}; ignores && i < labels.size(); ++i) {
      if (is_ignored(labels.data()[i])) mask.data()[i] = 0;
    }
    frames->set_mask(PixelMask{mask, LevelMapping{input.rig()}});
    is_mask_of_frame = ignores;
  }

  // Returns the message.
  std::string use_extrinsics(const Ground& found) {
    const Rig rig{as_written(with_extrinsics(input.rig(), seen_from(found, input.turned_rad())))};
    set_rig(rig, true);  // may equal the assumed extrinsics
    return extrinsics_message(rig);
  }

  // Rebuilds all stages; time, world and ids continue. Nothing has changed where it throws.
  void set_rig(const Rig& rig, bool is_estimated) {
    std::unique_ptr<FramePipeline> made{make_frames(rig, is_estimated)};
    made->continue_from(*frames);
    input.set_rig(rig);
    has_estimate = is_estimated;
    frames = std::move(made);
    is_unfinished = false;
  }

  void reset() {
    is_unfinished = true;
    input.restart();
    frames->reset();
    is_unfinished = false;
  }

  [[nodiscard]] std::vector<std::byte> save() {
    if (is_unfinished) reset();
    StateWriter state;
    Rig rig{input.rig()};
    std::uint8_t is_estimated{has_estimate ? std::uint8_t{1} : std::uint8_t{0}};
    state(input, rig, is_estimated);
    frames->exchange(state);
    return sealed(state.bytes(), settings_of(config, given_rig, options));
  }

  // Loads into new stages: nothing has changed where it throws.
  void load(std::span<const std::byte> saved) {
    const auto require = [](bool fits) {
      if (!fits) throw InputError{"saved state", "does not fit this pipeline.", "Begin without it."};
    };
    StateReader state{unsealed(saved, settings_of(config, given_rig, options))};
    FrameInput loaded{input};
    Rig rig{given_rig};
    std::uint8_t is_estimated{0};
    state(loaded, rig, is_estimated);
    require(problems(rig).empty() && with_extrinsics(given_rig, extrinsics_of(rig)) == rig &&
            (rig == input.rig() || !options.extrinsics_given));
    if (rig != input.rig()) loaded.set_rig(rig);
    std::unique_ptr<FramePipeline> made{make_frames(rig, is_estimated != 0)};
    made->exchange(state);
    require(state.fits());
    static_assert(std::is_nothrow_move_assignable_v<FrameInput>);
    has_estimate = is_estimated != 0;
    input = std::move(loaded);
    frames = std::move(made);
    is_unfinished = false;
  }

  Rig given_rig;
  Config config;
  PipelineOptions options;
  bool is_automatic;
  bool has_estimate{false};  // extrinsics were estimated
  Cpu cpu;
  std::string why_not_cuda;
  FrameResult result;
  FrameInput input;
  std::unique_ptr<FramePipeline> frames;
  StageImages unwanted_stages;
  GridGeometry window;           // window of the last frame
  bool is_mask_of_frame{false};  // the stages' mask has pixels that the last frame ignores
  bool is_unfinished{false};     // the stages have begun a frame that has thrown: the next one starts anew
  std::atomic_flag in_use;
};

Pipeline::Pipeline(const Config& config, const Rig& rig, const PipelineOptions& options) {
  check(config, rig, options);
  implementation_ = std::make_unique<Implementation>(config, rig, options);
}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

Pipeline::Implementation& Pipeline::implementation() const {
  if (!implementation_) throw std::logic_error{"This Pipeline has been moved from. Use the one it was moved to."};
  return *implementation_;
}

const FrameResult& Pipeline::process(const StereoFrame& frame) {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  self.process(frame, frame, self.result);
  return self.result;
}

void Pipeline::process(const StereoFrame& frame, FrameResult& into) {
  process(frame, frame, into);
}

void Pipeline::process(const StereoFrame& frame, const FrameImages& images, FrameResult& into) {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  self.process(frame, images, into);
}

void Pipeline::reset() {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  self.reset();
}

const Config& Pipeline::config() const {
  return implementation().config;
}
const Rig& Pipeline::rig() const {
  return implementation().given_rig;
}
const Rig& Pipeline::next_rig() const {
  return implementation().input.rig();
}
GridGeometry Pipeline::vehicle_grid() const {
  return vehicle_grid_of(implementation().config.grid);
}
GridGeometry Pipeline::world_grid() const {
  return implementation().window;
}
int Pipeline::threads() const {
  return implementation().cpu.threads();
}
MemoryUse Pipeline::memory_use() const {
  const Implementation& self{implementation()};
  MemoryUse use{self.frames->memory_use()};
  use.host_bytes +=
      sizeof self + self.input.memory_bytes() + memory_bytes_of(self.options.mask, self.result, self.unwanted_stages);
  return use;
}
BackEnd Pipeline::back_end() const {
  return implementation().options.back_end;
}
const std::string& Pipeline::why_not_cuda() const {
  return implementation().why_not_cuda;
}
std::vector<std::byte> Pipeline::save_state() const {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  return self.save();
}
void Pipeline::load_state(std::span<const std::byte> saved) {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  self.load(saved);
}

std::string_view simd_target() {
  return correlate_target();
}

}  // namespace stereogrid
