#pragma once

#include <cstdint>
#include <vector>

#include "apps/live/map_sample.h"

namespace surfit {

// Applies the changes of a sample like the page (src/live/page/shown_map.js).
class SampleClient {
 public:
  SamplePlace place() const { return place_; }
  const std::vector<PackedSurfel>& surfels() const { return surfels_; }

  // Applies an answer. Returns true if the round continues.
  bool Take(const SampleChanges& changes) {
    if (changes.epoch != place_.epoch) {
      surfels_.clear();
      place_ = {changes.epoch, changes.level, 0, 0};
    }
    for (; place_.level < changes.level; ++place_.level) Halve();
    surfels_.resize(changes.slots, PackedSurfel{});
    if (place_.slot == 0) begun_ = changes.version;
    for (std::size_t i = 0; i < changes.slot.size(); ++i) {
      surfels_.at(changes.slot[i]) = changes.surfel[i];
    }
    place_.slot = changes.next;
    if (changes.next == 0) place_.version = begun_;
    return changes.next != 0;
  }

 private:
  void Halve() {
    const std::size_t left = (surfels_.size() + 1) / 2;
    for (std::size_t i = 0; i < left; ++i) surfels_[i] = surfels_[2 * i];
    surfels_.resize(left);
  }

  SamplePlace place_;
  std::uint32_t begun_ = 0;
  std::vector<PackedSurfel> surfels_;
};

}  // namespace surfit
