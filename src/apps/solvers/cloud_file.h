#pragma once

#include <string>

#include "apps/solvers/register_run.h"
#include "surfit/io/point_cloud.h"

namespace surfit {

// A cloud, ready to be registered.
struct PreparedCloud {
  PointCloud cloud;  // its finite points, with the normals that it had or was given
  PointSet points;
  RegisteredCloud about;
};

// Normals and sigmas as in RunRegister(). Throws InputError naming `what`.
PreparedCloud PrepareCloud(PointCloud cloud, const std::string& what, const CloudSensor& sensor,
                           const CloudNormalOptions& normals, double floor_sigma_m);

// The same of a file. Throws InputError naming the file.
PreparedCloud ReadCloudFile(const std::string& path, const CloudSensor& sensor,
                            const CloudNormalOptions& normals, double floor_sigma_m);

}  // namespace surfit
