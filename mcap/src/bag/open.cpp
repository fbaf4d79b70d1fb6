// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>

#include "bag/bags.hpp"
#include "stereogrid/error.hpp"
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

std::uint16_t index_of(const Topic& topic, std::vector<Topic>& topics) {
  const auto key = [](const Topic& one) { return std::tie(one.name, one.type, one.message_encoding); };
  const auto found{std::ranges::find_if(topics, [&](const Topic& known) { return key(known) == key(topic); })};
  const auto index{found - topics.begin()};
  if (found != topics.end()) {
    found->message_count += topic.message_count;
  } else {
    if (index > std::numeric_limits<std::uint16_t>::max()) throw std::length_error{"too many topics"};
    topics.push_back(topic);
  }
  return static_cast<std::uint16_t>(index);
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
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored) ? open_folder_bag(path) : open_file_bag(path);
}

}  // namespace stereogrid::mcap
