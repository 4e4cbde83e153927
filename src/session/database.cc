#include "session/database.h"

#include <libdeflate.h>
#include <sqlite3.h>

#include <cstddef>
#include <new>
#include <type_traits>

namespace surfit {
namespace {

constexpr int kLockTimeout_ms = 3000;

// Checksum of the table name, and of type and value of each column.
std::int64_t ChecksumOf(const std::string& table, const Row& row) {
  std::uint32_t sum = Crc(table.data(), table.size());
  for (const auto& value : row) {
    const auto type = static_cast<unsigned char>(value.index());
    sum = Crc(&type, 1, sum);
    std::visit(
        [&](const auto& v) {
          using T = std::decay_t<decltype(v)>;
          if constexpr (std::is_same_v<T, Blob>) {
            sum = Crc(v.bytes.data(), v.bytes.size(), sum);
          } else if constexpr (std::is_same_v<T, std::string>) {
            sum = Crc(v.data(), v.size(), sum);
          } else {
            sum = Crc(&v, sizeof(v), sum);
          }
        },
        value);
  }
  return sum;
}

int Bind(sqlite3_stmt* statement, int place, std::int64_t value) {
  return sqlite3_bind_int64(statement, place, value);
}
int Bind(sqlite3_stmt* statement, int place, double value) {
  return sqlite3_bind_double(statement, place, value);
}
int Bind(sqlite3_stmt* statement, int place, const std::string& value) {
  return sqlite3_bind_text(statement, place, value.data(), static_cast<int>(value.size()),
                           SQLITE_STATIC);
}
int Bind(sqlite3_stmt* statement, int place, const Blob& value) {
  return sqlite3_bind_blob64(statement, place, value.bytes.data(), value.bytes.size(),
                             SQLITE_STATIC);
}

Row::value_type ColumnOf(sqlite3_stmt* statement, int column) {
  const auto size = [&] {
    return static_cast<std::size_t>(sqlite3_column_bytes(statement, column));
  };
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
      return sqlite3_column_int64(statement, column);
    case SQLITE_FLOAT:
      return sqlite3_column_double(statement, column);
    case SQLITE_TEXT: {
      const auto* const text = sqlite3_column_text(statement, column);
      return std::string(reinterpret_cast<const char*>(text), size());
    }
    default: {
      const auto* const bytes = static_cast<const char*>(sqlite3_column_blob(statement, column));
      return Blob{bytes == nullptr ? "" : std::string(bytes, size())};
    }
  }
}

}  // namespace

std::uint32_t Crc(const void* bytes, std::size_t size, std::uint32_t before) {
  return libdeflate_crc32(before, bytes, size);
}

void Database::Finalizer::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

// Opens the database with the settings for untrusted files (sqlite.org/security.html).
Database::Database(const std::string& path, Mode mode) : path_(path) {
  const int flags = mode == Mode::kRead    ? SQLITE_OPEN_READONLY
                    : mode == Mode::kWrite ? SQLITE_OPEN_READWRITE
                                           : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  const int result =
      sqlite3_open_v2(path.c_str(), &database_, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  try {
    Require(result);
    sqlite3_busy_timeout(database_, kLockTimeout_ms);
    sqlite3_db_config(database_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(database_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    Run("PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0");
  } catch (...) {
    sqlite3_close(database_);
    throw;
  }
}

Database::~Database() { sqlite3_close(database_); }

void Database::Require(int result) {
  if (result == SQLITE_OK || result == SQLITE_ROW || result == SQLITE_DONE) return;
  const int code = result & 0xff;
  if (code == SQLITE_NOMEM) throw std::bad_alloc();
  if (code == SQLITE_BUSY || code == SQLITE_LOCKED) {
    throw LockedError(path_, " is locked by another program: end this program first");
  }
  if (code == SQLITE_CORRUPT || code == SQLITE_NOTADB) {
    throw InputError(path_, " is damaged or not a session: ", sqlite3_errmsg(database_));
  }
  throw InputError(path_, ": ", database_ ? sqlite3_errmsg(database_) : sqlite3_errstr(result));
}

void Database::Run(const std::string& sql) {
  Require(sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr));
}

Database::Statement Database::Prepare(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  Require(sqlite3_prepare_v2(database_, sql.c_str(), -1, &statement, nullptr));
  return Statement(statement);
}

bool Database::Step(sqlite3_stmt* statement) {
  const int result = sqlite3_step(statement);
  Require(result);
  return result == SQLITE_ROW;
}

std::int64_t Database::Number(const std::string& sql) {
  const Statement statement = Prepare(sql);
  return Step(statement.get()) ? sqlite3_column_int64(statement.get(), 0) : 0;
}

std::vector<std::string> Database::Texts(const std::string& sql) {
  std::vector<std::string> texts;
  const Statement statement = Prepare(sql);
  while (Step(statement.get())) {
    const auto* const text = sqlite3_column_text(statement.get(), 0);
    texts.emplace_back(text == nullptr ? "" : reinterpret_cast<const char*>(text));
  }
  return texts;
}

void Database::Put(const std::string& table, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  std::string sql = "INSERT OR REPLACE INTO " + table + " VALUES (?";
  for (std::size_t i = 0; i < rows.front().size(); ++i) sql += ", ?";
  const Statement statement = Prepare(sql + ")");
  for (const Row& row : rows) {
    int place = 0;
    for (const auto& value : row) {
      ++place;
      Require(std::visit([&](const auto& v) { return Bind(statement.get(), place, v); }, value));
    }
    Require(Bind(statement.get(), place + 1, ChecksumOf(table, row)));
    Step(statement.get());
    Require(sqlite3_reset(statement.get()));
  }
}

void Database::Delete(const std::string& table, std::int64_t key) {
  Run(Concat("DELETE FROM ", table, " WHERE id = ", key));
}

void Database::ForEach(const std::string& table, std::size_t columns,
                       const std::function<void(const Row&, bool is_intact)>& take) {
  const Statement statement = Prepare("SELECT * FROM " + table + " ORDER BY id");
  ThrowIf(sqlite3_column_count(statement.get()) != static_cast<int>(columns) + 1, path_, ": table ",
          table, " must have ", columns + 1, " columns");
  while (Step(statement.get())) {
    Row row;
    for (std::size_t i = 0; i < columns; ++i) {
      row.push_back(ColumnOf(statement.get(), static_cast<int>(i)));
    }
    const std::int64_t sum = sqlite3_column_int64(statement.get(), static_cast<int>(columns));
    take(row, sum == ChecksumOf(table, row));
  }
}

void Database::Transact(const std::function<void()>& change) {
  Run("BEGIN IMMEDIATE");
  try {
    change();
    Run("COMMIT");
  } catch (...) {
    sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

}  // namespace surfit
