#include "apps/export/gaussians.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/kd_tree.h"
#include "io/clouds/ply.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr std::size_t kNeighbors = 6;
constexpr float kMaxSpacing = 4;     // ratio of the radius, for surfels at the rim of the map
constexpr float kSigmaRatio = 0.6f;  // ratio of the distance to the last of these neighbours
constexpr float kMinSigma_m = 1e-5f;
constexpr float kHarmonic0 = 0.28209479177387814f;  // spherical harmonic of degree 0
constexpr int kRestCoefficients = 45;               // of degrees 1 to 3

std::vector<PlyProperty> GaussianProperties() {
  std::vector<PlyProperty> properties;
  const auto add = [&](const std::string& name) { properties.push_back({name}); };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) {
    add(name);
  }
  for (int i = 0; i < kRestCoefficients; ++i) add(Concat("f_rest_", i));
  for (const char* name :
       {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    add(name);
  }
  return properties;
}

}  // namespace

std::vector<Gaussian> GaussiansOf(const std::vector<Surfel>& surfels) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(surfels.size());
  for (const Surfel& surfel : surfels) points.push_back(surfel.position_in_world);
  const KdTree tree(points);
  std::vector<Gaussian> gaussians(surfels.size());
  constexpr int kChunk = 1024;
  ParallelFor(0, static_cast<int>(surfels.size()), kChunk, [&](int begin, int end) {
    std::vector<KdTree::Neighbor> neighbors;
    for (int i = begin; i < end; ++i) {
      const Surfel& surfel = surfels[i];
      tree.FindNearest(points[i], kNeighbors + 1, &neighbors);
      const float spacing_m = std::sqrt(neighbors.back().squared_distance);
      const float sigma_m = kSigmaRatio * std::min(spacing_m, kMaxSpacing * surfel.radius_m);
      gaussians[i] = {points[i], surfel.normal_in_world, std::max(kMinSigma_m, sigma_m),
                      Eigen::Vector3f(surfel.color.r, surfel.color.g, surfel.color.b) / 255.f};
    }
  });
  return gaussians;
}

void WriteGaussians(const std::vector<Gaussian>& gaussians, const Rigid3d& export_from_world,
                    const std::string& path) {
  const Rigid3f transform = export_from_world.cast<float>();
  const float opacity = std::log(kGaussianOpacity / (1 - kGaussianOpacity));
  WritePlyVertices(path, gaussians.size(), GaussianProperties(), [&](std::size_t i, PlyRow* row) {
    const Gaussian& gaussian = gaussians[i];
    const Eigen::Vector3f position =
        (export_from_world * gaussian.position_m.cast<double>()).cast<float>();
    const Eigen::Vector3f normal = transform.rotation * gaussian.normal;
    for (const float number : position) row->Put(number);
    for (const float number : normal) row->Put(number);
    for (const float channel : gaussian.color) row->Put((channel - 0.5f) / kHarmonic0);
    for (int k = 0; k < kRestCoefficients; ++k) row->Put(0.f);
    row->Put(opacity);
    row->Put(std::log(gaussian.sigma_m));
    row->Put(std::log(gaussian.sigma_m));
    row->Put(std::log(kFlatness * gaussian.sigma_m));
    const auto rotation = Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), normal);
    row->Put(rotation.w());
    row->Put(rotation.x());
    row->Put(rotation.y());
    row->Put(rotation.z());
  });
}

}  // namespace surfit
