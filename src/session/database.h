#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace surfit {

struct Blob {
  std::string bytes;
};

// The values of a row, without its checksum; the first is its key.
using Row = std::vector<std::variant<std::int64_t, double, std::string, Blob>>;

// The CRC-32 of bytes, on from one of those before.
std::uint32_t Crc(const void* bytes, std::size_t size, std::uint32_t before = 0);

// An SQLite database. All throw InputError naming the file if it is damaged, full, no database, or
// locked by another program for longer than some seconds.
class Database {
 public:
  enum class Mode { kRead, kWrite, kCreate };
  Database(const std::string& path, Mode mode);
  ~Database();
  Database& operator=(Database&&) = delete;

  const std::string& path() const { return path_; }

  void Run(const std::string& sql);
  std::int64_t Number(const std::string& sql);             // the first of the first row
  std::vector<std::string> Texts(const std::string& sql);  // the first of each row

  // Puts rows of a table, or replaces those of their keys, with their checksums.
  void Put(const std::string& table, const std::vector<Row>& rows);
  void Delete(const std::string& table, std::int64_t key);
  // All rows by ascending key, of tables that have so many columns besides the checksum.
  // `take` is given a row and whether its checksum is right; whatever it throws ends it.
  void ForEach(const std::string& table, std::size_t columns,
               const std::function<void(const Row&, bool is_intact)>& take);

  // What makes a change whole: all of it is done, or nothing.
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
