// SPDX-License-Identifier: Apache-2.0
#include "bag/bags.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::mcap {
namespace {

namespace fs = std::filesystem;

constexpr int largest_value_bytes{1 << 29};

bool has_bytes(fs::path path, const char* suffix) {
  path += suffix;
  return io::is_file(path) && io::with_path_errors([&path] { return fs::file_size(path); }) > 0;
}

/// SQLite URI of a file, with options.
std::string uri_of(const fs::path& path) {
  const fs::path absolute{fs::absolute(path)};
  std::string uri{"file://"};
  for (const char character : absolute.native()) {
    const bool is_plain{(character >= '0' && character <= '9') || (character >= 'A' && character <= 'Z') ||
                        (character >= 'a' && character <= 'z') || character == '/' || character == '.' ||
                        character == '_' || character == '-'};
    uri += is_plain ? std::string(1, character) : fmt::format("%{:02X}", static_cast<unsigned char>(character));
  }
  // A journal beside it belongs to it: SQLite must look there. Without one nothing changes the file, and nothing need
  // be locked, or made beside it.
  const bool has_journal{has_bytes(path, "-wal") || has_bytes(path, "-journal")};
  return uri + (has_journal ? "?mode=ro" : "?mode=ro&immutable=1");
}

/// The file's own definitions may not do more than hold rows.
int authorize(void* /*unused*/, int action, const char* /*first*/, const char* second, const char* /*third*/,
              const char* /*fourth*/) {
  if (action == SQLITE_SELECT || action == SQLITE_READ) return SQLITE_OK;
  return action == SQLITE_FUNCTION && std::string_view{second} == "count" ? SQLITE_OK : SQLITE_DENY;
}

/// Whether SQLite may succeed later. It reports some failures of the disk (EIO) as a damaged file.
bool is_temporary(sqlite3* database) {
  int system_error{0};
  sqlite3_file_control(database, "main", SQLITE_FCNTL_LAST_ERRNO, &system_error);
  const int code{sqlite3_errcode(database) & 0xff};
  const bool has_failed_to_read{code == SQLITE_IOERR || (code == SQLITE_CORRUPT && system_error != 0)};
  const bool has_failed_to_open{code == SQLITE_CANTOPEN && io::is_temporary(sqlite3_system_errno(database))};
  return has_failed_to_read || has_failed_to_open || code == SQLITE_BUSY || code == SQLITE_LOCKED;
}

}  // namespace

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

void Statement::bind(int parameter, std::int64_t value) {
  if (sqlite3_bind_int64(statement_.get(), parameter, value) != SQLITE_OK) database_.fail();
}

bool Statement::step() {
  const int result{sqlite3_step(statement_.get())};
  if (result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
  return result == SQLITE_ROW;
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
}

bool Statement::is_integer(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_INTEGER;
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

View Statement::bytes(int column) const {
  const void* const data{sqlite3_column_blob(statement_.get(), column)};  // before sqlite3_column_bytes
  return {static_cast<const std::byte*>(data),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::string Statement::text(int column) const {
  const View data{bytes(column)};
  return {reinterpret_cast<const char*>(data.data()), data.size()};
}

void Database::Close::operator()(sqlite3* database) const {
  sqlite3_close_v2(database);
}

Database::Database(const fs::path& path) : name_{io::printable_path(path)} {
  sqlite3* opened{nullptr};
  const int result{sqlite3_open_v2(uri_of(path).c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr)};
  database_.reset(opened);
  if (result != SQLITE_OK) fail();
  restrict();
}

void Database::restrict() const {
  sqlite3* const database{database_.get()};
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, largest_value_bytes);
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (sqlite3_exec(database, "PRAGMA cell_size_check=ON", nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  sqlite3_set_authorizer(database, authorize, nullptr);
}

Statement Database::prepare(std::string_view sql) const {
  sqlite3_stmt* statement{nullptr};
  if (sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr) != SQLITE_OK) {
    fail();
  }
  return {*this, statement};
}

bool Database::has_column(const char* table, const char* column) const {
  // a table of a module (virtual) has no page of its own
  Statement found{prepare(
      fmt::format("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND rootpage > 0 AND name = '{}'", table))};
  if (!found.step() || found.integer(0) != 1) return false;
  return sqlite3_table_column_metadata(database_.get(), nullptr, table, column, nullptr, nullptr, nullptr, nullptr,
                                       nullptr) == SQLITE_OK;
}

void Database::fail() const {
  const char* const said{database_ ? sqlite3_errmsg(database_.get()) : "out of memory"};
  if (database_ && is_temporary(database_.get())) {
    throw DeviceError{fmt::format("{}: cannot be read: SQLite says '{}'. Check the disk, then try again.", name_,
                                  io::printable(said))};
  }
  throw InputError{name_, fmt::format("cannot be read: SQLite says '{}'.", said),
                   "If the recording was cut off, let SQLite mend a copy: sqlite3 FILE .recover | sqlite3 MENDED.db3"};
}

}  // namespace stereogrid::mcap
