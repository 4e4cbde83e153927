#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Pose graph of a g2o file.
struct G2oFile {
  PoseGraph graph;
  std::map<std::string, std::size_t> ignored_lines;  // number of lines per unknown tag
};

// Reads a 3D pose graph in the text format of g2o (Kummerle et al.: g2o: A general framework for
// graph optimization, ICRA 2011), with lines in any order:
//   VERTEX_SE3:QUAT id x y z qx qy qz qw          world_from_pose, metres
//   EDGE_SE3:QUAT i j x y z qx qy qz qw I11 ...   i_from_j, and the upper triangle of the
//                                                 information of (translation, rotation), by rows
//   FIX id ...
//   # comment
// The rotation part of the information refers to a rotation vector in rad, as in GTSAM and in the
// examples of Ceres. In g2o itself, it refers to (qx, qy, qz) of the quaternion, which is half of
// this vector.
//
// The error of the edge is that of i_from_j^-1 (estimated i_from_j), in the frame of j. Therefore
// the edge in the graph has a = j and b = i. An edge between ids that are not consecutive is a loop
// closure.
//
// Throws InputError that names the file, the line and the constraint. A file without vertices is an
// error.
G2oFile ReadG2o(const std::string& path);

// Writes poses, fixed poses and edges atomically in the same format, with enough digits for an
// exact round trip. Throws InputError that names the file if it cannot be written.
void WriteG2o(const PoseGraph& graph, const std::string& path);

}  // namespace surfit
