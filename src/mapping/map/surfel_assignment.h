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

// Surfel that matches the point of its pixel. `patch` is in the camera frame.
struct Candidate {
  Patch patch;
  float radius_m, confidence;               // of the surfel
  std::int32_t surfel;                      // id in the map
  int pixel;                                // index in raster order
  float distance2;                          // MergeGate::SquaredDistanceOnRay(), m^2
  bool is_duplicate = false;                // duplicate of a better candidate nearby
  const SurfelObservation* seen = nullptr;  // null: no points, see FrameObservations
};

// Candidates of a map cell.
struct CandidateList {
  std::vector<Candidate> candidates;  // sorted by surfel
  BucketList bands;                   // indices of `candidates` per image band (bands.h)
};

// Finds the surfels that match the points of a frame. Keeps references to all arguments. Surfels
// last seen before frame `active_since` are ignored.
class CandidateFinder {
 public:
  CandidateFinder(const PosedCamera& camera, const std::vector<MeasuredPoint>& points,
                  const Image<float>& free_depth_m, const MergeGate& gate, int active_since)
      : camera_(camera),
        frustum_(camera, 0.5f),  // includes the borders of the outermost pixels
        points_(points),
        free_depth_m_(free_depth_m),
        gate_(gate),
        active_since_(active_since) {}

  // False if these bounds have no candidate and no free-space violation.
  bool MaySee(const SurfelBounds& bounds) const {
    return !bounds.empty() && frustum_.MaySee(bounds);
  }

  // Appends the candidates of some blocks. Marks free-space violations for removal. `blocks`:
  // indices in the map. Calls for different blocks may run in parallel. Does not set
  // CandidateList::bands.
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
  // surfels last seen in earlier frames are ignored
  const int active_since_;
};

// Assigns each point to the nearest matching candidate of 3 x 3 pixels. Order per frame:
// SetCandidates(), AssignAll(), then AssignmentsOfRow(), and SelectNew(). Not thread-safe, except
// AssignmentsOfRow().
class SurfelAssignment {
 public:
  // State of the point of a pixel. Values below kOpen: assigned to the surfel of pixel (u + state %
  // 3 - 1, v + state / 3 - 1). kOpen: not assigned. kNew: becomes a new surfel.
  enum State : std::uint8_t { kOwn = 4, kOpen = 9, kNew = 10, kNoPoint = 11 };

  // Keeps a reference to the gate.
  explicit SurfelAssignment(const MergeGate& gate) : gate_(gate) {}

  // Starts a frame. Keeps the nearest candidate per pixel. If another candidate of the pixel is its
  // duplicate, marks the less confident of both. Keeps pointers to the candidates, which must not
  // move.
  void SetCandidates(int width, int height, std::vector<CandidateList>* lists);

  // Assigns all points, and marks duplicates of neighbouring candidates. Returns the number of
  // points.
  int AssignAll(const std::vector<MeasuredPoint>& points);

  // Selects new surfels from the points without assignment, except points that match another new
  // surfel. Returns their pixels in raster order, one list per band. The result is valid until the
  // next call.
  const std::vector<std::vector<int>>& SelectNew(const std::vector<MeasuredPoint>& points);

  // Nearest candidate of a pixel; null: none.
  Candidate* OfPixel(int pixel) const { return own_[pixel]; }

  // Masks of the pixels of row v. Bit k: the point of pixel k of 3 x 3, row by row, is assigned to
  // this pixel's surfel. `masks` has one value per column.
  void AssignmentsOfRow(int v, std::uint16_t* masks) const;

 private:
  void SetCandidates(int band, std::vector<CandidateList>* lists);
  int ChooseBand(const std::vector<MeasuredPoint>& points, int begin, int end);
  void MarkDuplicates(int u, int v, int begin, int end);
  int Keep(int v, const float* state_of_column);
  void SelectNewOfPhase(const std::vector<MeasuredPoint>& points, int band, int phase);
  bool IsCovered(const std::vector<MeasuredPoint>& points, int pixel) const;
  std::size_t PaddedIndex(int pixel) const {
    return static_cast<std::size_t>(pixel / width_ + 1) * (width_ + 2) + pixel % width_ + 1;
  }

  const MergeGate& gate_;
  int width_ = 0, height_ = 0;
  Image<Candidate*> own_;  // null: no candidate
  Image<State> states_;
  // Pixels of points without assignment, by band and phase (parity of row and column).
  std::vector<std::array<std::vector<int>, 4>> open_;
  std::vector<std::vector<int>> new_;  // pixels, by band
};

}  // namespace surfit
