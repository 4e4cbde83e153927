#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "registration/global/cloud_features.h"
#include "registration/global/cloud_fit.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {
namespace {

constexpr double kGateSpacings = 4;          // distance gate of the finest level
constexpr double kSigmaSpacings = 0.1;       // smallest standard deviation of a point
constexpr double kPointSigmaSpacings = 0.5;  // kSigmaSpacings for residuals with in-plane distances
constexpr double kNoiseSigmas = 3;
constexpr double kOnSurfaceCells = 0.35;  // maximum distance from the other surface
constexpr double kNearCells = 2.5;        // maximum distance from the other key points

constexpr double kKeyCount = 4000;   // wanted number of key points
constexpr double kLeastKeys = 1500;  // with fewer key points, the cells shrink
constexpr double kFpfhCells = 5;     // radius of the histograms, in cells
constexpr double kKeyToleranceCells = 1.5;
constexpr double kKeySigmaCells = 0.2;
constexpr int kMaxKeyMatches = 3000;
constexpr int kMaxHypotheses = 60;
constexpr std::size_t kRegisteredHypotheses = 12;

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

PointSet Widened(PointSet set, double least_sigma_m) {
  const auto least = static_cast<float>(least_sigma_m);
  for (float& sigma : set.sigma_m) sigma = std::max(sigma, least);
  return set;
}

PointSet PointSetOfKeys(const KeyPoints& keys, double sigma_m) {
  PointSet set;
  set.points = keys.points;
  set.normals = keys.normals;
  set.sigma_m.assign(set.points.size(), static_cast<float>(sigma_m));
  return set;
}

bool Measures(const std::string& residual, ResidualType type) {
  return ResidualTypeFromName(residual) == type;
}

struct ScoredKeyPose {
  Rigid3d target_from_source;
  double score = 0;
};

double MaxDisagreement(const CloudRegistration& result, const CloudCriteria& criteria) {
  return criteria.max_disagreement_spacings * result.spacing_m + kNoiseSigmas * result.sigma_m;
}

class CloudRegistrar {
 public:
  CloudRegistrar(const SensedCloud& source, const SensedCloud& target,
                 const CloudStartOptions& start, const RegisterCloudsOptions& options)
      : source_(source), target_(target), criteria_(start.criteria), options_(options) {
    const CloudScale a = MeasureScale(source.points.points), b = MeasureScale(target.points.points);
    spacing_m_ = std::max(a.spacing_m, b.spacing_m);
    noise_m_ = std::max(a.noise_m, b.noise_m);
    const bool in_plane = Measures(options.icp.residual, ResidualType::kPointToPoint);
    const double sigma_m =
        std::max((in_plane ? kPointSigmaSpacings : kSigmaSpacings) * spacing_m_, noise_m_);
    source_.points = Widened(std::move(source_.points), sigma_m);
    target_.points = Widened(std::move(target_.points), sigma_m);
    if (!(options_.icp.gates.max_distance_m > 0)) {
      options_.icp.gates.max_distance_m = kGateSpacings * spacing_m_ + kNoiseSigmas * noise_m_;
    }
    if (!(spacing_m_ > 0)) return;
    // Key points have a uniform density, so that dense regions do not dominate the comparison.
    cell_m_ = CellSize();
    const PointSet from =
        PointSetOfKeys(MakeKeyPoints(source_.points.points, cell_m_, source_.viewpoint), cell_m_);
    const PointSet to =
        PointSetOfKeys(MakeKeyPoints(target_.points.points, cell_m_, target_.viewpoint), cell_m_);
    const double tolerance_m = kOnSurfaceCells * cell_m_ + kNoiseSigmas * noise_m_;
    forward_ = std::make_unique<CloudComparison>(from, to, kNearCells * cell_m_, tolerance_m);
    backward_ = std::make_unique<CloudComparison>(to, from, kNearCells * cell_m_, tolerance_m);
    if (!source.has_viewpoint || !target.has_viewpoint) return;
    source_ranges_.emplace(source_.points.points, source_.viewpoint, a.spacing_m);
    target_ranges_.emplace(target_.points.points, target_.viewpoint, b.spacing_m);
  }

  CloudRegistration From(const Rigid3d& start, const std::string& name) const {
    CloudRegistration result = Empty(name);
    if (!(spacing_m_ > 0)) return result;
    result.icp = Register(start, options_.levels);
    result.reason = Verify(start, options_.levels, &result);
    CompareWithMatches(&result);
    return result;
  }

  // Registers from matches of local shapes. The signs of the normals follow from the viewpoints,
  // or from the centres of the clouds if that fails: the viewpoint can be unknown.
  CloudRegistration FromMatches() const {
    CloudRegistration best = Empty("global");
    if (!(spacing_m_ > 0)) return best;
    for (const auto& [from, to] : Viewpoints()) {
      CloudRegistration result = FromMatches(from, to);
      if (result.accepted()) return result;
      if (Score(result) >= Score(best)) best = std::move(result);
    }
    return best;
  }

  static double Score(const CloudRegistration& result) {
    return result.overlap_ratio * result.inlier_ratio * result.inlier_ratio;
  }

 private:
  CloudRegistration Empty(const std::string& name) const {
    CloudRegistration result;
    result.start = name;
    result.spacing_m = spacing_m_;
    result.noise_m = noise_m_;
    return result;
  }

  // Normals with an arbitrary sign face the viewpoint of the target at the initial pose.
  IcpResult Register(const PointSet& source, const Eigen::Vector3d& viewpoint_in_target,
                     const PointSet& target, const Rigid3d& start, int levels) const {
    RegisterCloudsOptions options = options_;
    options.levels = levels;
    if (source_.has_signed_normals && target_.has_signed_normals) {
      return RegisterClouds(source, target, start, options);
    }
    PointSet from = source, to = target;
    FaceViewpoint(viewpoint_in_target, &to);
    FaceViewpoint(start.Inverse() * viewpoint_in_target, &from);
    return RegisterClouds(from, to, start, options);
  }

  IcpResult Register(const Rigid3d& start, int levels) const {
    return Register(source_.points, target_.viewpoint, target_.points, start, levels);
  }

  GlobalRegistrationReason Verify(const Rigid3d& start, int levels,
                                  CloudRegistration* result) const {
    IcpResult& icp = result->icp;
    const Rigid3d& pose = icp.target_from_source;
    const CloudAgreement there = forward_->At(pose), back = backward_->At(pose.Inverse());
    result->overlap_ratio = std::max(there.overlap_ratio, back.overlap_ratio);
    result->inlier_ratio = std::min(there.inlier_ratio, back.inlier_ratio);
    if (icp.termination == Termination::kSingularSystem)
      return GlobalRegistrationReason::kDegenerate;
    if (!icp.Succeeded()) return GlobalRegistrationReason::kNotRegistered;
    result->free_space_violation_ratio = ViolationRatio(pose);
    if (result->overlap_ratio < criteria_.min_overlap_ratio)
      return GlobalRegistrationReason::kLittleOverlap;
    if (result->inlier_ratio < criteria_.min_inlier_ratio)
      return GlobalRegistrationReason::kPoorFit;
    if (result->free_space_violation_ratio.value_or(0) > criteria_.max_free_space_violation_ratio)
      return GlobalRegistrationReason::kFreeSpaceViolation;
    if (!IsCertain(result)) return GlobalRegistrationReason::kDegenerate;
    const IcpResult reverse =
        Register(target_.points, source_.viewpoint, source_.points, start.Inverse(), levels);
    result->disagreement_m = reverse.Succeeded()
                                 ? forward_->Distance(pose, reverse.target_from_source.Inverse())
                                 : std::numeric_limits<double>::infinity();
    return result->disagreement_m > MaxDisagreement(*result, criteria_)
               ? GlobalRegistrationReason::kInconsistent
               : GlobalRegistrationReason::kAccepted;
  }

  // Searches other poses by matches, for the score margin. A large overlap with few deviations is
  // unique without this search.
  void CompareWithMatches(CloudRegistration* result) const {
    constexpr double kUniqueOverlap = 0.5, kUniqueInliers = 0.85;
    if (!result->accepted()) return;
    if (result->overlap_ratio >= kUniqueOverlap && result->inlier_ratio >= kUniqueInliers) return;
    const Rigid3d& pose = result->icp.target_from_source;
    result->score_margin = 1;
    for (const auto& [from, to] : Viewpoints()) {
      SetScoreMargin(KeyPosesFrom(from, to), pose, KeyScore(pose), result);
    }
  }

  std::optional<double> ViolationRatio(const Rigid3d& pose) const {
    if (!source_ranges_ || !target_ranges_) return std::nullopt;
    const double tolerance_m = 2 * spacing_m_ + kNoiseSigmas * noise_m_;
    return std::max(
        target_ranges_->ViolationRatio(source_.points.points, pose, tolerance_m),
        source_ranges_->ViolationRatio(target_.points.points, pose.Inverse(), tolerance_m));
  }

  // Returns whether the surfaces determine the pose. Directions are certain with a small standard
  // deviation. ReturnDistance() tests the other directions. `degenerate_directions` of ICP
  // gets the directions that are not determined.
  bool IsCertain(CloudRegistration* result) const {
    IcpResult& icp = result->icp;
    std::vector<Vector6d> uncertain;
    std::swap(uncertain, icp.degenerate_directions);
    const bool has_directions = icp.covariance || !uncertain.empty();
    if (icp.covariance) result->sigma_m = LargestSigma(icp, &uncertain);
    for (const Vector6d& direction : uncertain) {
      const double distance_m = ReturnDistance(direction, icp.target_from_source);
      result->sigma_m = std::max(result->sigma_m, distance_m);
      if (distance_m > criteria_.max_disagreement_spacings * spacing_m_) {
        icp.degenerate_directions.push_back(direction);
      }
    }
    if (!has_directions) result->sigma_m = std::numeric_limits<double>::infinity();
    return has_directions && icp.degenerate_directions.empty();
  }

  // Standard deviation of the source points along the least certain direction. Appends the
  // directions with a standard deviation above the limit.
  double LargestSigma(const IcpResult& icp, std::vector<Vector6d>* uncertain) const {
    // Motions about the centre of the source, scaled so that they move the points by about 1 m.
    const Eigen::Vector3d center = icp.target_from_source * MeanOf(source_.points.points);
    double radius2 = 0;
    for (const Eigen::Vector3f& point : source_.points.points) {
      radius2 += (icp.target_from_source * point.cast<double>() - center).squaredNorm();
    }
    radius2 /= static_cast<double>(std::max<std::size_t>(1, source_.points.size()));
    Matrix6d to_center = Matrix6d::Identity();  // (w, v) -> (|radius| w, motion of the centre)
    to_center.topLeftCorner<3, 3>() *= std::sqrt(radius2);
    to_center.bottomLeftCorner<3, 3>() = -CrossMatrix<double>(center);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(to_center * *icp.covariance *
                                                        to_center.transpose());
    const double limit_m = criteria_.max_sigma_spacings * spacing_m_;
    const Matrix6d from_center = to_center.inverse();
    for (int i = 5; i >= 0 && eigen.eigenvalues()[i] > limit_m * limit_m; --i) {
      uncertain->emplace_back(from_center * eigen.eigenvectors().col(i));
    }
    return std::sqrt(std::max(0., eigen.eigenvalues()[5]));
  }

  // Moves the points by half the distance gate along both senses of a direction, and runs ICP.
  // Returns the largest distance of the results from the pose. Surfaces that determine the
  // direction pull the points back. Points that slide along surfaces stay away. A local slope of
  // the cost does not show this: it depends on the sampling of the surfaces. Infinite if ICP fails.
  double ReturnDistance(const Vector6d& direction, const Rigid3d& pose) const {
    constexpr double kSmallMotion = 1e-3;  // of motions of the points by about 1 m
    constexpr double kGateRatio = 0.5;     // correct correspondences remain within the gate
    const Vector6d unit = direction.normalized();
    const double change_m =
        forward_->Distance(LeftIncrement<double>(kSmallMotion * unit, pose), pose) / kSmallMotion;
    if (!(change_m > 0)) return std::numeric_limits<double>::infinity();
    double largest_m = 0;
    for (const double sign : {-1., 1.}) {
      const Vector6d motion =
          sign * kGateRatio * options_.icp.gates.max_distance_m / change_m * unit;
      const IcpResult moved = Register(LeftIncrement<double>(motion, pose), 1);
      if (!moved.Succeeded()) return std::numeric_limits<double>::infinity();
      largest_m = std::max(largest_m, forward_->Distance(moved.target_from_source, pose));
    }
    return largest_m;
  }

  double CellSize() const {
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

  using ViewpointPair = std::pair<Eigen::Vector3d, Eigen::Vector3d>;
  std::array<ViewpointPair, 2> Viewpoints() const {
    return {{{source_.viewpoint, target_.viewpoint},
             {MeanOf(source_.points.points), MeanOf(target_.points.points)}}};
  }

  std::vector<ScoredKeyPose> KeyPosesFrom(const Eigen::Vector3d& source_viewpoint,
                                          const Eigen::Vector3d& target_viewpoint) const {
    const KeyPoints source = MakeKeyPoints(source_.points.points, cell_m_, source_viewpoint);
    const KeyPoints target = MakeKeyPoints(target_.points.points, cell_m_, target_viewpoint);
    const std::vector<KeyMatch> matches =
        MatchFpfh(FindFpfh(source, kFpfhCells * cell_m_), FindFpfh(target, kFpfhCells * cell_m_),
                  kMaxKeyMatches);
    const std::vector<KeyConsensus> hypotheses =
        FindKeyConsensus(source, target, matches, kKeyToleranceCells * cell_m_, kMaxHypotheses);
    return RegisterKeys(source, target, hypotheses);
  }

  CloudRegistration FromMatches(const Eigen::Vector3d& source_viewpoint,
                                const Eigen::Vector3d& target_viewpoint) const {
    const std::vector<ScoredKeyPose> poses = KeyPosesFrom(source_viewpoint, target_viewpoint);
    CloudRegistration result = Empty("global");
    if (poses.empty()) return result;
    const Rigid3d& start = poses.front().target_from_source;
    const int levels = std::min(2, options_.levels);
    result.icp = Register(start, levels);
    result.reason = Verify(start, levels, &result);
    result.score_margin = 1;
    SetScoreMargin(poses, start, poses.front().score, &result);
    return result;
  }

  // Compares the score of a pose with the other poses.
  void SetScoreMargin(const std::vector<ScoredKeyPose>& poses, const Rigid3d& pose, double score,
                      CloudRegistration* result) const {
    constexpr double kDistinctCells = 4;
    double rival = 0;
    for (const ScoredKeyPose& other : poses) {
      if (forward_->Distance(other.target_from_source, pose) < kDistinctCells * cell_m_) continue;
      rival = std::max(rival, other.score);
    }
    result->score_margin = std::min(result->score_margin, score > 0 ? 1 - rival / score : 0);
    if (result->accepted() && result->score_margin < criteria_.min_score_margin) {
      result->reason = GlobalRegistrationReason::kAmbiguous;
    }
  }

  double KeyScore(const Rigid3d& pose) const {
    const CloudAgreement a = forward_->At(pose), b = backward_->At(pose.Inverse());
    const double inliers = std::min(a.inlier_ratio, b.inlier_ratio);
    return std::max(a.overlap_ratio, b.overlap_ratio) * inliers * inliers;
  }

  // Registers the key points from the best hypotheses. Returns the poses without too many
  // free-space violations, best first.
  std::vector<ScoredKeyPose> RegisterKeys(const KeyPoints& source, const KeyPoints& target,
                                          const std::vector<KeyConsensus>& hypotheses) const {
    const double cell_m = cell_m_;
    const PointSet from = PointSetOfKeys(source, kKeySigmaCells * cell_m);
    const PointSet to = PointSetOfKeys(target, kKeySigmaCells * cell_m);
    std::vector<ScoredKeyPose> poses;
    poses.reserve(hypotheses.size());
    for (const KeyConsensus& hypothesis : hypotheses) {
      poses.push_back({hypothesis.target_from_source, KeyScore(hypothesis.target_from_source)});
    }
    const auto sort = [&] {
      std::stable_sort(poses.begin(), poses.end(),
                       [](const auto& a, const auto& b) { return a.score > b.score; });
    };
    sort();
    if (poses.size() > kRegisteredHypotheses) poses.resize(kRegisteredHypotheses);
    RegisterCloudsOptions options;
    options.levels = 2;
    options.icp.gates = {2 * cell_m, 0.8};
    options.icp.error_model.floor_sigma_m = kKeySigmaCells * cell_m;
    options.icp.min_inliers = 20;
    options.icp.min_inlier_ratio = 0.01;
    std::vector<ScoredKeyPose> registered;
    for (const ScoredKeyPose& pose : poses) {
      PointSet turned = from, facing = to;
      FaceViewpoint(target_.viewpoint, &facing);
      FaceViewpoint(pose.target_from_source.Inverse() * target_.viewpoint, &turned);
      const IcpResult icp = RegisterClouds(turned, facing, pose.target_from_source, options);
      const Rigid3d found = icp.Succeeded() ? icp.target_from_source : pose.target_from_source;
      const double violations = ViolationRatio(found).value_or(0);
      if (violations > 2 * criteria_.max_free_space_violation_ratio) continue;
      registered.push_back({found, KeyScore(found)});
    }
    poses = std::move(registered);
    sort();
    return poses;
  }

  SensedCloud source_, target_;
  const CloudCriteria& criteria_;
  RegisterCloudsOptions options_;
  double spacing_m_ = 0, noise_m_ = 0, cell_m_ = 0;
  std::unique_ptr<CloudComparison> forward_, backward_;
  std::optional<RangeImage> source_ranges_, target_ranges_;
};

}  // namespace

std::vector<std::string> CloudStartNames() { return {"identity", "file", "global", "auto"}; }

CloudRegistration RegisterCloudsFrom(const SensedCloud& source, const SensedCloud& target,
                                     const std::optional<Rigid3d>& given,
                                     const CloudStartOptions& start,
                                     const RegisterCloudsOptions& options) {
  Validate(start);
  Validate(options);
  ThrowIf(start.method == "file" && !given, "start is 'file', but there is no initial pose");
  const CloudRegistrar registrar(source, target, start, options);
  if (start.method == "global") return registrar.FromMatches();
  const bool uses_given = given && start.method != "identity";
  CloudRegistration result =
      registrar.From(uses_given ? *given : Rigid3d(), uses_given ? "file" : "identity");
  if (start.method != "auto" || result.accepted()) return result;
  CloudRegistration global = registrar.FromMatches();
  const bool is_better = CloudRegistrar::Score(global) > CloudRegistrar::Score(result);
  return global.accepted() || is_better ? global : result;
}

std::string ViolatedCriterion(const CloudRegistration& r, const CloudCriteria& criteria) {
  const auto at_least = [](const char* what, double value, double least) {
    return Concat(what, " is ", value, ", must be at least ", least);
  };
  const auto at_most = [](const char* what, double value, double most) {
    return Concat(what, " is ", value, ", must be at most ", most);
  };
  switch (r.reason) {
    case GlobalRegistrationReason::kNoStart:
      return "no pose agrees with matches of local shapes";
    case GlobalRegistrationReason::kNotRegistered:
      return Concat("ICP failed (", ToString(r.icp.termination), ") with an inlier ratio of ",
                    r.icp.inlier_ratio);
    case GlobalRegistrationReason::kDegenerate:
      if (r.icp.degenerate_directions.empty()) {
        return "there are too few separate surface regions to determine the pose";
      }
      return Concat("the surfaces do not constrain ", r.icp.degenerate_directions.size(),
                    " direction(s) of motion: ICP from displaced poses must return within ",
                    criteria.max_disagreement_spacings * r.spacing_m, " m");
    case GlobalRegistrationReason::kLittleOverlap:
      return at_least("overlap ratio", r.overlap_ratio, criteria.min_overlap_ratio);
    case GlobalRegistrationReason::kPoorFit:
      return at_least("ratio of points on the other surface to points near it", r.inlier_ratio,
                      criteria.min_inlier_ratio);
    case GlobalRegistrationReason::kFreeSpaceViolation:
      return at_most("ratio of free-space violations", r.free_space_violation_ratio.value_or(0),
                     criteria.max_free_space_violation_ratio);
    case GlobalRegistrationReason::kAmbiguous:
      return at_least("score margin over other poses", r.score_margin, criteria.min_score_margin);
    case GlobalRegistrationReason::kInconsistent:
      return at_most("distance of points after forward and backward registration in m",
                     r.disagreement_m, MaxDisagreement(r, criteria));
    case GlobalRegistrationReason::kNoView:
    case GlobalRegistrationReason::kLooksDifferent:
    case GlobalRegistrationReason::kAccepted:
      break;
  }
  return "";
}

}  // namespace surfit
