#include <iomanip>
#include <limits>
#include <locale>

#include "surfit/core/atomic_file.h"
#include "surfit/io/g2o.h"

namespace surfit {
namespace {

void WritePose(const Rigid3d& pose, std::ostream& out) {
  for (int i = 0; i < 3; ++i) out << ' ' << pose.translation[i];
  for (int i = 0; i < 4; ++i) out << ' ' << pose.rotation.coeffs()[i];
}

void WriteEdge(const PoseGraph& graph, const PoseGraphEdge& edge, std::ostream& out) {
  out << "EDGE_SE3:QUAT " << graph.poses[edge.b].id << ' ' << graph.poses[edge.a].id;
  WritePose(edge.a_from_b.Inverse(), out);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) out << ' ' << edge.information((i + 3) % 6, (j + 3) % 6);
  }
  out << '\n';
}

}  // namespace

void WriteG2o(const PoseGraph& graph, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.imbue(std::locale::classic());
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (const PoseGraphPose& pose : graph.poses) {
      out << "VERTEX_SE3:QUAT " << pose.id;
      WritePose(pose.world_from_pose, out);
      out << '\n';
    }
    for (const PoseGraphPose& pose : graph.poses) {
      if (pose.fixed) out << "FIX " << pose.id << '\n';
    }
    for (const PoseGraphEdge& edge : graph.edges) WriteEdge(graph, edge, out);
  });
}

}  // namespace surfit
