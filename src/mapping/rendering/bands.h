#pragma once

#include <cstddef>
#include <vector>

namespace surfit {

// Images are worked on in bands of so many rows.
constexpr int kBandRows = 16;
inline int BandCount(int height) { return (height + kBandRows - 1) / kBandRows; }

// Numbers of items in buckets: in the order they came there.
class BucketList {
 public:
  // Empties all buckets, and keeps their memory.
  void Clear(int bucket_count) {
    buckets_.resize(bucket_count);
    for (std::vector<int>& bucket : buckets_) bucket.clear();
  }
  void Add(int item, int bucket) { buckets_[bucket].push_back(item); }

  const std::vector<int>& In(int bucket) const { return buckets_[bucket]; }

 private:
  std::vector<std::vector<int>> buckets_;
};

// Empties a buffer that is used again and again, for at most so many items. It keeps its memory,
// but not that of one which needed far more.
template <typename T>
void ClearClosely(std::size_t most, std::vector<T>* buffer) {
  if (buffer->capacity() > 2 * most) *buffer = std::vector<T>();
  buffer->clear();
}

}  // namespace surfit
