// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>

#include "../messages/random_filler.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/mcap/reader.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/rosbag/rosbag.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

struct Entry {
  std::uint16_t topic;
  std::uint64_t log_ns;
  std::span<const std::byte> cdr;
};

bool is_among(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::ranges::find(names, name) != names.end();
}

/// A bag whose content is the input, without the file format, which has its own fuzzers.
class MemoryBag final : public mcap::Bag {
 public:
  void add(const std::string& name, const std::string& type, std::uint64_t log_ns, std::string_view cdr) {
    auto topic{std::ranges::find(topics_, name, &mcap::Topic::name)};
    if (topic == topics_.end()) topic = topics_.insert(topic, {name, type, "cdr", "", "", "", 0});
    ++topic->message_count;
    entries_.push_back({static_cast<std::uint16_t>(topic - topics_.begin()), log_ns, std::as_bytes(std::span{cdr})});
  }

  [[nodiscard]] const std::vector<mcap::Topic>& topics() const override { return topics_; }
  [[nodiscard]] std::uint64_t first_ns() const override { return 0; }
  [[nodiscard]] std::uint64_t last_ns() const override { return 0; }
  [[nodiscard]] std::vector<std::string> damage() const override { return {}; }
  [[nodiscard]] std::unique_ptr<mcap::MessageCursor> messages(const mcap::Selection& selection) const override {
    auto cursor{std::make_unique<Cursor>()};
    for (const Entry& entry : entries_) {
      if (entry.log_ns < selection.first_ns || entry.log_ns > selection.last_ns) continue;
      if (is_among(selection.topics, topics_[entry.topic].name)) {
        cursor->left.push_back({entry.topic, 0, entry.log_ns, entry.log_ns, entry.cdr});
      }
    }
    std::ranges::reverse(cursor->left);
    return cursor;
  }

 private:
  struct Cursor final : mcap::MessageCursor {
    const mcap::Message* next() override {
      if (left.empty()) return nullptr;
      message = left.back();
      left.pop_back();
      return &message;
    }
    std::vector<mcap::Message> left;  // the next one last
    mcap::Message message;
  };

  std::vector<mcap::Topic> topics_;
  std::vector<Entry> entries_;
};

/// Adds the second topic: right images, depth, disparities, or none beside images that hold both.
void add_second(MemoryBag& bag, char kind, const std::string& images, const std::string& type, std::uint64_t log_ns,
                std::string_view cdr) {
  const bool is_compressed{(kind & 1) != 0};
  const bool is_depth{(kind & 8) != 0};
  const bool is_other{(kind & 64) != 0};
  if (is_depth && is_other) {
    bag.add("/disparity", "stereo_msgs/msg/DisparityImage", log_ns, cdr);
  } else if (is_depth) {
    bag.add(is_compressed ? "/depth/image_rect_raw/compressedDepth" : "/depth/image_rect_raw", type, log_ns, cdr);
  } else if (!is_other) {
    bag.add("/right" + images, type, log_ns, cdr);
  }
}

/// Each message is recorded twice, which images without stamps make two pairs.
std::unique_ptr<mcap::Bag> bag_of(Bytes input) {
  const auto parts{parts_of(input, 6)};
  const char kind{parts[0].empty() ? '0' : parts[0].front()};
  const bool is_compressed{(kind & 1) != 0};
  const std::string images{(kind & 2) != 0 ? "/image_rect" : "/image_raw"};
  const std::string image_type{is_compressed ? "sensor_msgs/msg/CompressedImage" : "sensor_msgs/msg/Image"};
  auto bag{std::make_unique<MemoryBag>()};
  const std::string transport{is_compressed ? "/compressed" : ""};
  for (const std::uint64_t log_ns : {1, 2}) {
    bag->add("/left" + images + transport, image_type, log_ns, parts[1]);
    add_second(*bag, kind, images + transport, image_type, log_ns, parts[2]);
    bag->add("/left/camera_info", "sensor_msgs/msg/CameraInfo", log_ns, parts[3]);
    bag->add("/right/camera_info", "sensor_msgs/msg/CameraInfo", log_ns, parts[4]);
    if ((kind & 4) != 0) bag->add("/odom", "nav_msgs/msg/Odometry", log_ns, parts[5]);
    bag->add("/tf", "tf2_msgs/msg/TFMessage", log_ns, parts[5]);
  }
  return bag;
}

void check(const io::Recording& recording) {
  require(recording.size() > 0, "a recording without frames");
  require(problems(recording.rig()).empty(), "a rig that is none");
  accepts([&] {
    const StereoFrame frame{recording.load(0)};
    require(frame.left.width() == recording.rig().width_px && frame.left.height() == recording.rig().height_px,
            "an image that is not of the rig's size");
    require(frame.right.size() == (recording.gives_disparities() ? 0 : frame.left.size()), "images of two sizes");
    require(frame.disparity.size() == (recording.gives_disparities() ? frame.left.size() : 0),
            "disparities of another size");
    for (const float d : frame.disparity) require(std::isfinite(d) && d >= 0, "a disparity that is none");
  });
}

}  // namespace

/// A digit for the kind of bag, then files: five messages.
FUZZ_TARGET(bag_recording) {
  accepts([&] { check(*rosbag::bag_recording(bag_of(input), {{"a bag"}, {}, ""}, {})); });
}

/// A byte for the type, then a message. Its certainty is the message itself.
FUZZ_TARGET(bag_grid) {
  if (input.empty()) return;
  const std::span<const std::byte> cdr{std::as_bytes(input.subspan(1))};
  const bool has_cells{(input[0] & 1) != 0};
  accepts([&] {
    io::PlacedGrid grid{rosbag::decode_grid(
        cdr, has_cells ? messages::nav_msgs::GridCells::type_name : messages::nav_msgs::OccupancyGrid::type_name,
        "a grid")};
    accepts([&] { rosbag::set_certainty(grid, cdr, "a grid"); });
    const ObservedGrid made{io::resampled(grid, {0, -2, 0.5, 8, 8})};
    const auto is_share = [](float value) { return value >= 0 && value <= 1; };
    require(std::ranges::all_of(made.occupancy, is_share) && std::ranges::all_of(made.confidence, is_share),
            "a grid with values that are no probabilities");
  });
}

namespace {

/// Reads every byte; returns the number of messages.
std::uint64_t drain(mcap::MessageCursor& cursor) {
  std::uint64_t messages{0};
  for (; const mcap::Message* const message{cursor.next()}; ++messages) {
    std::uint64_t sum{0};
    for (const std::byte byte : message->data) sum += static_cast<std::uint64_t>(byte);
    require(sum <= 255 * message->data.size(), "bytes of more than 255");
  }
  return messages;
}

void drain(const mcap::Bag& bag) {
  const auto cursor{bag.messages({})};
  std::uint64_t last_ns{0};
  while (const mcap::Message* const message{cursor->next()}) {
    require(message->channel < bag.topics().size(), "a message of no topic");
    require(message->log_time_ns >= last_ns, "messages not in the order of time");
    last_ns = message->log_time_ns;
  }
}

}  // namespace

FUZZ_TARGET(mcap) {
  static const Folder folder;
  const auto file{folder.write("a.mcap", text_of(input))};
  accepts([&] {
    mcap::StreamReader stream{file};
    const std::uint64_t messages{drain(stream)};
    std::uint64_t counted{0};
    for (const auto& [channel, count] : stream.contents().message_counts) counted += count;
    require(counted == messages, "a stream counts other messages than it gives");
    const mcap::Reader reader{file};
    drain(*reader.messages());
    require(reader.is_indexed() || reader.damage().any() == stream.damage().any(), "what is damaged is not reported");
  });
}

FUZZ_TARGET(bag_db3) {
  static const Folder folder;
  const auto file{folder.write("a.db3", text_of(input))};
  accepts([&] { drain(*mcap::open_bag(file)); });
}

/// File metadata.yaml of a bag without parts.
FUZZ_TARGET(bag_metadata) {
  static const Folder folder;
  folder.write("metadata.yaml", text_of(input));
  accepts([&] { drain(*mcap::open_bag(folder.path())); });
}

namespace {

using namespace stereogrid::messages;

// Accepted messages are written and read back without a change.
template <Message M>
void read_and_write(std::span<const std::byte> cdr) {
  M message;
  if (!accepts([&] { decode(cdr, message); })) return;
  CdrWriter first;
  const auto written{first.encode(message)};
  M again;
  decode(written, again);
  CdrWriter second;
  require(std::ranges::equal(second.encode(again), written),
          "a message changes when it is written: " + std::string{M::type_name});
}

}  // namespace

/// A byte for the type, then a message.
FUZZ_TARGET(cdr) {
  if (input.empty()) return;
  const std::span<const std::byte> bytes{std::as_bytes(input.subspan(1))};
  int number{0};
  messages::test::for_each_type([&]<Message M>(const M& /*type*/) {
    if (number++ == input[0]) read_and_write<M>(bytes);
  });
}

}  // namespace stereogrid::fuzz
