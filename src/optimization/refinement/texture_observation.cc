#include <cmath>
#include <optional>

#include "optimization/refinement/joint_rows.h"
#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/reduced_system.h"
#include "optimization/refinement/shared_surfels.h"
#include "registration/global/view_fit.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

std::optional<Eigen::Vector2d> ImageOf(const Eigen::Vector3d& point_in_world,
                                       const Rigid3d& camera_from_world,
                                       const PinholeCamera& camera) {
  const Eigen::Vector3d point = camera_from_world * point_in_world;
  if (!(point.z() > 0)) return std::nullopt;
  const Eigen::Vector2d at = camera.Project(point);
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() <= camera.width - 1 && at.y() <= camera.height - 1)) {
    return std::nullopt;
  }
  return at;
}

std::optional<IntensityTap> TapAt(const Image<float>& image, const Eigen::Vector2d& at) {
  IntensityTap tap;
  tap.u = static_cast<float>(at.x());
  tap.v = static_cast<float>(at.y());
  const BilinearSample sample = SampleAt(image, tap.u, tap.v);
  tap.value = sample.value;
  tap.slope_u = sample.slope_u;
  tap.slope_v = sample.slope_v;
  if (!std::isfinite(tap.value + tap.slope_u + tap.slope_v)) return std::nullopt;
  return tap;
}

std::optional<TextureTaps> TapsOf(const SharedSurfel& surfel, const Image<float>& intensity,
                                  const Rigid3d& camera_from_world, const PinholeCamera& camera) {
  const std::array<Eigen::Vector3d, 3> points = TexturePoints(surfel);
  TextureTaps taps;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const auto at = ImageOf(points[j], camera_from_world, camera);
    const auto tap = at ? TapAt(intensity, *at) : std::nullopt;
    if (!tap) return std::nullopt;
    taps[j] = *tap;
  }
  return taps;
}

bool MeasuresPlane(const Eigen::Vector2d& at, const SharedSurfel& surfel,
                   const RefinementKeyframe& keyframe, const DepthCalibration& calibration,
                   const ErrorModel& model) {
  const int u = static_cast<int>(at.x() + 0.5), v = static_cast<int>(at.y() + 0.5);
  PlaneObservation seen;
  seen.u = static_cast<float>(u);
  seen.v = static_cast<float>(v);
  seen.inverse_depth = keyframe.images.inverse_depth(u, v);
  if (!(seen.inverse_depth > 0)) return false;
  seen.inverse_sigma =
      static_cast<float>(InversePlaneSigma(model, keyframe.images.noise, seen.inverse_depth));
  const PlaneResidual sight(seen, surfel, keyframe.world_from_camera.rotation.toRotationMatrix(),
                            keyframe.world_from_camera.translation,
                            MotionOf(seen, keyframe.images.readout, calibration.camera.height),
                            calibration);
  return std::abs(sight.Residual(0)) <= ErrorModel::kInlierSigmas;
}

// Returns whether a ring around the texture points observes the plane. The radius of the ring
// covers the smoothing of the image.
bool IsPlaneAround(const SharedSurfel& surfel, const RefinementKeyframe& keyframe,
                   const Rigid3d& camera_from_world, const DepthCalibration& calibration,
                   const ErrorModel& model) {
  constexpr int kPoints = 8;
  const std::array<Eigen::Vector3d, 3> points = TexturePoints(surfel);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * M_PI * i / kPoints;
    const Eigen::Vector3d beside =
        std::cos(angle) * (points[1] - points[0]) + std::sin(angle) * (points[2] - points[0]);
    const auto at = ImageOf(points[0] + 2 * beside, camera_from_world, calibration.camera);
    if (!at || !MeasuresPlane(*at, surfel, keyframe, calibration, model)) return false;
  }
  return true;
}

// Returns whether an image shift of 1 px changes the intensity differences by at least
// `min_slope_per_px`.
bool IsTextured(const TextureTaps& taps, double min_slope_per_px) {
  double squared = 0;
  for (int j = 1; j <= 2; ++j) {
    const double u = taps[j].slope_u - taps[0].slope_u, v = taps[j].slope_v - taps[0].slope_v;
    squared += u * u + v * v;
  }
  return squared >= min_slope_per_px * min_slope_per_px;
}

std::vector<TextureObservation> Observe(const SharedSurfel& surfel, const SharedSurfels& shared,
                                        const std::vector<RefinementKeyframe>& keyframes,
                                        const DepthCalibration& calibration,
                                        const ErrorModel& model) {
  std::vector<TextureObservation> seen;
  const auto inverse_sigma = static_cast<float>(InverseTextureSigma(model));
  bool textured = false;
  for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
    const int k = shared.observations[i].keyframe;
    if (keyframes[k].images.intensity.empty()) continue;
    const Rigid3d camera_from_world = keyframes[k].world_from_camera.Inverse();
    const auto taps =
        TapsOf(surfel, keyframes[k].images.intensity, camera_from_world, calibration.camera);
    if (!taps) continue;
    if (!IsPlaneAround(surfel, keyframes[k], camera_from_world, calibration, model)) continue;
    textured = textured || IsTextured(*taps, model.intensity_sigma);
    seen.push_back({k, static_cast<int>(i - surfel.begin), inverse_sigma, *taps});
  }
  if (!textured || seen.size() < 2) seen.clear();
  return seen;
}

}  // namespace

std::array<Eigen::Vector3d, 3> TexturePoints(const SharedSurfel& surfel) {
  const Eigen::Vector3d first = surfel.normal_in_world.unitOrthogonal();
  const Eigen::Vector3d second = surfel.normal_in_world.cross(first);
  return {surfel.point_in_world, surfel.point_in_world + surfel.texture_radius_m * first,
          surfel.point_in_world + surfel.texture_radius_m * second};
}

void ObserveTextures(const std::vector<RefinementKeyframe>& keyframes,
                     const DepthCalibration& calibration, const ErrorModel& model,
                     SharedSurfels* shared) {
  constexpr int kGrain = 256;
  JointState state = {{}, calibration};
  for (const RefinementKeyframe& keyframe : keyframes) {
    state.world_from_camera.push_back(keyframe.world_from_camera);
  }
  const PlacedPoses placed(state);
  const JointKernels kernels = KernelsOf(model);
  std::vector<std::vector<TextureObservation>> seen(shared->surfels.size());
  ParallelFor(0, static_cast<int>(seen.size()), kGrain, [&](int begin, int end) {
    for (int s = begin; s < end; ++s) {
      SharedSurfel& surfel = shared->surfels[s];
      surfel.point_in_world += SurfelResiduals(*shared, surfel, placed).Best(kernels).displacement *
                               surfel.normal_in_world;
      seen[s] = Observe(surfel, *shared, keyframes, calibration, model);
    }
  });
  for (std::size_t s = 0; s < seen.size(); ++s) {
    shared->surfels[s].textures_begin = shared->textures.size();
    shared->textures.insert(shared->textures.end(), seen[s].begin(), seen[s].end());
    shared->surfels[s].textures_end = shared->textures.size();
  }
}

}  // namespace surfit
