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

// Common base of formats with chunks: ROS 1 bags and MCAP. The constructor of a subclass reads the
// file and adds its messages. The part of a message is its chunk number, or -1 outside of chunks.
// Not thread-safe.
class ChunkedLog : public MessageLog {
 public:
  explicit ChunkedLog(const std::string& path) : file_(path) {}

  const std::string& path() const override { return file_.path(); }
  const std::vector<Topic>& topics() const override { return topics_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }
  std::string Read(const MessageLocation& place) const override;

 protected:
  struct Chunk {
    std::uint64_t at = 0, size = 0;  // position and size in the file, bytes
    Compression compression = Compression::kNone;
    std::uint64_t expanded_size = 0;  // size after decompression, bytes
  };

  const BinaryFile& file() const { return file_; }
  // Adds a chunk. Calls `take` repeatedly with the chunk number and a cursor over the decompressed
  // bytes, until no bytes are left. Each call must read at least one byte. The cursor is valid
  // during the call. `name` is the name of the bytes in error messages. If reading, decompression
  // or `take` throws InputError, skips the remaining messages of the chunk with a warning. The
  // warning contains `at`, the position of the record in the file, bytes.
  void AddChunk(const Chunk& chunk, std::uint64_t at, const std::string& name,
                const std::function<void(int, Cursor*)>& take);
  // Adds a message with the given bytes at position `at` of the part. Stores position, size and the
  // first 16 bytes (MessageLocation).
  void AddMessage(std::size_t topic, std::int64_t recorded_ns, int part, std::uint64_t at,
                  std::string_view bytes);
  // Index in topics() of the topic with this name, type and serialisation. The topic is added if it
  // does not exist.
  std::size_t AddTopic(const std::string& name, const std::string& type,
                       Serialization serialization);
  // Adds the warning "<path><sentence>". `sentence` begins with a colon or a space.
  void Warn(const std::string& sentence) { warnings_.push_back(path() + sentence); }

 private:
  // Decompressed bytes of a chunk, valid until another chunk is read.
  const std::string& ChunkBytes(int number) const;

  BinaryFile file_;
  std::vector<Chunk> chunks_;
  std::vector<Topic> topics_;
  std::vector<std::string> warnings_;
  // The last two chunks: depth and colour of a frame may be in consecutive chunks.
  mutable std::deque<std::pair<int, std::string>> loaded_;
};

}  // namespace surfit
