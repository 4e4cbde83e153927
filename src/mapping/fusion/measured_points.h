#pragma once

#include <vector>

#include "mapping/map/merge_gate.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// Point of a pixel in the camera frame, m. Aligned so that it does not cross a cache line.
struct alignas(32) MeasuredPoint {
  Patch patch = {};  // normal towards the camera; unspecified without a point
  // Radius of the disc that covers the pixel footprint: sqrt(2) z / f / |n_z|, limited at grazing
  // angles. 0: no point.
  float radius_m = 0;
  bool at_edge = false;  // depth edge: the normal is from a neighbour

  Eigen::Vector3f position() const { return {patch.x, patch.y, patch.z}; }
  Eigen::Vector3f normal() const { return {patch.nx, patch.ny, patch.nz}; }
};

// Computes the points of a frame in raster order, one per pixel. `surface`: preprocessed depth of
// the frame. A pixel without a normal gets the normal of a neighbour within half a sigma, or else
// no point. Reuses the memory of `points`.
void MeasurePoints(const RgbdFrame& frame, const FrameLevel& surface, const FusionOptions& options,
                   std::vector<MeasuredPoint>* points);

// Free depth per pixel, m: surfels with a smaller depth violate free space. Minimum of the measured
// depth minus margin over 3 x 3 pixels; 0 if a depth is missing. The margin is free_space_margin_m
// plus 4 sigma.
Image<float> FreeDepths(const Image<float>& depth_m, const DepthNoise& noise,
                        const FusionOptions& options);

// Weights of the points: exp(-g^2 / (2 * 0.6^2)) (Keller et al.). g is the distance from the
// principal point, relative to the farthest corner.
Image<float> PointWeights(const PinholeCamera& camera);

}  // namespace surfit
