#pragma once

#include <vector>

namespace surfit {

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

}  // namespace surfit
