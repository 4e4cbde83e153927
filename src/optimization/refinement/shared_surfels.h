#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "cost_functions/surfel_texture.h"
#include "surfit/optimization/refine.h"

namespace surfit {

// What one keyframe has measured of a surfel's plane.
struct PlaneObservation {
  int keyframe = 0;
  float u = 0, v = 0;       // px
  float inverse_depth = 0;  // 1/m, as measured
  float inverse_sigma = 0;  // m: 1 / sigma of that
};

// What a keyframe that has measured a surfel's plane sees of its texture.
struct TextureObservation {
  int keyframe = 0;
  int index = 0;            // of that keyframe among those that see the surfel
  float inverse_sigma = 0;  // of differences of intensity, the photometric weight included
  TextureTaps taps;
};

// A surfel that several keyframes see: a plane, free to move along its normal.
struct SharedSurfel {
  Eigen::Vector3d point_in_world, normal_in_world;  // metres, unit length
  double texture_radius_m = 0;                      // to the points beside it: TexturePoints()
  std::size_t begin = 0, end = 0;                   // of its observations
  std::size_t textures_begin = 0, textures_end = 0;
};

// A surfel's centre and the two points beside it, in tangential directions that are at right angles
// to each other; metres, in the world.
std::array<Eigen::Vector3d, 3> TexturePoints(const SharedSurfel& surfel);

// All surfels of a set of keyframes, and what these have measured of them. The observations of a
// surfel follow one another, in the keyframes' order.
struct SharedSurfels {
  std::vector<SharedSurfel> surfels;
  std::vector<PlaneObservation> observations;
  std::vector<TextureObservation> textures;
  std::vector<KeyframeReadout> readouts;  // of the keyframes
};

// The side of the cells of a keyframe's image, px.
int CellSize(const DepthCalibration& calibration, const RefinementOptions& options);

// Makes surfels from keyframes at their poses: where a cell of a keyframe's image shows none of
// those from earlier ones, the pixel in its middle becomes one. Then finds for each the keyframes
// that see it, and gives it the mean of the normals measured there. Surfels that fewer keyframes
// see than the options ask for are left out. The same at any number of threads.
SharedSurfels MakeSharedSurfels(const std::vector<RefinementKeyframe>& keyframes,
                                const DepthCalibration& calibration,
                                const RefinementOptions& options);

// From a surfel's centre to the points beside it, in the keyframe that it was made from.
inline constexpr double kTextureRadiusPx = 4;

// Moves each surfel to where its plane agrees best with what keyframes measure, as images are
// expanded there, and adds what those that have measured the plane see of its texture. A keyframe
// sees it where it measures the plane all around the points: what is before or behind that moves
// otherwise in the image. A surfel has none if fewer than two see it, or if for none of them it
// changes by a standard deviation per px. The same at any number of threads.
void ObserveTextures(const std::vector<RefinementKeyframe>& keyframes,
                     const DepthCalibration& calibration, const ErrorModel& model,
                     SharedSurfels* shared);

}  // namespace surfit
