#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Points with optional normals, colours, radii and confidences: each of these is empty or of the
// points' size.
struct PointCloud {
  std::vector<Eigen::Vector3f> points;  // metres
  std::vector<Eigen::Vector3f> normals;
  std::vector<Rgb8> colors;
  std::vector<float> radii_m = {};      // of surfels
  std::vector<float> confidences = {};  // of surfels
};

// Reads the element `vertex` of a PLY file, ascii or binary little endian: x y z of any scalar
// type, nx ny nz where there are all three, red green blue where there are all three as uchar,
// radius, confidence. Everything else in the file is skipped. Coordinates come as they are, NaN
// included. Throws InputError naming the file and what is wrong with it. A count that the file is
// too short for is refused before any memory is taken for it.
PointCloud ReadPly(const std::string& path);

// Reads a PLY file or, where the first line is not `ply`, a PCD file (Point Cloud Data 0.7: ascii,
// binary or binary_compressed): x y z of any type, normal_x normal_y normal_z where there are all
// three, rgb or rgba where there is one of four bytes. VIEWPOINT is not applied, no radii are read.
// The rest is as with ReadPly().
PointCloud ReadPointCloud(const std::string& path);

// Leaves out the points with a coordinate that is not finite; returns how many.
std::size_t RemoveNonFinite(PointCloud* cloud);

// Writes binary little endian PLY, atomically. Throws InputError naming the file if it cannot be
// written.
void WritePly(const PointCloud& cloud, const std::string& path);

// Writes binary PCD 0.7, atomically: x y z, normal_x normal_y normal_z and rgb (the bits 0x00rrggbb
// as a float, as PCL has it) where the cloud has them; no radii. Throws InputError naming the file
// if it cannot be written.
void WritePcd(const PointCloud& cloud, const std::string& path);

// Writes the map as binary little endian PLY, atomically, one vertex a surfel:
// float x y z nx ny nz, uchar red green blue, float radius confidence, int first_seen last_seen
// (metres, world frame, frame indices). Opens in CloudCompare, MeshLab and Open3D.
// Throws InputError naming the file if it cannot be written.
void WriteSurfelPly(const SurfelMap& map, const std::string& path);

// Reads such a file: all of these properties must be there, in any order and of any scalar type.
// Throws InputError naming the file and what is wrong with it.
std::vector<Surfel> ReadSurfelPly(const std::string& path);

}  // namespace surfit
