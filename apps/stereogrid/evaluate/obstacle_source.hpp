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

/// True if the drive has labelled objects in its own file (objects.jsonl).
[[nodiscard]] bool has_object_labels(const Input& input);

/// Truth of obstacles of an input: exact truth, or the drive's labelled boxes.
class ObstacleSource {
 public:
  /// Throws InputError where labels are damaged. `truth` must outlive this.
  explicit ObstacleSource(const TruthSource& truth);

  /// True if any frame has truth.
  [[nodiscard]] bool exists() const { return !places_.empty(); }
  /// "exact truth" or "labelled boxes".
  [[nodiscard]] std::string name() const;
  /// None: nothing is known of a frame of this name, or it lies within the first second. `known`: the frame's cells.
  [[nodiscard]] std::optional<evaluation::ObstacleTruth> frame(
      const std::string& name, const std::optional<TruthSource::FrameLabels>& known) const;

 private:
  const TruthSource& truth_;
  std::map<std::string, std::size_t> places_;  // frames with truth
  std::vector<std::vector<LabelledObject>> labels_;
};

}  // namespace stereogrid::app
