// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include "bag/bags.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

#include <fmt/format.h>

#include "stereogrid/mcap/reader.hpp"

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
                   "is not a recording: it begins neither as MCAP nor as SQLite, which rosbag2 writes.",
                   "Name an .mcap, a .db3, or the folder of a bag."};
}

std::unique_ptr<Bag> open_file_bag(const std::filesystem::path& path) {
  return first_bytes_of(path).starts_with(zstd_magic) ? open_packed_bag(path) : open_unpacked_bag(path);
}

std::unique_ptr<Bag> open_bag(const std::filesystem::path& path) {
  return io::is_folder(path) ? open_folder_bag(path) : open_file_bag(path);
}

namespace {

constexpr std::size_t channels_max{std::size_t{std::numeric_limits<std::uint16_t>::max()} + 1};

class McapBag : public Bag {
 public:
  explicit McapBag(const std::filesystem::path& path)
      : name_{io::printable_path(path)}, reader_{path}, topics_{name_}, topic_of_channel_(channels_max) {
    const Contents& contents{reader_.contents()};
    for (const auto& [id, channel] : contents.channels) {
      Topic topic;
      topic.name = channel.topic;
      topic.message_encoding = channel.message_encoding;
      if (const auto found{contents.schemas.find(channel.schema_id)}; found != contents.schemas.end()) {
        topic.type = found->second.name;
        topic.schema_encoding = found->second.encoding;
        topic.schema = found->second.data;
      }
      if (const auto found{channel.metadata.find("offered_qos_profiles")}; found != channel.metadata.end()) {
        topic.offered_qos_profiles = found->second;
      }
      const auto count{contents.message_counts.find(id)};
      topic.message_count = count == contents.message_counts.end() ? 0 : count->second;
      topic_of_channel_[id] = topics_.add(topic);
    }
  }

  [[nodiscard]] const std::vector<Topic>& topics() const override { return topics_.all(); }
  [[nodiscard]] std::uint64_t first_ns() const override { return reader_.contents().first_ns; }
  [[nodiscard]] std::uint64_t last_ns() const override { return reader_.contents().last_ns; }

  [[nodiscard]] std::unique_ptr<MessageCursor> messages(const Selection& selection) const override {
    return std::make_unique<Renumbered>(reader_.messages(selection), topic_of_channel_);
  }

  [[nodiscard]] std::vector<std::string> damage() const override {
    std::vector<std::string> sentences;
    for (const std::string& sentence : reader_.damage().sentences) sentences.push_back(name_ + ": " + sentence);
    return sentences;
  }

 private:
  std::string name_;
  Reader reader_;
  TopicList topics_;
  std::vector<std::uint16_t> topic_of_channel_;
};

}  // namespace

std::unique_ptr<Bag> open_mcap_bag(const std::filesystem::path& path) {
  return std::make_unique<McapBag>(path);
}

namespace {

namespace fs = std::filesystem;

/// A folder that is gone at the end of its scope; files that are open stay readable.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name{(fs::temp_directory_path() / "stereogrid-XXXXXX").string()};
    if (::mkdtemp(name.data()) == nullptr) {
      throw DeviceError{fmt::format("{}: no folder can be created ({}). Set TMPDIR to a folder with space.", name,
                                    std::generic_category().message(errno))};
    }
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

struct Free {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

void unpack(const FileInput& packed, FileOutput& out, std::uint64_t always_bytes) {
  const std::unique_ptr<ZSTD_DCtx, Free> context{ZSTD_createDCtx()};
  if (!context) throw std::bad_alloc{};
  Bytes in(ZSTD_DStreamInSize());
  Bytes unpacked(ZSTD_DStreamOutSize());
  const std::uint64_t most_bytes{std::max(always_bytes, most_growth * packed.size())};
  std::uint64_t written{0};
  bool is_frame_whole{true};
  for (std::uint64_t at{0}; at < packed.size();) {
    const std::size_t count{static_cast<std::size_t>(std::min<std::uint64_t>(in.size(), packed.size() - at))};
    packed.read(at, std::span{in}.first(count));
    at += count;
    ZSTD_inBuffer input{in.data(), count, 0};
    bool is_full{false};  // the decoder may hold more
    while (input.pos < input.size || is_full) {
      ZSTD_outBuffer output{unpacked.data(), unpacked.size(), 0};
      const std::size_t left{ZSTD_decompressStream(context.get(), &output, &input)};
      if (ZSTD_isError(left) != 0) {
        throw InputError{packed.name(), "is a damaged zstd file.", "Copy or record it again."};
      }
      written += output.pos;
      if (written > most_bytes) {
        throw InputError{packed.name(), fmt::format("unpacks to more than {} times its size.", most_growth),
                         "Unpack it with zstd, and name the unpacked file."};
      }
      out.write(View{unpacked}.first(output.pos));
      is_full = output.pos == output.size;
      is_frame_whole = left == 0;
    }
  }
  if (!is_frame_whole) throw InputError{packed.name(), "is a truncated zstd file.", "Copy or record it again."};
}

}  // namespace

std::unique_ptr<Bag> open_packed_bag(const fs::path& path, std::uint64_t always_bytes) {
  const FileInput packed{path};
  const TemporaryFolder folder;
  const fs::path file{folder.path() / path.stem()};
  FileOutput out{file};
  unpack(packed, out, always_bytes);
  out.close();
  return open_unpacked_bag(file);
}

}  // namespace stereogrid::mcap
