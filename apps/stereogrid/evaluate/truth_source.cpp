// SPDX-License-Identifier: Apache-2.0
#include "evaluate/output.hpp"

#include <filesystem>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/io/truth.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

std::filesystem::path labels_of(const io::Recording& recording) {
  return recording.contents().root / "objects.jsonl";
}

}  // namespace

TruthSource::TruthSource(Input input, TruthKind kind, std::optional<double> camera_height_m)
    : input_{std::move(input)}, kind_{kind}, camera_height_m_{camera_height_m}, sweeps_{input_.recording} {
  if (kind_ == TruthKind::automatic) kind_ = has_exact() ? TruthKind::exact : TruthKind::lidar;
  if (kind_ == TruthKind::lidar) {
    check_lidar();
  } else if (kind_ == TruthKind::objects) {
    // there is nothing to prepare
  } else if (input_.scene != nullptr) {
    truth_grid_ = input_.scene->truth_grid();
  } else if (has_exact()) {
    reader_ = std::make_unique<io::TruthReader>(input_.recording->contents().truth_folder);
    truth_grid_ = reader_->grid();
  } else {
    throw InputError{io::printable_path(input_.recording->contents().root), "has no folder truth/.",
                     input_.recording->has_scans() ? "It has lidar sweeps: use --truth lidar."
                                                   : "Give a rendered drive or a scene."};
  }
  for (std::size_t i{0}; i < input_.source->size(); ++i) places_.emplace(input_.source->name(i), i);
}

TruthSource::~TruthSource() = default;

std::vector<std::string> TruthSource::exact_names() const {
  if (reader_) return reader_->names();
  std::vector<std::string> names;
  for (std::size_t i{0}; i < input_.source->size(); ++i) names.push_back(input_.source->name(i));
  return names;
}

bool TruthSource::has_exact() const {
  return input_.scene != nullptr || input_.recording->has_truth();
}

void TruthSource::check_lidar() const {
  sweeps_.require(has_exact() ? "It has exact truth: use --truth truth."
                              : "Put KITTI's folder velodyne/ (raw drives: velodyne_points/) beside the images.");
}

std::optional<FrameTruth> TruthSource::exact(const std::string& name) const {
  if (reader_) return reader_->has(name) ? std::optional{reader_->frame(name)} : std::nullopt;
  const auto place{places_.find(name)};
  if (place == places_.end()) return std::nullopt;
  return input_.scene->truth(place->second);
}

double TruthSource::lidar_road_m(const Rig& rig) const {
  if (camera_height_m_) return *camera_height_m_;
  return rig == input_.source->rig() ? evaluation::kitti_camera_height_m : rig.camera_height_m;
}

std::optional<evaluation::Labels> TruthSource::lidar(const std::string& name, const GridGeometry& grid,
                                                     const Rig& rig) const {
  const auto place{places_.find(name)};
  if (place == places_.end()) return std::nullopt;
  const std::vector<evaluation::CameraPoint> points{sweeps_.of(place->second)};
  if (points.empty()) return std::nullopt;
  return evaluation::lidar_labels(points, rig, grid, lidar_road_m(rig));
}

std::optional<TruthSource::FrameLabels> TruthSource::frame(const std::string& name, const GridGeometry& grid,
                                                           const Rig& rig) const {
  if (kind_ == TruthKind::objects) return std::nullopt;
  if (kind_ == TruthKind::lidar) {
    auto labels{lidar(name, grid, rig)};
    if (!labels) return std::nullopt;
    return FrameLabels{std::move(*labels), std::nullopt};
  }
  auto truth{exact(name)};
  if (!truth) return std::nullopt;
  auto labels{evaluation::truth_labels(*truth, truth_grid_, input_.source->rig(), grid)};
  return FrameLabels{std::move(labels), std::move(truth)};
}

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
