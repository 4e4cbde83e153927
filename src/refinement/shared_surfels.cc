#include "refinement/shared_surfels.h"

#include <algorithm>
#include <cmath>

#include "refinement/joint_state.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

struct Plane {
  Eigen::Vector3d point, normal;
  double texture_radius_m = 0;
};

// The calibrated plane in the camera's frame that a pixel measures; nothing if it has none or is
// seen too obliquely. From 1/z = n . ray / d with d < 0, n ~ -(fx r_u, fy r_v, r - (u - cx) r_u -
// (v - cy) r_v).
std::optional<Plane> MeasuredPlane(const KeyframeImages& images, int u, int v,
                                   const DepthCalibration& calibration, double max_slant_rad) {
  const float measured = images.inverse_depth(u, v);
  const double slope_u = images.slope_u(u, v), slope_v = images.slope_v(u, v);
  if (!(measured > 0) || std::isnan(slope_u)) return std::nullopt;
  const PinholeCamera& camera = calibration.camera;
  const Eigen::Vector3d ray = camera.Ray(u, v);
  const double inverse_depth = measured + calibration.field.At(ray.x(), ray.y());
  if (!(inverse_depth > 0)) return std::nullopt;
  const Eigen::Vector3d normal =
      -Eigen::Vector3d(camera.fx * slope_u, camera.fy * slope_v,
                       inverse_depth - (u - camera.cx) * slope_u - (v - camera.cy) * slope_v)
           .normalized();
  if (!(-normal.dot(ray) > std::cos(max_slant_rad) * ray.norm())) return std::nullopt;
  return Plane{ray / inverse_depth, normal};
}

struct Pixel {
  int u = 0, v = 0;
};

std::optional<Pixel> PixelOf(const Eigen::Vector3d& point_in_camera, const PinholeCamera& camera) {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  const Eigen::Vector2d at = camera.Project(point_in_camera);
  const double u = std::floor(at.x() + 0.5), v = std::floor(at.y() + 0.5);
  if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) return std::nullopt;
  return Pixel{static_cast<int>(u), static_cast<int>(v)};
}

// Which cells of a keyframe's image show a surfel already.
class Cells {
 public:
  Cells(const PinholeCamera& camera, int size_px)
      : size_px_(size_px),
        taken_((camera.width + size_px - 1) / size_px, (camera.height + size_px - 1) / size_px) {}

  void Take(float u, float v) {
    taken_(static_cast<int>(u) / size_px_, static_cast<int>(v) / size_px_) = 1;
  }
  // The middle pixels of all free cells that lie within the image, row by row.
  std::vector<Pixel> FreeMiddles(const PinholeCamera& camera) const {
    std::vector<Pixel> pixels;
    for (int j = 0; j < taken_.height(); ++j) {
      for (int i = 0; i < taken_.width(); ++i) {
        const Pixel middle = {i * size_px_ + size_px_ / 2, j * size_px_ + size_px_ / 2};
        if (!taken_(i, j) && middle.u < camera.width && middle.v < camera.height) {
          pixels.push_back(middle);
        }
      }
    }
    return pixels;
  }

 private:
  int size_px_;
  Image<std::uint8_t> taken_;
};

std::vector<Plane> MakePlanes(const std::vector<RefinementKeyframe>& keyframes,
                              const DepthCalibration& calibration,
                              const RefinementOptions& options) {
  constexpr int kGrain = 4096;
  std::vector<Plane> planes;
  for (const RefinementKeyframe& keyframe : keyframes) {
    std::vector<std::optional<PlaneObservation>> seen(planes.size());
    ParallelFor(0, static_cast<int>(planes.size()), kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        seen[i] = Observe(planes[i].point, planes[i].normal, keyframe.images,
                          keyframe.world_from_camera, calibration, options);
      }
    });
    Cells cells(calibration.camera, CellSize(calibration, options));
    for (const auto& observation : seen) {
      if (observation) cells.Take(observation->u, observation->v);
    }
    const Rigid3d& pose = keyframe.world_from_camera;
    for (const Pixel& pixel : cells.FreeMiddles(calibration.camera)) {
      const auto plane =
          MeasuredPlane(keyframe.images, pixel.u, pixel.v, calibration, options.max_slant_rad);
      if (!plane) continue;
      const double radius_m = kTextureRadiusPx * plane->point.z() / calibration.camera.fx;
      planes.push_back({pose * plane->point, pose.rotation * plane->normal, radius_m});
    }
  }
  return planes;
}

// All keyframes' observations of a plane.
std::vector<PlaneObservation> ObserveAll(const Plane& plane,
                                         const std::vector<RefinementKeyframe>& keyframes,
                                         const DepthCalibration& calibration,
                                         const RefinementOptions& options) {
  std::vector<PlaneObservation> observations;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    auto observation = Observe(plane.point, plane.normal, keyframes[k].images,
                               keyframes[k].world_from_camera, calibration, options);
    if (!observation) continue;
    observation->keyframe = static_cast<int>(k);
    observations.push_back(*observation);
  }
  return observations;
}

// In the world. The noise of one normal would turn the plane about the surfel's own point, and
// with it what others see beside that point.
Eigen::Vector3d MeanNormal(const std::vector<PlaneObservation>& observations,
                           const std::vector<RefinementKeyframe>& keyframes,
                           const DepthCalibration& calibration, const RefinementOptions& options) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PlaneObservation& o : observations) {
    const RefinementKeyframe& keyframe = keyframes[o.keyframe];
    const auto plane = MeasuredPlane(keyframe.images, static_cast<int>(o.u), static_cast<int>(o.v),
                                     calibration, options.max_slant_rad);
    sum += keyframe.world_from_camera.rotation * plane->normal;
  }
  return sum.normalized();
}

}  // namespace

std::optional<PlaneObservation> Observe(const Eigen::Vector3d& point_in_world,
                                        const Eigen::Vector3d& normal_in_world,
                                        const KeyframeImages& images,
                                        const Rigid3d& world_from_camera,
                                        const DepthCalibration& calibration,
                                        const RefinementOptions& options) {
  const Rigid3d camera_from_world = world_from_camera.Inverse();
  const Eigen::Vector3d point = camera_from_world * point_in_world;
  const std::optional<Pixel> pixel = PixelOf(point, calibration.camera);
  if (!pixel) return std::nullopt;
  const auto plane = MeasuredPlane(images, pixel->u, pixel->v, calibration, options.max_slant_rad);
  if (!plane) return std::nullopt;
  const Eigen::Vector3d normal = camera_from_world.rotation * normal_in_world;
  if (!(normal.dot(plane->normal) > std::cos(options.observation_angle_rad))) return std::nullopt;
  if (!(std::abs(normal.dot(plane->point - point)) < options.observation_distance_m))
    return std::nullopt;
  PlaneObservation observation;
  observation.u = static_cast<float>(pixel->u);
  observation.v = static_cast<float>(pixel->v);
  observation.inverse_depth = images.inverse_depth(pixel->u, pixel->v);
  observation.inverse_sigma = static_cast<float>(
      InversePlaneSigma(options.error_model, images.noise, observation.inverse_depth));
  return observation;
}

int CellSize(const DepthCalibration& calibration, const RefinementOptions& options) {
  return std::max(1, calibration.camera.width / options.cells_across);
}

SharedSurfels MakeSharedSurfels(const std::vector<RefinementKeyframe>& keyframes,
                                const DepthCalibration& calibration,
                                const RefinementOptions& options) {
  constexpr int kGrain = 256;
  const std::vector<Plane> planes = MakePlanes(keyframes, calibration, options);
  std::vector<std::vector<PlaneObservation>> seen(planes.size());
  std::vector<Eigen::Vector3d> normals(planes.size());
  ParallelFor(0, static_cast<int>(planes.size()), kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      seen[i] = ObserveAll(planes[i], keyframes, calibration, options);
      normals[i] = MeanNormal(seen[i], keyframes, calibration, options);
    }
  });
  SharedSurfels shared;
  for (const RefinementKeyframe& keyframe : keyframes) {
    shared.readouts.push_back(keyframe.images.readout);
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (static_cast<int>(seen[i].size()) < options.min_observations) continue;
    SharedSurfel surfel;
    surfel.point_in_world = planes[i].point;
    surfel.normal_in_world = normals[i];
    surfel.texture_radius_m = planes[i].texture_radius_m;
    surfel.begin = shared.observations.size();
    shared.observations.insert(shared.observations.end(), seen[i].begin(), seen[i].end());
    surfel.end = shared.observations.size();
    shared.surfels.push_back(surfel);
  }
  if (options.error_model.UsesIntensities()) {
    ObserveTextures(keyframes, calibration, options.error_model, &shared);
  }
  return shared;
}

}  // namespace surfit
