#pragma once

#include <deque>
#include <limits>

namespace surfit {

// The last frames that were fused, by their index.
class FrameWindow {
 public:
  // So many before the newest one.
  explicit FrameWindow(int frames) : most_(static_cast<std::size_t>(frames) + 1) {}

  void Push(int index) {
    indices_.push_back(index);
    if (indices_.size() > most_) indices_.pop_front();
  }

  // What was last seen before this frame is outside; nothing is while there were fewer frames.
  int Begin() const {
    return indices_.size() == most_ ? indices_.front() : std::numeric_limits<int>::min();
  }

 private:
  const std::size_t most_;
  std::deque<int> indices_;
};

}  // namespace surfit
