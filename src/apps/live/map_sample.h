#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Surfel for web pages, little endian:
//   x, y, z      21 bits each: millimetres in the world frame, plus 2^20; clamped
//   normal       3 x int8, of length 127
//   color        3 x uint8
//   radius       uint8: half millimetres, at least 1; 0: no surfel
//   confidence   uint8: WeightByte
using PackedSurfel = std::array<std::uint8_t, 16>;

// Values outside of the ranges are clamped.
PackedSurfel PackSurfel(const Surfel& surfel);

// Position of a page in the stream of changes. A round goes through all slots and transfers
// their changes since `version`, the start of the previous round.
struct SamplePlace {
  std::uint32_t epoch = 0;
  std::uint32_t level = 0;
  std::uint32_t version = 0;  // of the start of the last complete round; 0: no data
  std::uint32_t slot = 0;
};

// Changes since a place in the stream. `slot` and `surfel` have equal sizes.
struct SampleChanges {
  std::uint32_t epoch = 0;    // the page clears its slots if its epoch differs
  std::uint32_t level = 0;    // the page drops every second slot until it has this level
  std::uint32_t slots = 0;    // of the sample
  std::uint32_t version = 0;  // current version of the sample
  std::uint32_t next = 0;     // first slot of the next request; 0: end of the round
  std::vector<std::uint32_t> slot;
  std::vector<PackedSurfel> surfel;
};

// Subset of a map for display, with limited size. Slot s contains the surfel with id s * 2^level,
// if it exists. If the map grows beyond the limit, `level` increases and every second slot is
// dropped. Not thread-safe.
class MapSample {
 public:
  explicit MapSample(std::size_t most_slots) : most_slots_(most_slots) {}

  // Updates the next `slots` slots. Returns true after the last slot. The next call then
  // starts again.
  bool Update(const SurfelMap& map, std::size_t slots);
  // Replaces the sample by a map, and begins a new epoch: pages start again.
  void Reset(const SurfelMap& map);

  // At most `most` changes, starting with the slot of `place`. A place of another epoch or a higher
  // level gets all surfels.
  SampleChanges ChangesFrom(SamplePlace place, std::size_t most) const;

  // NoiseConfidence() of the sample, as WeightByte.
  std::uint8_t Dust() const;

  // Number of slots with a surfel.
  std::size_t shown() const { return shown_; }

 private:
  void Fit(const SurfelMap& map);
  void Look(const SurfelMap& map, std::uint32_t slot);

  std::size_t most_slots_;
  std::uint32_t epoch_ = 1, level_ = 0, version_ = 0;
  std::uint32_t next_ = 0;
  std::size_t shown_ = 0;
  std::vector<PackedSurfel> surfels_;
  std::vector<std::uint32_t> versions_;  // version of the last change per slot
  std::vector<std::uint32_t> newest_;    // upper bound of versions_ per block of kBlock slots
};

}  // namespace surfit
