#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/binary_descriptor.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

class OptionVisitor;

// A point that can be found again in another image.
struct PlaceFeature {
  Eigen::Vector3f point;  // in the camera's frame, metres
  BinaryDescriptor descriptor = {};
};

// What is kept of a frame to be found again and to be registered to: about 260 kB for a camera of
// 640 x 480, whose images are kept at half the size.
struct PlaceView {
  PinholeCamera camera;                // of the images
  DepthNoise noise;                    // of the depth
  Image<std::uint16_t> depth;          // filtered, in 1/kDepthUnitsPerMetre; 0 = missing
  Image<std::uint8_t> intensity;       // 1 = black to 255 = white; 0 = unknown; empty = none
  std::vector<PlaceFeature> features;  // none without colour

  // Depth to 13.1 m; what is farther is missing. Rounding is 0.1 mm.
  static constexpr double kDepthUnitsPerMetre = 5000;

  bool empty() const { return depth.empty(); }
  std::size_t Bytes() const;
};

// A frame that stands for its place.
struct Keyframe {
  int frame_index = 0;
  double stamp_s = 0;
  Rigid3d world_from_camera;  // as last estimated
  PlaceView view;             // empty where it was given up to bound memory (LimitKeyframes)
};

// How views of places are made.
struct PlaceViewOptions {
  int max_width = 320;     // px; images are halved until they are no wider
  int max_features = 500;  // spread over the image

  void Visit(OptionVisitor& visitor);
};

// Takes the finest level of the pyramid that is not too wide, and features of the colours, which
// are of the finest level's pixels or empty. Throws InputError for impossible options.
PlaceView MakePlaceView(const FramePyramid& pyramid, const Image<Rgb8>& color,
                        const PlaceViewOptions& options);

// The view's surfaces again, normals computed anew, with intensities where it has them.
FramePyramid PyramidOf(const PlaceView& view, const PreprocessOptions& options);

// When a frame becomes a keyframe.
struct KeyframeOptions {
  // From the last keyframe the camera has moved so far,
  double max_distance_m = 0.2;
  double max_angle_rad = 0.21;  // 12 degrees
  // or sees less than this share of what the keyframe sees,
  double min_overlap_share = 0.7;
  // or so many frames have passed since in which it moved at all: by a tenth of what is above.
  int max_frames = 60;

  void Visit(OptionVisitor& visitor);
};

// Whether a frame at that pose is to become a keyframe, after the last one. `surface` is any level
// of its pyramid.
bool IsKeyframe(const Keyframe& last, int frame_index, const FrameLevel& surface,
                const Rigid3d& world_from_camera, const KeyframeOptions& options);

// The share of the points that a keyframe sees which fall into the image of a camera there, and are
// not hidden from it by the surface it sees. 0 where the keyframe's view is empty.
double OverlapShare(const Keyframe& keyframe, const FrameLevel& surface,
                    const Rigid3d& world_from_camera);

}  // namespace surfit
