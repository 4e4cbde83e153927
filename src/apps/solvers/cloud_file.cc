#include "apps/solvers/cloud_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "surfit/core/error.h"

namespace surfit {
namespace {

void KeepFinitePoints(const std::string& what, PointCloud* cloud, RegisteredCloud* about) {
  about->not_finite = RemoveNonFinite(cloud);
  about->points = cloud->points.size();
  if (cloud->points.empty()) throw InputError(Concat(what, ": contains no finite points"));
  if (cloud->points.size() > std::size_t{1} << 30) {
    throw InputError(
        Concat(what, ": contains ", cloud->points.size(), " points, must be at most 2^30"));
  }
}

// Scales normals to unit length. Zero and non-finite normals become (0, 0, 0).
void Normalize(std::vector<Eigen::Vector3f>* normals) {
  for (Eigen::Vector3f& normal : *normals) {
    const float length = normal.norm();
    if (std::isfinite(length) && length > 0) {
      normal /= length;
    } else {
      normal.setZero();
    }
  }
}

// True if all normals are zero, or if all other normals are equal although the points are in no
// plane. Some programs write a constant instead of normals.
bool AreUnset(const std::vector<Eigen::Vector3f>& normals,
              const std::vector<Eigen::Vector3f>& points) {
  constexpr double kMaxThickness = 0.01;  // of a plane, relative to the size of the cloud
  const auto is_set = [](const Eigen::Vector3f& normal) { return !normal.isZero(0); };
  const auto first = std::find_if(normals.begin(), normals.end(), is_set);
  if (first == normals.end()) return true;
  if (std::any_of(first, normals.end(), [&](const Eigen::Vector3f& normal) {
        return is_set(normal) && normal != *first;
      })) {
    return false;
  }
  Eigen::AlignedBox3f box;
  Eigen::AlignedBox1f along;
  for (const Eigen::Vector3f& point : points) {
    box.extend(point);
    along.extend(Eigen::Matrix<float, 1, 1>(first->dot(point)));
  }
  return along.sizes()[0] > kMaxThickness * box.sizes().norm();
}

// Index of the first equal point, for each point.
std::vector<std::uint32_t> FirstEquals(const std::vector<Eigen::Vector3f>& points) {
  std::vector<std::uint32_t> sorted(points.size());
  std::iota(sorted.begin(), sorted.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    return std::make_tuple(points[i].x(), points[i].y(), points[i].z());
  };
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(key(a), a) < std::make_pair(key(b), b);
  });
  std::vector<std::uint32_t> firsts(points.size());
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    const bool is_equal = k > 0 && key(sorted[k]) == key(sorted[k - 1]);
    firsts[sorted[k]] = is_equal ? firsts[sorted[k - 1]] : sorted[k];
  }
  return firsts;
}

// Estimates normals if the cloud has none.
PointSet MakePointSet(const CloudSensor& sensor, const CloudNormalOptions& normals,
                      double floor_sigma_m, PointCloud* cloud, RegisteredCloud* about) {
  const std::vector<std::uint32_t> firsts = FirstEquals(cloud->points);
  std::vector<std::uint32_t> used;                  // points that are equal to no earlier point
  std::vector<std::uint32_t> place(firsts.size());  // position of the first equal point in `used`
  for (std::uint32_t i = 0; i < firsts.size(); ++i) {
    if (firsts[i] == i) used.push_back(i);
  }
  for (std::uint32_t k = 0; k < used.size(); ++k) place[used[k]] = k;
  about->duplicates = firsts.size() - used.size();
  PointSet set;
  for (const std::uint32_t i : used) set.points.push_back(cloud->points[i]);
  set.sigma_m.assign(set.size(), static_cast<float>(floor_sigma_m));
  Normalize(&cloud->normals);
  if (AreUnset(cloud->normals, cloud->points)) {
    CloudSensor local = sensor;
    local.viewpoint -= cloud->origin;
    const CloudNormals estimated = EstimateCloudNormals(set.points, local, normals);
    about->normal_radius_m = estimated.radius_m;
    set.normals = estimated.normals;
    for (std::size_t k = 0; k < set.size(); ++k) {
      set.sigma_m[k] = std::hypot(set.sigma_m[k], estimated.deviation_m[k]);
    }
    cloud->normals.resize(cloud->points.size());
    for (std::size_t i = 0; i < firsts.size(); ++i) {
      cloud->normals[i] = set.normals[place[firsts[i]]];
    }
  } else {
    for (const std::uint32_t i : used) set.normals.push_back(cloud->normals[i]);
  }
  about->without_normal = std::count_if(set.normals.begin(), set.normals.end(),
                                        [](const auto& normal) { return normal.isZero(0); });
  return set;
}

}  // namespace

PreparedCloud PrepareCloud(PointCloud cloud, const std::string& what, const CloudSensor& sensor,
                           const CloudNormalOptions& normals, double floor_sigma_m) {
  PreparedCloud prepared;
  prepared.cloud = std::move(cloud);
  KeepFinitePoints(what, &prepared.cloud, &prepared.about);
  prepared.points = MakePointSet(sensor, normals, floor_sigma_m, &prepared.cloud, &prepared.about);
  prepared.has_signed_normals = prepared.about.normal_radius_m == 0;
  return prepared;
}

PreparedCloud ReadCloudFile(const std::string& path, const CloudSensor& sensor,
                            const CloudNormalOptions& normals, double floor_sigma_m) {
  return PrepareCloud(ReadPointCloudAboutOrigin(path), path, sensor, normals, floor_sigma_m);
}

}  // namespace surfit
