// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros2_source.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/ros_image.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using capture::CameraPair;
using capture::Clock;
using capture::Side;

constexpr std::size_t image_depth{5};  // as ROS has it for sensors
constexpr std::size_t pose_depth{100};
constexpr auto pose_patience{200ms};
constexpr auto first_pose_patience{1000ms};
constexpr std::int64_t before_all{std::numeric_limits<std::int64_t>::min()};
constexpr std::int64_t step_back_ns{1'000'000'000};  // images that overtake each other are nearer
constexpr auto other_clock{10s};                     // so far off, stamps say nothing of latency

template <class T>
std::int64_t nanoseconds(T instant) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()).count();
}

/// A simulation's, or that of a bag which is played.
struct SimulatedClock {
  STEREOGRID_MESSAGE("rosgraph_msgs/msg/Clock", clock);

  messages::builtin_interfaces::Time clock;
};

/// A camera's topic.
struct Images {
  Side side;
  mcap::Topic topic;
  std::string name;
};

}  // namespace

struct Ros2Source::State {
  explicit State(const Ros2Setup& given)
      : setup{given}, poses_name{io::printable(given.poses)}, poses{poses_name}, pair{new_pair()} {}

  [[nodiscard]] std::shared_ptr<CameraPair> new_pair() const {
    return std::make_shared<CameraPair>(setup.calibration, setup.pairing);
  }
  void take_image(const Images& images, std::span<const std::byte> cdr);
  [[nodiscard]] std::shared_ptr<CameraPair> pair_of(Side side, std::int64_t stamp_ns);
  void take_clock(std::span<const std::byte> cdr);
  void request_reset(const char* why);
  void take_pose(std::span<const std::byte> cdr);
  [[nodiscard]] Pose2 pose_at(std::int64_t stamp_ns);
  void log_dropped_poses();
  void place(capture::LiveFrame& live);

  [[nodiscard]] std::shared_ptr<CameraPair> current() const {
    const std::scoped_lock lock{mutex};
    return pair;
  }
  [[nodiscard]] Clock::time_point instant_of(std::int64_t stamp_ns) const {
    return Clock::time_point{std::chrono::nanoseconds{stamp_ns - clock_ns}};
  }
  [[nodiscard]] std::int64_t stamp_of(Clock::time_point instant) const { return nanoseconds(instant) + clock_ns; }

  const Ros2Setup setup;
  // stamps are Unix time, or a simulation's; the same offset always, so that frames get them back as they were
  const std::int64_t clock_ns{nanoseconds(std::chrono::system_clock::now()) - nanoseconds(Clock::now())};
  const std::string poses_name;
  PoseBuffer poses;
  // used by next()
  std::shared_ptr<CameraPair> last_pair;
  std::int64_t frames{0};

  mutable std::mutex mutex;  // protects the members below
  std::shared_ptr<CameraPair> pair;
  std::array<std::int64_t, 2> newest_ns{before_all, before_all};  // newest stamp of each camera; their clocks may
                                                                  // differ
  std::int64_t simulated_ns{0};
  std::map<std::string, std::int64_t> earlier;  // dropped before a step back
  std::int64_t without_pose{0};
  std::string pose_fault;
  rosbag::PoseTally tally;
  std::size_t reported_dropped{0};  // last reported number
};

std::shared_ptr<CameraPair> Ros2Source::State::pair_of(Side side, std::int64_t stamp_ns) {
  const std::scoped_lock lock{mutex};
  std::int64_t& newest{newest_ns.at(side == Side::left ? 0 : 1)};
  if (stamp_ns + step_back_ns < newest) request_reset("the stamps of the images step back");
  newest = std::max(newest, stamp_ns);
  return pair;
}

void Ros2Source::State::take_clock(std::span<const std::byte> cdr) {
  SimulatedClock message;
  messages::decode(cdr, message);
  const std::int64_t now_ns{rosbag::ns_of(message.clock)};
  const std::scoped_lock lock{mutex};
  if (now_ns < std::exchange(simulated_ns, now_ns)) request_reset("/clock steps back");
}

void Ros2Source::State::request_reset(const char* why) {
  spdlog::info("{}: restart", why);
  poses.clear();
  setup.transforms->clear();
  for (const capture::Drop& drop : pair->dropped()) earlier[drop.reason] += drop.frames;
  pair = new_pair();
  newest_ns.fill(before_all);
}

void Ros2Source::State::take_image(const Images& images, std::span<const std::byte> cdr) {
  const std::int64_t header_ns{rosbag::header_stamp_ns(cdr)};
  const std::int64_t stamp_ns{header_ns == 0 ? stamp_of(Clock::now()) : header_ns};  // 0: cameras that do not stamp
  const std::shared_ptr<CameraPair> taker{pair_of(images.side, stamp_ns)};
  try {
    if (images.side == Side::right && setup.pairing.has_depth) {
      const Rig& rig{setup.calibration.rig};
      taker->add_depth(
          io::fit_depth(rosbag::decode_depth(cdr, images.topic, images.name), rig.width_px, rig.height_px, images.name),
          instant_of(stamp_ns));
    } else {
      taker->add(images.side, rosbag::decode_image(cdr, rosbag::is_compressed(images.topic), images.name),
                 instant_of(stamp_ns));
    }
  } catch (const InputError&) {
    taker->add_unusable();
    throw;  // reported once by the node
  }
}

void Ros2Source::State::take_pose(std::span<const std::byte> cdr) {
  std::vector<io::StampedPose> found;
  {
    const std::scoped_lock lock{mutex};
    rosbag::add_poses(found, tally, messages::nav_msgs::Odometry::type_name, cdr);
    if (tally.dropped() > 0 && tally.dropped() >= 10 * reported_dropped) log_dropped_poses();
  }
  poses.add(found);
}

/// The mutex is locked.
void Ros2Source::State::log_dropped_poses() {
  if (reported_dropped == tally.dropped()) return;
  reported_dropped = tally.dropped();
  spdlog::warn("{}: {}. Correct what publishes them.", poses_name, tally.text());
}

Pose2 Ros2Source::State::pose_at(std::int64_t stamp_ns) {
  const std::optional<Pose2>& fixed{setup.base_from_camera};
  const auto of_tf = [&](const std::string& frame, const std::string& child) {
    return setup.transforms->at(frame, child, stamp_ns, pose_patience);
  };
  if (!setup.world_frame.empty()) {
    return fixed ? rosbag::pose_of_vehicle(of_tf(setup.world_frame, setup.base_frame)) * *fixed
                 : rosbag::pose_of_camera(of_tf(setup.world_frame, setup.camera_frame));
  }
  const Pose2 base{poses.at(stamp_ns, pose_patience)};
  return base * (fixed ? *fixed : rosbag::pose_of_camera(of_tf(setup.base_frame, setup.camera_frame)));
}

void Ros2Source::State::place(capture::LiveFrame& live) {
  if (setup.poses.empty() && setup.world_frame.empty()) return;
  try {
    live.frame.world_from_vehicle = pose_at(live.frame.stamp_ns);
  } catch (const InputError& error) {
    const std::scoped_lock lock{mutex};
    ++without_pose;
    pose_fault = error.what() + (tally.dropped() > 0 ? fmt::format(" Of {}, {}.", poses_name, tally.text()) : "");
    throw;
  }
  const std::scoped_lock lock{mutex};
  pose_fault.clear();
}

Ros2Source::Ros2Source(std::shared_ptr<dds::Node> node, const Ros2Setup& setup)
    : node_{std::move(node)}, state_{std::make_shared<State>(setup)} {
  if (setup.uses_sim_time) {
    node_->subscribe("/clock", std::string{SimulatedClock::type_name}, 1,
                     [state = state_](std::span<const std::byte> cdr) { state->take_clock(cdr); });
  }
  if (!setup.poses.empty()) {
    node_->subscribe(setup.poses, std::string{messages::nav_msgs::Odometry::type_name}, pose_depth,
                     [state = state_](std::span<const std::byte> cdr) { state->take_pose(cdr); });
    state_->poses.wait_for_first(first_pose_patience);  // images before it cannot be placed
  }
  subscribe_images(capture::Side::left, setup.left);
  subscribe_images(capture::Side::right, setup.right);
}

void Ros2Source::subscribe_images(capture::Side side, const mcap::Topic& topic) {
  node_->subscribe(topic.name, topic.type, image_depth,
                   [state = state_, images = Images{side, topic, io::printable(topic.name)}](
                       std::span<const std::byte> cdr) { state->take_image(images, cdr); });
}

Ros2Source::~Ros2Source() {
  const std::scoped_lock lock{state_->mutex};
  state_->log_dropped_poses();
}

const Rig& Ros2Source::rig() const {
  return state_->setup.calibration.rig;
}

std::optional<capture::LiveFrame> Ros2Source::next(std::chrono::milliseconds patience) {
  State& state{*state_};
  const std::shared_ptr<CameraPair> pair{state.current()};
  std::optional<capture::LiveFrame> live{pair->next(patience)};
  if (!live) return std::nullopt;
  live->resets_before = state.last_pair && state.last_pair != pair;
  state.last_pair = pair;
  live->frame.stamp_ns = state.stamp_of(live->captured);
  live->frame.index = state.frames++;
  live->frame.name = fmt::format("{:06}", live->frame.index);
  if (std::chrono::abs(Clock::now() - live->captured) > other_clock) live->captured = Clock::now();
  state.place(*live);
  return live;
}

std::string Ros2Source::fault() const {
  const std::string of_images{state_->current()->fault()};
  const std::scoped_lock lock{state_->mutex};
  return of_images.empty() ? state_->pose_fault : of_images;
}

std::vector<capture::Drop> Ros2Source::dropped() const {
  const std::scoped_lock lock{state_->mutex};
  std::map<std::string, std::int64_t> reasons{state_->earlier};
  for (const capture::Drop& drop : state_->pair->dropped()) reasons[drop.reason] += drop.frames;
  if (state_->without_pose > 0) reasons["no pose of its instant"] = state_->without_pose;
  std::vector<capture::Drop> drops;
  for (const auto& [reason, frames] : reasons) drops.push_back({reason, frames});
  return drops;
}

}  // namespace stereogrid::app
