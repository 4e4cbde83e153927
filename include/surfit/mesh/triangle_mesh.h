#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Triangle mesh. Normals and colours are empty or have one entry per vertex. This and the indices
// are not checked.
struct TriangleMesh {
  using Triangle = std::array<std::uint32_t, 3>;

  std::vector<Eigen::Vector3f> vertices;  // metres
  std::vector<Eigen::Vector3f> normals;   // unit length, towards the observed side
  std::vector<Rgb8> colors;
  std::vector<Triangle> triangles;  // counterclockwise from the observed side
};

// Keeps the triangles with kept[i] != 0 and their vertices, in order. Throws unless `kept` has one
// element per triangle.
void KeepTriangles(const std::vector<std::uint8_t>& kept, TriangleMesh* mesh);

// Writes the mesh atomically, by the extension of the path, with normals and colours if it has
// them:
//   .ply  binary little endian: float x y z nx ny nz, uchar red green blue, lists of int
//   .obj  Wavefront text: positions with 5 decimals, then vertex colours in [0, 1]
//   .glb  glTF 2.0 in one file, y up: x right, y down and z forward become x, -y and -z; colours
//         become linear; no normals, because the material is unlit
// Throws InputError for other extensions, if the file cannot be written, and for a .glb without
// triangles.
void WriteMesh(const TriangleMesh& mesh, const std::string& path);

// Throws InputError unless the extension of the path is .ply, .obj or .glb.
void RequireMeshEnding(const std::string& path);

}  // namespace surfit
