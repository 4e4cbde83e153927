#pragma once

#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/bags/decompress.h"
#include "io/bags/message_log.h"
#include "io/cursor.h"
#include "io/sequences/frame_bytes.h"

namespace surfit {

// What files of chunks have in common: ROS 1 bags and MCAP.
class ChunkedLog : public MessageLog {
 public:
  explicit ChunkedLog(const std::string& path) : file_(path) {}

  const std::string& path() const override { return file_.path(); }
  const std::vector<Topic>& topics() const override { return topics_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }
  std::string Read(const MessagePlace& place) const override;

 protected:
  struct Chunk {
    std::uint64_t at = 0, size = 0;  // in the file
    Compression compression = Compression::kNone;
    std::uint64_t expanded_size = 0;
  };

  const BinaryFile& file() const { return file_; }
  // Calls `take` with the chunk's number and its bytes until no bytes are left. If they cannot be
  // expanded or taken, the rest is left out, and a warning names the record at byte `at`.
  void AddChunk(const Chunk& chunk, std::uint64_t at, const std::string& name,
                const std::function<void(int, Cursor*)>& take);
  // Lists a message, whose bytes are at `at` of the part.
  void AddMessage(std::size_t topic, std::int64_t recorded_ns, int part, std::uint64_t at,
                  std::string_view bytes);
  // Returns the number of the topic. A topic that is there already is not added again.
  std::size_t AddTopic(const std::string& name, const std::string& type,
                       Serialization serialization);
  void Warn(const std::string& sentence) { warnings_.push_back(path() + sentence); }

 private:
  // The chunk's bytes, valid until the next but one is asked for.
  const std::string& ChunkBytes(int number) const;

  BinaryFile file_;
  std::vector<Chunk> chunks_;
  std::vector<Topic> topics_;
  std::vector<std::string> warnings_;
  // Two: depth and colour of one moment may stand in neighbours.
  mutable std::deque<std::pair<int, std::string>> loaded_;
};

}  // namespace surfit
