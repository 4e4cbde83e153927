#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "surfit/optimization/pose_graph.h"

namespace surfit {

class OptionVisitor;

// Treatment of information matrices that are not positive semidefinite:
// - "refuse": InputError
// - "project": negative eigenvalues are set to 0
// - "blocks": the covariance of rotation and translation is dropped. Negative eigenvalues of the
//   blocks of rotation and translation are set to 0.
std::vector<std::string> IndefiniteInformationNames();

// Options of ReadG2o().
struct G2oOptions {
  std::string odometry = "consecutive";           // one of OdometryNames()
  std::string indefinite_information = "refuse";  // one of IndefiniteInformationNames()

  void Visit(OptionVisitor& visitor);
};

// Pose graph of a g2o file.
struct G2oFile {
  PoseGraph graph;
  std::map<std::string, std::size_t> ignored_lines;  // number of lines per unknown tag
  std::size_t indefinite_count = 0;                  // number of changed information matrices
  // Number of poses, if the file has no vertices; otherwise 0. Their ids are those of the edges,
  // priors and positions, in ascending order.
  std::size_t chained_count = 0;
};

// Reads a pose graph in the text format of g2o (Kummerle et al.: g2o: A general framework for graph
// optimization, ICRA 2011), with lines in any order. In SE(3):
//   VERTEX_SE3:QUAT id x y z qx qy qz qw          world_from_pose, metres
//   EDGE_SE3:QUAT i j x y z qx qy qz qw I11 ...   i_from_j, and the upper triangle of the
//                                                 information of (translation, rotation), by rows
//   PARAMS_SE3OFFSET p x y z qx qy qz qw          pose_from_sensor
//   EDGE_SE3_PRIOR i p x y z qx qy qz qw I11 ...  world_from_sensor of parameter p
//   EDGE_SE3_XYZPRIOR i p x y z I11 ...           position of sensor p, 3 x 3 information
//   EDGE_POINTXYZ_PRIOR i x y z I11 ...           position of pose i, 3 x 3 information
// In SE(2), with angles in rad and the information of (x, y, angle):
//   VERTEX_SE2 id x y angle
//   EDGE_SE2 i j x y angle I11 I12 I13 I22 I23 I33
//   EDGE_PRIOR_SE2 i x y angle I11 ...
//   EDGE_PRIOR_SE2_XY i x y I11 I12 I22
// In both:
//   FIX id ...
//   # comment
// The rotation part of the information in SE(3) refers to a rotation vector in rad, as in GTSAM and
// in the examples of Ceres. In g2o itself, it refers to (qx, qy, qz) of the quaternion, which is
// half of this vector.
//
// In g2o, the error of an edge is i_from_j^-1 (estimated i_from_j), a motion in the frame of j. The
// error of PoseGraphEdge is in the frame of a. Therefore the edge in the graph has a = j and b = i.
//
// A file of SE(2) gives a graph with PoseGraph::planar. Quaternions are normalised; their norm must
// be 1 within 1 %. Entries of information matrices are at most 1e30, and coordinates at most 1e9 m.
// PoseGraphEdge::loop follows from G2oOptions::odometry. Lines with other tags are ignored.
//
// The poses of a file without vertices are computed by ChainPosesOf(). A file with vertices must
// have a vertex for each id.
//
// Throws InputError for invalid options, and InputError that names the file, the line and the
// constraint. A file without poses and a file with lines of SE(2) and SE(3) are errors.
G2oFile ReadG2o(const std::string& path, const G2oOptions& options = {});

// Writes poses, fixed poses, edges and priors atomically in the same format. Numbers have 17
// digits, so ReadG2o() gives the same graph up to relative rounding errors of about 1e-16.
// PoseGraphEdge::loop is not written. The graph must be valid, which is not checked. Throws
// InputError that names the file if it cannot be written. A sensor offset in SE(2) is an error,
// because the format does not have it.
void WriteG2o(const PoseGraph& graph, const std::string& path);

}  // namespace surfit
