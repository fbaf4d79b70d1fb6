// SPDX-License-Identifier: Apache-2.0
#include "info/look.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "diagnostics/frame_tally.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t first_tried{3};
constexpr std::size_t others_tried{5};
constexpr std::chrono::seconds longest_try{3};

std::set<std::size_t> spread(std::size_t frames, std::size_t count) {
  std::set<std::size_t> indices;
  const std::size_t steps{std::min(count, frames)};
  for (std::size_t i{0}; i < steps; ++i) indices.insert(steps == 1 ? 0 : i * (frames - 1) / (steps - 1));
  return indices;
}

double median(std::vector<double> values) {
  const auto middle{values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)};
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Number of occurrences, and the first frame.
struct Tally {
  std::size_t frames{0};
  std::string first;

  void add(const std::string& name) {
    if (frames++ == 0) first = name;
  }
};

/// Input of one of several cameras, without a source.
Input camera_input(const Input& input, std::size_t camera) {
  Input own;
  if (input.recording != nullptr) own.recording = input.recording->other_cameras()[camera - 1].get();
  own.scene = input.scene;
  own.poses = input.poses;
  own.extrinsics_given = input.extrinsics_given;
  return own;
}

PipelineOptions options_of_all(const Input& input) {
  return {.stages = false,
          .mask = input.mask,
          .other_masks = input.other_masks,
          .camera_names = input.source->camera_names(),
          .extrinsics_given = input.extrinsics_given};
}

/// Options of a pipeline of one camera alone.
PipelineOptions options_of(const Input& input, std::size_t camera) {
  PipelineOptions options{options_of_all(input)};
  if (camera > 0)
    options.mask = camera <= options.other_masks.size() ? options.other_masks[camera - 1] : Image<std::uint8_t>{};
  options.other_masks.clear();
  options.camera_names.clear();
  return options;
}

class CameraLook {
 public:
  /// `name`: of one of several cameras; `options`: of its own pipeline.
  CameraLook(const Input& input, const Config& config, std::size_t camera, const std::string& name,
             const PipelineOptions& options)
      : all_{input},
        own_{camera == 0 ? Input{} : camera_input(input, camera)},
        input_{camera == 0 ? input : own_},
        camera_{static_cast<int>(camera)},
        rig_{input.source->rigs()[camera]},
        config_{config},
        pipeline_{config, rig_, options} {
    look_.camera = name;
  }
  CameraLook(const CameraLook&) = delete;
  CameraLook& operator=(const CameraLook&) = delete;

  /// `all`: frames of all cameras; nullptr: it cannot be loaded.
  void load(const StereoFrame* all) {
    ++look_.looked_at;
    const StereoFrame* const frame{all == nullptr ? nullptr : frame_of(*all, camera_)};
    if (frame == nullptr) return;  // reported by the source, or a slower camera
    if (frame->left.empty()) return report(fmt::format("frame {}: no usable images", frame->name));
    ++look_.usable;
    if (look_.usable == 1 && input_.recording != nullptr) {
      for (std::string& text : faults_of_frame(*frame, context())) report(std::move(text));
    }
    if (frame->left == before_.left && frame->right == before_.right && frame->disparity == before_.disparity)
      repeated_.add(frame->name);
    before_ = *frame;
    if (frame->right.empty()) return;
    if (is_without_texture(*frame)) return blank_.add(frame->name);
    if (frame->left == frame->right) identical_.add(frame->name);
  }

  void attempt(const StereoFrame& all, std::size_t index) {
    const std::optional<StereoFrame> frame{own_frame(all, index)};
    if (!frame || frame->left.empty()) return;
    const FrameResult& result{pipeline_.process(*frame)};
    ++look_.tried;
    const io::FrameSummary summary{io::summary_of(*frame, result)};
    tally_.add(summary);
    const auto own{std::ranges::find_if(
        result.warnings, [](const Warning& warning) { return warning.text.starts_with("the lowest rows"); })};
    if (own != result.warnings.end()) own_vehicle_ = own->text;
    if (const auto residual_px{io::row_residual_px(*frame)}) residuals_px_.push_back(*residual_px);
    if (!shows_road(summary)) return;
    found_.push_back(result.ground);
    found_.back().pitch_rad += result.rig.camera_pitch_rad - result.level_rig.camera_pitch_rad;
  }

  void report(std::string text) { look_.problems.push_back(std::move(text)); }

  [[nodiscard]] std::size_t tried() const { return look_.tried; }

  Look diagnose() {
    if (identical_.frames > 0) {
      report(fmt::format("left and right are the same image {}: give the right camera's images.",
                         in_frames(identical_, look_.looked_at)));
    }
    if (blank_.frames > 0) {
      report(fmt::format("an image is black or without texture {}: is a lens covered, or the exposure far off?",
                         in_frames(blank_, look_.looked_at)));
    }
    if (repeated_.frames > 0) {
      report(
          fmt::format("the images are those of the frame before {}: frames were recorded twice, or the camera has "
                      "stopped. Leave them out: for the filter they are new observations.",
                      in_frames(repeated_, look_.looked_at)));
    }
    const Findings found{findings_of(tally_, context())};
    look_.problems.insert(look_.problems.end(), found.texts.begin(), found.texts.end());
    if (!own_vehicle_.empty()) report(own_vehicle_);
    measure_road();
    if (!residuals_px_.empty()) look_.row_residual_px = median(residuals_px_);
    const Rig& rig{pipeline_.next_rig()};
    look_.rig = rig;
    if (rig != rig_) {
      look_.mount = fmt::format("mount: {{camera_height_m: {:.3f}, camera_pitch_rad: {:.4f}, camera_roll_rad: {:.4f}}}",
                                rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad);
    }
    const bool is_nothing_known{look_.tried > 0 && tally_.unknown.frames == look_.tried};
    look_.is_hopeless = look_.usable == 0 || found.are_sides_swapped || is_nothing_known;
    return std::move(look_);
  }

 private:
  /// The camera's frame alone, with the place of all in the input.
  [[nodiscard]] std::optional<StereoFrame> own_frame(const StereoFrame& all, std::size_t index) const {
    const StereoFrame* const frame{frame_of(all, camera_)};
    if (frame == nullptr) return std::nullopt;
    StereoFrame own{*frame};
    own.others.clear();
    own.camera = 0;
    own.index = static_cast<std::int64_t>(index);
    return own;
  }

  [[nodiscard]] std::string in_frames(const Tally& tally, std::size_t all) const {
    return fmt::format("in {} of {} frames (first: {})", tally.frames, all, tally.first);
  }

  [[nodiscard]] TallyContext context() const {
    return {input_, config_, rig_, pipeline_.next_rig(), [this](std::size_t index) {
              const auto all{loaded(*all_.source, index)};
              return all ? own_frame(*all, index) : std::nullopt;
            }};
  }

  void measure_road() {
    look_.road_found = found_.size();
    if (found_.empty()) return;
    const auto median_of = [&](double Ground::*what) {
      std::vector<double> values;
      for (const Ground& ground : found_) values.push_back(ground.*what);
      return median(std::move(values));
    };
    look_.road = {median_of(&Ground::height_m),       median_of(&Ground::pitch_rad),
                  median_of(&Ground::roll_rad),       true,
                  median_of(&Ground::height_sigma_m), median_of(&Ground::pitch_sigma_rad),
                  median_of(&Ground::roll_sigma_rad)};
  }

  const Input& all_;
  Input own_;
  const Input& input_;  // input of this camera
  int camera_;
  Rig rig_;
  const Config& config_;
  Pipeline pipeline_;
  std::vector<Ground> found_;
  std::vector<double> residuals_px_;
  FrameTally tally_;
  std::string own_vehicle_;  ///< warning of a frame that shows the vehicle itself
  Tally identical_;
  Tally repeated_;
  StereoFrame before_;
  Tally blank_;
  Look look_;
};

}  // namespace

Looks look_at_frames(const Input& input, const Config& config, std::size_t count) {
  Looks looks;
  const FrameSource& source{*input.source};
  const std::vector<std::string> names{names_of_cameras(source)};
  std::vector<std::unique_ptr<CameraLook>> cameras;
  for (std::size_t i{0}; i < source.rigs().size(); ++i)
    cameras.push_back(std::make_unique<CameraLook>(input, config, i, names[i], options_of(input, i)));
  std::set<std::size_t> unusable;
  std::vector<std::string> faults;
  const std::set<std::size_t> looked_at{spread(source.size(), count)};
  for (const std::size_t index : looked_at) {
    std::optional<StereoFrame> frame;
    try {
      frame = source.load(index);
    } catch (const InputError& error) {
      unusable.insert(index);
      looks.problems.push_back(fmt::format("frame {} cannot be used: {}", source.name(index), error.what()));
    }
    for (const auto& camera : cameras) camera->load(frame ? &*frame : nullptr);
    if (frame && !frame->left.empty() && !frame->fault.empty())
      faults.push_back(fmt::format("frame {}: {}", frame->name, frame->fault));
  }
  if (!faults.empty())
    looks.problems.push_back(
        fmt::format("{} of {} frames lack a camera's images. {}", faults.size(), looked_at.size(), faults[0]));
  std::set<std::size_t> tried{spread(source.size(), others_tried)};
  // the first ones that can be used, one after the other
  for (std::size_t index{0}, taken{0}; index < source.size() && index < 10 && taken < first_tried; ++index) {
    tried.insert(index);
    taken += unusable.contains(index) ? 0 : 1;
  }
  const auto start{std::chrono::steady_clock::now()};
  PlaceCheck places{1};
  std::optional<Pipeline> all;
  if (cameras.size() > 1) all.emplace(config, source.rigs(), options_of_all(input));
  for (const std::size_t index : tried) {
    if (cameras.front()->tried() >= first_tried && std::chrono::steady_clock::now() - start > longest_try) break;
    try {
      const StereoFrame frame{source.load(index)};
      for (const auto& camera : cameras) camera->attempt(frame, index);
      if (all) places.add(all->process(frame));
    } catch (const InputError&) {  // said where it was looked at
    }
  }
  for (const auto& camera : cameras) looks.cameras.push_back(camera->diagnose());
  for (std::string& text : places.findings()) looks.problems.push_back(std::move(text));
  return looks;
}

}  // namespace stereogrid::app
