// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/quaternion.hpp>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"

namespace stereogrid::rosbag {

/// Transforms of /tf and /tf_static, the last ten seconds of them, as tf2 keeps them. For any threads.
class TransformBuffer {
 public:
  /// Transforms with numbers that are not finite, quaternions of another length than 1 or a frame as its own parent are
  /// dropped. Returns which one, and why, at the first one; else "".
  std::string add(const messages::tf2_msgs::TFMessage& message, bool are_static);
  /// Removes all but static transforms.
  void clear();

  /// Takes points of `source` to `target` at that instant: through chains of any depth, linear and slerp between two
  /// stamps. No extrapolation. Waits for missing transforms, in wall time, no longer than `patience`. Throws
  /// InputError: the frames are not connected, or not at that instant.
  [[nodiscard]] cv::Affine3d at(const std::string& target, const std::string& source, std::int64_t stamp_ns,
                                std::chrono::milliseconds patience);
  /// True: the frames are connected, which is waited for up to `patience`.
  [[nodiscard]] bool are_connected(const std::string& target, const std::string& source,
                                   std::chrono::milliseconds patience);
  /// As at(), at the newest instant of each link.
  [[nodiscard]] cv::Affine3d newest(const std::string& target, const std::string& source,
                                    std::chrono::milliseconds patience);

 private:
  struct Stamped {
    std::int64_t stamp_ns;
    cv::Quatd rotation;
    cv::Vec3d translation;
  };
  struct Link {
    std::string parent;
    bool is_static;
    std::vector<Stamped> history;  // stamps grow; static: one
  };
  struct Found;

  std::string add(const messages::geometry_msgs::TransformStamped& message, bool is_static);
  [[nodiscard]] cv::Affine3d wait_for(const std::string& target, const std::string& source, std::int64_t stamp_ns,
                                      std::chrono::milliseconds patience);
  [[nodiscard]] std::vector<std::string> ancestors_of(const std::string& frame) const;
  [[nodiscard]] Found find(const std::string& target, const std::string& source, std::int64_t stamp_ns) const;
  [[nodiscard]] Found up_to(const std::string& ancestor, const std::string& frame, std::int64_t stamp_ns) const;
  [[nodiscard]] static Found parent_from(const std::string& child, const Link& link, std::int64_t stamp_ns);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Link> links_;  // by child
  bool has_dropped_{false};
};

/// Place and heading on the ground of a camera whose optical frame (z ahead) has that transform to the world.
[[nodiscard]] Pose2 pose_of_camera(const cv::Affine3d& world_from_camera);
/// Place and heading on the ground of a vehicle (x ahead).
[[nodiscard]] Pose2 pose_of_vehicle(const cv::Affine3d& world_from_vehicle);
/// Frame whose z = 0 is the road for a camera: base_footprint (REP 120) where TF connects it, else the vehicle's.
[[nodiscard]] std::string ground_frame(TransformBuffer& transforms, const std::string& vehicle_frame,
                                       const std::string& camera_frame);
/// Places one of several cameras in the vehicle frame: x, y and yaw of its rig; height, pitch and roll above
/// ground_frame(), which count as measured (Calibration::has_extrinsics) if that is base_footprint. Returns the place
/// as a text. Throws InputError: TF does not connect the frames. `images`: for error messages.
[[nodiscard]] std::string place_camera(io::Calibration& calibration, TransformBuffer& transforms,
                                       const std::string& vehicle_frame, const std::string& camera_frame,
                                       const std::string& images);
/// Sets height, pitch and roll from the transform of the left optical frame to a frame on the ground. Returns false and
/// changes nothing where the camera is not above the ground, or points straight up or down.
[[nodiscard]] bool set_extrinsics(Rig& rig, const cv::Affine3d& ground_from_camera);

}  // namespace stereogrid::rosbag
