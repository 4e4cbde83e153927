#pragma once

#include <cstdint>
#include <vector>

#include "mapping/candidate_list.h"
#include "mapping/measured_points.h"
#include "mapping/posed_camera.h"
#include "mapping/view_frustum.h"

namespace surfit {

// Finds the surfels of a map that the points of a frame may be merged with.
class CandidateFinder {
 public:
  CandidateFinder(const PosedCamera& camera, const std::vector<MeasuredPoint>& points,
                  const Image<float>& free_depth_m, const MergeGate& gate, int active_since)
      : camera_(camera),
        frustum_(camera, 0.5f),  // to the borders of the outermost pixels
        points_(points),
        free_depth_m_(free_depth_m),
        gate_(gate),
        active_since_(active_since) {}

  // Surfels of these may be candidates, or seen through.
  bool MaySee(const SurfelBounds& bounds) const {
    return !bounds.empty() && frustum_.MaySee(bounds);
  }

  // Adds the candidates of some blocks to a list. None of them is marked for removal; those that
  // are seen through are marked so as well.
  void Find(const std::vector<std::int32_t>& blocks, SurfelMap* map,
            std::vector<Candidate>* candidates) const;

  struct BlockPixels;

 private:
  std::uint64_t Project(const SurfelBlock& block, BlockPixels* pixels) const;
  void Judge(std::uint64_t inside, std::int32_t first_id, SurfelBlock* block, BlockPixels* pixels,
             std::vector<Candidate>* candidates) const;

  const PosedCamera& camera_;
  const ViewFrustum frustum_;
  const std::vector<MeasuredPoint>& points_;
  const Image<float>& free_depth_m_;
  const MergeGate& gate_;
  const int active_since_;  // surfels that were last seen before this frame are left alone
};

}  // namespace surfit
