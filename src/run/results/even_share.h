#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace surfit {

// Keeps an even share of things that come one after the other, nobody knows how many: every
// stride-th, and whenever there are too many, every other is dropped and the stride doubled, so
// that half of `most` to `most` remain.
template <typename T>
class EvenShare {
 public:
  // An even number.
  explicit EvenShare(std::size_t most) : most_(most) {}

  // Whether the next one is to be kept. To be called once for each.
  bool TakesNext() {
    if (offered_++ % stride_ != 0) return false;
    if (kept_.size() == most_) DropEveryOther();
    return true;
  }
  void Keep(T thing) { kept_.push_back(std::move(thing)); }

  const std::vector<T>& kept() const { return kept_; }

 private:
  // The next one, at `most` strides, is a multiple of the new stride as well.
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
