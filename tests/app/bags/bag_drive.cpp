// SPDX-License-Identifier: Apache-2.0
#include "bag_drive.hpp"

#include <sqlite3.h>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/mcap/writer.hpp"

namespace stereogrid::app::testing {

void write_mcap(const fs::path& path, const std::vector<Entry>& entries) {
  mcap::Writer writer{path, {.chunk_bytes = 20'000}};
  std::map<std::string, std::uint16_t> channels;
  for (const Entry& entry : entries) {
    auto [channel, is_new]{channels.try_emplace(entry.topic)};
    if (is_new)
      channel->second = writer.add_channel(entry.topic, "cdr", writer.add_schema(entry.type, "ros2msg", ""), {});
    const auto time_ns{static_cast<std::uint64_t>(entry.log_ns)};
    writer.write(channel->second, 0, time_ns, time_ns, entry.data);
  }
  writer.close();
}

void write_db3(const fs::path& folder, const std::vector<Entry>& entries) {
  fs::create_directories(folder);
  sqlite3* database{nullptr};
  ASSERT_EQ(sqlite3_open((folder / "bag_0.db3").c_str(), &database), SQLITE_OK);
  const auto execute = [&](const std::string& line) {
    ASSERT_EQ(sqlite3_exec(database, line.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << line;
  };
  execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)");
  execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)");
  execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
  execute("BEGIN");
  std::map<std::string, std::size_t> topics;
  for (const Entry& entry : entries) {
    const auto [topic, is_new]{topics.try_emplace(entry.topic, topics.size() + 1)};
    const std::string id{std::to_string(topic->second)};
    if (is_new) execute("INSERT INTO topics VALUES(" + id + ",'" + entry.topic + "','" + entry.type + "','cdr')");
    sqlite3_stmt* row{nullptr};
    const std::string insert{"INSERT INTO messages VALUES(NULL," + id + "," + std::to_string(entry.log_ns) + ",?)"};
    ASSERT_EQ(sqlite3_prepare_v2(database, insert.c_str(), -1, &row, nullptr), SQLITE_OK);
    sqlite3_bind_blob(row, 1, entry.data.data(), static_cast<int>(entry.data.size()), SQLITE_STATIC);
    ASSERT_EQ(sqlite3_step(row), SQLITE_DONE);
    sqlite3_finalize(row);
  }
  execute("COMMIT");
  sqlite3_close(database);
  std::ofstream{folder / "metadata.yaml"}
      << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths:\n"
         "    - bag_0.db3\n  compression_format: \"\"\n  compression_mode: \"\"\n";
}

messages::std_msgs::Header header(std::int64_t stamp_ns) {
  return {{static_cast<std::int32_t>(stamp_ns / 1'000'000'000), static_cast<std::uint32_t>(stamp_ns % 1'000'000'000)},
          "camera"};
}

messages::geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child,
                                                    const messages::geometry_msgs::Vector3& translation,
                                                    const messages::geometry_msgs::Quaternion& rotation) {
  messages::geometry_msgs::TransformStamped one;
  one.header.frame_id = parent;
  one.child_frame_id = child;
  one.transform = {translation, rotation};
  return one;
}

messages::sensor_msgs::Image image_of(const Image<std::uint8_t>& grey, const std::string& encoding) {
  messages::sensor_msgs::Image message;
  message.width = static_cast<std::uint32_t>(grey.width());
  message.height = static_cast<std::uint32_t>(grey.height());
  message.encoding = encoding;
  const bool is_wide{encoding == "mono16"};
  const std::uint32_t copies{encoding == "mono8" || is_wide ? 1U : 3U};
  message.step = message.width * (is_wide ? 2 : copies) + 2;  // rows with a margin
  for (int v{0}; v < grey.height(); ++v) {
    for (int u{0}; u < grey.width(); ++u) {
      const unsigned value{grey(u, v)};
      if (is_wide) {
        message.data.push_back(static_cast<std::uint8_t>(value << 4));  // 12 bits
        message.data.push_back(static_cast<std::uint8_t>(value >> 4));
      } else {
        message.data.insert(message.data.end(), copies, static_cast<std::uint8_t>(value));
      }
    }
    message.data.insert(message.data.end(), 2, 0);
  }
  return message;
}

void Bags::SetUpTestSuite() {
  SharedFolderTest::SetUpTestSuite();
  // values without rounding errors; CameraInfo has no extrinsics
  run_well({"simulate", small_scene("street", "&frames=4&focal=128&baseline=0.25"), "--out", drive(), "--no-truth"});
  edit(drive() / "calibration.yaml", "mount.*\n", "");
  run_well({"run", drive(), "--out", plain(), "--poses", "none"});
}

CameraInfo Bags::info(bool is_right) {
  return info(is_right, io::read_calibration(drive() / "calibration.yaml", 160, 100).rig);
}

CameraInfo Bags::info(bool is_right, const Rig& rig) {
  CameraInfo message;
  message.width = 160;
  message.height = 100;
  message.distortion_model = "plumb_bob";
  message.d.resize(5);
  message.k = {rig.focal_px, 0, rig.cx_px, 0, rig.focal_px, rig.cy_px, 0, 0, 1};
  message.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double shift{is_right ? -rig.focal_px * rig.baseline_m : 0};
  message.p = {rig.focal_px, 0, rig.cx_px, shift, 0, rig.focal_px, rig.cy_px, 0, 0, 0, 1, 0};
  return message;
}

Entry Bags::image(const std::string& topic, const char* side, std::size_t frame, const std::string& encoding,
                  std::int64_t late_ns) {
  const fs::path file{drive() / side / ("00000" + std::to_string(frame) + ".png")};
  const std::int64_t stamp_ns{stamp_of(frame) + late_ns};
  const std::int64_t log_ns{start_ns + stamp_ns + 3'000'000};
  if (encoding == "png") {
    const std::string bytes{text_of(file)};
    messages::sensor_msgs::CompressedImage message;
    message.header = header(stamp_ns);
    message.format = "mono8; png compressed";
    message.data.assign(bytes.begin(), bytes.end());
    return entry(topic, log_ns, message);
  }
  messages::sensor_msgs::Image message{image_of(io::read_grey(file), encoding)};
  message.header = header(stamp_ns);
  return entry(topic, log_ns, message);
}

namespace {

std::string info_topic(const std::string& images) {
  return images.substr(0, images.find('/', 1)) + "/camera_info";
}

}  // namespace

std::vector<Entry> Bags::entries(const Wanted& wanted) {
  std::vector<Entry> all;
  CameraInfo left{info(false)};
  CameraInfo right{info(true)};
  wanted.spoil_infos(left, right);
  for (std::size_t i{0}; i < frames; ++i) {
    if (wanted.has_infos) {
      all.push_back(entry(info_topic(wanted.left), start_ns + stamp_of(i), left));
      all.push_back(entry(info_topic(wanted.right), start_ns + stamp_of(i), right));
    }
    all.push_back(image(wanted.left, "left", i, wanted.encoding, 0));
    all.push_back(image(wanted.right, "right", i, wanted.encoding, wanted.right_late_ns));
  }
  return all;
}

Outcome Bags::run_bag(const fs::path& path, const Words& more) {
  fs::remove_all(out());
  return run_tool(joined({"run", path, "--out", out()}, more));
}

fs::path Bags::run_bag_well(const char* name, const fs::path& path) {
  const Outcome outcome{run_bag(path)};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  fs::path run{*folder / name};
  fs::remove_all(run);
  fs::rename(out(), run);
  return run;
}

std::string Bags::expect_plain(const std::vector<Entry>& content) {
  write_mcap(bag(), content);
  const Outcome outcome{run_bag(bag())};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  expect_equal_runs(plain(), out());
  return outcome.errors;
}

void Bags::expect_error(const std::vector<Entry>& content, const std::string& said, const Words& more) {
  write_mcap(bag(), content);
  EXPECT_THAT(errors_of(65, joined({"info", bag()}, more)), AllOf(HasSubstr(said), HasSubstr("drive.mcap")));
}

}  // namespace stereogrid::app::testing
