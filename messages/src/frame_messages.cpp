// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/frame_messages.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>

#include "fill/fill.hpp"
#include "outlet.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid::messages {
namespace {

constexpr std::uint64_t diagnostics_period_ns{1'000'000'000};
constexpr double voxel_min_m{0.01};
constexpr double voxel_max_m{10};

struct Last {
  std::int64_t stamp_ns;
  Pose2 world_from_vehicle;
};

struct PredictedGrid {
  double horizon_s;
  Topic<nav_msgs::OccupancyGrid> topic;
};

const Rig& checked(const Rig& rig) {
  if (const std::vector<std::string> found{problems(rig)}; !found.empty()) throw InputError{found.front()};
  return rig;
}

void check_voxel(double side_m) {
  if (side_m == 0 || (side_m >= voxel_min_m && side_m <= voxel_max_m)) return;
  throw ConfigError{"The side of the voxels of points must be 0 (all points) or 0.01 … 10 m."};
}

FrameMessagesOptions checked(FrameMessagesOptions options) {
  const auto is_allowed = [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '/';
  };
  const std::string& node{options.node};
  if (node.empty() || !std::ranges::all_of(node, is_allowed) || node.front() == '/' || node.back() == '/' ||
      node.find("//") != std::string::npos) {
    throw ConfigError{"\"" + node + "\" is not a name of a node: letters, digits and _, with / between names."};
  }
  for (const std::string* const frame : {&options.world_frame, &options.vehicle_frame, &options.camera_frame}) {
    if (frame->empty()) throw ConfigError{"A frame needs a name."};
  }
  check_voxel(options.points_voxel_m);
  return options;
}

// 0.5 s: "_0_5", as names of ROS have no dots.
std::string suffix_of(double horizon_s) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "_%g", horizon_s);
  std::string suffix{text.data()};
  std::ranges::replace_if(
      suffix, [](unsigned char letter) { return std::isalnum(letter) == 0; }, '_');
  return suffix;
}

// 0: `now_ns` is not later.
std::uint64_t elapsed_ns(std::int64_t now_ns, std::int64_t before_ns) {
  return now_ns > before_ns ? static_cast<std::uint64_t>(now_ns) - static_cast<std::uint64_t>(before_ns) : 0;
}

template <class T>
void check_layer(const GridGeometry& geometry, const Image<T>& layer) {
  if (!layer.empty() && layer.width() == geometry.nx && layer.height() == geometry.ny) return;
  throw InputError{"frame result", "its grids are not of the size that their geometry has.",
                   "Send results of Pipeline::process()."};
}

void check(const FrameResult& result) {
  for (const Image<float>* const layer : {&result.observed, &result.vehicle.occupancy}) {
    check_layer(result.vehicle.geometry, *layer);
  }
  if (!result.witness.empty()) check_layer(result.vehicle.geometry, result.witness);
  const GridLayers& world{result.world};
  for (const Image<float>* const layer :
       {&world.occupancy, &world.velocity_x, &world.velocity_y, &world.moving, &world.age_s}) {
    check_layer(world.geometry, *layer);
  }
  if (!result.world_elevation_m.empty()) {
    check_layer(world.geometry, result.world_elevation_m);
    check_layer(world.geometry, result.world_elevation_sigma_m);
    check_layer(world.geometry, result.world_terrain);
  }
  for (const Prediction& one : result.predictions) check_layer(world.geometry, one.world_occupancy);
}

bool goes_on(const FrameResult& result) {
  return !has_any(result.status, {FrameStatus::clock_gap, FrameStatus::clock_stepped_back, FrameStatus::pose_jump});
}

}  // namespace

/// Topics of a camera.
struct CameraTopics {
  /// `name`: of one of several cameras; "": of the only one. `frame`: of the left camera.
  CameraTopics(Outlet& outlet, const std::string& camera_name, const std::string& left_frame, const Rig& first_rig)
      : name{camera_name},
        frame{name.empty() ? left_frame : name + "_" + left_frame},
        rig{first_rig},
        disparity{outlet.camera_topic<stereo_msgs::DisparityImage>(name, "disparity")},
        camera_info{outlet.camera_topic<sensor_msgs::CameraInfo>(name, "left/camera_info")},
        annotated{outlet.camera_topic<sensor_msgs::CompressedImage>(name, "left/image_annotated/compressed")},
        u_disparity{outlet.camera_topic<sensor_msgs::CompressedImage>(name, "u_disparity/compressed")} {}

  void set_rig(const Rig& now) {
    rig = now;
    level_rig = LevelMapping{now}.level_rig();
  }
  [[nodiscard]] const std::string& frame_of_level() const { return level_rig == rig ? frame : level_frame; }

  std::string name;
  std::string frame;
  std::string level_frame{frame + "_level"};
  Rig rig;
  Rig level_rig{LevelMapping{rig}.level_rig()};
  Topic<stereo_msgs::DisparityImage> disparity;
  Topic<sensor_msgs::CameraInfo> camera_info;
  Topic<sensor_msgs::CompressedImage> annotated;
  Topic<sensor_msgs::CompressedImage> u_disparity;
};

struct FrameMessages::Implementation {
  Implementation(Sink& sink, const Rig& rig, const FrameMessagesOptions& given)
      : options{checked(given)}, outlet{sink, options.node, options.topics} {
    cameras.emplace_back(outlet, "", options.camera_frame, checked(rig));
    static_cast<void>(outlet.topic<nav_msgs::OccupancyGrid>(predicted_name));  // selectable before its first message
    outlet.check_selection();
  }

  // Rigs and names of several cameras, which are known with their first result.
  void set_cameras(const FrameResult& result) {
    const std::vector<FrameResult>& seen{result.cameras};
    if (seen.empty()) return;
    if (!std::ranges::equal(cameras, seen, {}, &CameraTopics::name, &FrameResult::camera_name)) {
      cameras.clear();
      for (const FrameResult& one : seen)
        cameras.emplace_back(outlet, one.camera_name, options.camera_frame, checked(one.rig));
      is_extrinsics_sent = false;
    }
    for (std::size_t i{0}; i < seen.size(); ++i) {
      if (cameras[i].rig == seen[i].rig) continue;
      cameras[i].set_rig(checked(seen[i].rig));
      is_extrinsics_sent = false;
    }
  }

  void mark(std_msgs::Header& header, const std::string& frame) const {
    header.stamp = stamp;
    header.frame_id = frame;
  }

  void send_transforms(const FrameResult& result);
  void send_odometry(const FrameResult& result, const std::optional<PoseCovariances>& covariances);
  void send_grid(Topic<nav_msgs::OccupancyGrid>& topic, const std::string& frame, const GridGeometry& geometry,
                 const Image<float>& occupancy);
  void send_predictions(const FrameResult& result);
  void send_grids(const FrameResult& result);
  void send_obstacles(const FrameResult& result);
  void send_images(const FrameResult& result);
  void send_pictures(const FrameFacts& facts);
  void send_diagnostics(const FrameResult& result, const FrameFacts& facts);

  static constexpr const char* predicted_name{"predicted_grid"};

  FrameMessagesOptions options;
  Outlet outlet;
  std::vector<CameraTopics> cameras;
  std::vector<Rig> rigs;  // working memory
  Topic<nav_msgs::OccupancyGrid> occupancy_grid{outlet.topic<nav_msgs::OccupancyGrid>("occupancy_grid", true)};
  Topic<nav_msgs::OccupancyGrid> observed_grid{outlet.topic<nav_msgs::OccupancyGrid>("observed_grid", true)};
  std::vector<PredictedGrid> predicted_grids;
  Topic<nav_msgs::OccupancyGrid> planning_grid{outlet.topic<nav_msgs::OccupancyGrid>("planning_grid", true)};
  Topic<grid_map_msgs::GridMap> grid_map{outlet.topic<grid_map_msgs::GridMap>("grid_map", true)};
  Topic<foxglove_msgs::Grid> packed_grid{outlet.topic<foxglove_msgs::Grid>("packed_grid", true)};
  Topic<nav2_dynamic_msgs::ObstacleArray> obstacles{outlet.topic<nav2_dynamic_msgs::ObstacleArray>("obstacles")};
  Topic<vision_msgs::Detection3DArray> detections{outlet.topic<vision_msgs::Detection3DArray>("detections")};
  Topic<visualization_msgs::MarkerArray> markers{outlet.topic<visualization_msgs::MarkerArray>("obstacle_markers")};
  Topic<sensor_msgs::PointCloud2> points{outlet.topic<sensor_msgs::PointCloud2>("points")};
  Topic<sensor_msgs::PointCloud2> obstacle_points{outlet.topic<sensor_msgs::PointCloud2>("obstacle_points")};
  Topic<sensor_msgs::PointCloud2> ground_points{outlet.topic<sensor_msgs::PointCloud2>("ground_points")};
  Topic<sensor_msgs::LaserScan> scan{outlet.topic<sensor_msgs::LaserScan>("scan")};
  Topic<nav_msgs::Odometry> odometry{outlet.topic<nav_msgs::Odometry>("odometry")};
  Topic<tf2_msgs::TFMessage> tf{outlet.topic<tf2_msgs::TFMessage>("/tf")};
  Topic<tf2_msgs::TFMessage> tf_static{outlet.topic<tf2_msgs::TFMessage>("/tf_static", true)};
  Topic<diagnostic_msgs::DiagnosticArray> status{outlet.topic<diagnostic_msgs::DiagnosticArray>("status")};
  Topic<diagnostic_msgs::DiagnosticArray> diagnostics{outlet.topic<diagnostic_msgs::DiagnosticArray>("/diagnostics")};

  VoxelFilter voxel_filter;
  std::int64_t stamp_ns{0};
  builtin_interfaces::Time stamp;  // the same
  bool is_extrinsics_sent{false};
  std::optional<Last> last;
  std::optional<std::int64_t> diagnosed_ns;
  FrameCounts counted;  // until diagnosed_ns
  FrameCounts recent;   // in the second before diagnosed_ns
};

void FrameMessages::Implementation::send_transforms(const FrameResult& result) {
  const auto set = [&](geometry_msgs::TransformStamped& one, const std::string& frame, const std::string& child,
                       const geometry_msgs::Transform& transform) {
    mark(one.header, frame);
    one.child_frame_id = child;
    one.transform = transform;
  };
  if (!is_extrinsics_sent) {
    is_extrinsics_sent = outlet.offer(tf_static, stamp_ns, [&](tf2_msgs::TFMessage& message) {
      message.transforms.clear();
      for (const CameraTopics& camera : cameras) {
        set(message.transforms.emplace_back(), options.vehicle_frame, camera.frame, vehicle_from_camera(camera.rig));
        if (camera.level_rig == camera.rig) continue;
        set(message.transforms.emplace_back(), options.vehicle_frame, camera.level_frame,
            vehicle_from_camera(camera.level_rig));
      }
    });
  }
  outlet.offer(tf, stamp_ns, [&](tf2_msgs::TFMessage& message) {
    message.transforms.resize(1);
    set(message.transforms.front(), options.world_frame, options.vehicle_frame,
        world_from_vehicle(result.world_from_vehicle));
  });
}

void FrameMessages::Implementation::send_odometry(const FrameResult& result,
                                                  const std::optional<PoseCovariances>& covariances) {
  const std::uint64_t dt_ns{last && goes_on(result) ? elapsed_ns(stamp_ns, last->stamp_ns) : 0};
  const Pose2 moved{dt_ns > 0 ? inverse(last->world_from_vehicle) * result.world_from_vehicle : Pose2{}};
  outlet.offer(odometry, stamp_ns, [&](nav_msgs::Odometry& message) {
    mark(message.header, options.world_frame);
    message.child_frame_id = options.vehicle_frame;
    fill(message, result.world_from_vehicle, moved, static_cast<double>(dt_ns) * 1e-9, covariances);
  });
  last = {stamp_ns, result.world_from_vehicle};
}

void FrameMessages::Implementation::send_grid(Topic<nav_msgs::OccupancyGrid>& topic, const std::string& frame,
                                              const GridGeometry& geometry, const Image<float>& occupancy) {
  outlet.offer(topic, stamp_ns, [&](nav_msgs::OccupancyGrid& message) {
    mark(message.header, frame);
    fill(message, geometry, occupancy, options.scale);
  });
}

void FrameMessages::Implementation::send_predictions(const FrameResult& result) {
  for (const Prediction& prediction : result.predictions) {
    auto found{std::ranges::find(predicted_grids, prediction.horizon_s, &PredictedGrid::horizon_s)};
    if (found == predicted_grids.end()) {
      const std::string suffix{suffix_of(prediction.horizon_s)};
      predicted_grids.push_back(
          {prediction.horizon_s, outlet.topic<nav_msgs::OccupancyGrid>(predicted_name, true, suffix)});
      found = predicted_grids.end() - 1;
    }
    send_grid(found->topic, options.world_frame, result.world.geometry, prediction.world_occupancy);
  }
  if (result.predictions.empty()) return;
  outlet.offer(planning_grid, stamp_ns, [&](nav_msgs::OccupancyGrid& message) {
    mark(message.header, options.world_frame);
    fill_highest(message, result, options.scale);
  });
}

void FrameMessages::Implementation::send_grids(const FrameResult& result) {
  send_grid(occupancy_grid, options.world_frame, result.world.geometry, result.world.occupancy);
  send_grid(observed_grid, options.vehicle_frame, result.vehicle.geometry, result.observed);
  send_predictions(result);
  outlet.offer(grid_map, stamp_ns, [&](grid_map_msgs::GridMap& message) {
    mark(message.header, options.world_frame);
    fill(message, result);
  });
  outlet.offer(packed_grid, stamp_ns, [&](foxglove_msgs::Grid& message) {
    message.timestamp = stamp;
    message.frame_id = options.world_frame;
    fill(message, result);
  });
  outlet.offer(scan, stamp_ns, [&](sensor_msgs::LaserScan& message) {
    mark(message.header, options.vehicle_frame);
    rigs.clear();
    for (const CameraTopics& camera : cameras) rigs.push_back(camera.rig);
    fill(message, rigs, result.vehicle.geometry, result.vehicle.occupancy.view());
  });
}

void FrameMessages::Implementation::send_obstacles(const FrameResult& result) {
  outlet.offer(obstacles, stamp_ns, [&](nav2_dynamic_msgs::ObstacleArray& message) {
    mark(message.header, options.world_frame);
    fill(message, result, options.node);
  });
  outlet.offer(detections, stamp_ns, [&](vision_msgs::Detection3DArray& message) {
    mark(message.header, options.world_frame);
    fill(message, result);
  });
  outlet.offer(markers, stamp_ns,
               [&](visualization_msgs::MarkerArray& message) { fill(message, result, stamp, options.world_frame); });
}

void FrameMessages::Implementation::send_images(const FrameResult& result) {
  if (result.stages.obstacle_disparity.empty()) return;
  for (std::size_t i{0}; i < cameras.size(); ++i) {
    outlet.offer(cameras[i].disparity, stamp_ns, [&](stereo_msgs::DisparityImage& message) {
      mark(message.header, cameras[i].frame_of_level());
      fill(message, i == 0 ? result.stages : result.cameras[i].stages, cameras[i].level_rig);
    });
  }
  std::optional<std::vector<LabelledPoint>> measured;
  const auto offer = [&](Topic<sensor_msgs::PointCloud2>& topic, std::optional<PointLabel> label) {
    outlet.offer(topic, stamp_ns, [&](sensor_msgs::PointCloud2& message) {
      if (!measured) {
        measured = points_of(result, cameras.front().level_rig);
        voxel_filter.apply(*measured, result.vehicle.geometry, options.points_voxel_m);
      }
      mark(message.header, options.vehicle_frame);
      fill(message, *measured, label);
    });
  };
  offer(points, std::nullopt);
  offer(obstacle_points, PointLabel::obstacle);
  offer(ground_points, PointLabel::road);
}

void FrameMessages::Implementation::send_pictures(const FrameFacts& facts) {
  const auto offer = [&](Topic<sensor_msgs::CompressedImage>& topic, const std::string& frame, const auto& jpeg,
                         std::size_t camera) {
    if (!jpeg || !outlet.wants(topic)) return;
    const std::span<const std::byte> bytes{jpeg(static_cast<int>(camera))};
    if (bytes.empty()) return;
    outlet.offer(topic, stamp_ns, [&](sensor_msgs::CompressedImage& message) {
      mark(message.header, frame);
      fill(message, bytes);
    });
  };
  for (std::size_t i{0}; i < cameras.size(); ++i) {
    CameraTopics& camera{cameras[i]};
    outlet.offer(camera.camera_info, stamp_ns, [&](sensor_msgs::CameraInfo& message) {
      mark(message.header, camera.frame);
      fill(message, camera.rig);
    });
    offer(camera.annotated, camera.frame, facts.left_jpeg, i);
    offer(camera.u_disparity, camera.frame_of_level(), facts.u_disparity_jpeg, i);
  }
}

void FrameMessages::Implementation::send_diagnostics(const FrameResult& result, const FrameFacts& facts) {
  // diagnostics: once a second, and at once after the clock has stepped back
  const bool is_due{!diagnosed_ns || stamp_ns < *diagnosed_ns ||
                    elapsed_ns(stamp_ns, *diagnosed_ns) >= diagnostics_period_ns};
  if (is_due) {
    const FrameCounts now{counts_of(facts)};
    if (now.used < counted.used || now.dropped < counted.dropped) counted = {};
    recent = {.used = now.used - counted.used, .dropped = now.dropped - counted.dropped};
    counted = now;
    diagnosed_ns = stamp_ns;
  }
  const auto fill_status = [&](diagnostic_msgs::DiagnosticArray& message) {
    mark(message.header, "");
    fill(message, result, facts, recent, options);
  };
  outlet.offer(status, stamp_ns, fill_status);
  if (is_due) outlet.offer(diagnostics, stamp_ns, fill_status);
}

FrameMessages::FrameMessages(Sink& sink, const Rig& rig, const FrameMessagesOptions& options)
    : implementation_{std::make_unique<Implementation>(sink, rig, options)} {}
FrameMessages::FrameMessages(FrameMessages&&) noexcept = default;
FrameMessages& FrameMessages::operator=(FrameMessages&&) noexcept = default;
FrameMessages::~FrameMessages() = default;

void FrameMessages::send(const FrameResult& result, const FrameFacts& facts) {
  check(result);
  Implementation& it{*implementation_};
  it.stamp_ns = facts.stamp_ns;
  it.stamp = time_of(facts.stamp_ns);
  it.set_cameras(result);
  it.send_transforms(result);
  it.send_odometry(result, facts.covariances);
  it.send_grids(result);
  it.send_obstacles(result);
  it.send_images(result);
  it.send_pictures(facts);
  it.send_diagnostics(result, facts);
}

void FrameMessages::set_points_voxel(double side_m) {
  check_voxel(side_m);
  implementation_->options.points_voxel_m = side_m;
}

void FrameMessages::set_rig(const Rig& rig) {
  implementation_->cameras.front().set_rig(checked(rig));
  implementation_->is_extrinsics_sent = false;
}

}  // namespace stereogrid::messages
