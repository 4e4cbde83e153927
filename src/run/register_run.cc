#include "surfit/run/register_run.h"

#include <iomanip>
#include <utility>

#include "run/cloud_file.h"
#include "run/output_folder.h"
#include "run/registration_json.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/io/point_cloud.h"
#include "surfit/pictures/pictures.h"

namespace surfit {
namespace {

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

RegisterRunResult RunRegister(const RegisterRunOptions& options) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  RegisterRunResult result;
  const double floor_sigma_m = options.registration.icp.error_model.floor_sigma_m;
  const PreparedCloud source = ReadCloudFile(options.source, options.normals, floor_sigma_m);
  const PreparedCloud target = ReadCloudFile(options.target, options.normals, floor_sigma_m);
  result.source = source.about;
  result.target = target.about;
  PrepareOutputFolder(options.output, {"transform.txt", "registration.json", "aligned.ply",
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
