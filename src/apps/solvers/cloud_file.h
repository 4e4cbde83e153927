#pragma once

#include <string>

#include "apps/solvers/register_run.h"
#include "surfit/io/point_cloud.h"

namespace surfit {

// Cloud for registration.
struct PreparedCloud {
  PointCloud cloud;  // finite points with normals of unit length; (0, 0, 0): no normal
  PointSet points;   // without duplicates
  bool has_signed_normals = false;  // the normals are those of the file
  RegisteredCloud about;
};

// Removes points that are equal to an earlier point from `points`, because equal points slow down
// searches. Estimates normals and sigmas as described at RunRegister(). `what` names the cloud in
// the InputError that is thrown for a cloud without finite points or with more than 2^30.
// sensor.viewpoint is in the frame of the file.
PreparedCloud PrepareCloud(PointCloud cloud, const std::string& what, const CloudSensor& sensor,
                           const CloudNormalOptions& normals, double floor_sigma_m);

// PrepareCloud() for a file. Coordinates are relative to `cloud.origin`. Throws InputError with the
// name of the file.
PreparedCloud ReadCloudFile(const std::string& path, const CloudSensor& sensor,
                            const CloudNormalOptions& normals, double floor_sigma_m);

}  // namespace surfit
