#pragma once

#include <vector>

namespace surfit {

// Items sorted into buckets, in their order there. An item may be in several buckets.
template <typename T>
class BucketList {
 public:
  struct Span {
    const T *first, *last;
    const T* begin() const { return first; }
    const T* end() const { return last; }
  };

  // Takes `count` items; for_each_bucket_of(k, f) calls f(bucket) for the buckets of item k.
  template <typename ForEachBucketOf>
  void Assign(const T* items, int count, int bucket_count,
              const ForEachBucketOf& for_each_bucket_of) {
    begin_.assign(bucket_count + 1, 0);
    for (int k = 0; k < count; ++k) {
      for_each_bucket_of(k, [&](int bucket) { ++begin_[bucket]; });
    }
    int sum = 0;
    for (int& bucket : begin_) {
      sum += bucket;
      bucket = sum;
    }
    Resize(static_cast<std::size_t>(sum));
    for (int k = count - 1; k >= 0; --k) {
      for_each_bucket_of(k, [&](int bucket) { items_[--begin_[bucket]] = items[k]; });
    }
  }

  Span In(int bucket) const {
    return {items_.data() + begin_[bucket], items_.data() + begin_[bucket + 1]};
  }

 private:
  // Keeps just the memory that is needed: not twice as much, nor what was needed once.
  void Resize(std::size_t size) {
    if (items_.capacity() < size || items_.capacity() > 2 * size) {
      items_ = std::vector<T>(size);
    } else {
      items_.resize(size);
    }
  }

  std::vector<T> items_;
  std::vector<int> begin_;  // of each bucket, and the end of the last
};

}  // namespace surfit
