#pragma once

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

class OptionVisitor;

// Options of preprocessing: depth image to vertex and normal maps. All steps use inverse depth: it
// is linear on planes, and its noise does not depend on the depth. The functions below do not
// validate the options. They run in parallel. Their results do not depend on the number of threads.
// Depth has the values of RgbdFrame::depth_m. Cameras must have fy > 0, which is not checked.
//
// A depth edge separates neighbouring pixels whose inverse depth differs by more than
//   3 sigma + tan(max_slant_rad) / (f z),
// with sigma = DepthNoise::inverse_depth_sigma, the focal length f in px, and the depth z of the
// pixel.
struct PreprocessOptions {
  int filter_radius_px = 2;     // half width of the filter window; 0: no filter
  double filter_cutoff = 4;     // larger differences have no filter weight, in sigmas of 1/z
  int normal_radius_px = 3;     // maximum pixel offset for the normals
  double max_slant_rad = 1.45;  // larger angles of normal and ray give depth edges; below 1.57
  int pyramid_levels = 4;       // maximum number of levels; coarser levels have at least 40 x 30 px

  void Visit(OptionVisitor& visitor);
};

// Edge-preserving depth filter: weighted mean of inverse depth in a square window. The weight
// decreases with the pixel distance (triangle) and the difference of inverse depth (biweight). It
// is 0 beyond filter_cutoff. Depth in m. Missing pixels (0) stay missing and have no weight.
// Returns the input if filter_radius_px is 0.
Image<float> FilterDepth(const Image<float>& depth_m, const DepthNoise& noise,
                         const PreprocessOptions& options);

// Vertices z * ray(u, v) in the camera frame, m, for depth z in m. (0, 0, 0): missing depth.
VectorImage VertexMap(Image<float> depth_m, const PinholeCamera& camera);

// Normals of a vertex map, towards the camera. The map must have the size of `sensor.camera`, which
// is not checked. A plane n . X = d has the inverse depth
//   r = (n_x (u - cx)/fx + n_y (v - cy)/fy + n_z) / d,
// so n ~ (fx r_u, fy r_v, r - (u - cx) r_u - (v - cy) r_v). The gradient (r_u, r_v) is the
// least-squares slope of symmetric differences up to normal_radius_px, or up to a depth edge. (0,
// 0, 0) if one of the four direct neighbours is missing, outside the image or beyond a depth edge.
VectorImage NormalMap(const VectorImage& vertex, const DepthSensor& sensor,
                      const PreprocessOptions& options);

// Sets the normals of `surface` to (0, 0, 0) at depth edges, beside missing pixels and at the image
// border. Used for model views, which are less accurate at depth edges.
void DropNormalsAtEdges(const PreprocessOptions& options, FrameLevel* surface);

// Level of half the resolution, without intensities. A pixel has the mean normal, of unit length,
// and the mean inverse depth of 2 x 2 pixels. Missing pixels, and pixels behind a depth edge in
// this block, are ignored. An odd last column or row is dropped.
FrameLevel HalfResolution(const FrameLevel& fine, const PreprocessOptions& options);

// Pyramid of at most `pyramid_levels` levels from a finest level. Coarser levels have no
// intensities.
FramePyramid BuildPyramid(FrameLevel finest, const PreprocessOptions& options);

// Filter, vertex map, normal map and pyramid of a depth image in m. The pyramid has no intensities.
// The image must have the size of the camera, which is not checked. Readout and prior of the sensor
// have no effect.
FramePyramid PreprocessDepth(const Image<float>& depth_m, const DepthSensor& sensor,
                             const PreprocessOptions& options);

}  // namespace surfit
