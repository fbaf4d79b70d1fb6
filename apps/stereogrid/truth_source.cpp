// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "truth_source.hpp"

#include <utility>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/scan.hpp"
#include "stereogrid/io/truth.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

std::vector<evaluation::CameraPoint> into_camera(const std::vector<io::ScanPoint>& scan, const io::Transform& t) {
  std::vector<evaluation::CameraPoint> points;
  points.reserve(scan.size());
  for (const io::ScanPoint& s : scan) {
    const double x{s.x_m};
    const double y{s.y_m};
    const double z{s.z_m};
    points.push_back({t[0] * x + t[1] * y + t[2] * z + t[3], t[4] * x + t[5] * y + t[6] * z + t[7],
                      t[8] * x + t[9] * y + t[10] * z + t[11]});
  }
  return points;
}

}  // namespace

TruthSource::TruthSource(Input input, TruthKind kind, double camera_height_m)
    : input_{std::move(input)}, kind_{kind}, camera_height_m_{camera_height_m} {
  if (kind_ == TruthKind::automatic) kind_ = has_exact() ? TruthKind::exact : TruthKind::lidar;
  if (kind_ == TruthKind::lidar) {
    check_lidar();
  } else if (input_.scene != nullptr) {
    truth_grid_ = input_.scene->truth_grid();
  } else if (has_exact()) {
    reader_ = std::make_unique<io::TruthReader>(input_.recording->contents().truth_folder);
    truth_grid_ = reader_->grid();
  } else {
    throw InputError{input_.recording->contents().root.string(), "has no folder truth/.",
                     input_.recording->has_scans() ? "It has lidar sweeps: use --truth lidar."
                                                   : "Give a rendered drive or a scene."};
  }
  for (std::size_t i{0}; i < input_.source->size(); ++i) places_.emplace(input_.source->name(i), i);
}

TruthSource::~TruthSource() = default;

bool TruthSource::has_exact() const {
  return input_.scene != nullptr || input_.recording->has_truth();
}

void TruthSource::check_lidar() const {
  if (input_.scene != nullptr) {
    throw InputError{"A built-in scene has no lidar sweeps. Score it against its exact truth: --truth truth."};
  }
  const io::RecordingContents& contents{input_.recording->contents()};
  if (!input_.recording->has_scans()) {
    throw InputError{contents.root.string(), "has no lidar sweeps.",
                     has_exact() ? "It has exact truth: use --truth truth."
                                 : "Put KITTI's folder velodyne/ (raw drives: velodyne_points/) beside the images."};
  }
  if (!contents.calibration.camera_from_velodyne) {
    throw InputError{contents.calibration_file.string(), "does not say where the lidar is.",
                     "A line Tr (raw drives: the file calib_velo_to_cam.txt) is needed."};
  }
}

std::optional<FrameTruth> TruthSource::exact(const std::string& name) const {
  if (reader_) return reader_->has(name) ? std::optional{reader_->frame(name)} : std::nullopt;
  const auto place{places_.find(name)};
  if (place == places_.end()) return std::nullopt;
  return input_.scene->truth(place->second);
}

bool TruthSource::has_sweeps() const {
  return input_.recording != nullptr && input_.recording->has_scans() &&
         input_.recording->contents().calibration.camera_from_velodyne;
}

std::vector<evaluation::CameraPoint> TruthSource::sweep(const std::string& name) const {
  const auto place{places_.find(name)};
  if (!has_sweeps() || place == places_.end()) return {};
  const io::RecordingContents& contents{input_.recording->contents()};
  const io::RecordedFrame& frame{contents.frames[place->second]};
  if (frame.scan.empty()) return {};
  return into_camera(io::read_scan(frame.scan), *contents.calibration.camera_from_velodyne);
}

evaluation::CameraPoint TruthSource::lidar_in_camera() const {
  if (!has_sweeps()) return {};
  const io::Transform& t{*input_.recording->contents().calibration.camera_from_velodyne};
  return {t[3], t[7], t[11]};
}

std::optional<evaluation::Labels> TruthSource::lidar(const std::string& name, const GridGeometry& grid) const {
  const std::vector<evaluation::CameraPoint> points{sweep(name)};
  if (points.empty()) return std::nullopt;
  return evaluation::lidar_labels(points, input_.source->rig(), grid, camera_height_m_);
}

std::optional<TruthSource::FrameLabels> TruthSource::frame(const std::string& name, const GridGeometry& grid) const {
  if (kind_ == TruthKind::lidar) {
    auto labels{lidar(name, grid)};
    if (!labels) return std::nullopt;
    return FrameLabels{std::move(*labels), std::nullopt};
  }
  auto truth{exact(name)};
  if (!truth) return std::nullopt;
  auto labels{evaluation::truth_labels(*truth, truth_grid_, input_.source->rig(), grid)};
  return FrameLabels{std::move(labels), std::move(truth)};
}

}  // namespace stereogrid::app
