#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include "benchmarks/peers/peer.h"

namespace surfit::testing {
namespace {

using Cloud = pcl::PointCloud<pcl::PointNormal>;

Cloud::Ptr ToPcl(const PeerCloud& cloud) {
  auto result = pcl::make_shared<Cloud>();
  result->reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    pcl::PointNormal point;
    point.getVector3fMap() = cloud.points[i];
    point.getNormalVector3fMap() = cloud.normals[i];
    result->push_back(point);
  }
  return result;
}

// PCL uses one thread only, for all settings. Its default is ten iterations.
class PclPeer final : public Peer {
 public:
  std::string name() const override { return "PCL"; }

  void SetClouds(const PeerCloud& source, const PeerCloud& target) override {
    source_ = ToPcl(source);
    target_ = ToPcl(target);
  }

  Eigen::Matrix4d Register(const PeerRules& rules) override {
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
    icp.setInputSource(source_);
    icp.setInputTarget(target_);
    icp.setMaxCorrespondenceDistance(rules.max_distance_m);
    if (!rules.own_criteria) {
      icp.setMaximumIterations(PeerRules::kMaxIterations);
      // of the mean square
      icp.setEuclideanFitnessEpsilon(2 * PeerRules::kMinRelativeRmseChange);
    }
    Cloud aligned;
    icp.align(aligned);
    return icp.getFinalTransformation().cast<double>();
  }

 private:
  Cloud::Ptr source_, target_;
};

}  // namespace

std::unique_ptr<Peer> MakePclPeer() { return std::make_unique<PclPeer>(); }

}  // namespace surfit::testing
