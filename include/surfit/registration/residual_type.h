#pragma once

#include <string>
#include <vector>

namespace surfit {

// What registration makes small, for a source point p' = R p + t with the unit normal m and its
// target point q with the unit normal n. All are lengths in metres, weighted by 1 / sigma^2.
enum class ResidualType {
  kPointToPoint,           // p' - q (Besl and McKay 1992)
  kPointToPlane,           // n . (p' - q) (Chen and Medioni 1992)
  kSymmetricPointToPlane,  // (n + m) / 2 . (p' - q) (Rusinkiewicz 2019)
  kPlaneToPlane,           // U (p' - q), U^T U = C^-1, C of two planes (Segal et al. 2009, GICP)
};

// "point_to_point", "point_to_plane", "symmetric_point_to_plane", "plane_to_plane".
std::vector<std::string> ResidualTypeNames();
// Throws InputError that lists the names for an unknown one.
ResidualType ResidualTypeFromName(const std::string& name);
std::string ToString(ResidualType type);

// Which normals a pair must have.
enum class NeededNormals { kNone, kTarget, kBoth };
NeededNormals NormalsNeededBy(ResidualType type);

}  // namespace surfit
