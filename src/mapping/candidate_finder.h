#pragma once

#include <cstdint>
#include <vector>

#include "mapping/candidate_list.h"
#include "mapping/measured_points.h"
#include "mapping/merge_gate.h"
#include "mapping/surfel_projector.h"

namespace surfit {

// Finds the surfels of a map that the points of a frame may be merged with.
class CandidateFinder {
 public:
  static constexpr int kCapacity = 2048;  // surfels to search at once

  CandidateFinder(const SurfelMap& map, const PosedCamera& camera,
                  const std::vector<MeasuredPoint>& points, const Image<float>& free_depth_m,
                  const MergeGate& gate)
      : projector_(map, camera),
        camera_(camera),
        points_(points),
        free_depth_m_(free_depth_m),
        gate_(gate) {}

  // Lists the candidates among the surfels [begin, end), at most kCapacity of them. None of them is
  // to be removed; those that are seen through are marked so as well.
  void Find(int begin, int end, std::vector<std::uint8_t>* remove, CandidateList* list) const;

 private:
  struct Seen;
  struct Found;

  bool Project(int begin, int end, Seen* seen) const;
  void Judge(const Seen& seen, std::vector<std::uint8_t>* remove, Found* found) const;

  const SurfelProjector projector_;
  const PosedCamera& camera_;
  const std::vector<MeasuredPoint>& points_;
  const Image<float>& free_depth_m_;
  const MergeGate& gate_;
};

}  // namespace surfit
