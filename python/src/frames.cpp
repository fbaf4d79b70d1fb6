// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "recording.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::python {
namespace {

constexpr std::size_t frames_ahead{4};

/// Frames in memory.
class FrameList : public FrameSource {
 public:
  /// `rigs`: one at least.
  FrameList(const std::vector<MountedRig>& rigs, std::vector<StereoFrame> frames)
      : rigs_{without_masks(rigs)}, names_{names_of(rigs)}, frames_{std::move(frames)} {}

  [[nodiscard]] const Rig& rig() const override { return rigs_.front(); }
  [[nodiscard]] std::span<const Rig> rigs() const override { return rigs_; }
  [[nodiscard]] std::vector<std::string> camera_names() const override { return names_; }
  [[nodiscard]] std::size_t size() const override { return frames_.size(); }
  [[nodiscard]] std::string name(std::size_t index) const override { return frames_.at(index).name; }
  [[nodiscard]] StereoFrame load(std::size_t index) const override { return frames_.at(index); }

 private:
  std::vector<Rig> rigs_;
  std::vector<std::string> names_;
  std::vector<StereoFrame> frames_;
};

app::PoseSource pose_source_of(const std::string& poses) {
  if (poses.empty()) return app::PoseSource::input;
  if (poses == "none") return app::PoseSource::none;
  if (poses == "odometry") return app::PoseSource::odometry;
  throw ConfigError{fmt::format("poses '{}' (allowed: none, odometry; left out: those of the frames).", poses)};
}

}  // namespace

std::string numbered_name(std::int64_t index) {
  return fmt::format("{:06}", index);
}

void set_others(StereoFrame& frame, std::span<const Frame* const> others) {
  std::vector<StereoFrame> all;
  for (const Frame* other : others) {
    std::vector<StereoFrame> nested{all.emplace_back(other->data).others};
    all.back().others.clear();
    std::ranges::move(nested, std::back_inserter(all));
  }
  frame.others = std::move(all);
}

std::vector<MountedRig> Recording::rigs() const {
  std::vector<MountedRig> all;
  const std::vector<std::string> names{source().camera_names()};
  for (const Rig& rig : source().rigs()) {
    const std::size_t camera{all.size()};
    MountedRig& one{all.emplace_back(MountedRig{rig, input_->extrinsics_given})};
    if (camera < names.size()) one.name = names[camera];
    if (camera == 0) one.mask = input_->mask;
    if (camera > 0 && camera <= input_->other_masks.size()) one.mask = input_->other_masks[camera - 1];
  }
  return all;
}

std::shared_ptr<Recording> recording_of(const std::vector<const Frame*>& frames, const RigOrRigs& rig,
                                        const std::string& poses) {
  if (frames.empty()) throw InputError{"Recording: no frames (expected at least one)."};
  std::vector<StereoFrame> copies;
  std::set<std::string> names;
  for (const Frame* frame : frames) {
    StereoFrame& copy{copies.emplace_back(frame->data)};
    const auto index{static_cast<std::int64_t>(copies.size() - 1)};
    if (copy.name == numbered_name(copy.index)) copy.name = numbered_name(index);
    copy.index = index;
    if (!names.insert(copy.name).second) {
      throw InputError{fmt::format("Recording: two frames have the name '{}'. Give each frame its own.", copy.name)};
    }
    if (index > 0 && copy.stamp_ns <= copies[copies.size() - 2].stamp_ns) {
      throw InputError{
          fmt::format("Recording: stamp {} ns of frame {} is not after {} ns of the frame before it. Give "
                      "frames in order, with their stamp_ns.",
                      copy.stamp_ns, index, copies[copies.size() - 2].stamp_ns)};
    }
  }
  const std::vector<MountedRig> rigs{rigs_of(rig)};
  auto input{std::make_shared<app::Input>()};
  input->source = std::make_unique<FrameList>(rigs, std::move(copies));
  input->poses = pose_source_of(poses);
  input->mask = rigs.front().mask;
  for (std::size_t i{1}; i < rigs.size(); ++i) input->other_masks.push_back(rigs[i].mask);
  input->extrinsics_given = std::ranges::all_of(rigs, &MountedRig::extrinsics_given);
  app::InputOptions options;
  options.poses = poses;
  return std::make_shared<Recording>(std::move(input), std::move(options), io::FrameRange{0, frames.size()});
}

bool Recording::has_truth() const {
  return input_->scene != nullptr || (input_->recording != nullptr && input_->recording->has_truth());
}

const io::TruthReader& Recording::reader() const {
  if (!has_truth()) throw InputError{"The recording has no exact truth (folder truth/)."};
  const std::lock_guard lock{mutex_};
  if (!reader_) reader_ = std::make_unique<io::TruthReader>(input_->recording->contents().truth_folder);
  return *reader_;
}

TruthGrid Recording::truth_grid() const {
  return input_->scene != nullptr ? input_->scene->truth_grid() : reader().grid();
}

FrameTruth Recording::truth(std::size_t index) const {
  return input_->scene != nullptr ? input_->scene->truth(index) : reader().frame(source().name(index));
}

FrameIterator::FrameIterator(std::shared_ptr<Recording> recording,
                             const std::function<std::size_t(app::PoseStage&)>& first_of,
                             std::function<bool(std::size_t)> is_kept)
    : recording_{std::move(recording)},
      poses_{recording_->input().poses, recording_->source().rig(), recording_->input().mask, std::move(is_kept)},
      queue_{recording_->source(),        first_of ? first_of(poses_) : recording_->range().first,
             recording_->range().end,     frames_ahead,
             poses_.takes_time() ? 2 : 1, [this](io::QueuedFrame& queued) { poses_.place(queued); }} {
  recording_->skipped.clear();
}

std::optional<io::QueuedFrame> FrameIterator::wait() {
  constexpr std::chrono::milliseconds between_signals{100};
  for (;;) {
    {
      const ReleasedGil release;
      if (queue_.is_ready_within(between_signals)) return queue_.next();
    }
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

void FrameIterator::skip(const io::QueuedFrame& queued) {
  recording_->skipped.push_back({queued.index, queued.name, queued.error});
  const nb::object category{nb::module_::import_("stereogrid._core").attr("SkippedFrameWarning")};
  const std::string text{"frame " + queued.name + " is skipped: " + queued.error};
  if (PyErr_WarnEx(category.ptr(), text.c_str(), 1) != 0) throw nb::python_error();
}

std::unique_ptr<Frame> FrameIterator::next() {
  while (std::optional<io::QueuedFrame> queued{wait()}) {
    if (!queued->frame) {
      skip(*queued);
      continue;
    }
    if (!std::exchange(is_checked_, true)) {
      const ReleasedGil release;
      const std::optional<std::string> problem{io::finding_if_swapped(*queued->frame)};
      if (problem) throw InputError{*problem};
    }
    auto frame{std::make_unique<Frame>()};
    frame->data = std::move(*queued->frame);
    frame->warning = std::move(queued->warning);
    if (poses_.takes_time()) frame->odometry_ms = queued->prepared_ms;
    frame->recording = recording_;
    return frame;
  }
  return nullptr;
}

}  // namespace stereogrid::python
