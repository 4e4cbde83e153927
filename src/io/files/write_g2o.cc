#include <iomanip>
#include <limits>
#include <locale>

#include "io/files/g2o_order.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/io/g2o.h"

namespace surfit {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

void WritePosition(const Eigen::Vector3d& position, int count, std::ostream& out) {
  for (int i = 0; i < count; ++i) out << ' ' << position[i];
}

void WritePose(const Rigid3d& pose, bool planar, std::ostream& out) {
  WritePosition(pose.translation, planar ? 2 : 3, out);
  if (planar) {
    out << ' ' << QuaternionLog<double>(pose.rotation).z();
  } else {
    for (int i = 0; i < 4; ++i) out << ' ' << pose.rotation.coeffs()[i];
  }
}

template <typename Matrix, std::size_t kSize>
void WriteTriangle(const Matrix& information, const int (&order)[kSize], std::size_t size,
                   std::ostream& out) {
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = i; j < size; ++j) out << ' ' << information(order[i], order[j]);
  }
  out << '\n';
}

void WriteInformation(const Matrix6d& information, bool planar, std::ostream& out) {
  planar ? WriteTriangle(information, kPlanarOrder, 3, out)
         : WriteTriangle(information, kPoseOrder, 6, out);
}

void WriteEdge(const PoseGraph& graph, const PoseGraphEdge& edge, std::ostream& out) {
  out << (graph.planar ? "EDGE_SE2 " : "EDGE_SE3:QUAT ") << graph.poses[edge.b].id << ' '
      << graph.poses[edge.a].id;
  WritePose(edge.a_from_b.Inverse(), graph.planar, out);
  WriteInformation(edge.information, graph.planar, out);
}

// Writes each prior of SE(3) with a parameter of its own.
void WritePriors(const PoseGraph& graph, std::ostream& out) {
  std::size_t parameter = 0;
  const auto write_offset = [&](const Rigid3d& pose_from_sensor) {
    out << "PARAMS_SE3OFFSET " << parameter;
    WritePose(pose_from_sensor, false, out);
    out << '\n';
    return parameter++;
  };
  for (const PoseGraphPrior& prior : graph.priors) {
    if (graph.planar) {
      out << "EDGE_PRIOR_SE2 " << graph.poses[prior.pose].id;
      WritePose(prior.world_from_sensor, true, out);
    } else {
      const std::size_t offset = write_offset(prior.pose_from_sensor);
      out << "EDGE_SE3_PRIOR " << graph.poses[prior.pose].id << ' ' << offset;
      WritePose(prior.world_from_sensor, false, out);
    }
    WriteInformation(prior.information, graph.planar, out);
  }
  for (const PoseGraphPosition& position : graph.positions) {
    if (graph.planar) {
      out << "EDGE_PRIOR_SE2_XY " << graph.poses[position.pose].id;
    } else {
      const std::size_t offset =
          write_offset(Rigid3d(Eigen::Quaterniond::Identity(), position.sensor_in_pose));
      out << "EDGE_SE3_XYZPRIOR " << graph.poses[position.pose].id << ' ' << offset;
    }
    const int size = graph.planar ? 2 : 3;
    WritePosition(position.sensor_in_world, size, out);
    WriteTriangle(position.information, kPositionOrder, size, out);
  }
}

// The format has no offset of a sensor in SE(2).
void RequireWritable(const PoseGraph& graph, const std::string& path) {
  if (!graph.planar) return;
  for (const PoseGraphPrior& prior : graph.priors) {
    ThrowIf(!(prior.pose_from_sensor == Rigid3d()), path,
            " cannot hold the sensor offset of a prior in SE(2), must be 0");
  }
  for (const PoseGraphPosition& position : graph.positions) {
    ThrowIf(!position.sensor_in_pose.isZero(0), path,
            " cannot hold the sensor offset of a position in SE(2), must be 0");
  }
}

}  // namespace

void WriteG2o(const PoseGraph& graph, const std::string& path) {
  RequireWritable(graph, path);
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.imbue(std::locale::classic());
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (const PoseGraphPose& pose : graph.poses) {
      out << (graph.planar ? "VERTEX_SE2 " : "VERTEX_SE3:QUAT ") << pose.id;
      WritePose(pose.world_from_pose, graph.planar, out);
      out << '\n';
    }
    for (const PoseGraphPose& pose : graph.poses) {
      if (pose.fixed) out << "FIX " << pose.id << '\n';
    }
    for (const PoseGraphEdge& edge : graph.edges) WriteEdge(graph, edge, out);
    WritePriors(graph, out);
  });
}

}  // namespace surfit
