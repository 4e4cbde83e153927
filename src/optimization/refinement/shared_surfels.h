#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "cost_functions/surfel_texture.h"
#include "surfit/optimization/refine.h"

namespace surfit {

struct PlaneObservation {
  int keyframe = 0;
  float u = 0, v = 0;       // px
  float inverse_depth = 0;  // 1/m, as measured
  float inverse_sigma = 0;  // 1 / sigma of the inverse depth, m
};

// Observation of a surfel texture by a keyframe that observes the plane.
struct TextureObservation {
  int keyframe = 0;
  int index = 0;  // position of the keyframe in the observations of the surfel
  float inverse_sigma =
      0;  // 1 / sigma of differences of intensity, including the photometric weight
  TextureTaps taps;
};

// Surfel that several keyframes observe: a plane with a displacement along its normal.
struct SharedSurfel {
  Eigen::Vector3d point_in_world, normal_in_world;  // metres, unit length
  double texture_radius_m = 0;     // distance of the neighbouring points: TexturePoints()
  std::size_t begin = 0, end = 0;  // range of its observations
  std::size_t textures_begin = 0, textures_end = 0;
};

// Returns the centre of a surfel and two neighbouring points, in orthogonal tangential directions;
// metres, world frame.
std::array<Eigen::Vector3d, 3> TexturePoints(const SharedSurfel& surfel);

// All surfels of a set of keyframes with their observations. The observations of a surfel are
// contiguous, in the order of the keyframes.
struct SharedSurfels {
  std::vector<SharedSurfel> surfels;
  std::vector<PlaneObservation> observations;
  std::vector<TextureObservation> textures;
  std::vector<KeyframeReadout> readouts;  // per keyframe
};

// Cell size of a keyframe image, px.
int CellSize(const DepthCalibration& calibration, const RefinementOptions& options);

// Creates surfels from keyframes. If a cell of a keyframe image has no surfel of an earlier
// keyframe, its centre pixel becomes a surfel. Then finds the keyframes that observe each surfel,
// and averages their normals. Surfels with fewer than `min_observations` observations are removed.
// The result is the same for any number of threads.
SharedSurfels MakeSharedSurfels(const std::vector<RefinementKeyframe>& keyframes,
                                const DepthCalibration& calibration,
                                const RefinementOptions& options);

// Distance of the neighbouring points of a surfel, in the keyframe that created it.
inline constexpr double kTextureRadiusPx = 4;

// Moves each surfel to the optimal displacement of its plane, the linearisation point of the
// images, and adds texture observations. A keyframe observes the texture if it observes the plane
// everywhere around the points, because other surfaces move differently in the image. A surfel has
// no texture if fewer than two keyframes observe the texture. In at least one keyframe, an image
// shift of 1 px must change its intensity differences by a standard deviation. The result is the
// same for any number of threads.
void ObserveTextures(const std::vector<RefinementKeyframe>& keyframes,
                     const DepthCalibration& calibration, const ErrorModel& model,
                     SharedSurfels* shared);

}  // namespace surfit
