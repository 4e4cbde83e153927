#pragma once

#include <vector>

#include "mapping/candidate_list.h"
#include "mapping/measured_points.h"
#include "mapping/merge_gate.h"
#include "surfit/core/image.h"

namespace surfit {

// Chooses the surfel that each point is merged with.
class SurfelChoice {
 public:
  explicit SurfelChoice(const MergeGate& gate) : gate_(gate) {}

  // Begins a frame: gives each pixel the nearest of its candidates, and of those the first. The
  // lists must stay as they are while points choose.
  void SetCandidates(int width, int height, std::vector<CandidateList>* lists);

  // The point of a pixel chooses its pixel's surfel or, without one, the nearest of its neighbours'
  // surfels that it belongs to; marks it there. False if there is none. Points may choose at the
  // same time.
  bool Choose(const MeasuredPoint& point, int u, int v) const;

 private:
  Candidate* SurfelOfNeighbours(const MeasuredPoint& point, int u, int v) const;

  const MergeGate& gate_;
  Image<Candidate*> own_;  // null where there is none
};

}  // namespace surfit
