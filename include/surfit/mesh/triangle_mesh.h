#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Triangles with what their corners have: normals and colours are empty or of the vertices' size.
struct TriangleMesh {
  using Triangle = std::array<std::uint32_t, 3>;

  std::vector<Eigen::Vector3f> vertices;  // metres
  std::vector<Eigen::Vector3f> normals;   // unit length, to the side that was seen
  std::vector<Rgb8> colors;
  std::vector<Triangle> triangles;  // counterclockwise from the side that was seen
};

// Keeps the triangles with kept[i] != 0, in their order, and the vertices that these have.
void KeepTriangles(const std::vector<std::uint8_t>& kept, TriangleMesh* mesh);

// Writes the mesh atomically, by the ending of the path:
//   .ply  binary little endian: float x y z nx ny nz, uchar red green blue, lists of int;
//   .obj  Wavefront's text, with the colours of vertices as 0 to 1 after their positions;
//   .glb  glTF 2.0 in one file. It has y up: x right, y down and z forward become x, -y and -z,
//         and colours become linear.
// Throws InputError if the path has another ending, or the file cannot be written.
void WriteMesh(const TriangleMesh& mesh, const std::string& path);

// Throws InputError unless the path has one of these endings.
void RequireMeshEnding(const std::string& path);

}  // namespace surfit
