#pragma once

#include <cstdint>
#include <vector>

#include "mapping/bands.h"
#include "mapping/measured_points.h"
#include "mapping/merge_gate.h"
#include "mapping/posed_camera.h"
#include "mapping/view_frustum.h"
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
