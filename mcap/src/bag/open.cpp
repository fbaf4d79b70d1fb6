// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <string>
#include <string_view>

#include "bag/bags.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::mcap {
namespace {

constexpr std::string_view sqlite_magic{"SQLite format 3\0", 16};
constexpr std::string_view zstd_magic{"\x28\xb5\x2f\xfd", 4};
constexpr std::string_view ros1_magic{"#ROS"};  // #ROSBAG V2.0, #ROSRECORD V1.1

std::string first_bytes_of(const std::filesystem::path& path) {
  const FileInput file{path};
  Bytes first(std::min<std::uint64_t>(file.size(), sqlite_magic.size()));
  file.read(0, first);
  return {reinterpret_cast<const char*>(first.data()), first.size()};
}

}  // namespace

std::uint16_t TopicList::add(const Topic& topic) {
  constexpr std::size_t most_topics{std::size_t{std::numeric_limits<std::uint16_t>::max()} + 1};
  constexpr std::size_t most_text_bytes{std::size_t{256} << 20};
  const auto [found, is_new]{indices_.try_emplace({topic.name, topic.type, topic.message_encoding},
                                                  static_cast<std::uint16_t>(topics_.size()))};
  if (!is_new) {
    topics_[found->second].message_count += topic.message_count;
    return found->second;
  }
  text_bytes_ += topic.name.size() + topic.type.size() + topic.offered_qos_profiles.size() + topic.schema.size();
  if (topics_.size() == most_topics || text_bytes_ > most_text_bytes) {
    throw InputError{file_,
                     topics_.size() == most_topics ? "has more than 65536 topics."
                                                   : "has topics with more than 256 MiB of names and schemas.",
                     "Record the topics of the cameras only."};
  }
  topics_.push_back(topic);
  return found->second;
}

std::unique_ptr<Bag> open_unpacked_bag(const std::filesystem::path& path) {
  const std::string first{first_bytes_of(path)};
  if (first.starts_with(magic)) return open_mcap_bag(path);
  if (first == sqlite_magic) return open_db3_bag(path);
  if (first.starts_with(ros1_magic)) {
    throw InputError{io::printable_path(path), "is a bag of ROS 1, which is not read (allowed: bags of ROS 2).",
                     "Convert it: pip install rosbags, then rosbags-convert --src FILE.bag --dst FOLDER."};
  }
  throw InputError{io::printable_path(path),
                   "is no recording: it begins neither as MCAP nor as SQLite, which rosbag2 writes.",
                   "Name an .mcap, a .db3, or the folder of a bag."};
}

std::unique_ptr<Bag> open_file_bag(const std::filesystem::path& path) {
  return first_bytes_of(path).starts_with(zstd_magic) ? open_packed_bag(path) : open_unpacked_bag(path);
}

std::unique_ptr<Bag> open_bag(const std::filesystem::path& path) {
  return io::is_folder(path) ? open_folder_bag(path) : open_file_bag(path);
}

}  // namespace stereogrid::mcap
