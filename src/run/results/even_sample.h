#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace surfit {

// Evenly spaced sample of a stream of unknown length. Keeps every stride-th item. When it has
// `most` items, it drops every second item and doubles the stride before it keeps the next item.
// The sample has most / 2 to `most` items if the stream is long enough.
template <typename T>
class EvenSample {
 public:
  // `most` must be even and positive, which is not checked.
  explicit EvenSample(std::size_t most) : most_(most) {}

  // Returns true if the next item must be passed to Keep(). Call it once per item, in order.
  bool TakesNext() {
    if (offered_++ % stride_ != 0) return false;
    if (kept_.size() == most_) DropEveryOther();
    return true;
  }
  void Keep(T thing) { kept_.push_back(std::move(thing)); }

  const std::vector<T>& kept() const { return kept_; }

 private:
  // The current item has index most * stride. This is also a multiple of the new stride, because
  // `most` is even.
  void DropEveryOther() {
    for (std::size_t i = 1; 2 * i < kept_.size(); ++i) kept_[i] = std::move(kept_[2 * i]);
    kept_.resize(kept_.size() / 2);
    stride_ *= 2;
  }

  std::size_t most_;
  std::vector<T> kept_;
  int stride_ = 1;
  int offered_ = 0;
};

}  // namespace surfit
