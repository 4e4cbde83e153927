#pragma once

#include <vector>

#include "mapping/map/merge_gate.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// The point of a pixel, within one line of cache.
struct alignas(32) MeasuredPoint {
  Patch patch = {};  // in the camera frame; valid if radius_m > 0
  // sqrt(2) z / f / |n_z|, clamped at grazing angles: the disc that covers the pixel's footprint.
  // 0 where there is no point.
  float radius_m = 0;
  bool at_edge = false;  // the normal is a neighbour's

  Eigen::Vector3f position() const { return {patch.x, patch.y, patch.z}; }
  Eigen::Vector3f normal() const { return {patch.nx, patch.ny, patch.nz}; }
};

// The points of a frame, row by row. Reuses the memory of `points`.
void MeasurePoints(const RgbdFrame& frame, const FrameLevel& surface, const FusionOptions& options,
                   std::vector<MeasuredPoint>* points);

// Surfels at a pixel with less depth than this are seen through: all pixels around are measured,
// and behind it by the margin. 0 where some depth is missing.
Image<float> FreeDepths(const Image<float>& depth_m, const DepthNoise& noise,
                        const FusionOptions& options);

// The weight a of each pixel's point: exp(-g^2 / (2 * 0.6^2)) (Keller et al.), g its distance from
// the principal point as a share of the farthest corner's; 1 with uniform weighting.
Image<float> PointWeights(const PinholeCamera& camera, const FusionOptions& options);

}  // namespace surfit
