#include "surfit/mesh/mesh_surfels.h"

#include <algorithm>
#include <mutex>

#include "geometry/kd_tree.h"
#include "mesh/mesh_steps.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/error_statistics.h"

namespace surfit {
namespace {

class StageProgress {
 public:
  StageProgress(const MeshProgress& progress) : progress_(progress) {}

  // Starts the next stage. `part`: fraction of the total work in this stage.
  std::function<void(double)> Begin(const char* stage, double part) {
    begin_ += part_;
    part_ = part;
    done_ = 0;
    stage_ = stage;
    return [this](double share) {
      const std::lock_guard<std::mutex> lock(mutex_);
      done_ += share;
      if (progress_) progress_(stage_, begin_ + part_ * std::min(1., done_));
    };
  }

 private:
  const MeshProgress& progress_;
  std::mutex mutex_;
  double begin_ = 0, part_ = 0, done_ = 0;
  const char* stage_ = "";
};

// Sets the spacing of each surfel. If n surfels are within radius R, then pi R^2 = n spacing^2.
void MeasureSpacings(float radius_m, std::vector<MeshSurfel>* surfels) {
  const SurfelCubes cubes(*surfels, radius_m);
  ParallelFor(0, cubes.cube_count(), 16, [&](int begin, int end) {
    std::vector<SurfelCubes::Range> ranges;
    for (int c = begin; c < end; ++c) {
      const Eigen::Vector3f low = cubes.CubeOf(c).cast<float>() * radius_m;
      cubes.FindWithin(low - Eigen::Vector3f::Constant(radius_m),
                       low + Eigen::Vector3f::Constant(2 * radius_m), &ranges);
      for (std::uint32_t i = cubes.SurfelsOf(c).begin; i < cubes.SurfelsOf(c).end; ++i) {
        int count = 0;
        for (const SurfelCubes::Range& range : ranges) {
          for (std::uint32_t j = range.begin; j < range.end; ++j) {
            const auto offset = cubes.surfels()[j].position - cubes.surfels()[i].position;
            count += offset.squaredNorm() <= radius_m * radius_m ? 1 : 0;
          }
        }
        (*surfels)[cubes.order()[i]].spacing_m =
            radius_m * static_cast<float>(std::sqrt(M_PI / count));
      }
    }
  });
}

void CheckCloud(const PointCloud& cloud) {
  const std::size_t points = cloud.points.size();
  ThrowIf(cloud.normals.empty(), "the map has no points with normals");
  const auto check_count = [&](const char* attribute, std::size_t count) {
    ThrowIf(count > 0 && count != points, attribute, " has ", count, " elements, must have ",
            points, ", one per point");
  };
  check_count("normals", cloud.normals.size());
  check_count("colors", cloud.colors.size());
  check_count("radii_m", cloud.radii_m.size());
  check_count("confidences", cloud.confidences.size());
  const auto bad = std::find_if(cloud.points.begin(), cloud.points.end(),
                                [](const Eigen::Vector3f& point) { return !point.allFinite(); });
  ThrowIf(bad != cloud.points.end(), "point ", bad - cloud.points.begin(),
          " has a coordinate that is not finite: see RemoveNonFinite()");
}

// Converts points with normals. Depth noise grows with the square of the distance, and the radius
// grows with the distance. Confidence is about the number of observations. Therefore sigma ~
// radius^2 / sqrt(confidence).
std::vector<MeshSurfel> ToSurfels(const PointCloud& cloud, const MeshOptions& options) {
  constexpr float kMinConfidence = 0.1f;
  const auto trim_m = static_cast<float>(options.trim_distance_m);
  const bool has_radii = !cloud.radii_m.empty();
  std::vector<MeshSurfel> surfels;
  surfels.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const float length = cloud.normals[i].norm();
    if (!(length > 0.5f && length < 2) || (has_radii && !(cloud.radii_m[i] > 0))) continue;
    MeshSurfel surfel;
    surfel.position = cloud.points[i];
    surfel.normal = cloud.normals[i] / length;
    surfel.color = cloud.colors.empty() ? Rgb8{200, 200, 200} : cloud.colors[i];
    surfel.spacing_m = has_radii ? cloud.radii_m[i] : trim_m;
    surfel.sigma_m = has_radii ? surfel.spacing_m * surfel.spacing_m : 1;
    if (!cloud.confidences.empty())
      surfel.sigma_m /= std::sqrt(std::max(kMinConfidence, cloud.confidences[i]));
    const auto support_radii = static_cast<float>(options.support_radii);
    surfel.reach_m = has_radii ? std::min(trim_m, support_radii * surfel.spacing_m) : trim_m;
    surfels.push_back(surfel);
  }
  ThrowIf(surfels.empty(), "the map has no points with normals");
  if (!has_radii) MeasureSpacings(trim_m, &surfels);
  return surfels;
}

void MeasureDistances(const PointCloud& cloud, const TriangleMesh& mesh, double cell_m,
                      MeshSummary* summary) {
  constexpr int kPointsPerTask = 4096;
  const KdTree tree(mesh.vertices);
  const auto farthest = static_cast<float>(3 * cell_m * 3 * cell_m);
  const int count = static_cast<int>(cloud.points.size());
  std::vector<double> distances(count, -1);
  ParallelFor(0, count, kPointsPerTask, [&](int begin, int end) {
    std::uint32_t nearest = KdTree::kNone;
    for (int i = begin; i < end; ++i) {
      nearest = tree.Nearest(cloud.points[i], farthest, nearest).rank;
      if (nearest == KdTree::kNone) continue;
      const Eigen::Vector3f offset = cloud.points[i] - tree.Point(nearest);
      distances[i] = std::abs(mesh.normals[tree.order()[nearest]].dot(offset));
    }
  });
  distances.erase(std::remove(distances.begin(), distances.end(), -1.), distances.end());
  summary->covered = static_cast<double>(distances.size()) / count;
  if (distances.empty()) return;
  const ErrorStatistics statistics = Summarize(std::move(distances));
  summary->median_distance_m = statistics.median;
  summary->p90_distance_m = statistics.p90;
}

}  // namespace

TriangleMesh MeshSurfels(const PointCloud& cloud, const MeshOptions& options, MeshSummary* summary,
                         const MeshProgress& progress) {
  Validate(options);
  CheckCloud(cloud);
  StageProgress stages(progress);
  const auto cell_m = static_cast<float>(options.cell_m);
  std::vector<MeshSurfel> surfels = ToSurfels(cloud, options);
  FindSigmas(&surfels);
  constexpr int kRounds = 2;
  for (int i = 0; i < kRounds && options.normal_noise_rad > 0; ++i) {
    SmoothSurfels(options.normal_noise_rad, stages.Begin("smoothing surfels", 0.25), &surfels);
  }
  const SurfelCubes cubes(surfels, cell_m * DistanceField::kSide);
  surfels = {};
  const DistanceField field(cubes, cell_m, stages.Begin("computing distances", 0.2));
  TriangleMesh mesh = ExtractSurface(field, cubes, stages.Begin("making triangles", 0.2));
  *summary = {};
  DropSmallPieces(options.min_component_m, summary, &mesh);
  ThrowIf(mesh.triangles.empty(),
          "the map supports no triangle: see cell_m, trim_distance_m and min_component_m");
  summary->triangles_found = mesh.triangles.size();
  MeasureDistances(cloud, mesh, options.cell_m, summary);
  if (options.max_triangles > 0) {
    const auto done = stages.Begin("joining triangles", 0.1);
    done(0);
    summary->decimation_m = Decimate(options.max_triangles, &mesh);
  }
  if (options.watertight) CloseHoles(summary, &mesh);
  return mesh;
}

}  // namespace surfit
