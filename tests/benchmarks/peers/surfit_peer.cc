#include "benchmarks/peers/peer.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/register_clouds.h"

namespace surfit::testing {
namespace {

PointSet ToSurfit(const PeerCloud& cloud, double sigma_m) {
  PointSet set{cloud.points, cloud.normals, {}};
  set.sigma_m.assign(set.size(), static_cast<float>(sigma_m));
  return set;
}

// One sigma for all points, because the peers do not use a sensor model. The common criteria also
// match the peers: least squares over all points, for all normals, on one level.
class SurfitPeer final : public Peer {
 public:
  std::string name() const override { return "Surfit"; }

  void SetClouds(const PeerCloud& source, const PeerCloud& target) override {
    source_ = ToSurfit(source, kSigma_m);
    target_ = ToSurfit(target, kSigma_m);
  }

  Eigen::Matrix4d Register(const PeerRules& rules) override {
    const ThreadLimit limit(rules.threads);
    RegisterCloudsOptions options;
    options.icp.gates.max_distance_m = rules.max_distance_m;
    if (!rules.own_criteria) {
      options.levels = 1;
      options.icp.gates.max_normal_angle_rad = 0;
      options.icp.error_model.kernel.type = RobustKernelType::kNone;
      options.icp.stop_at_rmse_increase = false;
      options.icp.max_iterations = PeerRules::kMaxIterations;
      options.icp.min_relative_rmse_change = PeerRules::kMinRelativeRmseChange;
    }
    return RegisterClouds(source_, target_, Rigid3d(), options).target_from_source.Matrix();
  }

 private:
  static constexpr double kSigma_m = 0.01;

  PointSet source_, target_;
};

}  // namespace

std::unique_ptr<Peer> MakeSurfitPeer() { return std::make_unique<SurfitPeer>(); }

}  // namespace surfit::testing
