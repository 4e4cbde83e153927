#include <algorithm>
#include <map>

#include "io/bags/chunked_log.h"
#include "io/cursor.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t kRecordHead = 1 + 8;  // operation and size

Serialization SerializationOf(std::string_view encoding) {
  if (encoding == "ros1") return Serialization::kRos1;
  return encoding == "cdr" ? Serialization::kCdr : Serialization::kOther;
}

class Mcap : public ChunkedLog {
 public:
  explicit Mcap(const std::string& path) : ChunkedLog(path) {
    ThrowIf(!file().Has(0, kMcapMagic.size()) || file().Read(0, kMcapMagic.size()) != kMcapMagic,
            path, " is not an MCAP file: the signature MCAP0 is missing");
    Index();
  }

 private:
  enum Operation : std::uint8_t {
    kFooter = 2,
    kSchema = 3,
    kChannel = 4,
    kMessage = 5,
    kChunk = 6,
    kDataEnd = 15
  };

  void Index() {
    std::uint64_t at = kMcapMagic.size();
    while (file().Has(at, kRecordHead)) {
      const std::string name = Concat(path(), ": the record at byte ", at);
      const std::string head = file().Read(at, kRecordHead);
      Cursor cursor(head, name);
      const auto operation = cursor.Take<std::uint8_t>();
      const auto size = cursor.Take<std::uint64_t>();
      at += kRecordHead;
      if (operation == kDataEnd || operation == kFooter) return;
      if (!file().Has(at, size)) break;
      if (operation == kChunk) {
        TakeChunk(at, size, name);
      } else if (operation >= kSchema && operation <= kMessage) {
        const std::string bytes = file().Read(at, size);
        TakeRecord(operation, -1, at, bytes, name);
      }
      at += size;
    }
    Warn(Concat(" is damaged or truncated: the data from byte ", at, " to the end are skipped"));
  }

  void TakeChunk(std::uint64_t at, std::uint64_t size, const std::string& name) {
    constexpr std::uint64_t kLongestHead =
        8 + 8 + 8 + 4 + 4 + 16 + 8;  // allows 16 bytes for the compression name
    const std::string head = file().Read(at, std::min(size, kLongestHead));
    Cursor cursor(head, name);
    cursor.Bytes(8 + 8);  // first and last time
    Chunk chunk;
    chunk.expanded_size = cursor.Take<std::uint64_t>();
    cursor.Bytes(4);  // checksum
    chunk.compression = ParseCompression(std::string(cursor.Counted()), name);
    chunk.size = cursor.Take<std::uint64_t>();
    chunk.at = at + cursor.at();
    ThrowIf(chunk.size > size - cursor.at(), name,
            " is damaged: its chunk is larger than the record");
    AddChunk(chunk, at, name, [&](int number, Cursor* inner) {
      const auto operation = inner->Take<std::uint8_t>();
      const std::string_view record = inner->Bytes(inner->Take<std::uint64_t>());
      TakeRecord(operation, number, inner->at() - record.size(), record, name);
    });
  }

  void TakeRecord(std::uint8_t operation, int part, std::uint64_t at, std::string_view bytes,
                  const std::string& name) {
    Cursor cursor(bytes, name);
    if (operation == kSchema) {
      const auto id = cursor.Take<std::uint16_t>();
      types_[id] = PlainType(std::string(cursor.Counted()));
    } else if (operation == kChannel) {
      TakeChannel(&cursor);
    } else if (operation == kMessage) {
      const auto topic = topic_of_.find(cursor.Take<std::uint16_t>());
      ThrowIf(topic == topic_of_.end(), name, " is damaged: a message has an unknown channel");
      cursor.Bytes(4);  // sequence number
      const auto recorded_ns = cursor.Take<std::uint64_t>();
      cursor.Bytes(8);  // publish time
      const std::uint64_t begin = cursor.at();
      AddMessage(topic->second, static_cast<std::int64_t>(recorded_ns), part, at + begin,
                 bytes.substr(begin));
    }
  }

  // Adds a channel. Chunks repeat channels, so known ids are ignored.
  void TakeChannel(Cursor* cursor) {
    const auto id = cursor->Take<std::uint16_t>();
    if (topic_of_.count(id) > 0) return;
    const std::string type = types_[cursor->Take<std::uint16_t>()];
    const std::string topic(cursor->Counted());
    topic_of_[id] = AddTopic(topic, type, SerializationOf(cursor->Counted()));
  }

  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, std::size_t> topic_of_;
};

}  // namespace

std::unique_ptr<MessageLog> OpenMcap(const std::string& path) {
  return std::make_unique<Mcap>(path);
}

}  // namespace surfit
