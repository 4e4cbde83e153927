#include <omp.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/Registration.h>
#include <open3d/pipelines/registration/TransformationEstimation.h>

#include "benchmarks/peers/peer.h"

namespace surfit::testing {
namespace {

namespace o3d = open3d::pipelines::registration;
using Cloud = open3d::geometry::PointCloud;

Cloud ToOpen3d(const PeerCloud& cloud) {
  Cloud result;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    result.points_.push_back(cloud.points[i].cast<double>());
    result.normals_.push_back(cloud.normals[i].cast<double>());
  }
  return result;
}

// The thresholds are absolute: the ratio of source points with a match, and the RMSE in m.
class Open3dPeer final : public Peer {
 public:
  std::string name() const override { return "Open3D"; }

  void SetClouds(const PeerCloud& source, const PeerCloud& target) override {
    source_ = ToOpen3d(source);
    target_ = ToOpen3d(target);
  }

  Eigen::Matrix4d Register(const PeerRules& rules) override {
    omp_set_num_threads(rules.threads);
    o3d::ICPConvergenceCriteria criteria;
    if (!rules.own_criteria) {
      constexpr double kTypicalRmse = 0.01;
      criteria = o3d::ICPConvergenceCriteria(PeerRules::kMinRelativeRmseChange,
                                             PeerRules::kMinRelativeRmseChange * kTypicalRmse,
                                             PeerRules::kMaxIterations);
    }
    return o3d::RegistrationICP(source_, target_, rules.max_distance_m, Eigen::Matrix4d::Identity(),
                                o3d::TransformationEstimationPointToPlane(), criteria)
        .transformation_;
  }

 private:
  Cloud source_, target_;
};

}  // namespace

std::unique_ptr<Peer> MakeOpen3dPeer() { return std::make_unique<Open3dPeer>(); }

}  // namespace surfit::testing
