#pragma once

#include <cstddef>
#include <vector>

namespace surfit {

// Images are processed in bands of kBandRows rows.
constexpr int kBandRows = 16;
inline int BandCount(int height) { return (height + kBandRows - 1) / kBandRows; }

// Indices of items per bucket, in order of insertion.
class BucketList {
 public:
  // Empties all buckets and sets their number. Call before Add(). Indices are not checked.
  void Clear(int bucket_count) {
    buckets_.resize(bucket_count);
    for (std::vector<int>& bucket : buckets_) bucket.clear();
  }
  void Add(int item, int bucket) { buckets_[bucket].push_back(item); }

  const std::vector<int>& In(int bucket) const { return buckets_[bucket]; }

 private:
  std::vector<std::vector<int>> buckets_;
};

// Clears a buffer for `most` items. Frees its memory if it is more than twice as large.
template <typename T>
void ClearClosely(std::size_t most, std::vector<T>* buffer) {
  if (buffer->capacity() > 2 * most) *buffer = std::vector<T>();
  buffer->clear();
}

}  // namespace surfit
