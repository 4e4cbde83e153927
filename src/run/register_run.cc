#include "surfit/run/register_run.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <utility>

#include "run/output_folder.h"
#include "run/registration_json.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/io/point_cloud.h"
#include "surfit/pictures/cloud_picture.h"

namespace surfit {
namespace {

PointCloud ReadCloud(const std::string& path, RegisteredCloud* about) {
  PointCloud cloud = ReadPointCloud(path);
  about->not_finite = RemoveNonFinite(&cloud);
  about->points = cloud.points.size();
  if (cloud.points.empty()) throw InputError(Concat(path, ": there is no finite point"));
  if (cloud.points.size() > std::size_t{1} << 30) {
    throw InputError(
        Concat(path, ": there are ", cloud.points.size(), " points, must be at most 2^30"));
  }
  return cloud;
}

// Normals of unit length; what has none, or none that is finite, gets (0, 0, 0).
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

// Gives the cloud the normals that it lacks.
PointSet MakePointSet(const RegisterRunOptions& options, PointCloud* cloud,
                      RegisteredCloud* about) {
  const double floor_sigma_m = options.registration.icp.error_model.floor_sigma_m;
  PointSet set;
  set.points = cloud->points;
  set.sigma_m.assign(set.size(), static_cast<float>(floor_sigma_m));
  if (cloud->normals.empty()) {
    CloudNormals estimated = EstimateCloudNormals(cloud->points, options.normals);
    about->normal_radius_m = estimated.radius_m;
    cloud->normals = std::move(estimated.normals);
    for (std::size_t i = 0; i < set.size(); ++i) {
      set.sigma_m[i] = std::hypot(set.sigma_m[i], estimated.deviation_m[i]);
    }
  } else {
    Normalize(&cloud->normals);
  }
  set.normals = cloud->normals;
  about->without_normal = std::count_if(set.normals.begin(), set.normals.end(),
                                        [](const auto& normal) { return normal.isZero(0); });
  return set;
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

void RegisterRunOptions::Validate() const {
  normals.Validate();
  registration.Validate();
  for (const auto& [name, value] :
       {std::pair("source", &source), std::pair("target", &target), std::pair("output", &output)}) {
    if (value->empty()) throw InputError(Concat(name, " is empty, must be set"));
  }
}

RegisterRunResult RunRegister(const RegisterRunOptions& options) {
  options.Validate();
  const ThreadLimit limit(options.threads);
  RegisterRunResult result;
  PointCloud source = ReadCloud(options.source, &result.source);
  PointCloud target = ReadCloud(options.target, &result.target);
  PrepareOutputFolder(options.output, {"transform.txt", "registration.json", "aligned.ply",
                                       "before.png", "after.png"});
  const PointSet source_points = MakePointSet(options, &source, &result.source);
  const PointSet target_points = MakePointSet(options, &target, &result.target);
  result.icp = RegisterClouds(source_points, target_points, Rigid3d(), options.registration);
  const PointCloud aligned = Moved(source, result.icp.target_from_source);
  WriteTransform(result.icp.target_from_source, options.output + "/transform.txt");
  WriteRegistrationJson(result, options, options.output + "/registration.json");
  WritePly(aligned, options.output + "/aligned.ply");
  WriteTwoCloudPicture(source.points, target.points, options.output + "/before.png");
  WriteTwoCloudPicture(aligned.points, target.points, options.output + "/after.png");
  return result;
}

}  // namespace surfit
