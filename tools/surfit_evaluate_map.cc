// Compares a map with a reference surface: accuracy and completeness.

#include <filesystem>
#include <iostream>
#include <set>
#include <vector>

#include "common/json.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string map, reference, estimate, groundtruth;
  MapErrorOptions error;

  void Visit(OptionVisitor& v) {
    v.Add(
        map, "map",
        "the map, a PLY or PCD file with points or surfels, or a folder of such files that make it "
        "up: the tiles of a scan",
        Required(), AsFlag());
    v.Add(reference, "reference",
          "the true surface as a dense point cloud (PLY or PCD), in the map's frame", Required(),
          AsFlag());
    v.Add(estimate, "estimate",
          "the run's trajectory (TUM format), with --groundtruth: the map is taken to the "
          "reference as its trajectory is for ATE, or else compared as it lies",
          AsFlag());
    v.Add(groundtruth, "groundtruth", "the true trajectory, in the reference's frame", AsFlag());
    v.AddPart(error, "error", "how they are compared");
  }
};

// Of a folder all of its files that are clouds, by name.
std::vector<Eigen::Vector3f> ReadMapPoints(const std::string& path) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(path)) return ReadPointCloud(path).points;
  std::set<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".ply" || extension == ".pcd") files.insert(entry.path());
  }
  if (files.empty()) throw InputError(path + ": has no .ply or .pcd file");
  std::vector<Eigen::Vector3f> points;
  for (const fs::path& file : files) {
    const PointCloud part = ReadPointCloud(file);
    points.insert(points.end(), part.points.begin(), part.points.end());
  }
  return points;
}

// By the rigid motion that takes the trajectory as near to the truth as one can.
Rigid3d ReferenceFromMap(const Options& options) {
  if (options.estimate.empty() && options.groundtruth.empty()) return Rigid3d();
  RequireFlag("estimate", options.estimate);
  RequireFlag("groundtruth", options.groundtruth);
  const Trajectory truth = ReadTumTrajectory(options.groundtruth);
  const auto evaluation =
      EvaluateTrajectory(truth, ReadTumTrajectory(options.estimate), Stamps(truth), {});
  if (!evaluation.ate || evaluation.ate->alignment.status != AlignmentStatus::kAligned) {
    throw InputError(Concat("the ", evaluation.matched, " poses of ", options.estimate,
                            " that match ", options.groundtruth,
                            " place no map, must be at least 3 that are not in a line"));
  }
  return evaluation.ate->alignment.target_from_source;
}

Json ToJson(const MapError& error, const Rigid3d& reference_from_map, Options options) {
  Json json;
  SetStatistics("accuracy", "m", &error.accuracy_m, &json);
  json["completeness"] = error.completeness;
  SetStatistics("plane_accuracy", "m", error.plane_accuracy_m ? &*error.plane_accuracy_m : nullptr,
                &json);
  json["map_points"] = error.map_points;
  json["reference_points"] = error.reference_points;
  json["reference_from_map"] = {{"translation_m", reference_from_map.translation},
                                {"quaternion_xyzw", reference_from_map.rotation.coeffs()}};
  json["options"] = FlagsToJson(TableOf(&options));
  return json;
}

int Run(const Options& options) {
  const Rigid3d reference_from_map = ReferenceFromMap(options);
  std::vector<Eigen::Vector3f> map = ReadMapPoints(options.map);
  for (Eigen::Vector3f& point : map) {
    point = (reference_from_map * point.cast<double>()).cast<float>();
  }
  const PointCloud reference = ReadPointCloud(options.reference);
  const MapError error = ComputeMapError(map, reference.points, reference.normals, options.error);
  PrintJson(ToJson(error, reference_from_map, options));
  std::cerr << "accuracy " << error.accuracy_m.mean << " m mean, " << error.accuracy_m.p90
            << " m for 90 %; " << 100 * error.completeness << " % of the reference mapped within "
            << options.error.completeness_distance_m << " m" << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "compares a map with a reference surface. Prints JSON on stdout and a summary on stderr: "
      "accuracy is the distance from each map point to the nearest reference point (the "
      "reference's spacing is part of it), plane_accuracy the distance to that point's plane where "
      "the reference has normals, completeness the share of the reference with a map point near "
      "by.",
      surfit::tools::Run);
}
