// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/io/run_folder/description.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"

namespace stereogrid::io {

/// The grids of a frame, vehicle frame.
struct RunGrids {
  Image<float> observed;
  Image<float> occupancy;
  Image<float> velocity_x;  ///< m/s relative to the ground, vehicle axes
  Image<float> velocity_y;
  Image<CellWitness> witness;  ///< empty: ground.model plane, or a run of an older version
};

/// The filtered grid of a frame as the filter keeps it, world frame.
struct RunWorldGrid {
  GridGeometry geometry;  ///< moves with the vehicle in whole cells
  Image<float> occupancy;
};

/// Reads the folder that `stereogrid run` leaves.
class STEREOGRID_EXPORT RunReader {
 public:
  /// Throws InputError: no run, damaged, or without grids.
  explicit RunReader(std::filesystem::path folder);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] const GridGeometry& grid() const { return grid_; }
  [[nodiscard]] const std::vector<RunFrame>& frames() const { return frames_; }
  /// Input of the run.
  [[nodiscard]] const RunInput& input() const { return input_; }
  /// As given: of the calibration.
  [[nodiscard]] const Rig& rig() const { return rig_; }
  /// Rig with the extrinsics of a frame, as estimated by the run. Frames without a ground plane have those of the next
  /// frame that has one.
  [[nodiscard]] Rig rig_of(const RunFrame& frame) const;
  /// Rigs of all cameras: rig_of() the first, and the others as given.
  [[nodiscard]] std::vector<Rig> rigs_of(const RunFrame& frame) const;
  /// Names of several cameras; empty: one camera.
  [[nodiscard]] const std::vector<std::string>& camera_names() const { return camera_names_; }
  /// "default" and so on.
  [[nodiscard]] const std::string& preset() const { return preset_; }
  /// Horizons of its predictions, s.
  [[nodiscard]] const std::vector<double>& predict_s() const { return predict_s_; }
  /// Throws InputError: also where the run was written without one of them (--layers).
  [[nodiscard]] RunGrids grids(const std::string& name) const;
  /// The filtered grid's alone. Throws as grids().
  [[nodiscard]] Image<float> occupancy(const std::string& name) const;
  /// Throws InputError.
  [[nodiscard]] RunWorldGrid world_grid(const std::string& name) const;

 private:
  void read_run();
  void check_extrinsics();
  void check_grids() const;
  [[noreturn]] void report_array(const std::filesystem::path& file, const std::string& array) const;

  std::filesystem::path folder_;
  GridGeometry grid_;
  double world_cell_size_m_{0};  // 0: unknown
  Rig rig_;
  std::vector<Rig> other_rigs_;
  std::vector<std::string> camera_names_;
  RunInput input_;
  std::string preset_;
  std::vector<double> predict_s_;
  bool compact_{false};
  std::vector<std::string> layers_;  // none: all
  std::vector<RunFrame> frames_;
};

}  // namespace stereogrid::io
