// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>

#include "bag/bags.hpp"
#include "compression.hpp"
#include "merge.hpp"
#include "read/scanner.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/reader.hpp"

namespace stereogrid::mcap {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_metadata_bytes{std::size_t{4} << 20};

/// Content of metadata.yaml.
struct Metadata {
  std::vector<fs::path> parts;
  bool are_messages_packed{false};
};

std::string lower(std::string text) {
  for (char& character : text) {
    if (character >= 'A' && character <= 'Z') character = static_cast<char>(character - 'A' + 'a');
  }
  return text;
}

Metadata parse_metadata(const fs::path& folder, const std::string& text, const std::string& name) {
  const YAML::Node bag{YAML::Load(text)["rosbag2_bagfile_information"]};
  if (!bag.IsMap()) throw InputError{name, "has no 'rosbag2_bagfile_information'.", "Make it anew (ros2 bag reindex)."};
  Metadata metadata;
  std::set<fs::path> named;
  for (const YAML::Node& part : bag["relative_file_paths"]) {
    // old versions put the folder's name before it, and no part is anywhere else
    const fs::path file{fs::path{part.as<std::string>()}.filename()};
    if (!named.insert(file).second) {
      throw InputError{name, fmt::format("names {} twice.", io::printable_path(file)),
                       "Make it anew (ros2 bag reindex)."};
    }
    metadata.parts.push_back(folder / file);
  }
  const std::string mode{lower(bag["compression_mode"].as<std::string>(""))};
  metadata.are_messages_packed = mode == "message";
  const std::string format{bag["compression_format"].as<std::string>("")};
  if ((metadata.are_messages_packed || mode == "file") && format != "zstd") {
    throw InputError{name, fmt::format("the compression_format is '{}' (allowed: zstd).", format),
                     "Convert the bag (ros2 bag convert)."};
  }
  for (fs::path& part : metadata.parts) {
    const fs::path packed{part.string() + ".zstd"};
    if (mode == "file" && !io::is_there(part) && io::is_there(packed)) part = packed;
  }
  return metadata;
}

/// Parts of a folder without metadata.yaml, as a killed rosbag2 leaves it: all files with a known extension.
Metadata parts_without_metadata(const fs::path& folder) {
  Metadata metadata;
  for (const fs::path& entry : io::entries_of(folder)) {
    const bool is_packed{entry.extension() == ".zstd" || entry.extension() == ".zst"};
    const fs::path extension{is_packed ? entry.stem().extension() : entry.extension()};
    const bool is_old{extension == ".bag"};  // ROS 1: rejected with the remedy
    if (extension == ".mcap" || extension == ".db3" || is_old) metadata.parts.push_back(entry);
  }
  return metadata;
}

Metadata read_metadata(const fs::path& folder) {
  const fs::path file{folder / "metadata.yaml"};
  const std::string name{io::printable_path(file)};
  try {
    Metadata metadata{io::is_there(file) ? parse_metadata(folder, io::read_text(file, largest_metadata_bytes), name)
                                         : parts_without_metadata(folder)};
    if (!metadata.parts.empty()) return metadata;
  } catch (const YAML::Exception& wrong) {
    throw InputError{name, fmt::format("is not as rosbag2 writes it ({}).", io::printable(wrong.what())),
                     "Make it anew (ros2 bag reindex), or name a file of the bag."};
  }
  throw InputError{io::printable_path(folder), "holds no recording: no .mcap, no .db3.", "Name the folder of a bag."};
}

/// Unpacks each message; skips damaged ones.
class UnpackedMessages : public MessageCursor {
 public:
  UnpackedMessages(std::unique_ptr<MessageCursor> cursor, Damage& damage)
      : cursor_{std::move(cursor)}, damage_{damage} {}

  const Message* next() override {
    while (const Message* const packed{cursor_->next()}) {
      if (!unpack(*packed)) continue;
      message_ = *packed;
      message_.data = data_;
      return &message_;
    }
    return nullptr;
  }

 private:
  bool unpack(const Message& packed) {
    try {
      const std::uint64_t size{zstd_content_size(packed.data).value_or(largest_chunk_bytes)};
      if (size > largest_chunk_bytes) throw Malformed{"it has more than 512 MiB"};
      decompress(Compression::zstd, packed.data, size, data_);
      return true;
    } catch (const Malformed& wrong) {
      std::string sentence{fmt::format("The message of {} ns is skipped: {}.", packed.log_time_ns, wrong.what())};
      if (std::ranges::find(damage_.sentences, sentence) == damage_.sentences.end()) {
        ++damage_.messages_skipped;
        note(damage_, std::move(sentence));
      }
      return false;
    }
  }

  std::unique_ptr<MessageCursor> cursor_;
  Damage& damage_;
  Bytes data_;
  Message message_;
};

class FolderBag : public Bag {
 public:
  explicit FolderBag(const fs::path& folder) : name_{io::printable_path(folder)}, topics_{name_} {
    const Metadata metadata{read_metadata(folder)};
    are_messages_packed_ = metadata.are_messages_packed;
    for (const fs::path& part : metadata.parts) {
      parts_.push_back(open_file_bag(part));
      std::vector<std::uint16_t>& numbers{numbers_.emplace_back()};
      for (const Topic& topic : parts_.back()->topics()) numbers.push_back(topics_.add(topic));
    }
  }

  [[nodiscard]] const std::vector<Topic>& topics() const override { return topics_.all(); }

  [[nodiscard]] std::uint64_t first_ns() const override {
    std::optional<std::uint64_t> first;
    for (const auto& part : parts_) {
      if (has_messages(*part)) first = std::min(first.value_or(part->first_ns()), part->first_ns());
    }
    return first.value_or(0);
  }

  [[nodiscard]] std::uint64_t last_ns() const override {
    std::uint64_t last{0};
    for (const auto& part : parts_) last = std::max(last, part->last_ns());
    return last;
  }

  [[nodiscard]] std::unique_ptr<MessageCursor> messages(const Selection& selection) const override {
    std::vector<std::uint64_t> first_ns;
    for (const auto& part : parts_) first_ns.push_back(part->first_ns());
    auto merged{std::make_unique<MergeByTime>(first_ns, [this, selection](std::size_t part) {
      return std::make_unique<Renumbered>(parts_[part]->messages(selection), numbers_[part]);
    })};
    if (!are_messages_packed_) return merged;
    return std::make_unique<UnpackedMessages>(std::move(merged), damage_);
  }

  [[nodiscard]] std::vector<std::string> damage() const override {
    std::vector<std::string> sentences;
    for (const auto& part : parts_) {
      for (std::string& sentence : part->damage()) sentences.push_back(std::move(sentence));
    }
    for (const std::string& sentence : damage_.sentences) sentences.push_back(name_ + ": " + sentence);
    return sentences;
  }

 private:
  static bool has_messages(const Bag& bag) {
    return std::ranges::any_of(bag.topics(), [](const Topic& topic) { return topic.message_count > 0; });
  }

  std::string name_;
  std::vector<std::unique_ptr<Bag>> parts_;
  std::vector<std::vector<std::uint16_t>> numbers_;  // index of each part's topics among all
  TopicList topics_;
  mutable Damage damage_;  // damage of messages compressed one by one
  bool are_messages_packed_{false};
};

}  // namespace

std::unique_ptr<Bag> open_folder_bag(const fs::path& path) {
  return std::make_unique<FolderBag>(path);
}

}  // namespace stereogrid::mcap
