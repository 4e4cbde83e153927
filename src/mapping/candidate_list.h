#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapping/bucket_list.h"
#include "mapping/merge_gate.h"

namespace surfit {

// A surfel that belongs to the point of the pixel it projects to.
struct Candidate {
  Patch patch;  // in the camera frame
  std::int32_t surfel;
  int pixel;
  float distance2;  // between point and surfel, squared
  // 1 for each of the 3 x 3 pixels around, row by row, whose point has chosen this surfel. A byte
  // each, so that points can choose at the same time.
  std::array<std::uint8_t, 9> chosen_by;
};

// The candidates of a cell of a map.
struct CandidateList {
  std::vector<Candidate> candidates;  // in the order of their surfels
  BucketList bands;                   // of their numbers
};

}  // namespace surfit
