// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "file.hpp"
#include "format.hpp"
#include "stereogrid/mcap/bag.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace stereogrid::mcap {

[[nodiscard]] std::unique_ptr<Bag> open_mcap_bag(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Bag> open_db3_bag(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Bag> open_folder_bag(const std::filesystem::path& path);

/// An .mcap or a .db3, by its first bytes.
[[nodiscard]] std::unique_ptr<Bag> open_unpacked_bag(const std::filesystem::path& path);
/// A file that unpacks to more times its size, and to more than `always_bytes`, is no recording, and would fill the
/// disk.
inline constexpr std::uint64_t most_growth{200};
/// The same compressed with zstd: unpacked into the folder of temporary files, where only the open file keeps it.
[[nodiscard]] std::unique_ptr<Bag> open_packed_bag(const std::filesystem::path& path,
                                                   std::uint64_t always_bytes = std::uint64_t{1} << 30);
/// Any of them.
[[nodiscard]] std::unique_ptr<Bag> open_file_bag(const std::filesystem::path& path);

/// Topics of a bag, distinct in name, type and encoding.
class TopicList {
 public:
  /// `file`: name in error messages.
  explicit TopicList(std::string file) : file_{std::move(file)} {}

  /// Index of the topic, which Message::channel has; a known topic gets its messages. Throws InputError: more than
  /// 65536 topics, or more than 256 MiB of text.
  std::uint16_t add(const Topic& topic);
  [[nodiscard]] const std::vector<Topic>& all() const { return topics_; }
  void count_message(std::uint16_t index) { ++topics_[index].message_count; }

 private:
  std::string file_;
  std::vector<Topic> topics_;
  std::map<std::tuple<std::string, std::string, std::string>, std::uint16_t> indices_;
  std::size_t text_bytes_{0};
};

/// Messages whose channels have other numbers outside: `numbers[channel]`.
class Renumbered : public MessageCursor {
 public:
  Renumbered(std::unique_ptr<MessageCursor> cursor, const std::vector<std::uint16_t>& numbers)
      : cursor_{std::move(cursor)}, numbers_{numbers} {}

  const Message* next() override {
    const Message* const message{cursor_->next()};
    if (message == nullptr) return nullptr;
    message_ = *message;
    message_.channel = numbers_[message->channel];
    return &message_;
  }

 private:
  std::unique_ptr<MessageCursor> cursor_;
  const std::vector<std::uint16_t>& numbers_;
  Message message_;
};

class Database;

/// A prepared SELECT.
class Statement {
 public:
  void bind(int parameter, std::int64_t value);
  /// To the next row; false: there is none.
  bool step();
  /// To before the first row.
  void reset();

  [[nodiscard]] bool is_integer(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  /// Valid until the next step() or reset().
  [[nodiscard]] View bytes(int column) const;
  [[nodiscard]] std::string text(int column) const;

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  Statement(const Database& database, sqlite3_stmt* statement) : database_{database}, statement_{statement} {}

  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// Foreign SQLite file: opened read-only, without its views, triggers, or functions. Every function throws InputError;
/// DeviceError if the disk fails or another process holds the file.
class Database {
 public:
  explicit Database(const std::filesystem::path& path);

  [[nodiscard]] Statement prepare(std::string_view sql) const;
  /// True if the column exists in a table with rows.
  [[nodiscard]] bool has_column(const char* table, const char* column) const;
  /// Printable.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// With what SQLite says.
  [[noreturn]] void fail() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  void restrict() const;

  std::string name_;
  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace stereogrid::mcap
