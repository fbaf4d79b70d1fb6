// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../support.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::app::testing {

using messages::sensor_msgs::CameraInfo;

constexpr std::int64_t step_ns{100'000'000};
constexpr std::int64_t start_ns{1'700'000'000'000'000'000};  // a clock of today
constexpr std::size_t frames{4};

/// A message of a bag.
struct Entry {
  std::string topic;
  std::string type;
  std::int64_t log_ns;
  std::vector<std::byte> data;
};

void write_mcap(const fs::path& path, const std::vector<Entry>& entries);
/// A folder as rosbag2 leaves it.
void write_db3(const fs::path& folder, const std::vector<Entry>& entries);

[[nodiscard]] messages::std_msgs::Header header(std::int64_t stamp_ns);
[[nodiscard]] messages::geometry_msgs::TransformStamped transform(
    const std::string& parent, const std::string& child, const messages::geometry_msgs::Vector3& translation,
    const messages::geometry_msgs::Quaternion& rotation = {0, 0, 0, 1});
/// An optical frame whose z points ahead and x to the right.
constexpr messages::geometry_msgs::Quaternion ahead{-0.5, 0.5, -0.5, 0.5};
/// `encoding`: mono8, mono16 (12 bits), or of three equal channels. Without header; rows have a margin.
[[nodiscard]] messages::sensor_msgs::Image image_of(const Image<std::uint8_t>& grey, const std::string& encoding);

template <class M>
Entry entry(const std::string& topic, std::int64_t log_ns, const M& message) {
  messages::CdrWriter writer;
  const auto bytes{writer.encode(message)};
  return {topic, std::string{M::type_name}, log_ns, {bytes.begin(), bytes.end()}};
}

/// Content of the bag for a test.
struct Wanted {
  std::string encoding{"mono8"};  ///< or "png"
  std::string left{"/left/image_rect"};
  std::string right{"/right/image_rect"};
  std::int64_t right_late_ns{0};
  std::function<void(CameraInfo& left, CameraInfo& right)> spoil_infos{[](CameraInfo&, CameraInfo&) {}};
  bool has_infos{true};
};

/// A drive of four frames as a plain folder, which each test puts into bags.
class Bags : public SharedFolderTest {
 protected:
  static void SetUpTestSuite();
  static fs::path drive() { return *folder / "drive"; }
  static fs::path plain() { return *folder / "plain"; }  ///< its run
  static fs::path bag() { return *folder / "drive.mcap"; }
  static fs::path out() { return *folder / "out"; }

  static std::int64_t stamp_of(std::size_t frame) { return static_cast<std::int64_t>(frame) * step_ns; }
  /// As the drive's calibration.yaml.
  static CameraInfo info(bool is_right);
  static CameraInfo info(bool is_right, const Rig& rig);
  static Entry image(const std::string& topic, const char* side, std::size_t frame, const std::string& encoding,
                     std::int64_t late_ns);
  static std::vector<Entry> entries(const Wanted& wanted);

  /// Into out(), which is emptied before.
  static Outcome run_bag(const fs::path& path, const Words& more = {"--poses", "none"});
  /// The same, of a bag that can be used. `name`: where the results go to.
  static fs::path run_bag_well(const char* name, const fs::path& path = bag());
  /// Expects the run of this bag to equal that of the plain folder. Returns its messages.
  static std::string expect_plain(const std::vector<Entry>& content);
  static void expect_error(const std::vector<Entry>& content, const std::string& said, const Words& more = {});
};

}  // namespace stereogrid::app::testing
