// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "backend/cpu.hpp"
#include "fusion/fusion.hpp"
#include "geometry/composed.hpp"
#include "pipeline/results.hpp"

namespace stereogrid {
namespace {

std::vector<CameraSetup> one_camera(CameraSetup setup) {
  std::vector<CameraSetup> cameras;
  cameras.push_back(std::move(setup));
  return cameras;
}

// a_from_world · world_from_b, the identity for the same pose.
Pose2 relative(const Pose2& world_from_a, const Pose2& world_from_b) {
  return world_from_a == world_from_b ? Pose2{} : inverse(world_from_a) * world_from_b;
}

std::vector<std::unique_ptr<CameraPipeline>> pipelines_of(Cpu& cpu, std::vector<CameraSetup> setups) {
  std::vector<std::unique_ptr<CameraPipeline>> cameras;
  for (CameraSetup& setup : setups) cameras.push_back(std::make_unique<CameraPipeline>(std::move(setup), cpu));
  return cameras;
}

std::vector<Rig> level_rigs_of(const std::vector<std::unique_ptr<CameraPipeline>>& cameras) {
  std::vector<Rig> rigs;
  for (const auto& camera : cameras) rigs.push_back(camera->level_rig());
  return rigs;
}

std::size_t flow_points(const std::vector<std::unique_ptr<CameraPipeline>>& cameras) {
  std::size_t points{0};
  for (const auto& camera : cameras) points += camera->flow_points();
  return points;
}

}  // namespace

FramePipeline::FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                             double turned_rad, GroundMode mode)
    : FramePipeline{config, cpu, one_camera({config, level_rig, std::move(stages), turned_rad, mode})} {}

FramePipeline::FramePipeline(const Config& config, Cpu& cpu, std::vector<CameraSetup> cameras)
    : config_{config},
      cpu_{cpu},
      cameras_{pipelines_of(cpu, std::move(cameras))},
      window_{vehicle_grid_of(config.grid)},
      tracker_{config.tracking, level_rigs_of(cameras_)},
      velocity_evidence_{window_.cells(), velocity_axis(config.filter), flow_points(cameras_)} {
  now_.reserve(cameras_.size());
  observed_.reserve(cameras_.size());
  terrains_.reserve(cameras_.size());
  new_extrinsics_.reserve(cameras_.size());
  held_.ids.reserve(retained_cells_max);
  if (has_one_camera()) return;
  held_.cells.reserve(retained_cells_max);
  vectors_.reserve(flow_points(cameras_));
  clusters_.reserve(cameras_.size() * at(0).clusters().capacity());
}

std::span<const NewExtrinsics> FramePipeline::process(const FrameSet& frame, FrameResult& result,
                                                      const GridsHandler& on_grids) {
  if (frame.restarts) reset();
  const FrameGrids grids{grids_of(frame, frame.world_from_vehicle)};
  look(frame, result);
  cpu_.together(
      [&] { filter(grids, false, result); },
      [&] { for_cameras([](CameraPipeline& camera, CameraFrame& now) { now.rejection = camera.check(now); }); });
  for (CameraFrame& now : now_) of(now).settle(now, now.rejection);
  // again from the state before the frame
  if (std::ranges::any_of(now_, [](const CameraFrame& now) { return !now.is_usable(); })) filter(grids, true, result);
  find_terrains();
  const auto find_segments = [this] {
    for_cameras([](CameraPipeline& camera, CameraFrame& now) { camera.find_segments(now); });
  };
  const auto remember_elevation = [&] {
    if (FrameTerrain* const common{at(0).terrain()}) common->remember_elevation(terrains_, result);
  };
  cpu_.together(find_segments, [&] {
    for_cameras([](CameraPipeline& camera, CameraFrame& now) { camera.finish_ground(now); });
    cpu_.together(remember_elevation, [&] { publish(grids, result); });
  });

  new_extrinsics_.clear();
  for (CameraFrame& now : now_) {
    of(now).end(now);
    if (now.settled.new_extrinsics) new_extrinsics_.push_back({now.frame.camera, *now.settled.new_extrinsics});
  }
  is_first_ = false;
  result.obstacles.clear();
  if (!has_one_camera()) report_cameras(result);
  if (on_grids) on_grids(new_extrinsics_);
  cpu_.together([&] { update_tracks(frame, result); },
                [&] { for_cameras([](CameraPipeline& camera, CameraFrame& now) { camera.add_features(now); }); });
  result.timing_ms.flow += std::exchange(filter_flow_ms_, 0);
  for (const CameraFrame& now : now_) {
    result.timing_ms.ground += now.times.ground;
    result.timing_ms.flow += now.times.flow;
    result.timing_ms.track += now.times.track;
  }
  return new_extrinsics_;
}

template <class Work>
void FramePipeline::for_cameras(const Work& work) {
  cpu_.for_ranges(static_cast<int>(now_.size()), 1, [&](int begin, int end) {
    for (int i{begin}; i < end; ++i) work(of(now_[static_cast<std::size_t>(i)]), now_[static_cast<std::size_t>(i)]);
  });
}

void FramePipeline::reset() {
  is_first_ = true;
  tracker_.reset();
  for (const std::unique_ptr<CameraPipeline>& camera : cameras_) camera->reset();
}

void FramePipeline::continue_from(const FramePipeline& before) {
  tracker_.continue_ids(before.tracker_);
  for (std::size_t i{0}; i < cameras_.size(); ++i) cameras_[i]->continue_from(*before.cameras_[i]);
}

FrameGrids FramePipeline::grids_of(const FrameSet& frame, const Pose2& world_from_camera) const {
  const GridGeometry window{window_.at(frame.world_from_vehicle)};
  const GridGeometry vehicle{vehicle_grid_of(config_.grid)};
  return {frame,
          window,
          grid_in_vehicle(vehicle, {}),
          grid_in_vehicle(window, inverse(frame.world_from_vehicle)),
          grid_in_vehicle(vehicle, relative(world_from_camera, frame.world_from_vehicle)),
          grid_in_vehicle(window, inverse(world_from_camera)),
          is_first_};
}

bool FramePipeline::has_frame(int camera) const {
  return std::ranges::any_of(now_, [&](const CameraFrame& now) { return now.frame.camera == camera; });
}

void FramePipeline::look(const FrameSet& frame, FrameResult& result) {
  now_.clear();
  for (const LevelFrame& one : frame.cameras) {
    FrameResult& seen{has_one_camera() ? result : result.cameras[static_cast<std::size_t>(one.camera)]};
    now_.push_back({one, grids_of(frame, one.world_from_camera), seen});
  }
  for_cameras([](CameraPipeline& camera, CameraFrame& now) { camera.begin(now); });
  for_cameras([](CameraPipeline& camera, CameraFrame& now) { camera.look(now); });
  for (int camera{0}; camera < static_cast<int>(cameras_.size()); ++camera) {
    if (has_frame(camera)) continue;
    at(camera).look_at_nothing(grids_of(frame, frame.world_from_vehicle));
    StageImages& stages{result.cameras[static_cast<std::size_t>(camera)].stages};
    set_unknown(stages);
    stages.obstacle_disparity.fill(0);
    stages.road_disparity.fill(0);
    stages.match_confidence.fill(0);
  }
}

void FramePipeline::filter(const FrameGrids& grids, bool is_checked, FrameResult& result) {
  for_cameras([is_checked](CameraPipeline& camera, const CameraFrame& now) {
    camera.observe(now, !is_checked || now.is_usable());
  });
  if (!has_one_camera()) {
    observed_.clear();
    for (const CameraFrame& now : now_) observed_.push_back({&of(now).stages(), &now.result});
    at(0).stages().fuse_cameras(observed_, result);
  }
  at(0).stages().filter(grids, {find_velocities(grids), held_cells(is_checked)}, result);
}

std::span<const VelocityEvidence> FramePipeline::find_velocities(const FrameGrids& grids) {
  if (config_.filter.model != FilterModel::joint) return {};
  const ScopedTimer timer{filter_flow_ms_};
  vectors_.clear();
  for (const CameraFrame& now : now_) {
    const std::vector<FlowVector>& own{of(now).flow_vectors()};
    if (!has_one_camera()) vectors_.insert(vectors_.end(), own.begin(), own.end());
  }
  const std::span views{grids.frame.views};
  return velocity_evidence_.gather(has_one_camera() ? at(0).flow_vectors() : vectors_, grids.window, ranges_of(cpu_),
                                   views.empty() ? CameraView{} : views.front());
}

std::span<const RetainedCell> FramePipeline::held_cells(bool is_checked) {
  const auto of_camera = [&](const CameraFrame& now) -> const std::vector<RetainedCell>& {
    return of(now).near().held(!is_checked || now.is_usable()).cells;
  };
  if (has_one_camera()) return of_camera(now_.front());
  held_.cells.clear();
  for (const CameraFrame& now : now_) {
    for (const RetainedCell& cell : of_camera(now)) {
      if (held_.cells.size() < retained_cells_max) held_.cells.push_back(cell);
    }
  }
  return held_.cells;
}

// Terrains of usable frames.
void FramePipeline::find_terrains() {
  terrains_.clear();
  for (const CameraFrame& now : now_) {
    if (now.is_usable() && of(now).terrain() != nullptr) terrains_.push_back(of(now).terrain());
  }
}

// Completes the result but for its obstacles and elevations. The grids are final from here on.
void FramePipeline::publish(const FrameGrids& grids, FrameResult& result) {
  FrameTerrain* const terrain{at(0).terrain()};
  at(0).stages().finish(grids, final_step(grids.frame, result), result);
  at(0).stages().publish(grids, result);
  for (const CameraFrame& now : now_) {
    of(now).publish(now);
    if (now.frame.camera == 0) continue;
    of(now).stages().publish(now.grids, now.result);
    result.timing_ms.match += now.result.timing_ms.match;
    result.timing_ms.count += now.result.timing_ms.count;
    result.timing_ms.project += now.result.timing_ms.project;
  }
  if (!has_one_camera()) fuse_terrain(result);
  if (terrain == nullptr) return;
  terrain->classify(result);
  limit_speed(grids.frame.dt_s, result);
}

FinalStep FramePipeline::final_step(const FrameSet& frame, FrameResult& result) {
  const bool is_joint{config_.filter.model == FilterModel::joint};
  FinalStep step{is_joint && std::ranges::any_of(now_, &CameraFrame::is_usable),
                 std::ranges::any_of(frame.cameras, std::not_fn(&LevelFrame::has_external_disparity)), is_joint};
  FrameTerrain* const common{at(0).terrain()};
  if (common == nullptr) return step;
  const auto claims_free = [&frame](Point2 at) { return claimed(frame.other_grids, at) < 0.5; };
  common->find_bounds(terrains_, frame.other_grids.empty() ? std::function<bool(Point2)>{} : claims_free,
                      ranges_of(cpu_), result);
  step.bounds = common->add_bars(terrains_, at(0).stages().filtered(result));
  return step;
}

// The smallest limit of the cameras.
void FramePipeline::limit_speed(double dt_s, FrameResult& result) {
  constexpr double infinity{std::numeric_limits<double>::infinity()};
  for (int camera{0}; camera < static_cast<int>(cameras_.size()); ++camera) {
    FrameResult& seen{has_one_camera() ? result : result.cameras[static_cast<std::size_t>(camera)]};
    const bool is_usable{std::ranges::any_of(
        now_, [&](const CameraFrame& now) { return now.frame.camera == camera && now.is_usable(); })};
    at(camera).terrain()->limit_speed(is_usable, has_frame(camera) ? infinity : dt_s, seen);
    if (camera > 0 && seen.speed_limit_mps >= result.speed_limit_mps) continue;
    result.speed_limit_mps = seen.speed_limit_mps;
    result.speed_limit_reason = seen.speed_limit_reason;
  }
}

// Takes the surer elevation where several cameras see a cell.
void FramePipeline::fuse_terrain(FrameResult& result) {
  FrameTerrain::clear(result);
  for (const CameraFrame& now : now_) {
    for (std::size_t i{0}; i < result.terrain.size() && now.is_usable(); ++i) {
      const float sigma_m{now.result.elevation_sigma_m.data()[i]};
      TerrainClass& kind{result.terrain.data()[i]};
      kind = combined(kind, now.result.terrain.data()[i]);
      if (std::isnan(sigma_m) || result.elevation_sigma_m.data()[i] <= sigma_m) continue;
      result.elevation_sigma_m.data()[i] = sigma_m;
      result.elevation_m.data()[i] = now.result.elevation_m.data()[i];
    }
  }
}

void FramePipeline::update_tracks(const FrameSet& frame, FrameResult& result) {
  const ScopedTimer timer{now_.front().times.track};
  std::vector<Cluster>& clusters{find_clusters(result.world)};
  if (FrameTerrain* const terrain{at(0).terrain()})
    add_low_objects(terrain->low_cells(), result.world, frame.world_from_vehicle, clusters);
  held_.ids.clear();
  Tracker::Cameras looking{0};
  for (const CameraFrame& now : now_) {
    const std::vector<std::int64_t>& ids{of(now).near().held(now.is_usable()).ids};
    held_.ids.insert(held_.ids.end(), ids.begin(), ids.end());
    if (now.is_usable()) looking |= Tracker::Cameras{1} << static_cast<unsigned>(now.frame.camera);
  }
  std::ranges::sort(held_.ids);
  tracker_.update(result.world, clusters, frame.world_from_vehicle, frame.dt_s, held_.ids,
                  has_one_camera() ? Tracker::all_cameras : looking);
  tracker_.report(frame.world_from_vehicle, vehicle_grid_of(config_.grid), result.obstacles);
  for (const CameraFrame& now : now_)
    of(now).near().update(result, tracker_, now.ground.plane, now.frame.world_from_camera, now.is_usable());
  report_too_close(held_, result);
}

std::vector<Cluster>& FramePipeline::find_clusters(const GridLayers& world) {
  clusters_.clear();
  for (const CameraFrame& now : now_) {
    of(now).find_clusters(world, now);
    if (has_one_camera()) return of(now).clusters();
    fuse_clusters(of(now).clusters(), static_cast<std::uint8_t>(now.frame.camera), clusters_);
  }
  return clusters_;
}

// Conditions of a frame are those that all its cameras have.
void FramePipeline::report_cameras(FrameResult& result) {
  for (const CameraFrame& now : now_) {
    for (const Warning& warning : now.result.warnings)
      result.warnings.push_back({now.result.camera_name + ": " + warning.text});
  }
  for (const FrameStatus status : now_.front().result.status) {
    const auto has = [status](const CameraFrame& now) { return has_any(now.result.status, {status}); };
    if (std::ranges::all_of(now_, has)) result.add(status, std::nullopt);
  }
  std::ranges::sort(result.status);
  const FrameResult& first{result.cameras.front()};
  result.ground = first.ground;
  result.obstacle_density = first.obstacle_density;
  result.road_density = first.road_density;
}

MemoryUse FramePipeline::memory_use() const {
  MemoryUse use;
  for (const std::unique_ptr<CameraPipeline>& camera : cameras_) {
    const MemoryUse more{camera->memory_use()};
    use.host_bytes += more.host_bytes;
    use.device_bytes += more.device_bytes;
  }
  use.host_bytes += sizeof *this + memory_bytes_of(tracker_, velocity_evidence_, held_.cells, held_.ids, vectors_,
                                                   clusters_, observed_, terrains_, new_extrinsics_);
  return use;
}

}  // namespace stereogrid
