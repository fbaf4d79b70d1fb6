// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "input.hpp"
#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/rosbag/rosbag.hpp"
#include "stereogrid/rosbag/transforms.hpp"

namespace stereogrid::app {

/// The last seconds of where the vehicle was, as it comes, for instants of images. For any threads.
class PoseBuffer {
 public:
  /// `name`: where the poses come from, for error messages.
  explicit PoseBuffer(std::string name) : name_{std::move(name)} {}

  /// Adds poses. Stamps older than the buffer's belong to another clock: the buffer is cleared first.
  void add(const std::vector<io::StampedPose>& poses);
  void clear();

  /// Pose at an instant, interpolated; up to one usual interval after the last pose the motion continues. Waits up to
  /// `patience` for a later pose. Throws InputError: there is none.
  [[nodiscard]] Pose2 at(std::int64_t stamp_ns, std::chrono::milliseconds patience);
  /// Returns when there is a pose, or after `patience`.
  void wait_for_first(std::chrono::milliseconds patience);

 private:
  [[nodiscard]] Pose2 between(std::int64_t stamp_ns) const;

  std::string name_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<io::StampedPose> poses_;  // stamps grow
};

/// Topics and options of a source.
struct Ros2Setup {
  mcap::Topic left;
  mcap::Topic right;  ///< images, or depth or disparities of the left ones (PairingOptions::has_depth)
  io::Calibration calibration;
  capture::PairingOptions pairing{};
  std::string poses{};         ///< topic of nav_msgs/Odometry; "": the frames have none, or those of TF
  std::string world_frame{};   ///< not empty: poses are those of TF in this frame
  std::string base_frame{};    ///< the robot's, of which the topic has the poses
  std::string camera_frame{};  ///< left camera's optical frame
  std::shared_ptr<rosbag::TransformBuffer> transforms{};
  std::optional<Pose2> base_from_camera{};  ///< given by the user; none: that of TF at the frame's instant
  bool uses_sim_time{false};                ///< time is that of /clock
};

/// Images of two cameras, or of one with depth, as topics of ROS 2, paired by their stamps, which the frames keep. If
/// poses are required, frames without one are left out and counted, as are dropped poses. After a step back of the
/// stamps the stream counts as a new one.
class Ros2Source final : public capture::LiveSource {
 public:
  Ros2Source(std::shared_ptr<dds::Node> node, const Ros2Setup& setup);
  ~Ros2Source() override;

  [[nodiscard]] const Rig& rig() const override;
  [[nodiscard]] std::optional<capture::LiveFrame> next(std::chrono::milliseconds patience) override;
  [[nodiscard]] bool has_ended() const override { return false; }
  [[nodiscard]] std::string fault() const override;
  [[nodiscard]] std::vector<capture::Drop> dropped() const override;

 private:
  struct State;

  void subscribe_images(capture::Side side, const mcap::Topic& topic);

  std::shared_ptr<dds::Node> node_;
  std::shared_ptr<State> state_;  // the node has it, too
};

/// Sleeps 50 ms at a time and logs what it waits for: after 2 s, then every 10 s.
class Waiting {
 public:
  void print(const std::string& sentence);

 private:
  using Clock = std::chrono::steady_clock;

  std::string sentence_;
  Clock::time_point next_log_{};
};

/// Newest message of each topic; subscribed for the lifetime of this object.
class NewestMessages {
 public:
  explicit NewestMessages(dds::Node& node) : node_{node} {}
  NewestMessages(const NewestMessages&) = delete;
  NewestMessages& operator=(const NewestMessages&) = delete;
  ~NewestMessages();

  /// A topic that has been added already: no effect.
  void add(const mcap::Topic& topic);
  [[nodiscard]] std::optional<std::vector<std::byte>> of(const std::string& topic) const;

 private:
  struct State {
    std::mutex mutex;
    std::map<std::string, std::vector<std::byte>> messages;  // empty: none yet
  };

  dds::Node& node_;
  std::shared_ptr<State> state_{std::make_shared<State>()};  // the node has it, too
};

/// Start of a SOURCE of ROS 2, before the namespace.
inline constexpr std::string_view ros2_scheme{"ros2:"};

/// Frames of TF that place grids.
struct GridFrames {
  std::string camera;  ///< left camera's
  std::string world;   ///< frame of the poses; "": none
  Pose2 vehicle_from_camera;
  std::shared_ptr<rosbag::TransformBuffer> transforms;
};

/// Subscribes grids of another program on the network, whose topic is chosen as in bags and waited for. Returns
/// Input::grid_at: the grid of the nearest stamp that has come. It throws InputError: TF does not place it, or as
/// rosbag::decode_grid().
[[nodiscard]] decltype(Input::grid_at) subscribe_grids(dds::Node& node, const InputOptions& options, GridFrames frames);

/// Topics that others publish below the namespace of SOURCE, all where the options name topics. `elsewhere`: names of
/// the other topics of images.
[[nodiscard]] std::vector<mcap::Topic> topics_of(const dds::Node& node, const InputOptions& options,
                                                 std::string* elsewhere = nullptr);

struct FoundImages {
  rosbag::ImageTopics images;
  mcap::Topic left;
  mcap::Topic right;
};

/// Topics of left images and of right images or depth, chosen as in bags; logs what it waits for.
[[nodiscard]] FoundImages wait_for_images(dds::Node& node, const InputOptions& options);

struct LiveCalibration {
  io::Calibration calibration;
  std::string camera_frame{};  ///< frame_id of the left CameraInfo; "": unknown
};

/// Calibration of the file in the options, else of CameraInfo (and of DisparityImage), which is waited for. Throws
/// InputError: it does not fit the images; depth that does not belong to them.
[[nodiscard]] LiveCalibration live_calibration(dds::Node& node, const InputOptions& options, const FoundImages& found);

}  // namespace stereogrid::app
