#include "apps/solvers/register_run.h"

#include <iomanip>
#include <vector>

#include "apps/solvers/cloud_file.h"
#include "apps/solvers/result_json.h"
#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "output/pictures/pictures.h"
#include "run/posed_views.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

constexpr Rgb8 kSourcePaint = {240, 130, 20};
constexpr Rgb8 kTargetPaint = {30, 110, 220};

std::vector<Eigen::Vector3f> PointsOf(const FrameLevel& level, const Rigid3d& frame_from_camera) {
  const Eigen::Matrix3f rotation = frame_from_camera.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = frame_from_camera.translation.cast<float>();
  std::vector<Eigen::Vector3f> points;
  for (int v = 0; v < level.vertex.height(); ++v) {
    for (int u = 0; u < level.vertex.width(); ++u) {
      const Eigen::Vector3f point = level.vertex(u, v);
      if (point.z() > 0) points.emplace_back(rotation * point + translation);
    }
  }
  return points;
}

void WriteClouds(const PosedPair& pair, const Rigid3d& target_from_source,
                 const std::string& stem) {
  const auto source_points = PointsOf(pair.source.view.pyramid.levels.front(), target_from_source);
  const auto target_points = PointsOf(pair.target.view.pyramid.levels.front(), Rigid3d());
  WriteTwoCloudPicture(source_points, target_points, stem + ".png");
  PointCloud both;
  both.points = source_points;
  both.points.insert(both.points.end(), target_points.begin(), target_points.end());
  both.colors.assign(source_points.size(), kSourcePaint);
  both.colors.resize(both.points.size(), kTargetPaint);
  WritePly(both, stem + ".ply");
}

PointCloud Moved(PointCloud cloud, const Rigid3d& pose) {
  for (auto& point : cloud.points) point = (pose * point.cast<double>()).cast<float>();
  for (auto& normal : cloud.normals) normal = (pose.rotation * normal.cast<double>()).cast<float>();
  return cloud;
}

void WriteTransform(const Rigid3d& pose, const std::string& path) {
  const Eigen::Matrix4d matrix = pose.Matrix();
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << std::setprecision(17);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        file << matrix(row, column) << (column < 3 ? ' ' : '\n');
      }
    }
  });
}

}  // namespace

AlignRunResult RunAlign(const AlignRunOptions& options) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  const PosedPair pair = ReadPosedPair(options.sequence, options.source, options.target,
                                       options.preprocess, options.icp.error_model);
  const OutputFolder owned(options.output, {"before.ply", "after.ply", "before.png", "after.png"});

  AlignRunResult result;
  result.registration =
      RegisterGlobally(pair.source.view, pair.target.view, options.initialize, options.icp);
  const Rigid3d& estimated = result.registration.icp.target_from_source;
  if (const std::optional<Rigid3d> truth = pair.TargetFromSource()) {
    result.initial_error = ErrorOf(Rigid3d(), *truth);
    result.final_error = ErrorOf(estimated, *truth);
  }
  WriteClouds(pair, Rigid3d(), options.output + "/before");
  WriteClouds(pair, estimated, options.output + "/after");
  return result;
}

RegisterRunResult RunRegister(const RegisterRunOptions& options) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  RegisterRunResult result;
  const double floor_sigma_m = options.registration.icp.error_model.floor_sigma_m;
  const PreparedCloud source =
      ReadCloudFile(options.source, options.sensor, options.normals, floor_sigma_m);
  const PreparedCloud target =
      ReadCloudFile(options.target, options.sensor, options.normals, floor_sigma_m);
  result.source = source.about;
  result.target = target.about;
  const OutputFolder owned(options.output, {"transform.txt", "registration.json", "aligned.ply",
                                            "before.png", "after.png"});
  result.icp = RegisterClouds(source.points, target.points, Rigid3d(), options.registration);
  const PointCloud aligned = Moved(source.cloud, result.icp.target_from_source);
  WriteTransform(result.icp.target_from_source, options.output + "/transform.txt");
  WriteRegistrationJson(result, options, options.output + "/registration.json");
  WritePly(aligned, options.output + "/aligned.ply");
  WriteTwoCloudPicture(source.cloud.points, target.cloud.points, options.output + "/before.png");
  WriteTwoCloudPicture(aligned.points, target.cloud.points, options.output + "/after.png");
  return result;
}

}  // namespace surfit
