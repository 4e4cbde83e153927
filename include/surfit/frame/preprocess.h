#pragma once

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

class OptionVisitor;

// How a depth image becomes vertex and normal maps. All of it works on inverse depth: a plane is
// linear there in pixel coordinates, and the sensor's noise is the same at every depth, so that
// one threshold serves near and far.
struct PreprocessOptions {
  int filter_radius_px = 2;     // of the depth filter's window; 0 = no filter
  double filter_cutoff = 4;     // differences beyond this many sigmas have no weight in the filter
  int normal_radius_px = 3;     // differences up to this offset make a normal
  double max_slant_rad = 1.45;  // a surface steeper than this to the ray counts as a depth edge
  int pyramid_levels = 4;  // the pyramid is shorter where a level would be under 40 x 30 pixels

  void Visit(OptionVisitor& visitor);
};

// Edge-preserving depth filter: the weighted mean of inverse depth over a square window, weights
// from the distance in pixels (triangle) and from the difference in inverse depth (biweight,
// zero at the cut-off). Depth in metres, 0 = missing; missing pixels stay missing and have no say.
Image<float> FilterDepth(const Image<float>& depth_m, const DepthNoise& noise,
                         const PreprocessOptions& options);

// Vertices z * ray(u, v) in the camera frame, 0 where depth is missing.
VectorImage VertexMap(Image<float> depth_m, const PinholeCamera& camera);

// Normals of the vertex map's surface, facing the camera. With inverse depth r(u, v), a plane
// n . X = d is seen as r = (n_x (u - cx)/fx + n_y (v - cy)/fy + n_z) / d, so that
//   n ~ (fx r_u, fy r_v, r - (u - cx) r_u - (v - cy) r_v).
// The gradient is the least-squares slope of symmetric differences up to normal_radius_px, as far
// as both sides continue the surface; (0, 0, 0) where that fails at one pixel (depth edges).
VectorImage NormalMap(const VectorImage& vertex, const DepthSensor& sensor,
                      const PreprocessOptions& options);

// Zeroes the surface's normals where NormalMap would give none: a map is less exact at its depth
// edges, and a view of it shows these as any depth image does.
void DropNormalsAtEdges(const PreprocessOptions& options, FrameLevel* surface);

// Half the resolution: each pixel is the mean inverse depth of its 2 x 2 block, seen along the
// block's central ray, without pixels that lie behind a depth edge; normals are averaged likewise.
FrameLevel HalfResolution(const FrameLevel& fine, const PreprocessOptions& options);

// A level and its coarser ones, as many as the options and the size allow.
FramePyramid BuildPyramid(FrameLevel finest, const PreprocessOptions& options);

// Filter, vertex map, normal map and pyramid of one depth image.
FramePyramid PreprocessDepth(const Image<float>& depth_m, const DepthSensor& sensor,
                             const PreprocessOptions& options);

}  // namespace surfit
