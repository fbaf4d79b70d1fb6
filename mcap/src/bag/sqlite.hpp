// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "format.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace stereogrid::mcap {

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
