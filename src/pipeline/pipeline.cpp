// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pipeline.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <iterator>
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
#include "pipeline/settings.hpp"
#include "pipeline/stages.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

// Throws std::logic_error where another thread holds the flag.
class Exclusive {
 public:
  explicit Exclusive(std::atomic_flag& flag) : flag_{flag} {
    if (flag.test_and_set(std::memory_order_acquire)) {
      throw std::logic_error{
          "This Pipeline is in use by another thread or called by its own on_grids. Give each thread a pipeline of its "
          "own, and call it when process() has returned."};
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
  Implementation(const Config& parameters, std::span<const Rig> given, const PipelineOptions& asked)
      : given_rigs(given.begin(), given.end()),
        options{asked},
        is_automatic{asked.back_end == BackEnd::automatic},
        has_estimate(given.size()),
        cpu{options.back_end == BackEnd::reference ? 1 : options.threads},
        input{parameters, given, options},
        is_mask_of_frame(given.size()) {
    for (std::size_t i{0}; i < cameras(); ++i) {
      configs.push_back(resolved(parameters, given, i, asked.extrinsics_given));
      if (cameras() > 1) camera_names.push_back(name_of_camera(options, i));
    }
    frames = make_frames(given_rigs, has_estimate);
    unwanted_stages.resize(cameras());
    frames_in.reserve(cameras());
    begin(result);
    end(result);
    window = result.world.geometry;
  }

  [[nodiscard]] std::size_t cameras() const { return given_rigs.size(); }
  [[nodiscard]] const Config& config() const { return configs.front(); }

  // Sets options.back_end where it is automatic.
  std::unique_ptr<FramePipeline> make_frames(const std::vector<Rig>& rigs, const std::vector<std::uint8_t>& estimated) {
    if (options.back_end == BackEnd::automatic) {
      options.back_end = BackEnd::cuda;
      try {
        return make_frames(rigs, estimated);
      } catch (const DeviceError& error) {  // also: what only the CPU supports
        why_not_cuda = error.what();
        options.back_end = BackEnd::cpu;
      }
    }
    std::vector<CameraSetup> setups;
    for (std::size_t i{0}; i < rigs.size(); ++i) {
      const LevelMapping mapping{rigs[i]};
      const Rig& level_rig{mapping.level_rig()};
      setups.push_back({configs[i], level_rig, make_stages(i, level_rig, PixelMask{mask_of(options, i), mapping}),
                        rigs[i].camera_pitch_rad - level_rig.camera_pitch_rad, mode(estimated[i] != 0)});
    }
    return std::make_unique<FramePipeline>(config(), cpu, std::move(setups));
  }

  [[nodiscard]] GroundMode mode(bool is_estimated) const {
    if (options.extrinsics_given) return GroundMode::given;
    return is_estimated ? GroundMode::found : GroundMode::assumed;
  }

  std::unique_ptr<Stages> make_stages(std::size_t camera, const Rig& level_rig, PixelMask mask) {
    const bool is_first{camera == 0};
    const StagesOptions wanted{options.stages,
                               is_first && !options.horizons_s.empty(),
                               is_first ? &result : nullptr,
                               std::move(mask),
                               is_first,
                               [this](int count, const auto& work) { cpu.for_ranges(count, 1, work); }};
    if (options.back_end == BackEnd::cuda) {
      if (wanted.predictions) throw DeviceError{"Predictions are supported on the CPU only."};
      return cuda_stages(configs[camera], level_rig, options.device, wanted);
    }
    return options.back_end == BackEnd::reference ? reference_stages(configs[camera], level_rig, cpu, wanted)
                                                  : cpu_stages(configs[camera], level_rig, cpu, wanted);
  }

  void process(const StereoFrame& frame, const FrameImages& images, FrameResult& into) {
    const bool has_others{cameras() > 1};
    if (has_others && frame.others.size() >= cameras()) {
      throw InputError{title_of(frame), "has more frames than the pipeline has cameras.", "Give one of each camera."};
    }
    frames_in.clear();
    const bool has_images{!images.left.empty() || !images.right.empty() || !images.disparity.empty()};
    if (has_images || frame.others.empty() || !has_others) frames_in.push_back({frame, images});
    for (const StereoFrame& other : frame.others) {
      if (has_others) frames_in.push_back({other, other});
    }
    process_frames(into);
  }

  void process(const StereoFrame& frame, const DeviceImages& images, FrameResult& into) {
    const auto sized_as = []<class T>(View<const T, Device> view) {
      return View<const T>{view.data, view.width, view.height, view.pitch};
    };
    frames_in.clear();
    frames_in.push_back({frame, {sized_as(images.left), sized_as(images.right), sized_as(images.disparity)}});
    input.check(frames_in);  // reads no pixels
    for (const std::ptrdiff_t pitch : {images.left.pitch, images.right.pitch, images.disparity.pitch}) {
      if (pitch < 0) throw InputError{title_of(frame), "has a negative pitch in device memory.", "Turn the image."};
    }
    frames->fetch(frame.camera, images, fetched);
    process(frame, static_cast<FrameImages>(fetched), into);
  }

  // Without StagesOptions::stage_images the stages work in images of the pipeline's own.
  void process_frames(FrameResult& into) {
    input.check(frames_in);
    if (is_unfinished) reset();
    const FrameInput::Moment before{input.moment()};
    is_repeated = false;
    Stopwatch watch;
    try {
      const std::span<const NewExtrinsics> found{process_anywhere(into, before)};
      if (!found.empty()) {
        std::vector<Warning> messages{use_extrinsics(found)};
        input.rewind(before);  // the frame gets a grid, too
        static_cast<void>(process_anywhere(into, before));
        std::ranges::move(messages, std::back_inserter(into.warnings));
      }
    } catch (...) {
      input.rewind(before);  // the frame may be given again
      throw;
    }
    is_unfinished = false;
    if (!std::exchange(has_checked_views, true)) check_views(into);
    if (options.on_grids && is_repeated) options.on_grids(into);
    into.timing_ms.total = watch.lap();
  }

  void check_views(FrameResult& into) const {
    for (std::size_t i{0}; i < cameras(); ++i) {
      if (contains_view(into.vehicle.geometry, given_rigs[i])) continue;
      into.warnings.push_back({prefix_of(i) +
                               "directions of the camera's view lie outside of the grid. Set grid.rear_m, "
                               "grid.length_m or grid.width_m."});
    }
  }

  [[nodiscard]] std::string prefix_of(std::size_t camera) const {
    return cameras() == 1 ? "" : camera_names[camera] + ": ";
  }

  // A GPU that is lost, or whose driver fails: `automatic` continues on the CPU.
  std::span<const NewExtrinsics> process_anywhere(FrameResult& into, const FrameInput::Moment& before) {
    try {
      return process_on_rigs(into);
    } catch (const DeviceError& error) {
      if (!is_automatic || options.back_end != BackEnd::cuda) throw;
      why_not_cuda = error.what();
    }
    input.rewind(before);
    is_repeated = true;
    options.back_end = BackEnd::cpu;
    set_rigs(rigs(), has_estimate);
    const std::span<const NewExtrinsics> found{process_on_rigs(into)};
    into.add(FrameStatus::gpu_lost,
             "the GPU has failed: " + why_not_cuda + " The CPU continues, with the state reset.");
    return found;
  }

  [[nodiscard]] FrameResult& seen_by(std::size_t camera, FrameResult& into) const {
    return cameras() == 1 ? into : into.cameras[camera];
  }

  // Allocates missing images of `into`, and clears values that a frame may leave unset.
  void begin(FrameResult& into) {
    make_room(config(), options.horizons_s, into);
    into.cameras.resize(cameras() == 1 ? 0 : cameras());
    if (cameras() > 1) std::swap(into.stages, into.cameras.front().stages);
    into.status.clear();
    into.warnings.clear();
    for (std::size_t i{0}; i < cameras(); ++i) {
      const CameraInput& camera{input.camera(i)};
      FrameResult& seen{seen_by(i, into)};
      if (cameras() > 1) {
        begin_camera(config(), seen);
        seen.camera_name = camera_names[i];
      }
      if (!options.stages) seen.stages = std::exchange(unwanted_stages[i], {});
      make_room(configs[i], camera.level_rig(), seen.stages);
      seen.rig = camera.rig();
      seen.level_rig = camera.level_rig();
    }
    into.rig = input.camera(0).rig();
    into.level_rig = input.camera(0).level_rig();
  }

  // Stages of the first camera are the result's own.
  void end(FrameResult& into) {
    for (std::size_t i{0}; i < cameras() && !options.stages; ++i)
      unwanted_stages[i] = std::exchange(seen_by(i, into).stages, {});
    if (cameras() > 1) std::swap(into.stages, into.cameras.front().stages);
  }

  // Returns extrinsics that replace those of rigs: the frame has to be computed again.
  std::span<const NewExtrinsics> process_on_rigs(FrameResult& into) {
    begin(into);
    const FrameSet& converted{input.convert(frames_in, cpu, into)};
    for (const CameraImages& one : frames_in) set_mask(one.frame);
    is_unfinished = true;
    const auto on_grids = [&](std::span<const NewExtrinsics> found) {
      end(into);
      into.world_from_vehicle = converted.world_from_vehicle;
      window = into.world.geometry;
      is_repeated |= !found.empty();
      if (options.on_grids && !is_repeated) options.on_grids(into);
    };
    return frames->process(converted, into, std::cref(on_grids));  // a reference: without an allocation
  }

  // Pixels to ignore are masked in one frame, beside those of the vehicle itself.
  void set_mask(const StereoFrame& frame) {
    const auto camera = static_cast<std::size_t>(frame.camera);
    const Image<std::uint8_t>& labels{frame.labels};
    const auto is_ignored = [](std::uint8_t label) { return label == static_cast<std::uint8_t>(PixelLabel::ignore); };
    const bool ignores{std::ranges::any_of(labels, is_ignored)};
    if (!ignores && is_mask_of_frame[camera] == 0) return;
    Image<std::uint8_t> mask{mask_of(options, camera)};
    if (ignores && mask.empty()) {
      mask = Image<std::uint8_t>{labels.width(), labels.height()};
      mask.fill(255);
    }
    for (std::size_t i{0}; ignores && i < labels.size(); ++i) {
      if (is_ignored(labels.data()[i])) mask.data()[i] = 0;
    }
    frames->set_mask(frame.camera, PixelMask{mask, LevelMapping{input.camera(camera).rig()}});
    is_mask_of_frame[camera] = ignores ? 1 : 0;
  }

  [[nodiscard]] std::vector<Rig> rigs() const {
    std::vector<Rig> all;
    for (std::size_t i{0}; i < cameras(); ++i) all.push_back(input.camera(i).rig());
    return all;
  }

  // Returns the messages.
  std::vector<Warning> use_extrinsics(std::span<const NewExtrinsics> found) {
    std::vector<Rig> all{rigs()};
    std::vector<std::uint8_t> estimated{has_estimate};
    std::vector<Warning> messages;
    for (const NewExtrinsics& one : found) {
      const auto camera = static_cast<std::size_t>(one.camera);
      Rig& rig{all[camera]};
      rig = as_written(with_extrinsics(rig, seen_from(one.ground, input.camera(camera).turned_rad())));
      estimated[camera] = 1;
      messages.push_back({prefix_of(camera) + extrinsics_message(rig)});
    }
    set_rigs(all, estimated);  // may equal the assumed extrinsics
    return messages;
  }

  // Rebuilds all stages; time, world and ids continue. Nothing has changed where it throws.
  void set_rigs(const std::vector<Rig>& all, const std::vector<std::uint8_t>& estimated) {
    std::unique_ptr<FramePipeline> made{make_frames(all, estimated)};
    made->continue_from(*frames);
    for (std::size_t i{0}; i < cameras(); ++i) input.set_rig(i, all[i]);
    has_estimate = estimated;
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
    std::vector<Rig> all{rigs()};
    state(input, all, has_estimate);
    frames->exchange(state);
    return sealed(state.bytes(), settings_of(config(), given_rigs, options));
  }

  // Loads into new stages: nothing has changed where it throws.
  void load(std::span<const std::byte> saved) {
    const auto require = [](bool fits) {
      if (!fits) throw InputError{"saved state", "does not fit this pipeline.", "Begin without it."};
    };
    StateReader state{unsealed(saved, settings_of(config(), given_rigs, options))};
    FrameInput loaded{input};
    std::vector<Rig> all;
    std::vector<std::uint8_t> estimated;
    state(loaded, all, estimated);
    require(all.size() == cameras() && estimated.size() == cameras());
    for (std::size_t i{0}; i < cameras(); ++i) {
      const Rig& rig{all[i]};
      require(problems(rig).empty() && with_extrinsics(given_rigs[i], extrinsics_of(rig)) == rig &&
              (rig == input.camera(i).rig() || !options.extrinsics_given));
      if (rig != input.camera(i).rig()) loaded.set_rig(i, rig);
    }
    std::unique_ptr<FramePipeline> made{make_frames(all, estimated)};
    made->exchange(state);
    require(state.fits());
    static_assert(std::is_nothrow_move_assignable_v<FrameInput>);
    has_estimate = std::move(estimated);
    input = std::move(loaded);
    frames = std::move(made);
    is_unfinished = false;
    has_checked_views = true;  // in an earlier frame
  }

  std::vector<Rig> given_rigs;
  std::vector<Config> configs;            // by camera
  std::vector<std::string> camera_names;  // names of several cameras
  PipelineOptions options;
  bool is_automatic;
  std::vector<std::uint8_t> has_estimate;  // by camera: extrinsics were estimated
  Cpu cpu;
  std::string why_not_cuda;
  FrameResult result;
  StereoFrame fetched;  // images of process_from_device()
  FrameInput input;
  std::unique_ptr<FramePipeline> frames;
  std::vector<StageImages> unwanted_stages;    // by camera
  std::vector<CameraImages> frames_in;         // frames in work, by camera
  GridGeometry window;                         // window of the last frame
  std::vector<std::uint8_t> is_mask_of_frame;  // by camera: the mask has pixels that its last frame ignores
  bool has_checked_views{false};
  bool is_repeated{false};    // the frame in work is computed again
  bool is_unfinished{false};  // the stages have begun a frame that has thrown: the next one starts anew
  std::atomic_flag in_use;
};

Pipeline::Pipeline(const Config& config, std::span<const Rig> rigs, const PipelineOptions& options) {
  check(config, rigs, options);
  implementation_ = std::make_unique<Implementation>(config, rigs, options);
}
Pipeline::Pipeline(const Config& config, const Rig& rig, const PipelineOptions& options)
    : Pipeline{config, std::span{&rig, 1}, options} {}
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

void Pipeline::process_from_device(const StereoFrame& frame, const DeviceImages& images, FrameResult& into) {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  self.process(frame, images, into);
}

DeviceGrids Pipeline::device_grids() {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  return self.frames->device_grids();
}

void Pipeline::reset() {
  Implementation& self{implementation()};
  const Exclusive use{self.in_use};
  self.reset();
}

const Config& Pipeline::config() const {
  return implementation().config();
}
const Rig& Pipeline::rig() const {
  return implementation().given_rigs.front();
}
std::span<const Rig> Pipeline::rigs() const {
  return implementation().given_rigs;
}
const std::vector<std::string>& Pipeline::camera_names() const {
  return implementation().camera_names;
}
const Rig& Pipeline::next_rig(int camera) const {
  return implementation().input.camera(static_cast<std::size_t>(camera)).rig();
}
GridGeometry Pipeline::vehicle_grid() const {
  return vehicle_grid_of(implementation().config().grid);
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
  use.host_bytes += sizeof self + self.input.memory_bytes() +
                    memory_bytes_of(self.options.mask, self.options.other_masks, self.result, self.unwanted_stages,
                                    self.fetched.left, self.fetched.right, self.fetched.disparity);
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
