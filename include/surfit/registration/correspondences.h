#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace surfit {

// Matched points of two surfaces as structure of arrays, all of size(): a source point p' already
// moved into the target's camera frame, the target point q, its unit normal n, and the weight
// (1/m^2) of the residual n . (p' - q).
struct Correspondences {
  std::vector<double> px, py, pz;
  std::vector<double> qx, qy, qz;
  std::vector<double> nx, ny, nz;
  std::vector<double> weight;
  int inlier_count = 0;  // pairs whose residual is within ErrorModel::kInlierSigmas

  std::size_t size() const { return weight.size(); }
  void Add(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& n, double w) {
    px.push_back(p.x()), py.push_back(p.y()), pz.push_back(p.z());
    qx.push_back(q.x()), qy.push_back(q.y()), qz.push_back(q.z());
    nx.push_back(n.x()), ny.push_back(n.y()), nz.push_back(n.z());
    weight.push_back(w);
  }
};

}  // namespace surfit
