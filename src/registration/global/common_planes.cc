#include "registration/global/common_planes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surfit {
namespace {

bool IsOnAny(const std::vector<CommonPlane>& planes, const ComparedPoint& point,
             double tolerance_m) {
  return std::any_of(planes.begin(), planes.end(), [&](const CommonPlane& plane) {
    return std::abs(plane.DistanceTo(point.point)) < static_cast<float>(tolerance_m);
  });
}

}  // namespace

std::vector<CommonPlane> FindCommonPlanes(const std::vector<ComparedPoint>& points,
                                          double tolerance_m) {
  constexpr std::size_t kPlanes = 3, kCandidates = 100;
  const auto tolerance = static_cast<float>(tolerance_m);
  std::vector<ComparedPoint> rest;
  for (const ComparedPoint& point : points) {
    if (point.is_on_surface) rest.push_back(point);
  }
  std::vector<CommonPlane> planes;
  while (planes.size() < kPlanes && !rest.empty()) {
    const auto is_on = [&](const CommonPlane& plane, const ComparedPoint& point) {
      return std::abs(plane.DistanceTo(point.point)) < tolerance;
    };
    CommonPlane best;
    std::ptrdiff_t best_count = 0;
    const std::size_t step = std::max<std::size_t>(1, rest.size() / kCandidates);
    for (std::size_t i = 0; i < rest.size(); i += step) {
      const CommonPlane plane{rest[i].normal, rest[i].normal.dot(rest[i].point)};
      const auto count = std::count_if(rest.begin(), rest.end(), [&](const ComparedPoint& point) {
        return is_on(plane, point);
      });
      if (count <= best_count) continue;
      best = plane;
      best_count = count;
    }
    planes.push_back(best);
    rest.erase(std::remove_if(rest.begin(), rest.end(),
                              [&](const ComparedPoint& point) { return is_on(best, point); }),
               rest.end());
  }
  return planes;
}

int CountOffTwoPlanes(const std::vector<ComparedPoint>& points, double tolerance_m) {
  std::vector<CommonPlane> planes = FindCommonPlanes(points, tolerance_m);
  planes.resize(std::min<std::size_t>(planes.size(), 2));
  int count = 0;
  for (const ComparedPoint& point : points) {
    count += point.is_on_surface && !IsOnAny(planes, point, tolerance_m);
  }
  return count;
}

StructureCounts CountStructure(const std::vector<ComparedPoint>& points, const RangeImage& image,
                               double plane_tolerance_m, double range_tolerance_m) {
  const std::vector<CommonPlane> planes = FindCommonPlanes(points, plane_tolerance_m);
  StructureCounts counts;
  for (const ComparedPoint& point : points) {
    if (IsOnAny(planes, point, plane_tolerance_m)) continue;
    const RangeImage::Visibility visibility =
        image.VisibilityOf(point.point.cast<double>(), range_tolerance_m);
    counts.free_space += visibility == RangeImage::Visibility::kFreeSpace;
    counts.visible += visibility == RangeImage::Visibility::kFreeSpace ||
                      visibility == RangeImage::Visibility::kSurface;
  }
  return counts;
}

}  // namespace surfit
