#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace surfit {

// The data of N functors of one kind (see point_functor.h) as structure of arrays in precision S.
// Arrays are padded by copies of the last point, so that lanes can be loaded whole.
template <typename Functor, typename S>
class BatchData {
 public:
  static constexpr int kPadding = 16;

  std::size_t size() const { return size_; }
  const S* array(int i) const { return arrays_[i].data(); }

  // Makes room for `size` points without values; Set() all of them, then call Pad().
  void Resize(std::size_t size) {
    size_ = size;
    for (auto& array : arrays_) array.resize(size + kPadding);
  }
  void Set(std::size_t point, const std::array<double, Functor::kDataSize>& data) {
    for (int i = 0; i < Functor::kDataSize; ++i) arrays_[i][point] = static_cast<S>(data[i]);
  }
  S* array(int i) { return arrays_[i].data(); }
  void Pad() {
    if (size_ == 0) return;
    for (auto& array : arrays_) {
      for (int k = 0; k < kPadding; ++k) array[size_ + k] = array[size_ - 1];
    }
  }

  static BatchData FromFunctors(const std::vector<Functor>& functors) {
    BatchData batch;
    batch.Resize(functors.size());
    for (std::size_t i = 0; i < functors.size(); ++i) batch.Set(i, functors[i].data);
    batch.Pad();
    return batch;
  }

 private:
  std::size_t size_ = 0;
  std::array<std::vector<S>, Functor::kDataSize> arrays_;
};

}  // namespace surfit
