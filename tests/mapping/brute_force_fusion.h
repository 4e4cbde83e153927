#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "mapping/fusion/measured_points.h"
#include "mapping/plane_frame.h"
#include "mapping/rendering/frame_colors.h"
#include "surfit/mapping/fusion.h"

namespace surfit::testing {

// Reference implementation of the fusion of one frame: double precision, all pairs of points and
// surfels, no projection tables, no dormancy. `margin` is the distance of the closest decision to
// its limit. Above the rounding of single precision, both implementations decide alike.
class BruteForceFusion {
 public:
  BruteForceFusion(const FrameWithSurface& f, const Rigid3d& world_from_camera,
                   const FusionOptions& options)
      : f_(f),
        width_(f.surface.camera.width),
        height_(f.surface.camera.height),
        world_from_camera_(world_from_camera),
        options_(options),
        weights_(PointWeights(f.surface.camera)),
        normal_(f.surface.normal) {
    for (int pixel = 0; pixel < width_ * height_; ++pixel) {
      if (AtEdge(pixel)) SetNormal(pixel, NormalOfNeighbour(pixel));
    }
  }

  FusionReport Fuse(SurfelMap* map) {
    const int pixels = width_ * height_, count = map->id_end();
    std::vector<std::uint8_t> remove(count, 0);
    std::vector<int> pixel_of(count, -1), own(pixels, -1), chosen(pixels, -1);
    for (const int i : map->Ids()) {
      pixel_of[i] = PixelOf(CameraPosition((*map)[i]));
      remove[i] = pixel_of[i] >= 0 && SeenThrough(CameraPosition((*map)[i]).z(), pixel_of[i]);
    }
    const SurfelMap before = *map;
    for (int pixel = 0; pixel < pixels; ++pixel) {
      own[pixel] =
          Nearest(before, pixel, [&](int i) { return pixel_of[i] == pixel && !remove[i]; });
    }
    for (int pixel = 0; pixel < pixels; ++pixel) {
      chosen[pixel] = Nearest(before, pixel, [&](int i) {
        return pixel_of[i] >= 0 && own[pixel_of[i]] == i && AreNeighbours(pixel, pixel_of[i]);
      });
    }
    const std::vector<std::uint8_t> seen_through = remove;
    for (const int i : map->Ids()) {
      if (pixel_of[i] < 0 || seen_through[i] || !SquaredDistance(before[i], pixel_of[i])) continue;
      for (int q = 0; q < pixels; ++q) {
        if (own[q] < 0 || own[q] == i || !AreNeighbours(pixel_of[i], q)) continue;
        // In its own pixel, or in a neighbour pixel if it is the nearest surfel of its pixel.
        if (q != pixel_of[i] && own[pixel_of[i]] != i) continue;
        if (!AreDoubles(before[i], before[own[q]])) continue;
        const bool worse = before[i].confidence < before[own[q]].confidence;
        if (worse) remove[i] = true;
        if (!worse && q == pixel_of[i]) remove[own[q]] = true;
      }
    }
    return Apply(remove, chosen, map);
  }

  double margin() const { return margin_; }

 private:
  // Records the distance of the value to zero, which is the limit.
  bool Positive(double value) {
    margin_ = std::min(margin_, std::fabs(value));
    return value > 0;
  }

  Eigen::Vector3d CameraPosition(const Surfel& s) const {
    return world_from_camera_.Inverse() * s.position_in_world.cast<double>();
  }

  int PixelOf(const Eigen::Vector3d& p) {
    if (!Positive(p.z() - 0.05)) return -1;
    const PinholeCamera& camera = f_.surface.camera;
    const Eigen::Vector2d at = camera.Project(p) + Eigen::Vector2d(0.5, 0.5);
    for (const double x : {at.x(), at.y()}) Positive((x - std::round(x)) / camera.fx);
    const int u = static_cast<int>(std::floor(at.x())), v = static_cast<int>(std::floor(at.y()));
    return u >= 0 && v >= 0 && u < width_ && v < height_ ? v * width_ + u : -1;
  }

  bool SeenThrough(double z, int pixel) {
    const int u = pixel % width_, v = pixel / width_;
    bool through = true;
    for (int qv = std::max(0, v - 1); qv < std::min(height_, v + 2); ++qv) {
      for (int qu = std::max(0, u - 1); qu < std::min(width_, u + 2); ++qu) {
        const double d = f_.frame.depth_m(qu, qv);
        const double margin = options_.free_space_margin_m + 4 * f_.surface.noise.SigmaZ(d);
        if (d == 0 || !Positive(d - margin - z)) through = false;
      }
    }
    return through;
  }

  Eigen::Vector3d Vertex(int pixel) const {
    return f_.surface.vertex(pixel % width_, pixel / width_).cast<double>();
  }
  Eigen::Vector3d Normal(int pixel) const {
    return normal_(pixel % width_, pixel / width_).cast<double>();
  }
  void SetNormal(int pixel, const Eigen::Vector3d& n) {
    normal_.Set(pixel % width_, pixel / width_, n.cast<float>());
  }

  bool HasOwnNormal(int pixel) const {
    return !f_.surface.normal(pixel % width_, pixel / width_).isZero(0);
  }
  bool AtEdge(int pixel) const { return Vertex(pixel).z() > 0 && !HasOwnNormal(pixel); }

  // Normal of the neighbour with the nearest plane, within half a sigma.
  Eigen::Vector3d NormalOfNeighbour(int pixel) {
    const Eigen::Vector3d p = Vertex(pixel);
    double nearest = f_.surface.noise.SigmaZ(p.z()) / 2;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int q = 0; q < width_ * height_; ++q) {
      if (!AreNeighbours(pixel, q) || !HasOwnNormal(q)) continue;
      const double distance = std::fabs(Normal(q).dot(p - Vertex(q)));
      if (!Positive(nearest - distance) || !Positive(-Normal(q).dot(p))) continue;
      nearest = distance;
      normal = Normal(q);
    }
    return normal;
  }

  bool IsPoint(int pixel) const { return Vertex(pixel).z() > 0 && !Normal(pixel).isZero(0); }

  double Radius(int pixel) const {
    const double slant = 1 / std::fabs(Normal(pixel).z());
    return std::sqrt(2) * Vertex(pixel).z() / f_.surface.camera.fx *
           std::min(slant, 1. * options_.max_slant_scale);
  }

  // Squared distance, if point and surfel belong to the same surface.
  std::optional<double> SquaredDistance(const Surfel& s, int pixel) {
    const Eigen::Vector3d n =
        world_from_camera_.rotation.conjugate() * s.normal_in_world.cast<double>();
    const Eigen::Vector3d gap = Vertex(pixel) - CameraPosition(s);
    const double along = n.dot(gap);
    const double across = (gap - along / n.dot(Vertex(pixel)) * Vertex(pixel)).norm();
    const double reach = std::min(Radius(pixel), 1. * options_.max_spacing_m);
    const double angle = std::acos(std::min(1., n.dot(Normal(pixel))));
    const bool near = Positive(options_.merge_distance_m - std::fabs(along));
    const bool above = Positive(reach - across);
    const bool parallel = Positive(options_.merge_angle_rad - angle);
    if (!near || !above || !parallel) return std::nullopt;
    return along * along + across * across;
  }

  // True if the surfels overlap across the surface, along the normal of b.
  bool AreDoubles(const Surfel& a, const Surfel& b) {
    const Eigen::Vector3d gap = (a.position_in_world - b.position_in_world).cast<double>();
    const Eigen::Vector3d n = b.normal_in_world.cast<double>();
    const double along = n.dot(gap), across = (gap - along * n).norm();
    const double reach =
        options_.duplicate_ratio * std::min({a.radius_m, b.radius_m, options_.max_spacing_m});
    const double angle = std::acos(std::min(1., n.dot(a.normal_in_world.cast<double>())));
    const bool near = Positive(options_.merge_distance_m - std::fabs(along));
    const bool above = Positive(reach - across);
    return Positive(options_.merge_angle_rad - angle) && near && above;
  }

  template <typename MayTake>
  int Nearest(const SurfelMap& map, int pixel, const MayTake& may_take) {
    if (!IsPoint(pixel)) return -1;
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (const int i : map.Ids()) {
      if (!may_take(i)) continue;
      const auto distance2 = SquaredDistance(map[i], pixel);
      if (!distance2) continue;
      if (Positive(std::sqrt(least) - std::sqrt(*distance2))) {
        nearest = i;
        least = *distance2;
      }
    }
    return nearest;
  }

  bool AreNeighbours(int a, int b) const {
    return std::abs(a % width_ - b % width_) <= 1 && std::abs(a / width_ - b / width_) <= 1;
  }

  // Pixels with even rows and columns come first, then pixels with odd rows and columns.
  std::vector<int> NewPixels(const std::vector<int>& chosen) {
    std::vector<int> taken;
    for (const auto& [odd_v, odd_u] :
         {std::pair(0, 0), std::pair(1, 1), std::pair(0, 1), std::pair(1, 0)}) {
      for (int pixel = 0; pixel < width_ * height_; ++pixel) {
        if (pixel % width_ % 2 != odd_u || pixel / width_ % 2 != odd_v) continue;
        if (!IsPoint(pixel) || chosen[pixel] >= 0) continue;
        bool covered = false;
        for (const int q : taken) {
          if (AreNeighbours(pixel, q) && SquaredDistance(NewSurfel(q), pixel)) covered = true;
        }
        if (!covered) taken.push_back(pixel);
      }
    }
    std::sort(taken.begin(), taken.end());
    return taken;
  }

  // Bilinear interpolation at the projection, for a frame with one capture time.
  SeenColor ColorAt(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
    const PinholeCamera& camera = f_.surface.camera;
    const Eigen::Vector2d at = camera.Project(point);
    if (at.x() <= -0.5 || at.y() <= -0.5 || at.x() >= width_ - 0.5 || at.y() >= height_ - 0.5) {
      return {};
    }
    const double u = std::clamp(at.x(), 0., width_ - 1.), v = std::clamp(at.y(), 0., height_ - 1.);
    Eigen::Vector3d color = Eigen::Vector3d::Zero();
    for (int q = 0; q < width_ * height_; ++q) {
      const double share =
          std::max(0., 1 - std::fabs(u - q % width_)) * std::max(0., 1 - std::fabs(v - q / width_));
      const Rgb8 c = f_.frame.color[q];
      color += share * Eigen::Vector3d(c.r, c.g, c.b);
    }
    const double fineness = camera.fx / point.z() / 500;
    const double cosine = std::fabs(normal.dot(point.normalized()));
    return {color.cast<float>(), static_cast<float>(fineness * fineness * cosine)};
  }

  Surfel NewSurfel(int pixel) const {
    const SeenColor seen = ColorAt(Vertex(pixel), Normal(pixel));
    return {(world_from_camera_ * Vertex(pixel)).cast<float>(),
            (world_from_camera_.rotation * Normal(pixel)).cast<float>(),
            ToRgb8(seen.color),
            static_cast<float>(Radius(pixel)),
            weights_[pixel],
            f_.frame.index,
            f_.frame.index,
            AtEdge(pixel),
            seen.weight};
  }

  SurfelObservation Average(const std::vector<int>& pixels, const Surfel& surfel) {
    const float surfel_radius_m = surfel.radius_m;
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), normal = position;
    SurfelObservation seen;
    const Rigid3d camera_from_world = world_from_camera_.Inverse();
    const SeenColor color =
        ColorAt(camera_from_world * surfel.position_in_world.cast<double>(),
                camera_from_world.rotation * surfel.normal_in_world.cast<double>());
    seen.color = color.color;
    seen.color_weight = color.weight;
    seen.weight = seen.shape_weight = 0;
    seen.radius_m = surfel_radius_m * FusionOptions::kMaxRadiusRatio;
    seen.at_edge = true;
    for (const int pixel : pixels) {
      seen.at_edge &= AtEdge(pixel);
      const double weight = weights_[pixel];
      seen.weight += weights_[pixel];
      const bool fine = Positive(FusionOptions::kMaxRadiusRatio * surfel_radius_m - Radius(pixel));
      if (!fine || AtEdge(pixel)) continue;
      seen.shape_weight += weights_[pixel];
      position += weight * (world_from_camera_ * Vertex(pixel));
      normal += weight * (world_from_camera_.rotation * Normal(pixel));
      seen.radius_m = std::min(seen.radius_m, static_cast<float>(Radius(pixel)));
    }
    seen.position_in_world = (position / seen.shape_weight).cast<float>();
    seen.normal_in_world = (normal / seen.shape_weight).cast<float>();
    return seen;
  }

  FusionReport Apply(const std::vector<std::uint8_t>& remove, const std::vector<int>& chosen,
                     SurfelMap* map) {
    FusionReport report;
    std::vector<std::vector<int>> pixels_of(map->id_end());
    for (int pixel = 0; pixel < width_ * height_; ++pixel) {
      report.input_points += IsPoint(pixel);
      if (chosen[pixel] < 0) continue;
      ++report.merged_points;
      pixels_of[chosen[pixel]].push_back(pixel);
    }
    for (const int i : map->Ids()) {
      if (pixels_of[i].empty()) continue;
      ++report.merged;
      map->Merge(i, Average(pixels_of[i], (*map)[i]), FusionOptions::kMaxConfidence);
      map->block(i / SurfelBlock::kCapacity)
          .SetLastSeen(i % SurfelBlock::kCapacity, f_.frame.index);
    }
    for (const int i : map->Ids()) {
      if (remove[i]) map->Mark(i);
    }
    report.removed = static_cast<int>(map->RemoveMarked());
    for (const int pixel : NewPixels(chosen)) {
      map->Append(NewSurfel(pixel));
      ++report.added;
    }
    report.covered_points = report.input_points - report.merged_points - report.added;
    return report;
  }

  const FrameWithSurface& f_;
  const int width_, height_;
  const Rigid3d world_from_camera_;
  const FusionOptions options_;
  const Image<float> weights_;
  VectorImage normal_;  // normals of the frame, and normals from neighbours
  double margin_ = std::numeric_limits<double>::infinity();
};

}  // namespace surfit::testing
