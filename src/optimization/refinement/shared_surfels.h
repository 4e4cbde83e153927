#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "cost_functions/surfel_texture.h"
#include "surfit/optimization/refine.h"

namespace surfit {

// Depth pixel of a keyframe that observes a surfel.
struct PlaneObservation {
  int keyframe = 0;
  float u = 0, v = 0;       // px
  float inverse_depth = 0;  // 1/m, as measured
  float inverse_sigma = 0;  // 1 / sigma of the inverse depth, m
};

// Intensities of a keyframe at the texture points of a surfel.
struct TextureObservation {
  int keyframe = 0;
  int index = 0;            // position of the keyframe in the observations of the surfel
  float inverse_sigma = 0;  // 1 / sigma of intensity differences, including the photometric weight
  TextureTaps taps;
};

// Surfel that several keyframes observe. The ranges [begin, end) are indices in SharedSurfels.
struct SharedSurfel {
  Eigen::Vector3d point_in_world, normal_in_world;   // metres, unit length
  double texture_radius_m = 0;                       // distance of TexturePoints() from the centre
  std::size_t begin = 0, end = 0;                    // observations
  std::size_t textures_begin = 0, textures_end = 0;  // textures; equal: no texture
};

// Returns the surfel centre and two points beside it, in orthogonal tangential directions. World
// frame, m.
std::array<Eigen::Vector3d, 3> TexturePoints(const SharedSurfel& surfel);

// The observations of a surfel are contiguous and ordered by keyframe.
struct SharedSurfels {
  std::vector<SharedSurfel> surfels;
  std::vector<PlaneObservation> observations;
  std::vector<TextureObservation> textures;
  std::vector<KeyframeReadout> readouts;  // per keyframe
};

// Cell size of a keyframe image, px: image width / cells_across, at least 1.
int CellSize(const DepthCalibration& calibration, const RefinementOptions& options);

// Creates surfels from keyframes. The centre pixel of a cell becomes a surfel if the cell has no
// surfel of an earlier keyframe. The normal of a surfel is the mean over all observing keyframes.
// Surfels with fewer than three observations are removed. The result is the same for
// any number of threads. With a photometric weight, calls ObserveTextures(). All keyframes have the
// image size of `calibration`.
SharedSurfels MakeSharedSurfels(const std::vector<RefinementKeyframe>& keyframes,
                                const DepthCalibration& calibration,
                                const RefinementOptions& options);

// Distance of TexturePoints() from the surfel centre, in the image of the keyframe that created the
// surfel.
inline constexpr double kTextureRadiusPx = 4;

// Moves each surfel to its optimal displacement, and adds texture observations of keyframes that
// also observe the plane around the texture points. A surfel has texture if at least two keyframes
// observe it. In one of them, an image shift of 1 px must change the intensity differences by a
// standard deviation. The result is the same for any number of threads. Call it once. Keyframes
// without intensities are ignored.
void ObserveTextures(const std::vector<RefinementKeyframe>& keyframes,
                     const DepthCalibration& calibration, const ErrorModel& model,
                     SharedSurfels* shared);

}  // namespace surfit
