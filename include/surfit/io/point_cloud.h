#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Points with optional attributes. The vector of an attribute is empty or has the size of `points`.
struct PointCloud {
  std::vector<Eigen::Vector3f> points;   // metres
  std::vector<Eigen::Vector3f> normals;  // not normalised
  std::vector<Rgb8> colors;
  std::vector<float> radii_m = {};      // of surfels; metres
  std::vector<float> confidences = {};  // of surfels
  // Position of the coordinates (0, 0, 0) of `points`, m. Not 0 only after
  // ReadPointCloudAboutOrigin().
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
};

// Reads the element `vertex` of a PLY file: ascii, binary_little_endian or binary_big_endian. Names
// are read in upper or lower case. x, y and z have any scalar type. Optional properties: nx ny nz,
// red green blue (uchar), radius, confidence. Other content is ignored. Coordinates are not checked
// and may be NaN. Throws InputError that names the file and the error. A vertex count that exceeds
// the file size is rejected before memory is allocated.
PointCloud ReadPly(const std::string& path);

// Reads a PLY file as ReadPly(), or a PCD file (Point Cloud Data 0.7: ascii, binary or
// binary_compressed) if the first line is not `ply`. PCD fields: x y z of any type, and optionally
// normal_x normal_y normal_z and one 4-byte rgb or rgba. VIEWPOINT is not applied. Radii and
// confidences are not read from PCD. Throws InputError that names the file and the error.
PointCloud ReadPointCloud(const std::string& path);

// Reads a file as ReadPointCloud(), with coordinates relative to *origin. The difference is
// computed in double precision, so that coordinates of a survey keep their precision. Null: as
// ReadPointCloud(path). If *origin is std::nullopt, it becomes (0, 0, 0), or the first finite
// point, rounded to 1 m, if this is more than 100 m from (0, 0, 0). PointCloud::origin stays 0.
PointCloud ReadPointCloud(const std::string& path, std::optional<Eigen::Vector3d>* origin);

// Reads a file as ReadPointCloud() with an origin of std::nullopt, and stores the origin in
// PointCloud::origin.
PointCloud ReadPointCloudAboutOrigin(const std::string& path);

// Triangles of the faces of a PLY file: indices of its vertices. Faces with more corners are split
// into fans. Empty for a PCD file, and for a PLY file without the list vertex_indices or
// vertex_index of the element `face`. Throws InputError that names the file and the error.
std::vector<Eigen::Vector3i> ReadTriangles(const std::string& path);

// Removes the points with a coordinate that is not finite. Returns the number of removed points.
// Throws if an attribute has another size than `points`.
std::size_t RemoveNonFinite(PointCloud* cloud);

// Writes binary little-endian PLY atomically. Coordinates include `origin`, and are double if it is
// not 0. Throws InputError that names the file if it cannot be written. Throws if an attribute has
// another size than `points`.
void WritePly(const PointCloud& cloud, const std::string& path);

// Writes binary PCD 0.7 atomically: x y z, and normal_x normal_y normal_z and rgb (the bits
// 0x00rrggbb as a float, as in PCL) if the cloud has them. Coordinates include `origin`, and are
// double if it is not 0. Radii and confidences are not written. Throws InputError that names the
// file if it cannot be written. Throws if an attribute has another size than `points`.
void WritePcd(const PointCloud& cloud, const std::string& path);

// Writes the map atomically as binary little-endian PLY, one vertex per surfel, in metres in the
// world frame. Properties: float x y z nx ny nz, uchar red green blue, float radius confidence, int
// first_seen last_seen (frame indices), uchar from_stereo (0 or 1). CloudCompare, MeshLab and
// Open3D can open the file. Throws InputError that names the file if it cannot be written.
void WriteSurfelPly(const SurfelMap& map, const std::string& path);

// Reads a file of WriteSurfelPly(). All its properties except from_stereo are required, in any
// order and of any scalar type. Integers are clamped to their range; NaN becomes 0. Floats are not
// checked. The file has no at_edge and no color_weight: these members have their default values.
// Throws InputError that names the file and the error.
std::vector<Surfel> ReadSurfelPly(const std::string& path);

}  // namespace surfit
