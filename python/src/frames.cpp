// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <nanobind/stl/string.h>

#include <utility>

#include "arrays.hpp"
#include "recording.hpp"
#include "released_gil.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::python {
namespace {

constexpr std::size_t frames_ahead{4};

}  // namespace

bool Recording::has_truth() const {
  return input_.scene != nullptr || input_.recording->has_truth();
}

const io::TruthReader& Recording::reader() const {
  if (!input_.recording->has_truth()) throw InputError{"The recording has no exact truth (folder truth/)."};
  const std::lock_guard lock{mutex_};
  if (!reader_) reader_ = std::make_unique<io::TruthReader>(input_.recording->contents().truth_folder);
  return *reader_;
}

TruthGrid Recording::truth_grid() const {
  return input_.scene != nullptr ? input_.scene->truth_grid() : reader().grid();
}

FrameTruth Recording::truth(std::size_t index) const {
  return input_.scene != nullptr ? input_.scene->truth(index) : reader().frame(source().name(index));
}

FrameIterator::FrameIterator(std::shared_ptr<Recording> recording,
                             const std::function<std::size_t(app::PoseStage&)>& first_of,
                             std::function<bool(std::size_t)> is_kept)
    : recording_{std::move(recording)},
      poses_{recording_->input().poses, recording_->source().rig(), recording_->input().mask, std::move(is_kept)},
      queue_{recording_->source(),
             first_of ? first_of(poses_) : recording_->range().first,
             recording_->range().end,
             frames_ahead,
             poses_.takes_time() ? 2 : 1,
             [this](io::QueuedFrame& queued) { queued.warning = poses_.place(*queued.frame); }} {
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
