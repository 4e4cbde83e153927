#pragma once

#include <cstdint>
#include <vector>

#include "mapping/bucket_list.h"
#include "mapping/merge_gate.h"
#include "surfit/mapping/surfel.h"

namespace surfit {

// A surfel that belongs to the point of the pixel it projects to.
struct Candidate {
  Patch patch;  // in the camera frame
  float radius_m, confidence;
  std::int32_t surfel;
  int pixel;
  float distance2;              // between point and surfel, squared
  bool is_superfluous = false;  // another one of its pixel or of one beside does as well
  const SurfelObservation* seen = nullptr;  // by the points that chose it; null if none did
};

// The candidates of a cell of a map.
struct CandidateList {
  std::vector<Candidate> candidates;  // in the order of their surfels
  BucketList bands;                   // of their numbers
};

}  // namespace surfit
