#pragma once

#include <string>

#include "apps/solvers/register_run.h"
#include "surfit/io/point_cloud.h"

namespace surfit {

// Point cloud for registration.
struct PreparedCloud {
  PointCloud cloud;  // finite points with normals of the file or estimated normals
  PointSet points;   // the same points with sigmas
  RegisteredCloud about;
};

// Sets normals and sigmas as RunRegister(). Throws InputError for a cloud without finite points or
// with more than 2^30 points. `what`: name of the cloud in messages. Zero and non-finite normals
// become (0, 0, 0). `floor_sigma_m`: smallest sigma, m.
PreparedCloud PrepareCloud(PointCloud cloud, const std::string& what, const CloudSensor& sensor,
                           const CloudNormalOptions& normals, double floor_sigma_m);

// Reads a PLY or PCD file, then PrepareCloud(). Throws InputError with the file name.
PreparedCloud ReadCloudFile(const std::string& path, const CloudSensor& sensor,
                            const CloudNormalOptions& normals, double floor_sigma_m);

}  // namespace surfit
