#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mapping/bucket_list.h"

namespace surfit {

// A surfel that belongs to the point of the pixel it projects to.
struct Candidate {
  Eigen::Vector3f position, normal;  // in the camera frame
  std::int32_t surfel;
  int pixel;
  // 1 for each of the 3 x 3 pixels around, row by row, whose point has chosen this surfel. A byte
  // each, so that points can choose at the same time.
  std::array<std::uint8_t, 9> chosen_by;
};

// What a candidate offers to its pixel.
struct Offer {
  float distance2;  // between point and surfel, squared
  int pixel;
  int candidate;  // its place in the list
};

// The candidates among a part of a map.
struct CandidateList {
  std::vector<Candidate> candidates;  // in the order of their surfels
  BucketList<Offer> offers;           // by band, and there in that order
};

}  // namespace surfit
