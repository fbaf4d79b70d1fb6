// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::io {

/// Reads a disparity image of ground truth, KITTI's and ours: 16-bit PNG, disparity in px × 256, 0 = none (0 in the
/// result too). Throws InputError: missing, damaged, in colour, or of 8-bit values.
[[nodiscard]] STEREOGRID_EXPORT Image<float> read_truth_disparity(const std::filesystem::path& path);

/// Reads the truth/ folder of the plain-folder layout (docs/input.md).
class STEREOGRID_EXPORT TruthReader {
 public:
  /// `folder`: the truth/ folder itself. Throws InputError: grid.json or objects.jsonl missing or not understood.
  explicit TruthReader(const std::filesystem::path& folder);

  [[nodiscard]] const TruthGrid& grid() const { return grid_; }
  /// The frames that have truth, in the order of objects.jsonl.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] bool has(const std::string& name) const { return lines_.contains(name); }
  /// Everything about one frame. Throws InputError: no such frame, a file missing, damaged or of the wrong size.
  [[nodiscard]] FrameTruth frame(const std::string& name) const;
  /// Ego motion and objects only, no images and cells.
  [[nodiscard]] FrameTruth objects(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  TruthGrid grid_;
  std::vector<std::string> names_;
  std::map<std::string, std::string> lines_;  // lines of objects.jsonl, by frame
};

/// Writes a recording in the plain-folder layout; several cameras in folders camera0, camera1 … of it. Call write() for
/// each frame, then finish(): calibration.yaml, poses.csv and objects.jsonl come last, so that a folder half-written is
/// not taken for a whole one.
class STEREOGRID_EXPORT PlainFolderWriter {
 public:
  /// `truth`: the cells that ground truth is given on; none: the recording has no truth. Throws InputError where the
  /// folder already holds images, DeviceError where it cannot be written.
  PlainFolderWriter(const std::filesystem::path& folder, const Rig& rig, std::optional<TruthGrid> truth = std::nullopt);
  /// `rigs`: of each StereoFrame::camera, one at least. The first one's folder has the truth.
  PlainFolderWriter(const std::filesystem::path& folder, std::span<const Rig> rigs,
                    std::optional<TruthGrid> truth = std::nullopt);

  /// Writes the frame of the first camera, and its others. `truth` belongs to the frame; nullptr: none. Throws
  /// DeviceError.
  void write(const StereoFrame& frame, const FrameTruth* truth = nullptr);

  /// Throws DeviceError.
  void finish();

 private:
  std::filesystem::path folder_;
  Rig rig_;
  std::optional<TruthGrid> truth_;
  std::vector<NamedPose> poses_;
  std::string objects_;
  std::vector<PlainFolderWriter> others_;  // other cameras, by StereoFrame::camera − 1
};

/// The labels of a frame.
struct LabelledFrame {
  std::string name;
  std::vector<LabelledObject> objects;
};

/// Reads a drive's objects.jsonl (docs/input.md): a line per frame, in the order of the file. Throws InputError:
/// missing, not understood, numbers out of all range, a frame named twice.
[[nodiscard]] STEREOGRID_EXPORT std::vector<LabelledFrame> read_object_labels(const std::filesystem::path& path);

}  // namespace stereogrid::io
