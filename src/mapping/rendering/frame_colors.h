#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/rendering/posed_camera.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// A colour that a frame saw, in 8-bit steps of sRGB, and how much it tells; 0 if nothing.
struct SeenColor {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float weight = 0;
};

// Points with their normals, in the camera's frame, and what was seen of them. Initialised, as
// whole lanes are worked on.
struct ColorBatch {
  static constexpr int kCapacity = 64;

  void Add(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
    const float values[] = {point.x(), point.y(), point.z(), normal.x(), normal.y(), normal.z()};
    for (int i = 0; i < 6; ++i) patch[i][count] = values[i];
    ++count;
  }
  SeenColor Seen(int k) const { return {{color[0][k], color[1][k], color[2][k]}, weight[k]}; }

  int count = 0;
  alignas(32) float patch[6][kCapacity] = {};  // position and normal
  alignas(32) float color[3][kCapacity] = {};
  alignas(32) float weight[kCapacity] = {};
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

  // What is seen of all points of the batch, in the camera's frame at the frame's pose. The frame
  // has colours.
  void LookUp(ColorBatch* batch) const;
  // Of a single point with its normal.
  SeenColor At(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  // Of two rows or columns beside each other: where a pixel and the next are between the black ends
  // of both.
  struct Range {
    int begin, end;
    bool Has(int i) const { return i >= begin && i < end; }
  };

  // As many places in the image as there are lanes, and what is seen there.
  template <typename V>
  struct Samples;

  void FindBorders();
  template <typename V>
  void LookUp(int first, ColorBatch* batch) const;
  template <typename V>
  Samples<V> Sample(const V& u, const V& v) const;
  template <typename V>
  struct Corners;
  template <typename V>
  void ReadCorners(const V& at_u, const V& at_v, Corners<V>* corners) const;

  const Image<Rgb8>& color_;
  const float fx_, fy_, cx_, cy_;
  const Eigen::Vector3f turn_, velocity_;  // per second
  const float middle_s_, row_s_;  // of the middle row, after the pose's moment, and of one row more
  std::vector<Range> rows_, columns_;  // by the first of the two
};

}  // namespace surfit
