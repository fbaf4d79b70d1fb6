// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <span>
#include <utility>

#include "ros2/ros2_source.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t grid_depth{5};  // as ROS has it for sensors
constexpr std::size_t messages_kept{20};
constexpr auto transform_patience{200ms};

/// The last messages of a topic by their stamps. For any threads.
class LastMessages {
 public:
  void add(std::span<const std::byte> cdr) {
    Stamped message{rosbag::header_stamp_ns(cdr), {cdr.begin(), cdr.end()}};
    const std::scoped_lock lock{mutex_};
    if (messages_.size() == messages_kept) messages_.pop_front();
    messages_.push_back(std::move(message));
  }

  /// The nearest one within rosbag::grid_tolerance_ns; empty: none.
  [[nodiscard]] std::vector<std::byte> at(std::int64_t stamp_ns) const {
    const std::scoped_lock lock{mutex_};
    const auto apart = [stamp_ns](const Stamped& one) { return std::abs(one.stamp_ns - stamp_ns); };
    const auto nearest{std::ranges::min_element(messages_, {}, apart)};
    if (nearest == messages_.end() || apart(*nearest) > rosbag::grid_tolerance_ns) return {};
    return nearest->cdr;
  }

 private:
  struct Stamped {
    std::int64_t stamp_ns;
    std::vector<std::byte> cdr;
  };

  mutable std::mutex mutex_;
  std::deque<Stamped> messages_;
};

/// Subscribed topics of grids. Used by the node's thread and by that of the frames.
struct LastGrids {
  rosbag::GridTopics topics;
  std::string type;  ///< message type of topics.cells
  GridFrames frames;
  LastMessages cells{};
  LastMessages certainty{};

  [[nodiscard]] std::optional<io::PlacedGrid> at(const StereoFrame& frame) const;
  [[nodiscard]] Pose2 vehicle_from(const std::string& grid_frame, const StereoFrame& frame) const;
};

std::optional<io::PlacedGrid> LastGrids::at(const StereoFrame& frame) const {
  const std::vector<std::byte> cdr{cells.at(frame.stamp_ns)};
  if (cdr.empty()) return std::nullopt;
  io::PlacedGrid grid{rosbag::decode_grid(cdr, type, io::printable(topics.cells))};
  const std::vector<std::byte> graded{certainty.at(rosbag::header_stamp_ns(cdr))};
  if (!graded.empty()) rosbag::set_certainty(grid, graded, io::printable(topics.certainty));
  grid.vehicle_from_grid = vehicle_from(rosbag::frame_id_of(cdr), frame) * grid.vehicle_from_grid;
  return grid;
}

Pose2 LastGrids::vehicle_from(const std::string& grid_frame, const StereoFrame& frame) const {
  if (grid_frame == frames.camera) return frames.vehicle_from_camera;  // the axes are a body's all the same
  if (!frames.world.empty() && grid_frame == frames.world && frame.world_from_vehicle) {
    return inverse(*frame.world_from_vehicle);
  }
  const cv::Affine3d grid_from_camera{
      frames.transforms->at(grid_frame, frames.camera, frame.stamp_ns, transform_patience)};
  return frames.vehicle_from_camera * inverse(rosbag::camera_in_vehicle(grid_from_camera));
}

}  // namespace

decltype(Input::grid_at) subscribe_grids(dds::Node& node, const InputOptions& options, GridFrames frames) {
  auto grids{std::make_shared<LastGrids>()};
  grids->frames = std::move(frames);
  Waiting waiting;
  for (;;) {
    const std::vector<mcap::Topic> topics{topics_of(node, options)};
    grids->topics = rosbag::choose_grid_topics(topics, options.grid_topic);
    if (const std::string & cells{grids->topics.cells}; !cells.empty()) {
      grids->type = rosbag::find_topic(topics, cells)->type;
      break;
    }
    waiting.print(fmt::format("{} {}.", options.paths.front(), grids->topics.reason));
  }
  node.subscribe(grids->topics.cells, grids->type, grid_depth,
                 [grids](std::span<const std::byte> cdr) { grids->cells.add(cdr); });
  if (!grids->topics.certainty.empty()) {
    node.subscribe(grids->topics.certainty, std::string{messages::nav_msgs::OccupancyGrid::type_name}, grid_depth,
                   [grids](std::span<const std::byte> cdr) { grids->certainty.add(cdr); });
  }
  spdlog::info("grids of {}{}", io::printable(grids->topics.cells),
               grids->topics.certainty.empty() ? "" : " with " + io::printable(grids->topics.certainty));
  return [grids](const StereoFrame& frame) { return grids->at(frame); };
}

}  // namespace stereogrid::app
