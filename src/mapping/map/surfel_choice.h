#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapping/fusion/measured_points.h"
#include "mapping/map/merge_gate.h"
#include "mapping/map/view_frustum.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/image.h"
#include "surfit/mapping/surfel_block.h"

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

struct RowOutcome;

// Chooses the surfel that each point is merged with: of those its own and the eight pixels around
// it have, the nearest.
class SurfelChoice {
 public:
  // What became of a pixel's point. Below kOpen: it chose the surfel of the pixel
  // (u + state % 3 - 1, v + state / 3 - 1).
  enum State : std::uint8_t { kOwn = 4, kOpen = 9, kNew = 10, kNoPoint = 11 };

  explicit SurfelChoice(const MergeGate& gate) : gate_(gate) {}

  // Begins a frame: gives each pixel the nearest of its candidates, and of those the first, and
  // finds out which others are superfluous. The lists must stay where they are from then on.
  void SetCandidates(int width, int height, std::vector<CandidateList>* lists);

  // All points choose, and each pixel's candidate finds out whether those around make it
  // superfluous. Returns how many points there are.
  int ChooseAll(const std::vector<MeasuredPoint>& points);

  // Those points that nothing in the map stands for become surfels, but for those that others of
  // these stand for. Returns the pixels of the new ones in raster order, a list for each band.
  const std::vector<std::vector<int>>& ChooseNew(const std::vector<MeasuredPoint>& points);

  // The candidate of a pixel, null if it has none.
  Candidate* OfPixel(int pixel) const { return own_[pixel]; }

  // For each pixel of row v, as a mask: which of the nine pixels around it, row by row, have points
  // that chose its surfel.
  void ChoosingOfRow(int v, std::uint16_t* masks) const;

 private:
  void SetCandidates(int band, std::vector<CandidateList>* lists);
  int ChooseBand(const std::vector<MeasuredPoint>& points, int begin, int end);
  int Keep(int v, const RowOutcome& outcome);
  void ChooseNewOfPhase(const std::vector<MeasuredPoint>& points, int band, int phase);
  bool IsCovered(const std::vector<MeasuredPoint>& points, int pixel) const;
  // In the image of states, which has a border of one pixel.
  std::size_t PaddedIndex(int pixel) const {
    return static_cast<std::size_t>(pixel / width_ + 1) * (width_ + 2) + pixel % width_ + 1;
  }

  const MergeGate& gate_;
  int width_ = 0, height_ = 0;
  Image<Candidate*> own_;  // null where there is none
  Image<State> states_;
  // Pixels, by band and phase: whether rows and columns are even or odd.
  std::vector<std::array<std::vector<int>, 4>> open_;
  std::vector<std::vector<int>> new_;  // pixels, by band
};

}  // namespace surfit
