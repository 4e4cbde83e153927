#include "io/bags/chunked_log.h"

#include <algorithm>

#include "surfit/core/error.h"

namespace surfit {

void ChunkedLog::AddChunk(const Chunk& chunk, std::uint64_t at, const std::string& name,
                          const std::function<void(int, Cursor*)>& take) {
  const int number = static_cast<int>(chunks_.size());
  chunks_.push_back(chunk);
  try {
    Cursor cursor(ChunkBytes(number), name);
    while (cursor.left() > 0) take(number, &cursor);
  } catch (const InputError& error) {
    Warn(Concat(": the chunk at byte ", at,
                " is damaged, its remaining messages are skipped: ", error.what()));
  }
}

const std::string& ChunkedLog::ChunkBytes(int number) const {
  constexpr std::size_t kKept = 2;
  for (const auto& [of, bytes] : loaded_) {
    if (of == number) return bytes;
  }
  const Chunk& chunk = chunks_[number];
  std::string bytes =
      Decompress(chunk.compression, file_.Read(chunk.at, chunk.size), chunk.expanded_size,
                 Concat(path(), ": the chunk at byte ", chunk.at));
  if (loaded_.size() == kKept) loaded_.pop_front();
  loaded_.emplace_back(number, std::move(bytes));
  return loaded_.back().second;
}

void ChunkedLog::AddMessage(std::size_t topic, std::int64_t recorded_ns, int part, std::uint64_t at,
                            std::string_view bytes) {
  MessageLocation place{recorded_ns, part, at, bytes.size(), {}};
  bytes.copy(place.head.data(), place.head.size());
  topics_[topic].messages.push_back(place);
}

std::size_t ChunkedLog::AddTopic(const std::string& name, const std::string& type,
                                 Serialization serialization) {
  const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const Topic& topic) {
    return topic.name == name && topic.type == type && topic.serialization == serialization;
  });
  const std::size_t number = known - topics_.begin();
  if (known == topics_.end()) topics_.push_back({name, type, serialization, {}});
  return number;
}

std::string ChunkedLog::Read(const MessageLocation& place) const {
  if (place.part < 0) return file_.Read(place.at, place.size);
  return ChunkBytes(place.part).substr(place.at, place.size);
}

}  // namespace surfit
