#pragma once

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

class OptionVisitor;

// Conversion of depth images to vertex and normal maps. All steps use inverse depth, which is
// linear on planes. Its noise does not depend on the depth, so one threshold applies to all depths.
struct PreprocessOptions {
  int filter_radius_px = 2;     // half the filter window; 0: no filter
  double filter_cutoff = 4;     // larger differences have no filter weight, in sigmas
  int normal_radius_px = 3;     // maximum pixel offset for the normals
  double max_slant_rad = 1.45;  // surfaces at larger angles to the ray are depth edges
  int pyramid_levels = 4;       // fewer if a level would be smaller than 40 x 30 pixels

  void Visit(OptionVisitor& visitor);
};

// Edge-preserving depth filter: weighted mean of inverse depth in a square window. A weight is the
// product of a triangle function of the pixel distance and a biweight function of the difference in
// inverse depth. It is 0 beyond filter_cutoff. Depth in m. Missing pixels (0) stay missing and have
// no weight.
Image<float> FilterDepth(const Image<float>& depth_m, const DepthNoise& noise,
                         const PreprocessOptions& options);

// Vertices z * ray(u, v) in the camera frame, m. (0, 0, 0): missing depth.
VectorImage VertexMap(Image<float> depth_m, const PinholeCamera& camera);

// Normals of a vertex map, towards the camera. A plane n . X = d has the inverse depth r = (n_x (u
// - cx)/fx + n_y (v - cy)/fy + n_z) / d, so
//   n ~ (fx r_u, fy r_v, r - (u - cx) r_u - (v - cy) r_v).
// The gradient (r_u, r_v) is the least-squares slope of symmetric differences. Offsets grow up to
// normal_radius_px, or until a depth edge. (0, 0, 0) if a direct neighbour is beyond a depth edge.
VectorImage NormalMap(const VectorImage& vertex, const DepthSensor& sensor,
                      const PreprocessOptions& options);

// Sets normals to 0 at the depth edges of NormalMap(). For model views: the map is less accurate at
// its depth edges.
void DropNormalsAtEdges(const PreprocessOptions& options, FrameLevel* surface);

// Level of half the resolution, without intensities. A pixel has the mean normal and the mean
// inverse depth of a block of 2 x 2 pixels, on the central ray of the block. Pixels behind a depth
// edge in the block are ignored.
FrameLevel HalfResolution(const FrameLevel& fine, const PreprocessOptions& options);

// Pyramid from a finest level, with at most `pyramid_levels` levels.
FramePyramid BuildPyramid(FrameLevel finest, const PreprocessOptions& options);

// Depth filter, vertex map, normal map and pyramid of a depth image in m. No intensities.
FramePyramid PreprocessDepth(const Image<float>& depth_m, const DepthSensor& sensor,
                             const PreprocessOptions& options);

}  // namespace surfit
