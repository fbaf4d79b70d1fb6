// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/image.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"
#include "stereogrid/rosbag/transforms.hpp"

namespace stereogrid::rosbag {

/// Content of the second topic: the right images; depth or disparities of the left images; or the first topic again,
/// whose images are left and right beside each other, or left above right.
enum class SecondTopic { right, depth, disparity, beside, below };

/// Topics of the images of a bag.
struct ImageTopics {
  std::string left;
  std::string right;
  SecondTopic second{SecondTopic::right};

  [[nodiscard]] bool has_depth() const { return second == SecondTopic::depth || second == SecondTopic::disparity; }
  [[nodiscard]] bool is_one_topic() const { return second == SecondTopic::beside || second == SecondTopic::below; }
};

/// The second topic for people: "depth of /camera/depth", "disparities of …", or its name alone.
[[nodiscard]] std::string second_of(const ImageTopics& topics);

/// Encodings of the first messages (sensor_msgs/Image) by topic.
using Encodings = std::map<std::string, std::string>;

/// Returns the requested topics; "": found by their names. Pairs come before depth and disparities, these before a
/// single topic, which is `beside` until its images are seen. `bag`: for messages. `encodings`: may lack topics. Throws
/// InputError, which lists the candidates: there is no pair, or more than one camera has one.
[[nodiscard]] ImageTopics choose_image_topics(const std::string& bag, const std::vector<mcap::Topic>& topics,
                                              const ImageTopics& asked, const Encodings& encodings = {});

/// True for sensor_msgs/Image and CompressedImage with messages, depth left out where the name says so.
[[nodiscard]] bool holds_images(const mcap::Topic& topic);
/// Content of a topic as the second one; none: neither depth nor disparities.
[[nodiscard]] std::optional<SecondTopic> depth_kind_of(const mcap::Topic& topic, const Encodings& encodings);

/// nullptr: there is no such topic, or nothing on it.
[[nodiscard]] const mcap::Topic* find_topic(const std::vector<mcap::Topic>& topics, const std::string& name);

/// The one of these topics that is the right camera's by the name of the left camera's; empty: none.
[[nodiscard]] std::string right_name_of(const std::string& left, const std::vector<std::string>& there);

/// CameraInfo topic of a camera, beside its images.
[[nodiscard]] std::string info_topic_of(const mcap::Topic& images);
/// The one of these topics of CameraInfo that is called after the images (image_left: camera_info_left; left:
/// left_info, left/camera_info), else that beside them, which may not be there.
[[nodiscard]] std::string info_topic_of(const mcap::Topic& images, const std::vector<std::string>& there);
/// True if the topic's name says that the images are rectified.
[[nodiscard]] bool is_rectified(const mcap::Topic& images);
[[nodiscard]] bool is_compressed(const mcap::Topic& images);

/// The header, with which messages of images begin. Throws InputError.
[[nodiscard]] std::int64_t header_stamp_ns(std::span<const std::byte> cdr);
[[nodiscard]] std::int64_t ns_of(const messages::builtin_interfaces::Time& stamp);

/// A sensor_msgs/Image or CompressedImage, as io::decode_ros_image().
[[nodiscard]] io::ScaledImage decode_image(std::span<const std::byte> cdr, bool is_compressed, const std::string& name);

/// As io::decode_ros_depth() or io::decode_ros_disparities(). `topic`: of the message.
[[nodiscard]] Image<float> decode_depth(std::span<const std::byte> cdr, const mcap::Topic& topic,
                                        const std::string& name);

/// T of a DisparityImage, m; 0: it has none. Throws InputError: damaged.
[[nodiscard]] double disparity_baseline_m(std::span<const std::byte> cdr);
/// T of the first DisparityImage of a topic, m; 0: it has none.
[[nodiscard]] double first_baseline_m(const mcap::Bag& bag, const std::string& topic);

/// Topics of grids that another program has computed.
struct GridTopics {
  std::string cells;        ///< nav_msgs/OccupancyGrid or GridCells; empty: none
  std::string certainty{};  ///< OccupancyGrid with 0 … 100 for each cell, `cells` with "_certainty" behind; empty: none
  std::string reason{};     ///< why there are none, as the end of a message about the bag
};

/// Largest distance in time of a frame from its grid.
inline constexpr std::int64_t grid_tolerance_ns{100'000'000};

/// The requested topic; "": the only one, or the only one whose name has "occupancy".
[[nodiscard]] GridTopics choose_grid_topics(const std::vector<mcap::Topic>& topics, const std::string& asked);

/// frame_id of a message that begins with a header. Throws InputError.
[[nodiscard]] std::string frame_id_of(std::span<const std::byte> cdr);

/// Grid of a nav_msgs/OccupancyGrid (percent; others are unknown) or GridCells (occupied cells; the rest is unknown),
/// at its place in its frame. The confidence is 0.9 where cells are known. Throws InputError: damaged, tilted, too
/// large.
[[nodiscard]] io::PlacedGrid decode_grid(std::span<const std::byte> cdr, std::string_view type,
                                         const std::string& name);
/// Replaces the confidence of known cells by that of an OccupancyGrid of the same size. Throws InputError.
void set_certainty(io::PlacedGrid& grid, std::span<const std::byte> cdr, const std::string& name);

/// Number of poses that messages had, and of those that were dropped, by reason.
struct PoseTally {
  std::size_t poses{0};              ///< with those dropped; a message that cannot be decoded counts as one
  std::size_t undecodable{0};        ///< messages that are cut short or of another type
  std::size_t not_finite{0};         ///< NaN or infinity in the position or the orientation
  std::size_t not_unit{0};           ///< quaternions of another length than 1
  double first_length{0};            ///< length of the first one
  std::size_t too_far{0};            ///< positions beyond io::largest_position_m
  std::size_t contradicting{0};      ///< another pose has the same stamp
  std::set<std::string> transforms;  ///< transforms on /tf between other frames: five at most

  [[nodiscard]] std::size_t dropped() const { return undecodable + not_finite + not_unit + too_far + contradicting; }
  /// "2 of 3 poses are dropped (…)", with the reasons; empty: none.
  [[nodiscard]] std::string text() const;
};

/// Adds the poses of the vehicle on the ground that a message has: of nav_msgs/Odometry, or of the transform
/// odom → base_link in a tf2_msgs/TFMessage. `type`: type_name of one of them. Dropped poses are counted.
void add_poses(std::vector<io::StampedPose>& poses, PoseTally& tally, std::string_view type,
               std::span<const std::byte> cdr);

/// Poses of the vehicle in a bag, by stamp; all stamps differ.
struct BagPoses {
  std::vector<io::StampedPose> poses;  ///< fewer than two: none
  std::string source;                  ///< topic and type; empty: the bag has no such topic
  std::string frame{"base_link"};      ///< whose poses they are
  std::string world_frame{"odom"};     ///< in which they are
  std::string others;                  ///< topics that could have been taken, too; empty: none
  PoseTally tally;
};

/// Transforms on /tf_static. Messages that cannot be decoded are passed over.
void add_static_transforms(TransformBuffer& transforms, const mcap::Bag& bag);

/// Place and heading on the ground of a camera relative to a frame of the vehicle. None: the frames are not connected.
/// The camera's frame is optical (z ahead) or a body's (x ahead), by its attitude.
[[nodiscard]] std::optional<Pose2> camera_in_vehicle(TransformBuffer& transforms, const std::string& vehicle_frame,
                                                     const std::string& camera_frame);

/// The same by the transform of that camera to the vehicle's frame.
[[nodiscard]] Pose2 camera_in_vehicle(const cv::Affine3d& vehicle_from_camera);

/// Poses of the first nav_msgs/Odometry by name, else of the transform odom → base_link on /tf.
[[nodiscard]] BagPoses poses_of(const mcap::Bag& bag);

/// A camera's calibration, and the topic that it came from.
struct NamedInfo {
  messages::sensor_msgs::CameraInfo message;
  std::string name;   ///< bag and topic, for messages
  std::string topic;  ///< for people
};

/// Adds the first message of each camera to those of a topic that several cameras share: cameras differ in frame_id or
/// in P[3]. The left camera comes first. Of more than two cameras three are kept.
void add_camera(std::vector<messages::sensor_msgs::CameraInfo>& cameras,
                const messages::sensor_msgs::CameraInfo& message);

/// Calibration from both messages, for images of this size. Throws InputError: not a stereo pair.
[[nodiscard]] io::Calibration calibration_of(NamedInfo left, NamedInfo right, bool are_rectified, int width_px,
                                             int height_px);

/// Topics of CameraInfo for images with depth; empty: not there.
struct DepthInfoTopics {
  std::string images;  ///< beside the images, else beside their depth, else the only one
  std::string depth;
  std::string right;  ///< name of the right camera, whose baseline is that of the depth
};
[[nodiscard]] DepthInfoTopics depth_info_topics(const mcap::Topic& images, const mcap::Topic& depth,
                                                const std::vector<std::string>& there);

/// Baseline of a right camera, m; 0: the message has none.
[[nodiscard]] double baseline_m_of(const messages::sensor_msgs::CameraInfo& right);

/// Messages that calibrate images with depth.
struct DepthInfos {
  NamedInfo images;
  std::optional<NamedInfo> depth;  ///< none: taken as aligned to the images
  double baseline_m{0};            ///< 0: unknown
};

/// Calibration of images of this size with depth: one camera and a baseline, a virtual one where none is known or the
/// known one is short. `images`: the topic of `topics.left`. Throws InputError: depth of another camera; disparities
/// of raw images.
[[nodiscard]] io::Calibration calibration_of(DepthInfos infos, const mcap::Topic& images, const ImageTopics& topics,
                                             int width_px, int height_px);

/// Calibration from the first CameraInfo of each camera, for images of this size. They are rectified if the topics'
/// names say so, or if rectification would change nothing. Both cameras' messages may be on one topic. Throws
/// InputError: a camera has none, or they are not of a pair.
[[nodiscard]] io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                             int width_px, int height_px);

/// True for an .mcap, a .db3, or a folder of them.
[[nodiscard]] bool is_bag(const std::filesystem::path& path);

/// Options for a bag, as set by the user.
struct BagOptions {
  ImageTopics topics;  ///< "": found
  double pair_tolerance_ms{10};
  std::string grid_topic{};  ///< as for choose_grid_topics()
};

/// Namespace of one of InputArguments::cameras without a slash at its end: itself if it begins with one, else below
/// `root`.
[[nodiscard]] std::string namespace_of(const std::string& root, std::string camera);

/// Searches the whole bag, whose path is that of the arguments, for the images of both cameras. With a namespace in
/// `arguments.cameras`: for those below it, whose place in the vehicle /tf_static has. Throws InputError.
[[nodiscard]] std::unique_ptr<io::Recording> bag_recording(std::unique_ptr<mcap::Bag> bag,
                                                           const io::InputArguments& arguments,
                                                           const BagOptions& options);

/// The same of a path that is one; of several namespaces in `arguments.cameras`, all as one recording. Throws
/// InputError; ConfigError as io::open_cameras(), and for options of one camera.
[[nodiscard]] std::unique_ptr<io::Recording> open_recording(const io::InputArguments& arguments,
                                                            const BagOptions& options);

}  // namespace stereogrid::rosbag
