// Compares a map with a reference surface: accuracy and completeness.

#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <vector>

#include "common/json.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "evaluate/evaluations.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::tools {
namespace {

struct MapOptions {
  std::string map, reference, estimate, groundtruth;
  MapErrorOptions error;

  void Visit(OptionVisitor& v) {
    v.Group("map");
    v.Add(map, SharedOption("map", Required(), Everyday()));
    v.Add(reference, "reference",
          "reference surface: a mesh (PLY) or a dense point cloud (PLY, PCD); with --estimate and "
          "--groundtruth the map is moved by their alignment",
          Required(), Everyday());
    v.Add(estimate, SharedOption("estimate"));
    v.Add(groundtruth, SharedOption("groundtruth"));
    v.AddPart(error, "error", "map comparison");
  }
};

// Points of a cloud file, or of all cloud files of a folder in the order of their names.
// Coordinates are relative to the origin, see ReadPointCloud().
std::vector<Eigen::Vector3f> ReadMapPoints(const std::string& path,
                                           std::optional<Eigen::Vector3d>* origin) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(path)) return ReadPointCloud(path, origin).points;
  std::set<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".ply" || extension == ".pcd") files.insert(entry.path());
  }
  if (files.empty()) throw InputError(path + ": contains no .ply or .pcd file");
  std::vector<Eigen::Vector3f> points;
  for (const fs::path& file : files) {
    const PointCloud part = ReadPointCloud(file, origin);
    points.insert(points.end(), part.points.begin(), part.points.end());
  }
  return points;
}

// Rigid alignment of the estimate to the ground truth; the identity without both.
Rigid3d ReferenceFromMap(const MapOptions& options) {
  if (options.estimate.empty() && options.groundtruth.empty()) return Rigid3d();
  RequireFlag("estimate", options.estimate);
  RequireFlag("groundtruth", options.groundtruth);
  const Trajectory truth = ReadTumTrajectory(options.groundtruth);
  const auto evaluation =
      EvaluateTrajectory(truth, ReadTumTrajectory(options.estimate), Stamps(truth), {});
  if (!evaluation.ate || evaluation.ate->alignment.status != AlignmentStatus::kAligned) {
    throw InputError(
        Concat("the ", evaluation.matched, " poses of ", options.estimate, " that match ",
               options.groundtruth,
               " do not define an alignment, must be at least 3 poses that are not collinear"));
  }
  return evaluation.ate->alignment.target_from_source;
}

Json ToJson(const MapError& error, const Rigid3d& reference_from_map, MapOptions options) {
  Json json;
  SetStatistics("accuracy", "m", &error.accuracy_m, &json);
  json["completeness"] = error.completeness;
  SetStatistics("plane_accuracy", "m", error.plane_accuracy_m ? &*error.plane_accuracy_m : nullptr,
                &json);
  json["map_points"] = error.map_points;
  json["reference_points"] = error.reference_points;
  json["reference_triangles"] = error.reference_triangles;
  json["reference_from_map"] = {{"translation_m", reference_from_map.translation},
                                {"quaternion_xyzw", reference_from_map.rotation.coeffs()}};
  json["options"] = FlagsToJson(TableOf(&options));
  return json;
}

int RunMap(const MapOptions& options) {
  const Rigid3d reference_from_map = ReferenceFromMap(options);
  std::optional<Eigen::Vector3d> origin;  // of all coordinates, set by the reference
  const PointCloud reference = ReadPointCloud(options.reference, &origin);
  // A pipe can only be read once, so that its faces are not read.
  const bool is_file = std::filesystem::is_regular_file(options.reference);
  const std::vector<Eigen::Vector3i> triangles =
      is_file ? ReadTriangles(options.reference) : std::vector<Eigen::Vector3i>();
  std::vector<Eigen::Vector3f> map = ReadMapPoints(options.map, &origin);
  for (Eigen::Vector3f& point : map) {
    const Eigen::Vector3d in_map = point.cast<double>() + *origin;
    point = (reference_from_map * in_map - *origin).cast<float>();
  }
  const MapError error =
      triangles.empty() ? ComputeMapError(map, reference.points, reference.normals, options.error)
                        : ComputeMapErrorOfMesh(map, reference.points, triangles, options.error);
  PrintJson(ToJson(error, reference_from_map, options));
  std::cerr << "mean accuracy " << error.accuracy_m.mean << " m, 90 % quantile "
            << error.accuracy_m.p90 << " m; " << 100 * error.completeness << " % of the "
            << (triangles.empty() ? "reference points have" : "reference area has")
            << " a map point within " << options.error.completeness_distance_m << " m" << std::endl;
  return kDone;
}

}  // namespace

Mode MapEvaluationMode() { return MakeMode("map", RunMap); }

}  // namespace surfit::tools
