#include "registration/global/cloud_pair.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr double kGateSpacings = 4;          // distance gate of the finest level
constexpr double kSigmaSpacings = 0.1;       // smallest standard deviation of a point
constexpr double kPointSigmaSpacings = 0.5;  // kSigmaSpacings for residuals with in-plane distances
constexpr double kOnSurfaceCells = 0.35;     // maximum distance from the other surface
constexpr double kPlaneCells = 0.5;          // added distance from a common plane
constexpr double kNearCells = 2.5;           // maximum distance from the other key points
constexpr int kMaxReturnIterations = 50;     // of RegisterAgain()
constexpr double kReturnRmseRatio = 0.01;    // factor of the termination limit of RegisterAgain()
constexpr double kKeyCount = 4000;           // wanted number of key points
constexpr double kLeastKeys = 1500;          // with fewer key points, the cells shrink

PointSet Widened(PointSet set, double least_sigma_m) {
  const auto least = static_cast<float>(least_sigma_m);
  for (float& sigma : set.sigma_m) sigma = std::max(sigma, least);
  return set;
}

bool Measures(const std::string& residual, ResidualType type) {
  return ResidualTypeFromName(residual) == type;
}

}  // namespace

Eigen::Vector3d MeanOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point : points) sum += point.cast<double>();
  return points.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(points.size()));
}

void FaceViewpoint(const Eigen::Vector3d& viewpoint, PointSet* set) {
  for (std::size_t i = 0; i < set->size(); ++i) {
    if (set->normals[i].cast<double>().dot(viewpoint - set->points[i].cast<double>()) < 0) {
      set->normals[i] = -set->normals[i];
    }
  }
}

PointSet PointSetOfKeys(const KeyPoints& keys, double sigma_m) {
  PointSet set;
  set.points = keys.points;
  set.normals = keys.normals;
  set.sigma_m.assign(set.points.size(), static_cast<float>(sigma_m));
  return set;
}

CloudPair::CloudPair(const SensedCloud& source, const SensedCloud& target,
                     const CloudCriteria& criteria, const RegisterCloudsOptions& options)
    : source_(source), target_(target), criteria_(criteria), options_(options) {
  const CloudScale a = MeasureScale(source.points.points), b = MeasureScale(target.points.points);
  spacing_m_ = std::max(a.spacing_m, b.spacing_m);
  noise_m_ = std::max(a.noise_m, b.noise_m);
  const bool in_plane = Measures(options.icp.residual, ResidualType::kPointToPoint);
  const double sigma_m =
      std::max((in_plane ? kPointSigmaSpacings : kSigmaSpacings) * spacing_m_, noise_m_);
  source_.points = Widened(std::move(source_.points), sigma_m);
  target_.points = Widened(std::move(target_.points), sigma_m);
  if (!(options_.icp.gates.max_distance_m > 0)) {
    options_.icp.gates.max_distance_m = kGateSpacings * spacing_m_ + kAgreementSigmas * noise_m_;
  }
  if (!(spacing_m_ > 0)) return;
  // Key points have a uniform density, so that dense regions do not dominate the comparison.
  cell_m_ = CellSize();
  const PointSet from =
      PointSetOfKeys(MakeKeyPoints(source_.points.points, cell_m_, source_.viewpoint), cell_m_);
  const PointSet to =
      PointSetOfKeys(MakeKeyPoints(target_.points.points, cell_m_, target_.viewpoint), cell_m_);
  surface_tolerance_m_ = kOnSurfaceCells * cell_m_ + kAgreementSigmas * noise_m_;
  // Normals of key points face the viewpoints, so two sides of a wall do not agree.
  const ComparisonLimits limits = {kNearCells * cell_m_, surface_tolerance_m_,
                                   source.has_viewpoint && target.has_viewpoint};
  forward_ = std::make_unique<CloudComparison>(from, to, limits);
  backward_ = std::make_unique<CloudComparison>(to, from, limits);
  if (!source.has_viewpoint || !target.has_viewpoint) return;
  source_ranges_.emplace(source_.points.points, source_.viewpoint, a.spacing_m);
  target_ranges_.emplace(target_.points.points, target_.viewpoint, b.spacing_m);
}

// Normals with an arbitrary sign face the viewpoint of the target at the initial pose.
IcpResult CloudPair::Register(const PointSet& source, const Eigen::Vector3d& viewpoint_in_target,
                              const PointSet& target, const Rigid3d& start,
                              const RegisterCloudsOptions& options) const {
  if (source_.has_signed_normals && target_.has_signed_normals) {
    return RegisterClouds(source, target, start, options);
  }
  PointSet from = source, to = target;
  FaceViewpoint(viewpoint_in_target, &to);
  FaceViewpoint(start.Inverse() * viewpoint_in_target, &from);
  return RegisterClouds(from, to, start, options);
}

IcpResult CloudPair::Register(const Rigid3d& start, int levels) const {
  RegisterCloudsOptions options = options_;
  options.levels = levels;
  return Register(source_.points, target_.viewpoint, target_.points, start, options);
}

IcpResult CloudPair::RegisterAgain(const Rigid3d& start) const {
  RegisterCloudsOptions options = options_;
  options.levels = 1;
  options.icp.min_inlier_ratio = 0;
  options.icp.max_iterations = std::max(options.icp.max_iterations, kMaxReturnIterations);
  options.icp.min_relative_rmse_change *= kReturnRmseRatio;
  options.icp.stop_at_rmse_increase = false;
  return Register(source_.points, target_.viewpoint, target_.points, start, options);
}

IcpResult CloudPair::RegisterReverse(const Rigid3d& start, int levels) const {
  RegisterCloudsOptions options = options_;
  options.levels = levels;
  options.icp.min_inlier_ratio = 0;
  return Register(target_.points, source_.viewpoint, source_.points, start.Inverse(), options);
}

double CloudPair::KeyScore(const Rigid3d& pose) const {
  const CloudAgreement a = Forward(pose), b = Backward(pose);
  const double inliers = std::min(a.inlier_ratio, b.inlier_ratio);
  return std::max(a.overlap_ratio, b.overlap_ratio) * inliers * inliers;
}

std::optional<double> CloudPair::ViolationRatio(const Rigid3d& pose) const {
  if (!source_ranges_ || !target_ranges_) return std::nullopt;
  const auto [forward, backward] = StructureAt(pose);
  return std::max(
      {target_ranges_->ViolationRatio(source_.points.points, pose, RangeTolerance()),
       source_ranges_->ViolationRatio(target_.points.points, pose.Inverse(), RangeTolerance()),
       forward.ViolationRatio(), backward.ViolationRatio()});
}

int CloudPair::CountOffPlanes(const Rigid3d& pose) const {
  return std::min(CountOffTwoPlanes(forward_->PointsAt(pose), PlaneTolerance()),
                  CountOffTwoPlanes(backward_->PointsAt(pose.Inverse()), PlaneTolerance()));
}

double CloudPair::PlaneTolerance() const { return surface_tolerance_m_ + kPlaneCells * cell_m_; }

double CloudPair::RangeTolerance() const { return 2 * spacing_m_ + kAgreementSigmas * noise_m_; }

std::array<StructureCounts, 2> CloudPair::StructureAt(const Rigid3d& pose) const {
  return {
      CountStructure(forward_->PointsAt(pose), *target_ranges_, PlaneTolerance(), RangeTolerance()),
      CountStructure(backward_->PointsAt(pose.Inverse()), *source_ranges_, PlaneTolerance(),
                     RangeTolerance())};
}

double CloudPair::CellSize() const {
  const auto count_of = [](const PointSet& set, double cell_m) {
    return static_cast<double>(VoxelCentroids(set.points, cell_m).size());
  };
  const double most = static_cast<double>(std::max(source_.points.size(), target_.points.size()));
  double cell_m = spacing_m_ * std::max(1., std::sqrt(most / kKeyCount));
  while (cell_m > 1.2 * spacing_m_ && std::max(count_of(source_.points, cell_m),
                                               count_of(target_.points, cell_m)) < kLeastKeys) {
    cell_m *= 0.8;
  }
  while (std::max(count_of(source_.points, cell_m), count_of(target_.points, cell_m)) >
         1.5 * kKeyCount) {
    cell_m *= 1.25;
  }
  return cell_m;
}

std::array<CloudPair::ViewpointPair, 2> CloudPair::Viewpoints() const {
  return {{{source_.viewpoint, target_.viewpoint},
           {MeanOf(source_.points.points), MeanOf(target_.points.points)}}};
}

}  // namespace surfit
