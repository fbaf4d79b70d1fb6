// SPDX-License-Identifier: Apache-2.0
#include "frame_stages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/core/matx.hpp>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/ray_fan.hpp"
#include "stereogrid/io/text.hpp"

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

constexpr float confidence_near{0.8F};  // cells that are deeper than a row of pixels
constexpr float occupied{0.9F};
constexpr int no_foot{-1};

struct Pixel {
  double u, v;
};

/// Pixel that shows a point of the ground; none: it is behind the camera.
std::optional<Pixel> pixel_of(const Rig& rig, double in_vehicle_x_m, double in_vehicle_y_m) {
  const auto [x_m, y_m]{inverse(camera_place(rig)) * Point2{in_vehicle_x_m, in_vehicle_y_m}};
  const double depth{x_m * std::cos(rig.camera_pitch_rad) + rig.camera_height_m * std::sin(rig.camera_pitch_rad)};
  const double below{rig.camera_height_m * std::cos(rig.camera_pitch_rad) - x_m * std::sin(rig.camera_pitch_rad)};
  if (!(depth > 0)) return std::nullopt;
  const double c{std::cos(rig.camera_roll_rad)};
  const double s{std::sin(rig.camera_roll_rad)};
  return Pixel{rig.cx_px + rig.focal_px * (s * below - c * y_m) / depth,
               rig.cy_px + rig.focal_px * (c * below + s * y_m) / depth};
}

bool is(std::uint8_t label, PixelLabel wanted) {
  return label == static_cast<std::uint8_t>(wanted);
}

/// Lowest row of an obstacle or a mover in each column.
std::vector<int> foot_rows(const Image<std::uint8_t>& labels) {
  std::vector<int> feet(static_cast<std::size_t>(labels.width()), no_foot);
  for (int v{0}; v < labels.height(); ++v) {
    for (int u{0}; u < labels.width(); ++u) {
      if (is(labels(u, v), PixelLabel::obstacle) || is(labels(u, v), PixelLabel::mover))
        feet[static_cast<std::size_t>(u)] = v;
    }
  }
  return feet;
}

/// Evidence of the labels for a cell.
struct Statement {
  float occupancy{0.5F};
  float confidence{0};
};

Statement statement_of(const Image<std::uint8_t>& labels, const std::vector<int>& feet, const Rig& rig, Point2 centre,
                       double half_m) {
  const auto middle{pixel_of(rig, centre.x, centre.y)};
  const auto near{pixel_of(rig, centre.x - half_m, centre.y)};
  const auto far{pixel_of(rig, centre.x + half_m, centre.y)};
  const auto left{pixel_of(rig, centre.x, centre.y + half_m)};
  const auto right{pixel_of(rig, centre.x, centre.y - half_m)};
  if (!middle || !near || !far || !left || !right) return {};
  const double u{std::round(middle->u)};
  const double v{std::round(middle->v)};
  if (!(u >= 0 && u < labels.width() && v >= 0 && v < labels.height())) return {};
  const double row_m{centre.x * centre.x / (rig.focal_px * rig.camera_height_m)};  // depth of a row of pixels
  const float confidence{confidence_near * static_cast<float>(std::min(1.0, 2 * half_m / row_m))};
  const int first{static_cast<int>(std::clamp(std::round(left->u), 0.0, u))};
  const int last{static_cast<int>(std::clamp(std::round(right->u), u, labels.width() - 1.0))};
  int nearest{no_foot};
  for (int column{first}; column <= last; ++column) nearest = std::max(nearest, feet[static_cast<std::size_t>(column)]);
  const bool is_cut{nearest == labels.height() - 1};  // the foot is below the image
  if (nearest >= far->v - 0.5 && nearest <= near->v + 0.5 && !is_cut) return {occupied, confidence};
  const bool is_before{nearest == no_foot || v > nearest};
  if (is_before && is(labels(static_cast<int>(u), static_cast<int>(v)), PixelLabel::passable))
    return {1 - occupied, confidence};
  return {};
}

/// Grid of labelled pixels, PixelLabel (H, W), on level ground below a camera mounted as `rig` says. In each column of
/// the image the lowest obstacle or mover stands on the ground at its lowest pixel: its cell is occupied, passable
/// pixels before it are free, and the rest is unknown. Confidence: 0.8, and less where a row of pixels is deeper than a
/// cell.
ObservedGrid label_grid(const Image<std::uint8_t>& labels, const Rig& rig, const GridGeometry& grid) {
  ObservedGrid made{grid, Image<float>{grid.nx, grid.ny}, Image<float>{grid.nx, grid.ny}};
  const std::vector<int> feet{foot_rows(labels)};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 centre{grid.x_min_m + (ix + 0.5) * grid.cell_size_m, grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
      const Statement statement{statement_of(labels, feet, rig, centre, grid.cell_size_m / 2)};
      made.occupancy(ix, iy) = statement.occupancy;
      made.confidence(ix, iy) = statement.confidence;
    }
  }
  return made;
}

}  // namespace

namespace {

/// Covariance of vehicle_from_camera · pose · vehicle_from_camera⁻¹, of a pose with this heading.
std::array<double, 9> of_vehicle(const std::array<double, 9>& of_camera, const Pose2& vehicle_from_camera,
                                 double heading_rad) {
  const double turn_rad{vehicle_from_camera.yaw_rad};
  const Pose2 lever{inverse(vehicle_from_camera)};
  const Point2 by_heading{Pose2{0, 0, turn_rad + heading_rad} * Point2{-lever.y_m, lever.x_m}};
  const cv::Matx33d turn{std::cos(turn_rad),
                         -std::sin(turn_rad),
                         by_heading.x,
                         std::sin(turn_rad),
                         std::cos(turn_rad),
                         by_heading.y,
                         0,
                         0,
                         1};
  const cv::Matx33d covariance{turn * cv::Matx33d{of_camera.data()} * turn.t()};
  std::array<double, 9> made{};
  std::ranges::copy(covariance.val, made.begin());
  return made;
}

}  // namespace

PoseStage::PoseStage(PoseSource poses, const Rig& rig, const Image<std::uint8_t>& mask,
                     std::function<bool(std::size_t)> is_kept)
    : poses_{poses}, rig_{rig}, is_kept_{std::move(is_kept)} {
  if (poses_ == PoseSource::odometry) odometry_.emplace(rig, mask);
}

PoseStage::Placed PoseStage::place(StereoFrame& frame) {
  if (poses_ == PoseSource::none) frame.world_from_vehicle.reset();
  for (StereoFrame& other : frame.others) {
    if (poses_ != PoseSource::input) other.world_from_vehicle.reset();
  }
  if (odometry_ && frame.left.empty()) frame.world_from_vehicle.reset();
  if (!odometry_ || frame.left.empty()) return {};
  OdometryStep step{odometry_->update(frame)};
  const Pose2 vehicle_from_camera{camera_place(rig_)};
  frame.world_from_vehicle = step.world_from_vehicle;
  if (vehicle_from_camera != Pose2{}) {  // it is of the camera
    step.covariances = {of_vehicle(step.covariances.pose, vehicle_from_camera, step.world_from_vehicle.yaw_rad),
                        of_vehicle(step.covariances.motion, vehicle_from_camera, 0)};
    frame.world_from_vehicle = vehicle_from_camera * step.world_from_vehicle * inverse(vehicle_from_camera);
  }
  if (const auto index{static_cast<std::size_t>(frame.index)}; is_kept_ && is_kept_(index)) {
    const std::lock_guard lock{mutex_};
    kept_.emplace(index, odometry_->save_state());
  }
  return {std::move(step.warning), step.covariances};
}

void PoseStage::place(io::QueuedFrame& queued) {
  Placed placed{place(*queued.frame)};
  if (placed.warning) queued.warning = std::move(placed.warning);
  queued.covariances = placed.covariances;
}

void PoseStage::load(const OdometryState& state) {
  if (odometry_) odometry_->load_state(state);
}

std::optional<OdometryState> PoseStage::take_state(std::size_t index) {
  const std::lock_guard lock{mutex_};
  const auto found{kept_.find(index)};
  if (found == kept_.end()) return std::nullopt;
  std::optional<OdometryState> state{std::move(found->second)};
  kept_.erase(kept_.begin(), std::next(found));  // erases those of unusable frames, too
  return state;
}

bool Sweeps::exist() const {
  return recording_ != nullptr && recording_->has_scans() && recording_->contents().calibration.camera_from_velodyne;
}

void Sweeps::require(const std::string& instead) const {
  if (recording_ == nullptr) throw InputError{"The input has no lidar sweeps. " + instead};
  const io::RecordingContents& contents{recording_->contents()};
  if (!recording_->has_scans()) throw InputError{io::printable_path(contents.root), "has no lidar sweeps.", instead};
  if (!contents.calibration.camera_from_velodyne) {
    throw InputError{io::printable_path(contents.calibration_file), "does not say where the lidar is.",
                     "A line Tr (raw drives: the file calib_velo_to_cam.txt) is needed."};
  }
}

std::vector<evaluation::CameraPoint> Sweeps::of(std::size_t index) const {
  if (!exist()) return {};
  const io::RecordingContents& contents{recording_->contents()};
  const io::RecordedFrame& frame{contents.frames.at(index)};
  if (frame.scan.empty()) return {};
  return into_camera(recording_->load_scan(index), *contents.calibration.camera_from_velodyne);
}

evaluation::CameraPoint Sweeps::lidar_in_camera() const {
  if (!exist()) return {};
  const io::Transform& t{*recording_->contents().calibration.camera_from_velodyne};
  return {t[3], t[7], t[11]};
}

const char* const stereo_alone{"stereo alone: "};

FusedSource fused_source(const std::string& name) {
  constexpr auto names{names_of(FusedSource{})};
  const auto found{std::ranges::find(names, name)};
  if (found == names.end()) throw ConfigError{fmt::format("fuse '{}' (allowed: {}).", name, fmt::join(names, ", "))};
  return static_cast<FusedSource>(found - names.begin());
}

FusionStage::FusionStage(FusedSource source, const Input& input, const GridGeometry& grid)
    : source_{source}, grid_at_{input.grid_at}, recording_{input.recording}, sweeps_{input.recording}, grid_{grid} {
  if (source == FusedSource::lidar) {
    sweeps_.require(input.recording == nullptr ? "Leave --fuse out."
                                               : "Put KITTI's folder velodyne/ (raw drives: velodyne_points/) beside "
                                                 "the images, or leave --fuse out.");
  }
  if (source == FusedSource::labels && (recording_ == nullptr || recording_->contents().labels.empty())) {
    throw InputError{recording_ == nullptr ? "The input" : io::printable_path(recording_->contents().root),
                     "has no labels.",
                     "Put label images in labels/ and 'labels' in calibration.yaml, or leave --fuse out."};
  }
  if (source != FusedSource::grids || grid_at_) return;
  if (recording_ == nullptr) {
    throw InputError{"Only bags and topics of ROS 2 have grids of other sources. Leave --fuse out."};
  }
  const io::RecordingContents& contents{recording_->contents()};
  if (!contents.grids_source.empty()) return;
  const std::string& reason{contents.why_no_grids};
  throw InputError{io::printable_path(contents.root),
                   reason.empty() ? "has no grids of another source: only bags of ROS 2 may." : reason + ".",
                   "Record them with the images, or leave --fuse out."};
}

std::optional<ObservedGrid> FusionStage::grid_of(const StereoFrame& frame, std::size_t index, const Rig& rig) const {
  if (source_ == FusedSource::labels) {
    if (frame.labels.empty()) return std::nullopt;
    return label_grid(frame.labels, rig, grid_);
  }
  if (source_ == FusedSource::grids) {
    const std::optional<io::PlacedGrid> grid{grid_at_ ? grid_at_(frame) : recording_->load_grid(index)};
    if (!grid) return std::nullopt;
    return resampled(*grid, grid_);
  }
  const std::vector<evaluation::CameraPoint> points{sweeps_.of(index)};
  if (points.empty()) return std::nullopt;
  return ObservedGrid{grid_,
                      evaluation::lidar_grid(points, sweeps_.lidar_in_camera(), rig, grid_, rig.camera_height_m)};
}

std::optional<std::string> FusionStage::add_grid(StereoFrame& frame, std::size_t index, const Rig& rig) const {
  if (source_ == FusedSource::none) return std::nullopt;
  try {
    std::optional<ObservedGrid> grid{grid_of(frame, index, rig)};
    constexpr std::array missing{"", "no lidar sweep", "no grid within 0.1 s", "no labels"};
    if (!grid) return std::string{stereo_alone} + missing[static_cast<std::size_t>(source_)];
    frame.other_grids.push_back(std::move(*grid));
    return std::nullopt;
  } catch (const InputError& error) {
    return stereo_alone + std::string{error.what()};
  }
}

}  // namespace stereogrid::app
