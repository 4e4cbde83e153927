#include <map>
#include <optional>

#include "io/bags/chunked_log.h"
#include "io/cursor.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::string_view kRosBagLine = "#ROSBAG V2.0\n";

using RecordFields = std::map<std::string, std::string_view, std::less<>>;

RecordFields ParseFields(std::string_view bytes, const std::string& name) {
  RecordFields fields;
  Cursor cursor(bytes, name);
  while (cursor.left() > 0) {
    const std::string_view field = cursor.Counted();
    const std::size_t equals = field.find('=');
    ThrowIf(equals == field.npos, name, " is damaged: a field has no '='");
    fields[std::string(field.substr(0, equals))] = field.substr(equals + 1);
  }
  return fields;
}

template <typename T>
T Value(const RecordFields& fields, std::string_view key, const std::string& name) {
  const auto found = fields.find(key);
  ThrowIf(found == fields.end(), name, " is damaged: it has no ", key);
  return Cursor(found->second, name).Take<T>();
}

std::string Text(const RecordFields& fields, std::string_view key) {
  const auto found = fields.find(key);
  return found == fields.end() ? "" : std::string(found->second);
}

// Converts a ROS time to ns. Low 32 bits: seconds, high 32 bits: nanoseconds.
std::int64_t Nanoseconds(std::uint64_t time) {
  constexpr std::int64_t kPerSecond = 1000000000;
  return static_cast<std::int64_t>(time & 0xFFFFFFFF) * kPerSecond +
         static_cast<std::int64_t>(time >> 32);
}

class RosBag : public ChunkedLog {
 public:
  explicit RosBag(const std::string& path) : ChunkedLog(path) {
    ThrowIf(!file().Has(0, kRosBagLine.size()) || file().Read(0, kRosBagLine.size()) != kRosBagLine,
            path, " is not a ROS 1 bag of format 2.0: the first line must be #ROSBAG V2.0");
    Index();
  }

 private:
  enum Operation : std::uint8_t { kMessage = 2, kBagHeader = 3, kChunk = 5, kConnection = 7 };

  // Record layout: header size, header, data size, data.
  void Index() {
    std::uint64_t at = kRosBagLine.size();
    while (at < file().size()) {
      const std::optional<std::uint64_t> header_size = Size(at);
      if (!header_size || !file().Has(at + 4, *header_size)) return EndsEarly(at);
      const std::uint64_t data = at + 8 + *header_size;
      const std::optional<std::uint64_t> data_size = Size(data - 4);
      if (!data_size || !file().Has(data, *data_size)) return EndsEarly(at);
      TakeRecord(at + 4, *header_size, data, *data_size);
      at = data + *data_size;
    }
  }

  std::optional<std::uint64_t> Size(std::uint64_t at) const {
    if (!file().Has(at, 4)) return std::nullopt;
    const std::string bytes = file().Read(at, 4);
    return Cursor(bytes, path()).Take<std::uint32_t>();
  }

  void EndsEarly(std::uint64_t at) {
    Warn(Concat(" is damaged or truncated: the data from byte ", at,
                " to the end are skipped (`rosbag reindex` repairs truncated recordings)"));
  }

  void TakeRecord(std::uint64_t header, std::uint64_t header_size, std::uint64_t data,
                  std::uint64_t data_size) {
    const std::string name = Concat(path(), ": the record at byte ", header);
    const std::string bytes = file().Read(header, header_size);
    const RecordFields fields = ParseFields(bytes, name);
    const auto operation = Value<std::uint8_t>(fields, "op", name);
    if (operation == kBagHeader && !Text(fields, "encryptor").empty())
      throw InputError(path(), " is encrypted, must be unencrypted");
    if (operation == kChunk) return TakeChunk(fields, data, data_size, name);
    if (operation != kMessage && operation != kConnection) return;
    TakeInner(operation, fields, -1, data, file().Read(data, data_size), name);
  }

  void TakeChunk(const RecordFields& fields, std::uint64_t at, std::uint64_t size,
                 const std::string& name) {
    Chunk chunk;
    chunk.at = at;
    chunk.size = size;
    chunk.compression = ParseCompression(Text(fields, "compression"), name);
    chunk.expanded_size = Value<std::uint32_t>(fields, "size", name);
    AddChunk(chunk, at, name, [&](int number, Cursor* cursor) {
      const RecordFields inner = ParseFields(cursor->Counted(), name);
      const auto operation = Value<std::uint8_t>(inner, "op", name);
      const std::string_view data = cursor->Counted();
      if (operation != kMessage && operation != kConnection) return;
      TakeInner(operation, inner, number, cursor->at() - data.size(), data, name);
    });
  }

  void TakeInner(std::uint8_t operation, const RecordFields& fields, int part, std::uint64_t at,
                 std::string_view data, const std::string& name) {
    const auto connection = Value<std::uint32_t>(fields, "conn", name);
    if (operation == kConnection) return TakeConnection(connection, fields, data, name);
    const auto topic = topic_of_.find(connection);
    ThrowIf(topic == topic_of_.end(), name, " is damaged: a message has the unknown connection ",
            connection);
    AddMessage(topic->second, Nanoseconds(Value<std::uint64_t>(fields, "time", name)), part, at,
               data);
  }

  // Adds a connection. A topic has one connection per publisher.
  void TakeConnection(std::uint32_t connection, const RecordFields& fields, std::string_view data,
                      const std::string& name) {
    if (topic_of_.count(connection) > 0) return;
    topic_of_[connection] =
        AddTopic(Text(fields, "topic"), PlainType(Text(ParseFields(data, name), "type")),
                 Serialization::kRos1);
  }

  std::map<std::uint32_t, std::size_t> topic_of_;
};

}  // namespace

std::unique_ptr<MessageLog> OpenRosBag(const std::string& path) {
  return std::make_unique<RosBag>(path);
}

}  // namespace surfit
