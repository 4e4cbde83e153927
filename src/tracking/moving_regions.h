#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "tracking/view_comparison.h"

namespace surfit {

// Mask of ViewGrid cells, nonzero on moving objects. Empty without moving objects.
using CellMask = Image<std::uint8_t>;

// Values of a CellMask. kMovingMargin: margin around the object.
enum : std::uint8_t { kNotMoving, kMovingMargin, kMovingCore };

// Depth of the centre pixel of each ViewGrid cell, m. 0: missing.
Image<float> DepthOfCells(const FrameLevel& frame);

// Marks the cells by their kinds, and a margin of this many cells by kMovingMargin. Marked cells
// keep the larger value.
void MarkMoving(const std::vector<int>& cells, const CellMask& kinds, int margin, CellMask* moving);

// Adds the moving cells of `more`, which must not be empty, to `moving`. Returns moving cells /
// cells with depth.
double AddMoving(const FrameLevel& frame, const CellMask& more, CellMask* moving);

// Detects moving objects. A connected region in front of the model is moving if an earlier frame
// observed free space at most of its points. Otherwise it may be a new surface. Views of the last
// 10 s are compared. Call Remember() for each frame with a pose, after Find(). Not thread-safe:
// Find() must not run beside the other functions.
class MovingRegions {
 public:
  MovingRegions();
  ~MovingRegions();

  // Returns the moving cells of a frame; empty: none. `comparison`: result of CompareViews() for
  // the frame at this pose. `stamp_s`: timestamp of the frame.
  CellMask Find(const FrameLevel& frame, const ViewComparison& comparison,
                const Rigid3d& world_from_camera, double stamp_s) const;

  // Stores the view if the last stored view is 0.2 s old. `moving`: result of Find(); an object
  // that moved stays detected in the next frame.
  void Remember(const FrameLevel& frame, const CellMask& moving, const Rigid3d& world_from_camera,
                double stamp_s);
  // Follows the moving cells of the last frame with a pose through a lost frame, by depth and
  // position in the image. Call for each lost frame with enough depth.
  void Follow(const FrameLevel& frame);
  // Returns the moving cells in the last followed frame; empty: none.
  CellMask Followed() const;
  // Forgets all stored views. Call if the world frame changes without a known correction.
  void Forget();
  // Applies a correction of the world frame to the stored poses.
  void Move(const Rigid3d& new_from_old_world);

 private:
  struct PastView;

  // Cells on the moving objects of the last frame; empty if there were none.
  CellMask MovedBefore(const FrameLevel& frame, const Image<Side>& sides,
                       const Rigid3d& world_from_camera, double stamp_s) const;
  void RemoveStaticCells(const FrameLevel& frame, const Image<Side>& sides,
                         const Rigid3d& world_from_camera, std::vector<int>* cells) const;
  bool Moves(const std::vector<int>& cells, const FrameLevel& frame, const CellMask& kinds,
             const CellMask& moved, const Rigid3d& world_from_camera) const;

  std::deque<PastView> past_views_;
  std::unique_ptr<PastView> last_;      // last frame with its moving cells; null if there are none
  std::unique_ptr<PastView> followed_;  // last lost frame with moving cells since the last pose
};

// Sets the depth, vertices and normals of moving cells to 0, at any resolution. An empty mask
// changes nothing. The colours stay.
Image<float> Without(Image<float> depth_m, const CellMask& moving);
RgbdFrame Without(RgbdFrame frame, const CellMask& moving);
FramePyramid Without(FramePyramid pyramid, const CellMask& moving);

}  // namespace surfit
