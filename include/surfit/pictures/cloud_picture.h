#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace surfit {

// Writes a PNG of two point clouds, source in orange and target in blue, as the target's camera
// sees them and obliquely from the side. Points are in metres in the target camera's frame (x
// right, y down, z forward); where the target lies not before such a camera, they are seen from far
// enough along z. Each pixel shows the nearest point: surfaces that coincide show both
// colours mingled, others one colour before the other. Throws InputError where the file cannot be
// written.
void WriteTwoCloudPicture(const std::vector<Eigen::Vector3f>& source,
                          const std::vector<Eigen::Vector3f>& target, const std::string& path);

}  // namespace surfit
