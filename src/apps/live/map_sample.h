#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// A surfel as pages get it, little endian:
//   x, y, z      21 bits each: millimetres in the world, plus 2^20; farther ones lie at the border
//   normal       3 x int8, of length 127
//   color        3 x uint8
//   radius       uint8: half millimetres, at least 1; 0: there is no surfel
//   confidence   uint8: WeightByte
using ShownSurfel = std::array<std::uint8_t, 16>;

ShownSurfel PackSurfel(const Surfel& surfel);

// Where a page stands among the changes of a sample. It goes through the slots from first to last
// and has then all changes since `version`; the next round asks for those since the version that
// this one began at.
struct SamplePlace {
  std::uint32_t epoch = 0;
  std::uint32_t level = 0;
  std::uint32_t version = 0;  // of its last whole round; 0: it has nothing
  std::uint32_t slot = 0;     // the first that it has not come to in this round
};

// What has changed from a place on.
struct SampleChanges {
  std::uint32_t epoch = 0;    // another than the page's: it forgets all that it has
  std::uint32_t level = 0;    // larger than the page's: it keeps every other slot, and again
  std::uint32_t slots = 0;    // of the sample; the page has none beyond
  std::uint32_t version = 0;  // of the sample now
  std::uint32_t next = 0;     // to go on from; 0: this was the end of the round
  std::vector<std::uint32_t> slot;
  std::vector<ShownSurfel> surfel;
};

// The part of a map that is shown, of a bounded size: slot s holds the surfel of id s 2^level, if
// there is one. When the map has grown too large for its slots every other one is dropped.
class MapSample {
 public:
  explicit MapSample(std::size_t most_slots) : most_slots_(most_slots) {}

  // Looks at so many slots, going on where the last call has ended. Returns whether they end with
  // the last one: then all of the sample has been looked at, and begins anew.
  bool Update(const SurfelMap& map, std::size_t slots);
  // Of another map: pages begin anew.
  void Reset(const SurfelMap& map);

  // At most `most` of the changes.
  SampleChanges ChangesFrom(SamplePlace place, std::size_t most) const;

  // DustConfidence() of the surfels, as a WeightByte.
  std::uint8_t Dust() const;

  std::size_t shown() const { return shown_; }  // surfels

 private:
  void Fit(const SurfelMap& map);
  void Look(const SurfelMap& map, std::uint32_t slot);

  std::size_t most_slots_;
  std::uint32_t epoch_ = 1, level_ = 0, version_ = 0;
  std::uint32_t next_ = 0;  // slot to look at
  std::size_t shown_ = 0;
  std::vector<ShownSurfel> surfels_;
  std::vector<std::uint32_t> versions_;  // when they have changed
  std::vector<std::uint32_t> newest_;    // for each kBlock slots: no version of them is newer
};

}  // namespace surfit
