#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/rendering/posed_camera.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// Colour (red, green, blue from 0 to 255) with its weight. Weight 0: no colour.
struct SeenColor {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float weight = 0;
};

// Points with normals in the camera frame, and their colours. Initialised, because whole vectors
// are processed.
struct ColorBatch {
  static constexpr int kCapacity = 64;

  // Adds a point, m, with its unit normal. Requires count < kCapacity.
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

// Colours of points from the colour image of a frame. Points are in the camera frame of the pose at
// RgbdFrame::stamp_s. A colour row is captured t later. At that time, the point X is in the camera
// frame at
//   X - t (turn x X + velocity).
// The weight of a colour is
//   (n / 500)^2 |cos a| / (1 + b^2)^2
// for n pixels per metre at the point, the angle a between normal and ray, and b pixels of motion
// in 5 ms. It is 0 outside of the image and at black image borders.
class FrameColors {
 public:
  // Keeps a reference to the colour image. `camera`: intrinsics; its pose is not used.
  FrameColors(const RgbdFrame& frame, const PosedCamera& camera, const FrameMotion& motion);

  // Sets colours and weights of the batch. Requires a colour image of at least 2 x 2 px, and points
  // with z > 0. Thread-safe.
  void LookUp(ColorBatch* batch) const;
  // Colour of one point. Same requirements.
  SeenColor At(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  // Pixels inside the black border in two neighbouring rows or columns. `begin` and `end` are
  // indices of the first pixel of a pair. Pairs serve bilinear interpolation.
  struct Range {
    int begin, end;
    bool Has(int i) const { return i >= begin && i < end; }
  };

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
  // Capture time of the middle row relative to the pose, and time per row.
  const float middle_s_, row_s_;
  std::vector<Range> rows_, columns_;
};

}  // namespace surfit
