#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/binary_descriptor.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

class OptionVisitor;

// Image feature with depth.
struct PlaceFeature {
  Eigen::Vector3f point;  // in the camera frame, metres
  BinaryDescriptor descriptor = {};
};

// Compact view of a keyframe for place recognition and registration: about 250 kB for a camera of
// 640 x 480 px.
struct PlaceView {
  PinholeCamera camera;
  DepthNoise noise;
  InverseDepthField field;             // correction in `depth` and `features`: see Recalibrate()
  Image<std::uint16_t> depth;          // filtered depth in 1/kDepthUnitsPerMetre m; 0: missing
  Image<std::uint8_t> intensity;       // 1: black, 255: white, 0: unknown or RGB 0; empty: none
  std::vector<PlaceFeature> features;  // empty without colour

  // Resolution of 0.2 mm. Depth above 13.1 m is missing.
  static constexpr double kDepthUnitsPerMetre = 5000;

  bool empty() const { return depth.empty(); }
  // Memory of images and features, bytes.
  std::size_t Bytes() const;
};

// Converts camera, depth and features of a view to a calibration of the full resolution. Pixels and
// measured depths do not change. The calibration of the view is `camera` and `field`. Points with a
// corrected inverse depth of at most InverseDepthField::kMinInverse become missing. No effect on an
// empty view.
void Recalibrate(const DepthCalibration& to, PlaceView* view);

// Frame with a stored view.
struct Keyframe {
  int frame_index = 0;
  double stamp_s = 0;
  Rigid3d world_from_camera;  // latest estimate
  PlaceView view;             // empty if removed by LimitKeyframes()
  int piece = 0;              // poses of different pieces are not comparable
};

// Options of MakePlaceView().
struct PlaceViewOptions {
  int max_width = 320;     // maximum width of the images, px; limited by the levels of the pyramid
  int max_features = 500;  // distributed over the image

  void Visit(OptionVisitor& visitor);
};

// Makes a view from the finest pyramid level within `max_width`, or from the coarsest level. The
// pyramid must have a level. Features come from `color`, which has the size of the finest pyramid
// level. An empty `color` gives no features and no intensities. Throws InputError for invalid
// options.
PlaceView MakePlaceView(const FramePyramid& pyramid, const Image<Rgb8>& color,
                        const PlaceViewOptions& options);

// Makes a view without intensities and features. Otherwise like MakePlaceView().
PlaceView MakeDepthView(const FramePyramid& pyramid, const PlaceViewOptions& options);

// Pyramid of the surfaces of a view, which must not be empty. Its finest level has the camera of
// the view. Normals are computed again. Intensities are included if the view has them.
FramePyramid PyramidOf(const PlaceView& view, const PreprocessOptions& options);

// Criteria of a new keyframe. One criterion is sufficient. Overlap and number of frames count only
// after some motion: a tenth of `max_distance_m` or of `max_angle_rad`.
struct KeyframeOptions {
  double max_distance_m = 0.2;  // distance from the last keyframe
  double max_angle_rad = 0.21;  // rotation from the last keyframe: 12 degrees
  // Minimum OverlapRatio() with the last keyframe. Not used if its view is empty.
  double min_overlap_ratio = 0.7;  // in [0, 1]
  // Maximum number of frames since the last keyframe.
  int max_frames = 60;

  void Visit(OptionVisitor& visitor);
};

// True if a frame at `world_from_camera` becomes the keyframe after `last`. `surface`: any level of
// the pyramid of the frame. Does not validate the options.
bool IsKeyframe(const Keyframe& last, int frame_index, const FrameLevel& surface,
                const Rigid3d& world_from_camera, const KeyframeOptions& options);

// Ratio of the points of a keyframe (every 8th row and column) that are visible in a camera at
// `world_from_camera`. Points more than 10 % behind `surface` are occluded. Pixels without depth
// occlude nothing. 0 if the view of the keyframe is empty or has no depth.
double OverlapRatio(const Keyframe& keyframe, const FrameLevel& surface,
                    const Rigid3d& world_from_camera);

}  // namespace surfit
