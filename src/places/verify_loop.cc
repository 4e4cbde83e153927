#include "surfit/places/verify_loop.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "places/expanded_view.h"
#include "places/match_features.h"
#include "registration/consensus.h"
#include "registration/view_fit.h"

namespace surfit {
namespace {

constexpr int kFeaturePoses = 3;  // that are refined at most
constexpr int kConsensusTries = 500;
constexpr double kRivalShiftM = 0.1;  // of the starts to both sides of the best pose
// Poses nearer to each other than this are one.
constexpr double kSameDistanceM = 0.04;
constexpr double kSameAngleRad = 0.035;

// A pose found on the coarser levels, and how well the views agree there.
struct CoarsePose {
  Rigid3d target_from_source;
  ViewFit fit;
};

bool AreSame(const Rigid3d& a, const Rigid3d& b) {
  return (a.translation - b.translation).norm() < kSameDistanceM &&
         RotationAngle(a.rotation.conjugate() * b.rotation) < kSameAngleRad;
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0., eigen.eigenvalues()[2]));
}

// The left increment that the information holds least, which moves points at that distance by 1 m.
Vector6d WeakestIncrement(const Matrix6d& information, double distance_m) {
  Matrix6d scaled = information;
  scaled.topRows<3>() /= distance_m;
  scaled.leftCols<3>() /= distance_m;
  Vector6d increment = Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled).eigenvectors().col(0);
  increment.head<3>() /= distance_m;
  return increment;
}

// The inverse of what the covariance is in truth. That of registration is as if all residuals were
// independent, but neighbours share noise through filters; and the views share what is wrong with
// the camera's calibration, of which the disagreement tells something, whatever the points' number.
Matrix6d RealisticInformation(const Matrix6d& covariance, double disagreement_rad,
                              double disagreement_m) {
  constexpr double kSharing = 25;  // points that share their noise: the depth filter's window
  constexpr double kFloorRad = 0.002, kFloorM = 0.004;
  Matrix6d realistic = kSharing * covariance;
  realistic.diagonal().head<3>().array() +=
      kFloorRad * kFloorRad + disagreement_rad * disagreement_rad;
  realistic.diagonal().tail<3>().array() += kFloorM * kFloorM + disagreement_m * disagreement_m;
  const Matrix6d information = realistic.inverse();
  return (information + information.transpose()) / 2;
}

double MeanDepth(const FrameLevel& level) {
  double sum = 0;
  int count = 0;
  for (const float z : level.vertex.z) {
    if (z > 0) sum += z, ++count;
  }
  return count > 0 ? sum / count : 0;
}

class LoopVerifier {
 public:
  LoopVerifier(const PlaceView& source, const PlaceView& target, const VerifyLoopOptions& options)
      : source_(Expand(source, options.preprocess, options.icp.error_model)),
        target_(Expand(target, options.preprocess, options.icp.error_model)),
        options_(options),
        coarse_icp_(options.icp) {
    coarse_icp_.gates.max_distance_m *= options.icp.gate_growth;
    coarse_icp_.error_model.floor_sigma_m *= 2;
    matches_ = MatchFeatures(source.features, target.features);
  }

  LoopVerdict Verify(const std::optional<Rigid3d>& prior) {
    verdict_.matches = static_cast<int>(matches_.size());
    const std::vector<Rigid3d> starts = Starts(prior);
    if (starts.empty()) return Refused(LoopReason::kNoStart);
    for (const Rigid3d& start : starts) RegisterCoarsely(start);
    if (poses_.empty()) return Refused(LoopReason::kNotRegistered);
    const CoarsePose best = *std::max_element(
        poses_.begin(), poses_.end(),
        [](const auto& a, const auto& b) { return a.fit.Score() < b.fit.Score(); });
    Describe(best);
    if (const auto reason = DoubtAboutViews()) return Refused(*reason);
    return VerifyPose(best);
  }

 private:
  LoopVerdict Refused(LoopReason reason) {
    verdict_.reason = reason;
    return verdict_;
  }

  std::vector<Rigid3d> Starts(const std::optional<Rigid3d>& prior) {
    std::vector<Rigid3d> starts;
    for (const Consensus& consensus : FindConsensus(source_.features, target_.features, matches_,
                                                    kFeaturePoses, kConsensusTries)) {
      const int agreeing = static_cast<int>(consensus.inliers.size());
      verdict_.agreeing_features = std::max(verdict_.agreeing_features, agreeing);
      if (agreeing >= options_.min_agreeing_features) {
        starts.push_back(consensus.target_from_source);
      }
    }
    if (prior) starts.push_back(*prior);
    return starts;
  }

  void RegisterCoarsely(const Rigid3d& start) {
    const IcpResult icp = Register(source_.coarser, target_.coarser, start, coarse_icp_);
    if (!icp.Succeeded()) return;
    poses_.push_back(
        {icp.target_from_source, MeasureFit(source_.Level(), target_.Level(),
                                            coarse_icp_.error_model, icp.target_from_source)});
  }

  void Describe(const CoarsePose& pose) {
    verdict_.target_from_source = pose.target_from_source;
    verdict_.overlap_share = pose.fit.overlap_share;
    verdict_.free_space_share = pose.fit.free_space_share;
    verdict_.value_correlation = pose.fit.value_correlation;
    verdict_.detail_correlation = pose.fit.detail_correlation;
  }

  std::optional<LoopReason> DoubtAboutViews() const {
    if (verdict_.overlap_share < options_.min_overlap_share) return LoopReason::kLittleOverlap;
    if (verdict_.free_space_share > options_.max_free_space_share) {
      return LoopReason::kFreeSpaceFilled;
    }
    if (!source_.has_color || !target_.has_color ||
        verdict_.value_correlation < options_.min_value_correlation ||
        verdict_.detail_correlation < options_.min_detail_correlation) {
      return LoopReason::kLooksDifferent;
    }
    return std::nullopt;
  }

  LoopVerdict VerifyPose(const CoarsePose& coarse) {
    const IcpResult icp =
        Register(source_.finest, target_.finest, coarse.target_from_source, options_.icp);
    verdict_.target_from_source = icp.target_from_source;
    verdict_.inlier_share = icp.inlier_share;
    verdict_.rmse_m = icp.rmse_m;
    if (icp.termination == Termination::kSingularSystem) return Refused(LoopReason::kDegenerate);
    if (!icp.Succeeded()) return Refused(LoopReason::kNotRegistered);
    verdict_.sigma_rad = LargestSigma(icp.covariance->topLeftCorner<3, 3>());
    verdict_.sigma_m = LargestSigma(icp.covariance->bottomRightCorner<3, 3>());
    if (verdict_.sigma_m > options_.max_sigma_m || verdict_.sigma_rad > options_.max_sigma_rad) {
      return Refused(LoopReason::kDegenerate);
    }
    if (icp.rmse_m > options_.max_rmse_m ||
        icp.inlier_share < options_.min_inlier_share * verdict_.overlap_share) {
      return Refused(LoopReason::kPoorFit);
    }
    MeasureLead(icp, coarse);
    if (verdict_.lead < options_.min_lead) return Refused(LoopReason::kAmbiguous);
    MeasureDisagreement(coarse.target_from_source);
    if (verdict_.disagreement_m > options_.max_disagreement_m ||
        verdict_.disagreement_rad > options_.max_disagreement_rad) {
      return Refused(LoopReason::kInconsistent);
    }
    verdict_.information =
        RealisticInformation(*icp.covariance, verdict_.disagreement_rad, verdict_.disagreement_m);
    return Refused(LoopReason::kAccepted);
  }

  // Other starts, also to both sides along what the data holds least, must lead to the same pose
  // or to a worse one.
  void MeasureLead(const IcpResult& icp, const CoarsePose& best) {
    const Vector6d weakest =
        WeakestIncrement(icp.information, MeanDepth(target_.finest.levels.front()));
    for (const double shift_m : {-kRivalShiftM, kRivalShiftM}) {
      RegisterCoarsely(LeftIncrement<double>(shift_m * weakest, icp.target_from_source));
    }
    double rival = 0;
    for (const CoarsePose& pose : poses_) {
      if (AreSame(pose.target_from_source, icp.target_from_source)) continue;
      rival = std::max(rival, pose.fit.Score());
    }
    verdict_.lead = best.fit.Score() > 0 ? 1 - rival / best.fit.Score() : 0;
  }

  void MeasureDisagreement(const Rigid3d& start) {
    const IcpResult back = Register(target_.finest, source_.finest, start.Inverse(), options_.icp);
    const Rigid3d difference = verdict_.target_from_source * back.target_from_source;
    verdict_.disagreement_m = difference.translation.norm();
    verdict_.disagreement_rad = back.Succeeded() ? RotationAngle(difference.rotation) : M_PI;
  }

  ExpandedView source_, target_;
  const VerifyLoopOptions& options_;
  IcpOptions coarse_icp_;
  std::vector<FeatureMatch> matches_;
  std::vector<CoarsePose> poses_;
  LoopVerdict verdict_;
};

}  // namespace

LoopVerdict VerifyLoop(const PlaceView& source, const PlaceView& target,
                       const VerifyLoopOptions& options,
                       const std::optional<Rigid3d>& target_from_source_prior) {
  options.Validate();
  if (source.empty() || target.empty()) return {};
  return LoopVerifier(source, target, options).Verify(target_from_source_prior);
}

}  // namespace surfit
