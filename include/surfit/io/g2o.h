#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "surfit/optimization/pose_graph.h"

namespace surfit {

// What a .g2o file holds.
struct G2oFile {
  PoseGraph graph;
  std::map<std::string, std::size_t> ignored_lines;  // by tags that are not known: how many
};

// Reads a pose graph in three dimensions, in the text format of g2o (Kummerle et al.: g2o: A
// general framework for graph optimization, ICRA 2011):
//   VERTEX_SE3:QUAT id x y z qx qy qz qw          world_from_pose, metres
//   EDGE_SE3:QUAT i j x y z qx qy qz qw I11 ...   i_from_j, and the upper triangle, row by row, of
//                                                 the information of (translation, rotation)
//   FIX id ...
// in any order; # begins a comment. As GTSAM and Ceres' examples do, the rotation is taken as a
// vector in rad; g2o itself means the quaternion's (qx, qy, qz), half of that. The error is that of
// i_from_j^-1 (estimated i_from_j), in the frame of j: the edge in the graph is b = i, a = j.
// An edge between ids that do not follow one another is a loop.
// Throws InputError naming file, line and constraint; and if there are no vertices.
G2oFile ReadG2o(const std::string& path);

// Writes all of it in the same format and order, atomically, with as many digits as give the same
// numbers again. Throws InputError naming the file if it cannot be written.
void WriteG2o(const PoseGraph& graph, const std::string& path);

}  // namespace surfit
