#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "surfit/core/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace surfit {

// Binary value of a column.
struct Blob {
  std::string bytes;
};

// Values of a row without checksum, key first. The key is the column `id`, an integer.
using Row = std::vector<std::variant<std::int64_t, double, std::string, Blob>>;

// CRC-32 of bytes. `before`: CRC of the preceding bytes. Does not throw.
std::uint32_t Crc(const void* bytes, std::size_t size, std::uint32_t before = 0);

// Lock of a session by another program. Says nothing about the content of the session.
class LockedError : public InputError {
 public:
  using InputError::InputError;
};

// SQLite database whose rows have checksums. Each table has the columns of Row and then `checksum`.
// Functions throw InputError with the path if the file is damaged or no database, or if the disk is
// full. They throw LockedError if another program locks the file for more than 3 s. Lack of memory
// throws std::bad_alloc.
//
// Use it from one thread at a time. Table names and SQL must be trusted text.
class Database {
 public:
  // kRead and kWrite require an existing file. kCreate also opens an existing file. Some damage is
  // found only at later calls.
  enum class Mode { kRead, kWrite, kCreate };
  Database(const std::string& path, Mode mode);
  ~Database();
  Database& operator=(Database&&) = delete;

  const std::string& path() const { return path_; }

  // Runs one or several statements and ignores their results.
  void Run(const std::string& sql);
  // First column of the first row; 0 without rows.
  std::int64_t Number(const std::string& sql);
  // First column of all rows; NULL gives an empty text.
  std::vector<std::string> Texts(const std::string& sql);

  // Inserts rows with checksums. Replaces rows with equal keys. All rows must have the same number
  // of columns. Run it in Transact().
  void Put(const std::string& table, const std::vector<Row>& rows);
  // Deletes a row. Does nothing without such a row.
  void Delete(const std::string& table, std::int64_t key);
  // Calls `take` for each row by ascending key. `columns`: number of columns without the checksum.
  // `is_intact`: the checksum is correct. Exceptions of `take` propagate. Throws InputError for
  // another number of columns.
  void ForEach(const std::string& table, std::size_t columns,
               const std::function<void(const Row&, bool is_intact)>& take);

  // Runs `change` in a transaction. Rolls back if it throws. Must not be nested.
  void Transact(const std::function<void()>& change);

 private:
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, Finalizer>;
  Statement Prepare(const std::string& sql);
  bool Step(sqlite3_stmt* statement);
  void Require(int result);

  std::string path_;
  sqlite3* database_ = nullptr;
};

}  // namespace surfit
