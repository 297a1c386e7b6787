// SQLite's C interface with owners and errors. Includes its header: only for sqlite_records.cpp.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/run/error.h"

namespace burnish {

struct CloseSqlite {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using SqliteDatabase = std::unique_ptr<sqlite3, CloseSqlite>;

inline Error sqlite_error(sqlite3* database) {
  const int code = sqlite3_errcode(database) & 0xff;
  const bool disk = code == SQLITE_FULL || code == SQLITE_IOERR || code == SQLITE_CANTOPEN;
  return {disk ? Cause::StorageFull : Cause::Internal,
          "the server cannot write its records: " + std::string(sqlite3_errmsg(database))};
}

/// One statement: bind() its values in their order, then run(), or step() through its rows.
class SqliteStatement {
 public:
  SqliteStatement(sqlite3* database, std::string_view sql) : database_(database) {
    sqlite3_stmt* made = nullptr;
    sqlite3_prepare_v2(database, sql.data(), static_cast<int>(sql.size()), &made, nullptr);
    statement_.reset(made);
  }

  /// The text must live until the last step.
  SqliteStatement& bind(std::string_view text) {
    sqlite3_bind_text64(statement_.get(), ++bound_, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
    return *this;
  }
  SqliteStatement& bind_bytes(std::string_view bytes) {
    sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC);
    return *this;
  }
  SqliteStatement& bind(std::int64_t number) {
    sqlite3_bind_int64(statement_.get(), ++bound_, number);
    return *this;
  }

  /// True: there is a row. Errors: StorageFull, Internal.
  Result<bool> step() {
    const int code = statement_ ? sqlite3_step(statement_.get()) : SQLITE_ERROR;
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return sqlite_error(database_);
  }
  Result<> run() {
    auto row = step();
    return row ? Result<>() : Result<>(std::move(row).error());
  }

  std::int64_t number(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  std::string text(int column) const {
    const void* const bytes = sqlite3_column_blob(statement_.get(), column);
    const int size = sqlite3_column_bytes(statement_.get(), column);
    return bytes ? std::string(static_cast<const char*>(bytes), static_cast<std::size_t>(size)) : "";
  }

 private:
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, CloseSqlite> statement_;
  int bound_ = 0;
};

}  // namespace burnish
