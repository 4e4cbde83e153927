#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "mesh/mesh_steps.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kCubesPerTask = 16;
constexpr int kFewest = 6;
constexpr float kFacingSameWay = 0.5f;
constexpr double kFlat = 4;         // minimum ratio of middle to smallest variance
constexpr float kMinSigma = 5e-4f;  // m; correlated error, added in quadrature
constexpr float kMaxSpacings = 8;   // maximum neighbourhood radius, in spacings
constexpr float kFewestSpacings = 2.5f;
constexpr float kPlaneSpacings = 4;

struct Plane {
  Eigen::Vector3f point, normal;
  float rms_m = 0;  // RMS distance of the surfels along the normal
};

class PlaneSum {
 public:
  void Add(float weight, const Eigen::Vector3f& offset, const Eigen::Vector3f& normal) {
    ++count_;
    weight_ += weight;
    normal_ += weight * normal;
    first_ += weight * offset;
    const Eigen::Vector3f weighted = weight * offset;
    second_[0] += weighted.x() * offset.x();
    second_[1] += weighted.x() * offset.y();
    second_[2] += weighted.x() * offset.z();
    second_[3] += weighted.y() * offset.y();
    second_[4] += weighted.y() * offset.z();
    second_[5] += weighted.z() * offset.z();
  }

  // Fits a plane to the added surfels. Returns false for fewer than kFewest surfels. If the surfels
  // are not planar or lie on a line, the plane has their mean normal.
  bool Fit(const MeshSurfel& surfel, Plane* plane) const {
    if (count_ < kFewest) return false;
    const Eigen::Vector3f mean = first_ / weight_;
    Eigen::Matrix3f covariance;
    covariance << second_[0], second_[1], second_[2], second_[1], second_[3], second_[4],
        second_[2], second_[4], second_[5];
    covariance = covariance / weight_ - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(covariance.cast<double>());
    const Eigen::Vector3d variances = solver.eigenvalues();
    plane->normal = solver.eigenvectors().col(0).cast<float>();
    if (plane->normal.dot(normal_) < 0) plane->normal = -plane->normal;
    const bool is_flat = variances[1] > kFlat * variances[0] && variances[1] > variances[2] / 20;
    if (!is_flat || plane->normal.dot(normal_) < kFacingSameWay * normal_.norm())
      plane->normal = normal_.normalized();
    plane->point = surfel.position + mean;
    plane->rms_m = std::sqrt(std::max(0.f, plane->normal.dot(covariance * plane->normal)));
    return true;
  }

 private:
  int count_ = 0;
  float weight_ = 0;
  Eigen::Vector3f first_ = Eigen::Vector3f::Zero(), normal_ = Eigen::Vector3f::Zero();
  std::array<float, 6> second_ = {};
};

class PlaneFitter {
 public:
  explicit PlaneFitter(const SurfelCubes& cubes) : cubes_(cubes) {}

  void Enter(int cube, float reach_m) {
    const Eigen::Vector3f low = cubes_.CubeOf(cube).cast<float>() * cubes_.cube_m();
    const Eigen::Vector3f margin = Eigen::Vector3f::Constant(reach_m);
    cubes_.FindWithin(low - margin, low + margin + Eigen::Vector3f::Constant(cubes_.cube_m()),
                      &ranges_);
  }

  // Fits a plane to the surfels within `reach_m` of `surfel` that have similar normals. Surfels are
  // excluded if their distance along the normal exceeds `gates` times the sum of both standard
  // deviations.
  bool Fit(const MeshSurfel& surfel, float reach_m, float gates, Plane* plane) const {
    PlaneSum sum;
    const float squared_reach = reach_m * reach_m, per_square = 1 / squared_reach;
    for (const SurfelCubes::Range& range : ranges_) {
      for (std::uint32_t j = range.begin; j < range.end; ++j) {
        const MeshSurfel& other = cubes_.surfels()[j];
        const Eigen::Vector3f offset = other.position - surfel.position;
        const float square = offset.squaredNorm();
        if (square >= squared_reach) continue;
        const float cosine = surfel.normal.dot(other.normal);
        if (cosine < kFacingSameWay) continue;
        // The term 0.25 * distance allows a normal error of 0.25 rad.
        const float height = std::abs(surfel.normal.dot(offset));
        if (height > gates * (surfel.sigma_m + other.sigma_m) + 0.25f * std::sqrt(square)) continue;
        const float share = 1 - square * per_square;
        sum.Add(share * share * cosine / (other.sigma_m * other.sigma_m), offset, other.normal);
      }
    }
    return sum.Fit(surfel, plane);
  }

 private:
  const SurfelCubes& cubes_;
  std::vector<SurfelCubes::Range> ranges_;
};

float MedianSpacing(const std::vector<MeshSurfel>& surfels) {
  std::vector<float> spacings;
  spacings.reserve(surfels.size());
  for (const MeshSurfel& surfel : surfels) spacings.push_back(surfel.spacing_m);
  return MedianOf(std::move(spacings));
}

}  // namespace

void FindSigmas(std::vector<MeshSurfel>* surfels) {
  constexpr float kAllHeights = 1e6f;
  constexpr float kMaxTimes = 4;  // maximum ratio of measured to scaled standard deviation
  const SurfelCubes cubes(*surfels, kPlaneSpacings * MedianSpacing(*surfels));
  std::vector<float> shown_m(surfels->size(), -1.f);  // RMS plane distance per surfel; -1: no plane
  ParallelFor(0, cubes.cube_count(), kCubesPerTask, [&](int begin, int end) {
    PlaneFitter fitter(cubes);
    for (int c = begin; c < end; ++c) {
      const SurfelCubes::Range range = cubes.SurfelsOf(c);
      fitter.Enter(c, 2 * cubes.cube_m());
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const MeshSurfel& surfel = cubes.surfels()[i];
        const float reach_m = std::min(kPlaneSpacings * surfel.spacing_m, 2 * cubes.cube_m());
        Plane plane;
        if (fitter.Fit(surfel, reach_m, kAllHeights, &plane))
          shown_m[cubes.order()[i]] = plane.rms_m;
      }
    }
  });
  std::vector<float> ratios;
  for (std::size_t i = 0; i < shown_m.size(); ++i)
    if (shown_m[i] >= 0) ratios.push_back(shown_m[i] / (*surfels)[i].sigma_m);
  const float scale = ratios.empty() ? 1.f : MedianOf(std::move(ratios));
  for (std::size_t i = 0; i < shown_m.size(); ++i) {
    float& sigma_m = (*surfels)[i].sigma_m;
    sigma_m *= scale;
    sigma_m = std::hypot(kMinSigma, std::clamp(shown_m[i], sigma_m, kMaxTimes * sigma_m));
  }
}

void SmoothSurfels(double normal_noise_rad, const std::function<void(double)>& done,
                   std::vector<MeshSurfel>* surfels) {
  constexpr float kGates = 3;  // association gate in standard deviations
  // A plane within the radius `reach` has n = pi reach^2 / spacing^2 surfels. The standard
  // deviation of its slope is 2 sigma / (reach sqrt(n)) = 2 sigma spacing / (sqrt(pi) reach^2).
  const auto factor = static_cast<float>(2 * 1.7 / (std::sqrt(M_PI) * normal_noise_rad));
  const float most_m = kMaxSpacings * MedianSpacing(*surfels);
  const auto reach_of = [&](const MeshSurfel& surfel) {
    const float wanted = std::sqrt(factor * surfel.sigma_m * surfel.spacing_m);
    return std::min(2 * most_m, std::clamp(wanted, kFewestSpacings * surfel.spacing_m,
                                           kMaxSpacings * surfel.spacing_m));
  };
  const SurfelCubes cubes(*surfels, most_m / 2);
  ParallelFor(0, cubes.cube_count(), kCubesPerTask, [&](int begin, int end) {
    PlaneFitter fitter(cubes);
    for (int c = begin; c < end; ++c) {
      const SurfelCubes::Range range = cubes.SurfelsOf(c);
      float farthest = 0;
      for (std::uint32_t i = range.begin; i < range.end; ++i)
        farthest = std::max(farthest, reach_of(cubes.surfels()[i]));
      fitter.Enter(c, farthest);
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const MeshSurfel& surfel = cubes.surfels()[i];
        Plane plane;
        if (!fitter.Fit(surfel, reach_of(surfel), kGates, &plane)) continue;
        MeshSurfel& smoothed = (*surfels)[cubes.order()[i]];
        smoothed.normal = plane.normal;
        smoothed.position += plane.normal.dot(plane.point - surfel.position) * plane.normal;
      }
    }
    done(static_cast<double>(cubes.SurfelsOf(end - 1).end - cubes.SurfelsOf(begin).begin) /
         static_cast<double>(surfels->size()));
  });
}

}  // namespace surfit
