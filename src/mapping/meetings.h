#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapping/candidate_list.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// A surfel and the pixel of a point that chose it.
struct Meeting {
  std::int32_t surfel;
  int pixel;

  std::int32_t block() const { return surfel / SurfelBlock::kCapacity; }
  int place() const { return surfel % SurfelBlock::kCapacity; }
};

// The meetings of a list's surfels, and how many of these have any: by surfel, and there in raster
// order.
inline std::vector<Meeting> Meetings(const CandidateList& list, int width, int* surfels) {
  constexpr std::array<std::uint8_t, 9> kOnlyByOwnPoint = {0, 0, 0, 0, 1, 0, 0, 0, 0};
  std::vector<Meeting> meetings;
  meetings.reserve(2 * list.candidates.size());
  for (const Candidate& candidate : list.candidates) {
    if (!candidate.chosen_by[4]) continue;  // nor did others: its own point chose another one
    ++*surfels;
    if (candidate.chosen_by == kOnlyByOwnPoint) {  // as most are
      meetings.push_back({candidate.surfel, candidate.pixel});
      continue;
    }
    for (int k = 0; k < 9; ++k) {
      const int pixel = candidate.pixel + (k / 3 - 1) * width + k % 3 - 1;
      if (candidate.chosen_by[k]) meetings.push_back({candidate.surfel, pixel});
    }
  }
  return meetings;
}

}  // namespace surfit
