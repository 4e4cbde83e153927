#include <algorithm>
#include <limits>
#include <utility>

#include "registration/global/cloud_pair.h"
#include "registration/global/key_poses.h"
#include "registration/global/pose_certainty.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {
namespace {

double MaxDisagreement(const CloudRegistration& result, const CloudCriteria& criteria) {
  return criteria.max_disagreement_spacings * result.spacing_m + kAgreementSigmas * result.sigma_m;
}

class CloudRegistrar {
 public:
  explicit CloudRegistrar(const CloudPair& pair) : pair_(pair) {}

  CloudRegistration From(const Rigid3d& start, const std::string& name) const {
    CloudRegistration result = Empty(name);
    if (pair_.IsEmpty()) return result;
    result.icp = pair_.Register(start, pair_.options().levels);
    result.reason = Verify(start, pair_.options().levels, &result);
    CompareWithMatches(&result);
    return result;
  }

  // Registers from matches of local shapes. The signs of the normals follow from the viewpoints,
  // or from the centres of the clouds if that fails: the viewpoint can be unknown.
  CloudRegistration FromMatches() const {
    CloudRegistration best = Empty("global");
    if (pair_.IsEmpty()) return best;
    for (const CloudPair::ViewpointPair& viewpoints : pair_.Viewpoints()) {
      CloudRegistration result = FromMatches(viewpoints);
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
    result.spacing_m = pair_.spacing_m();
    result.noise_m = pair_.noise_m();
    return result;
  }

  GlobalRegistrationReason Verify(const Rigid3d& start, int levels,
                                  CloudRegistration* result) const {
    IcpResult& icp = result->icp;
    const Rigid3d& pose = icp.target_from_source;
    const CloudAgreement there = pair_.Forward(pose), back = pair_.Backward(pose);
    result->overlap_ratio = std::max(there.overlap_ratio, back.overlap_ratio);
    result->inlier_ratio = std::min(there.inlier_ratio, back.inlier_ratio);
    if (icp.termination == Termination::kSingularSystem)
      return GlobalRegistrationReason::kDegenerate;
    if (!icp.Succeeded()) return GlobalRegistrationReason::kNotRegistered;
    result->free_space_violation_ratio = pair_.ViolationRatio(pose);
    if (result->overlap_ratio < pair_.criteria().min_overlap_ratio)
      return GlobalRegistrationReason::kLittleOverlap;
    if (result->inlier_ratio < pair_.criteria().min_inlier_ratio)
      return GlobalRegistrationReason::kPoorFit;
    if (result->free_space_violation_ratio.value_or(0) >
        pair_.criteria().max_free_space_violation_ratio)
      return GlobalRegistrationReason::kFreeSpaceViolation;
    if (!IsCertain(pair_, result)) return GlobalRegistrationReason::kDegenerate;
    const IcpResult reverse = pair_.RegisterReverse(start, levels);
    result->disagreement_m = reverse.Succeeded()
                                 ? pair_.Distance(pose, reverse.target_from_source.Inverse())
                                 : std::numeric_limits<double>::infinity();
    return result->disagreement_m > MaxDisagreement(*result, pair_.criteria())
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
    for (const CloudPair::ViewpointPair& viewpoints : pair_.Viewpoints()) {
      SetScoreMargin(FindKeyPoses(pair_, viewpoints), pose, pair_.KeyScore(pose), result);
    }
  }

  // Registers from the best poses. Free-space violations refute a pose, so the next pose follows.
  CloudRegistration FromMatches(const CloudPair::ViewpointPair& viewpoints) const {
    constexpr int kMaxRefuted = 4;
    std::vector<ScoredKeyPose> poses = FindKeyPoses(pair_, viewpoints);
    CloudRegistration best = Empty("global");
    for (int refuted = 0; refuted < kMaxRefuted && !poses.empty(); ++refuted) {
      CloudRegistration result = FromKeyPoses(poses);
      if (result.reason != GlobalRegistrationReason::kFreeSpaceViolation) return result;
      const Rigid3d start = poses.front().target_from_source;
      poses.erase(std::remove_if(poses.begin(), poses.end(),
                                 [&](const ScoredKeyPose& pose) {
                                   return !IsRival(pose.target_from_source, start);
                                 }),
                  poses.end());
      if (Score(result) >= Score(best)) best = std::move(result);
    }
    return best;
  }

  // Registers from the first pose. A pose that hangs on a few points beside two planes can be an
  // accident, because the search compares many poses.
  CloudRegistration FromKeyPoses(const std::vector<ScoredKeyPose>& poses) const {
    constexpr int kLeastOffPlanes = 50;  // key points off the two largest common planes
    CloudRegistration result = Empty("global");
    const Rigid3d& start = poses.front().target_from_source;
    const int levels = std::min(2, pair_.options().levels);
    result.icp = pair_.Register(start, levels);
    result.reason = Verify(start, levels, &result);
    if (result.accepted() && pair_.CountOffPlanes(result.icp.target_from_source) < kLeastOffPlanes)
      result.reason = GlobalRegistrationReason::kDegenerate;
    result.score_margin = 1;
    SetScoreMargin(poses, start, poses.front().score, &result);
    return result;
  }

  // Returns whether a pose differs from another by more than the tolerance of key poses.
  bool IsRival(const Rigid3d& other, const Rigid3d& pose) const {
    constexpr double kDistinctCells = 4;
    return pair_.Distance(other, pose) >= kDistinctCells * pair_.cell_m();
  }

  // Returns whether a rival of a pose remains a rival after its registration. Rivals can converge
  // to the pose, and free-space violations can refute them.
  bool RemainsRival(const Rigid3d& rival, const Rigid3d& pose) const {
    const IcpResult icp = pair_.Register(rival, std::min(2, pair_.options().levels));
    if (!icp.Succeeded()) return true;
    return IsRival(icp.target_from_source, pose) &&
           pair_.ViolationRatio(icp.target_from_source).value_or(0) <=
               pair_.criteria().max_free_space_violation_ratio;
  }

  // Compares the score of a pose with the other poses. Only rivals that make an accepted pose
  // ambiguous are registered.
  void SetScoreMargin(const std::vector<ScoredKeyPose>& poses, const Rigid3d& pose, double score,
                      CloudRegistration* result) const {
    const double least_margin = pair_.criteria().min_score_margin;
    const double tolerated = (1 - least_margin) * score;
    double rival = 0;
    for (const ScoredKeyPose& other : poses) {
      if (other.score <= rival || !IsRival(other.target_from_source, pose)) continue;
      const bool decides = result->accepted() && other.score > tolerated;
      if (!decides || RemainsRival(other.target_from_source, result->icp.target_from_source))
        rival = other.score;
    }
    result->score_margin = std::min(result->score_margin, score > 0 ? 1 - rival / score : 0);
    if (result->accepted() && result->score_margin < least_margin)
      result->reason = GlobalRegistrationReason::kAmbiguous;
  }

  const CloudPair& pair_;
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
  const CloudPair pair(source, target, start.criteria, options);
  const CloudRegistrar registrar(pair);
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
                    " direction(s) of motion: ICP from displaced poses must return within about ",
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
