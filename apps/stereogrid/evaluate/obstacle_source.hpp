// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evaluate/truth_source.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"

namespace stereogrid::app {

/// Are the objects of a drive labelled in its own file (objects.jsonl)?
[[nodiscard]] bool has_object_labels(const Input& input);

/// What obstacles of an input can be scored against: exact truth, or the drive's labelled boxes.
class ObstacleSource {
 public:
  /// Throws InputError where labels are damaged. `truth` must outlive this.
  explicit ObstacleSource(const TruthSource& truth);

  /// Is anything known of any frame?
  [[nodiscard]] bool exists() const { return !places_.empty(); }
  /// "exact truth" or "labelled boxes".
  [[nodiscard]] std::string name() const;
  /// None: nothing is known of a frame of this name, or it lies within the first second. `known`: the frame's cells.
  [[nodiscard]] std::optional<evaluation::ObstacleTruth> frame(
      const std::string& name, const std::optional<TruthSource::FrameLabels>& known) const;

 private:
  const TruthSource& truth_;
  std::map<std::string, std::size_t> places_;  // of the frames that something is known of
  std::vector<std::vector<LabelledObject>> labels_;
};

}  // namespace stereogrid::app
