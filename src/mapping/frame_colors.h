#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/posed_camera.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// A colour that a frame saw, in 8-bit steps of sRGB, and how much it tells; 0 if nothing.
struct SeenColor {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float weight = 0;
};

// What a frame's colour image shows of points. Colour is not taken at the moment of depth, nor are
// its rows taken at one moment, while the camera moves. So a point X of the frame's pose is looked
// up, bilinearly, where it was at the time t of the row that shows it,
//   X - t (turn x X + velocity).
// A colour tells the more, the finer and the less slanted the pixels are that show it, and the less
// the motion blurs them: with n pixels per metre at the point, the angle a between its normal and
// the ray, and b pixels of motion in 5 ms,
//   weight = (n / 500)^2 |cos a| / (1 + b^2)^2.
// Black borders, which undistorted images have, tell nothing.
class FrameColors {
 public:
  FrameColors(const RgbdFrame& frame, const PosedCamera& camera, const FrameMotion& motion);

  // Of a point with its normal, in the camera's frame at the frame's pose. The frame has colours.
  SeenColor At(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  // Of two rows or columns beside each other: where a pixel and the next are between the black ends
  // of both.
  struct Range {
    int begin, end;
    bool Has(int i) const { return i >= begin && i < end; }
  };

  void FindBorders();
  // Nothing outside the image.
  SeenColor Sample(float u, float v) const;

  const Image<Rgb8>& color_;
  const float fx_, fy_, cx_, cy_;
  const Eigen::Vector3f turn_, velocity_;  // per second
  const float middle_s_, row_s_;  // of the middle row, after the pose's moment, and of one row more
  std::vector<Range> rows_, columns_;  // by the first of the two
};

}  // namespace surfit
