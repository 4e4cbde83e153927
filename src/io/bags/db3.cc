#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <new>

#include "io/bags/decompress.h"
#include "io/bags/message_log.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

struct SqliteCloser {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};

// Signature of zstd data (RFC 8878, 3.1.1). Uncompressed CDR messages begin with the byte 0.
constexpr std::string_view kZstdMagic = "\x28\xB5\x2F\xFD";

class Db3 : public MessageLog {
 public:
  explicit Db3(const std::string& path) : path_(path) {
    Open();
    ReadTopics();
    ReadPlaces();
  }

  const std::string& path() const override { return path_; }
  const std::vector<Topic>& topics() const override { return topics_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

  std::string Read(const MessageLocation& place) const override {
    MoveTo(static_cast<sqlite3_int64>(place.at));
    std::string bytes(sqlite3_blob_bytes(blob_.get()), '\0');
    Require(sqlite3_blob_read(blob_.get(), bytes.data(), static_cast<int>(bytes.size()), 0));
    if (bytes.compare(0, kZstdMagic.size(), kZstdMagic) != 0) return bytes;
    return DecompressZstd(bytes, Concat(path_, ": message ", place.at));
  }

 private:
  void Require(int result) const {
    if (result == SQLITE_OK || result == SQLITE_ROW || result == SQLITE_DONE) return;
    if (result == SQLITE_NOMEM) throw std::bad_alloc();
    throw InputError("cannot read '", path_, "' as a ROS 2 bag in SQLite: ",
                     database_ ? sqlite3_errmsg(database_.get()) : sqlite3_errstr(result));
  }

  // Opens the database with the settings for untrusted files (sqlite.org/security.html).
  void Open() {
    sqlite3* database = nullptr;
    const int result = sqlite3_open_v2(path_.c_str(), &database,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
    database_.reset(database);
    Require(result);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    Require(sqlite3_exec(database, "PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0", nullptr,
                         nullptr, nullptr));
    // Views are rejected: a malicious view could run forever.
    auto tables = Prepare(
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND sql NOT LIKE '%VIRTUAL%' AND "
        "name IN ('topics', 'messages')");
    ThrowIf(!Step(tables.get()) || sqlite3_column_int(tables.get(), 0) != 2, path_,
            " is not a ROS 2 bag: the tables 'topics' and 'messages' are missing");
  }

  using Statement = std::unique_ptr<sqlite3_stmt, SqliteCloser>;
  Statement Prepare(const char* sql) const {
    sqlite3_stmt* statement = nullptr;
    Require(sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr));
    return Statement(statement);
  }
  bool Step(sqlite3_stmt* statement) const {
    const int result = sqlite3_step(statement);
    Require(result);
    return result == SQLITE_ROW;
  }
  std::string Text(sqlite3_stmt* statement, int column) const {
    const auto* const text = sqlite3_column_text(statement, column);
    return text == nullptr ? "" : reinterpret_cast<const char*>(text);
  }

  void ReadTopics() {
    const auto rows =
        Prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    while (Step(rows.get())) {
      topic_of_[sqlite3_column_int64(rows.get(), 0)] = topics_.size();
      const bool cdr = Text(rows.get(), 3) == "cdr";
      topics_.push_back({Text(rows.get(), 1),
                         PlainType(Text(rows.get(), 2)),
                         cdr ? Serialization::kCdr : Serialization::kOther,
                         {}});
    }
  }

  void ReadPlaces() {
    const auto rows = Prepare("SELECT rowid, topic_id, timestamp FROM messages ORDER BY rowid");
    while (Step(rows.get())) {
      const auto topic = topic_of_.find(sqlite3_column_int64(rows.get(), 1));
      if (topic == topic_of_.end()) continue;
      MessageLocation place;
      place.at = static_cast<std::uint64_t>(sqlite3_column_int64(rows.get(), 0));
      place.recorded_ns = sqlite3_column_int64(rows.get(), 2);
      ReadHead(&place);
      topics_[topic->second].messages.push_back(place);
    }
  }

  void ReadHead(MessageLocation* place) const {
    MoveTo(static_cast<sqlite3_int64>(place->at));
    place->size = static_cast<std::uint64_t>(sqlite3_blob_bytes(blob_.get()));
    const int count = static_cast<int>(std::min<std::uint64_t>(place->size, place->head.size()));
    Require(sqlite3_blob_read(blob_.get(), place->head.data(), count, 0));
    if (std::string_view(place->head.data(), kZstdMagic.size()) != kZstdMagic) return;
    place->head = {};
    Read(*place).copy(place->head.data(), place->head.size());
  }

  void MoveTo(sqlite3_int64 row) const {
    if (blob_) return Require(sqlite3_blob_reopen(blob_.get(), row));
    sqlite3_blob* blob = nullptr;
    const int result =
        sqlite3_blob_open(database_.get(), "main", "messages", "data", row, 0, &blob);
    blob_.reset(blob);
    Require(result);
  }

  std::string path_;
  std::unique_ptr<sqlite3, SqliteCloser> database_;
  mutable std::unique_ptr<sqlite3_blob, SqliteCloser> blob_;  // must be closed before database_
  std::vector<Topic> topics_;
  std::vector<std::string> warnings_;
  std::map<sqlite3_int64, std::size_t> topic_of_;
};

}  // namespace

std::unique_ptr<MessageLog> OpenDb3(const std::string& path) { return std::make_unique<Db3>(path); }

}  // namespace surfit
