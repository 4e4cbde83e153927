#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "tracking/view_comparison.h"

namespace surfit {

// Cells of a ViewGrid, not 0 where something moves; empty where nothing does.
using CellMask = Image<std::uint8_t>;

// Finds what moves before the camera. Whatever hides the model may be something that is seen for
// the first time, or has come there: that tells who looked there a moment ago. A connected region
// of points in front of the model moves if the camera saw through a good part of it some moment
// ago.
class MovingRegions {
 public:
  MovingRegions();
  ~MovingRegions();

  // In a frame, by what CompareViews() says of it.
  CellMask Find(const FrameLevel& frame, const ViewComparison& comparison,
                const Rigid3d& world_from_camera, double stamp_s) const;

  // A frame that has a pose, and what Find() found in it: the next ones are compared with it.
  void Remember(const FrameLevel& frame, const CellMask& moving, const Rigid3d& world_from_camera,
                double stamp_s);
  // The world has been corrected.
  void Move(const Rigid3d& new_from_old_world);

 private:
  struct Sight;

  // The cells that show what moved in the last frame; empty if nothing did.
  CellMask MovedBefore(const FrameLevel& frame, const Image<Side>& sides,
                       const Rigid3d& world_from_camera, double stamp_s) const;
  void DropWhatRests(const FrameLevel& frame, const Image<Side>& sides,
                     const Rigid3d& world_from_camera, std::vector<int>* cells) const;
  bool Moves(const std::vector<int>& cells, const FrameLevel& frame, const CellMask& kinds,
             const CellMask& moved, const Rigid3d& world_from_camera) const;

  std::deque<Sight> sights_;     // in the order of time
  std::unique_ptr<Sight> last_;  // with what moves in it; null if nothing does
};

// The same without what moves.
Image<float> Without(Image<float> depth_m, const CellMask& moving);
RgbdFrame Without(RgbdFrame frame, const CellMask& moving);
FramePyramid Without(FramePyramid pyramid, const CellMask& moving);

}  // namespace surfit
