#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace surfit {

// Evenly spaced sample of a stream of unknown length: every stride-th item. A full sample (`most`
// items) drops every second item and doubles the stride.
template <typename T>
class EvenSample {
 public:
  // `most` must be even and positive (not checked).
  explicit EvenSample(std::size_t most) : most_(most) {}

  // Call once per item, in order. True: pass the item to Keep() before the next call.
  bool TakesNext() {
    if (offered_++ % stride_ != 0) return false;
    if (kept_.size() == most_) DropEveryOther();
    return true;
  }
  void Keep(T thing) { kept_.push_back(std::move(thing)); }

  // Sample, in order. At least most / 2 items if the stream is long enough.
  const std::vector<T>& kept() const { return kept_; }

 private:
  // The current index is most * stride, a multiple of the new stride because `most` is even.
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
