// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "evaluate/obstacle_source.hpp"

#include <filesystem>
#include <utility>

#include "stereogrid/io/object_labels.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::app {
namespace {

std::filesystem::path labels_of(const io::Recording& recording) {
  return recording.contents().root / "objects.jsonl";
}

}  // namespace

bool has_object_labels(const Input& input) {
  return input.recording != nullptr && io::is_there(labels_of(*input.recording));
}

ObstacleSource::ObstacleSource(const TruthSource& truth) : truth_{truth} {
  if (truth.kind() == TruthKind::exact) {
    for (const std::string& name : truth.exact_names()) places_.emplace(name, places_.size());
  } else if (has_object_labels(truth.input())) {
    for (io::LabelledFrame& frame : io::read_object_labels(labels_of(*truth.input().recording))) {
      places_.emplace(frame.name, labels_.size());
      labels_.push_back(std::move(frame.objects));
    }
  }
}

std::string ObstacleSource::name() const {
  return truth_.kind() == TruthKind::exact ? "exact truth" : "labelled boxes";
}

std::optional<evaluation::ObstacleTruth> ObstacleSource::frame(
    const std::string& name, const std::optional<TruthSource::FrameLabels>& known) const {
  const auto place{places_.find(name)};
  if (place == places_.end() || !evaluation::is_settled(place->second, places_.size())) return std::nullopt;
  if (truth_.kind() != TruthKind::exact) {
    return evaluation::obstacle_truth(labels_[place->second], truth_.input().source->rig(),
                                      known ? &known->labels : nullptr);
  }
  if (!known || !known->truth) return std::nullopt;
  return evaluation::obstacle_truth(*known->truth, truth_.grid(), truth_.input().source->rig());
}

}  // namespace stereogrid::app
