#include "optimization/refinement/shared_surfels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "optimization/refinement/joint_state.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Maximum distance of a measured point from the surfel plane.
constexpr double kMaxPlaneDistance_m = 0.05;

struct Plane {
  Eigen::Vector3d point, normal;
  double texture_radius_m = 0;
};

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

class PosedKeyframe {
 public:
  PosedKeyframe(const RefinementKeyframe& keyframe, const DepthCalibration& calibration,
                const RefinementOptions& options)
      : images_(keyframe.images),
        camera_from_world_(keyframe.world_from_camera.Inverse()),
        calibration_(calibration),
        options_(options),
        least_cosine_of_slant_(std::cos(options.max_slant_rad)),
        least_cosine_of_normals_(std::cos(options.observation_angle_rad)) {}

  // Returns the plane of a pixel in the camera frame. std::nullopt without a measurement, or if the
  // slant exceeds `max_slant_rad`. The normal follows from r = 1/z = n . ray / d with d < 0:
  //   n ~ -(fx r_u, fy r_v, r - (u - cx) r_u - (v - cy) r_v).
  std::optional<Plane> PlaneAt(int u, int v) const {
    const float measured = images_.inverse_depth(u, v);
    const double slope_u = images_.slope_u(u, v), slope_v = images_.slope_v(u, v);
    if (!(measured > 0) || std::isnan(slope_u)) return std::nullopt;
    const PinholeCamera& camera = calibration_.camera;
    const Eigen::Vector3d ray = camera.Ray(u, v);
    const double inverse_depth = measured + calibration_.field.At(ray.x(), ray.y());
    if (!(inverse_depth > 0)) return std::nullopt;
    const Eigen::Vector3d normal =
        -Eigen::Vector3d(camera.fx * slope_u, camera.fy * slope_v,
                         inverse_depth - (u - camera.cx) * slope_u - (v - camera.cy) * slope_v)
             .normalized();
    if (!(-normal.dot(ray) > least_cosine_of_slant_ * ray.norm())) return std::nullopt;
    return Plane{ray / inverse_depth, normal};
  }

  // Returns std::nullopt if the plane is outside the image, or if the angle or distance is too
  // large.
  std::optional<PlaneObservation> Observe(const Plane& in_world) const {
    const Eigen::Vector3d point = camera_from_world_ * in_world.point;
    const std::optional<Pixel> pixel = PixelOf(point, calibration_.camera);
    if (!pixel) return std::nullopt;
    const auto plane = PlaneAt(pixel->u, pixel->v);
    if (!plane) return std::nullopt;
    const Eigen::Vector3d normal = camera_from_world_.rotation * in_world.normal;
    if (!(normal.dot(plane->normal) > least_cosine_of_normals_)) return std::nullopt;
    if (!(std::abs(normal.dot(plane->point - point)) < kMaxPlaneDistance_m)) {
      return std::nullopt;
    }
    PlaneObservation observation;
    observation.u = static_cast<float>(pixel->u);
    observation.v = static_cast<float>(pixel->v);
    observation.inverse_depth = images_.inverse_depth(pixel->u, pixel->v);
    observation.inverse_sigma = static_cast<float>(
        InversePlaneSigma(options_.error_model, images_.noise, observation.inverse_depth));
    return observation;
  }

 private:
  const KeyframeImages& images_;
  const Rigid3d camera_from_world_;
  const DepthCalibration& calibration_;
  const RefinementOptions& options_;
  const double least_cosine_of_slant_, least_cosine_of_normals_;
};

class Cells {
 public:
  Cells(const PinholeCamera& camera, int size_px)
      : size_px_(size_px),
        taken_((camera.width + size_px - 1) / size_px, (camera.height + size_px - 1) / size_px) {}

  void Take(float u, float v) {
    taken_(static_cast<int>(u) / size_px_, static_cast<int>(v) / size_px_) = 1;
  }
  // Centre pixels of all free cells within the image, by rows.
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

struct SeenPlane {
  Plane plane;
  std::vector<PlaneObservation> observations;
};

void ObserveBy(const PosedKeyframe& view, int keyframe, SeenPlane* seen) {
  auto observation = view.Observe(seen->plane);
  if (!observation) return;
  observation->keyframe = keyframe;
  seen->observations.push_back(*observation);
}

std::vector<SeenPlane> MakePlanes(const std::vector<RefinementKeyframe>& keyframes,
                                  const std::vector<PosedKeyframe>& views,
                                  const DepthCalibration& calibration,
                                  const RefinementOptions& options) {
  constexpr int kGrain = 256;
  std::vector<SeenPlane> planes;
  for (int k = 0; k < static_cast<int>(views.size()); ++k) {
    ParallelFor(0, static_cast<int>(planes.size()), kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) ObserveBy(views[k], k, &planes[i]);
    });
    Cells cells(calibration.camera, CellSize(calibration, options));
    for (const SeenPlane& seen : planes) {
      if (seen.observations.empty() || seen.observations.back().keyframe != k) continue;
      cells.Take(seen.observations.back().u, seen.observations.back().v);
    }
    const std::vector<Pixel> free = cells.FreeMiddles(calibration.camera);
    std::vector<SeenPlane> added(free.size());
    ParallelFor(0, static_cast<int>(free.size()), kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const auto plane = views[k].PlaneAt(free[i].u, free[i].v);
        if (!plane) continue;
        const Rigid3d& pose = keyframes[k].world_from_camera;
        const double radius_m = kTextureRadiusPx * plane->point.z() / calibration.camera.fx;
        added[i].plane = {pose * plane->point, pose.rotation * plane->normal, radius_m};
        for (int j = 0; j <= k; ++j) ObserveBy(views[j], j, &added[i]);
      }
    });
    for (SeenPlane& plane : added) {
      if (plane.plane.texture_radius_m > 0) planes.push_back(std::move(plane));
    }
  }
  return planes;
}

// The noise of a single normal would rotate the plane about the surfel centre, and displace it
// at the observations of other keyframes.
Eigen::Vector3d MeanNormal(const std::vector<PlaneObservation>& observations,
                           const std::vector<RefinementKeyframe>& keyframes,
                           const std::vector<PosedKeyframe>& views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PlaneObservation& o : observations) {
    const auto plane = views[o.keyframe].PlaneAt(static_cast<int>(o.u), static_cast<int>(o.v));
    sum += keyframes[o.keyframe].world_from_camera.rotation * plane->normal;
  }
  return sum.normalized();
}

}  // namespace

int CellSize(const DepthCalibration& calibration, const RefinementOptions& options) {
  return std::max(1, calibration.camera.width / options.cells_across);
}

SharedSurfels MakeSharedSurfels(const std::vector<RefinementKeyframe>& keyframes,
                                const DepthCalibration& calibration,
                                const RefinementOptions& options) {
  constexpr int kGrain = 256;
  std::vector<PosedKeyframe> views;
  views.reserve(keyframes.size());
  for (const RefinementKeyframe& keyframe : keyframes) {
    views.emplace_back(keyframe, calibration, options);
  }
  std::vector<SeenPlane> planes = MakePlanes(keyframes, views, calibration, options);
  constexpr std::size_t kMinObservations = 3;
  const auto is_seen_by_few = [](const SeenPlane& seen) {
    return seen.observations.size() < kMinObservations;
  };
  planes.erase(std::remove_if(planes.begin(), planes.end(), is_seen_by_few), planes.end());
  std::vector<Eigen::Vector3d> normals(planes.size());
  ParallelFor(0, static_cast<int>(planes.size()), kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      normals[i] = MeanNormal(planes[i].observations, keyframes, views);
    }
  });
  SharedSurfels shared;
  for (const RefinementKeyframe& keyframe : keyframes) {
    shared.readouts.push_back(keyframe.images.readout);
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto& [plane, observations] = planes[i];
    SharedSurfel surfel;
    surfel.point_in_world = plane.point;
    surfel.normal_in_world = normals[i];
    surfel.texture_radius_m = plane.texture_radius_m;
    surfel.begin = shared.observations.size();
    shared.observations.insert(shared.observations.end(), observations.begin(), observations.end());
    surfel.end = shared.observations.size();
    shared.surfels.push_back(surfel);
  }
  if (options.error_model.UsesIntensities()) {
    ObserveTextures(keyframes, calibration, options.error_model, &shared);
  }
  return shared;
}

}  // namespace surfit
