#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "registration/global/cloud_features.h"
#include "registration/global/cloud_fit.h"
#include "registration/global/common_planes.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {

// Standard deviations within which a measured distance agrees.
inline constexpr double kAgreementSigmas = 3;

// Mean of the points; zero without points.
Eigen::Vector3d MeanOf(const std::vector<Eigen::Vector3f>& points);

// Turns the normals of a cloud towards a viewpoint.
void FaceViewpoint(const Eigen::Vector3d& viewpoint, PointSet* set);

// Points and normals of key points, with a standard deviation.
PointSet PointSetOfKeys(const KeyPoints& keys, double sigma_m);

// Two clouds for RegisterCloudsFrom(), with their measured spacing and noise. Poses are
// target_from_source. Thread-safe after construction.
class CloudPair {
 public:
  // Keeps a reference to the criteria. With a distance gate of 0, the gate follows from spacing and
  // noise.
  CloudPair(const SensedCloud& source, const SensedCloud& target, const CloudCriteria& criteria,
            const RegisterCloudsOptions& options);

  // True if the spacing is unknown. Only scales are then valid.
  bool IsEmpty() const { return !(spacing_m_ > 0); }
  const SensedCloud& source() const { return source_; }
  const SensedCloud& target() const { return target_; }
  const CloudCriteria& criteria() const { return criteria_; }
  const RegisterCloudsOptions& options() const { return options_; }
  double spacing_m() const { return spacing_m_; }
  double noise_m() const { return noise_m_; }
  // Size of the cells that give about 4,000 key points.
  double cell_m() const { return cell_m_; }

  // Runs ICP from a pose, on the given number of levels.
  IcpResult Register(const Rigid3d& start, int levels) const;
  // Runs ICP on the finest level from a pose near a verified pose. It converges further than
  // Register(). IcpOptions::min_inlier_ratio has no effect, because the overlap is verified.
  IcpResult RegisterAgain(const Rigid3d& start) const;
  // Runs ICP from the target to the source, for a verified pose. The result has the pose
  // source_from_target. IcpOptions::min_inlier_ratio has no effect.
  IcpResult RegisterReverse(const Rigid3d& start, int levels) const;

  // Agreement of the key points at a pose, of the source with the target and vice versa.
  CloudAgreement Forward(const Rigid3d& pose) const { return forward_->At(pose); }
  CloudAgreement Backward(const Rigid3d& pose) const { return backward_->At(pose.Inverse()); }
  // Distance of the source points between two poses, m. See CloudComparison::Distance().
  double Distance(const Rigid3d& a, const Rigid3d& b) const { return forward_->Distance(a, b); }
  // Overlap times the squared ratio of inliers of the key points.
  double KeyScore(const Rigid3d& pose) const;
  // Larger ratio of free-space violations of both directions, of all points and of the key points
  // off the common planes. std::nullopt without viewpoints.
  std::optional<double> ViolationRatio(const Rigid3d& pose) const;
  // Smaller CountOffTwoPlanes() of both directions, of key points.
  int CountOffPlanes(const Rigid3d& pose) const;

  // Viewpoints of source and target that decide the signs of normals: those of the sensors, and the
  // centres of the clouds.
  using ViewpointPair = std::pair<Eigen::Vector3d, Eigen::Vector3d>;
  std::array<ViewpointPair, 2> Viewpoints() const;

 private:
  double CellSize() const;
  double PlaneTolerance() const;
  double RangeTolerance() const;
  // Structure of the source in the image of the target, and vice versa. Requires viewpoints.
  std::array<StructureCounts, 2> StructureAt(const Rigid3d& pose) const;
  IcpResult Register(const PointSet& source, const Eigen::Vector3d& viewpoint_in_target,
                     const PointSet& target, const Rigid3d& start,
                     const RegisterCloudsOptions& options) const;

  SensedCloud source_, target_;
  const CloudCriteria& criteria_;
  RegisterCloudsOptions options_;
  double spacing_m_ = 0, noise_m_ = 0, cell_m_ = 0;
  double surface_tolerance_m_ = 0;  // of key points
  std::unique_ptr<CloudComparison> forward_, backward_;
  std::optional<RangeImage> source_ranges_, target_ranges_;
};

}  // namespace surfit
