#pragma once

#include <limits>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/icp.h"

namespace surfit {

class OptionVisitor;

// View for global registration, without a predicted pose. The pyramid must have a level, except for
// the method identity.
struct ColoredView {
  FramePyramid pyramid;
  Image<Rgb8> color;  // same pixels as the finest level; empty: no colour
};

// Acceptance criteria of a global registration, which must all hold. The order of the tests is:
// overlap, free space, appearance, registration with its sigmas, RMSE and inliers, score margin,
// backward registration. They are strict, because a wrong registration distorts the map, while a
// rejected registration costs little.
struct FitCriteria {
  double min_overlap_ratio = 0.3;                // of points on the surface of the other view
  double max_free_space_violation_ratio = 0.03;  // ratio of free-space violations; 1: no limit
  bool needs_color = true;                       // reject views without colour
  double min_value_correlation = 0.6;            // correlation of the brightness in the overlap
  double min_detail_correlation = 0.2;           // correlation of the image details in the overlap
  double min_inlier_ratio = 0.4;                 // inlier ratio divided by overlap ratio
  double max_rmse_m = 0.02;
  double max_sigma_m = 0.01;           // translation, in the least certain direction
  double max_sigma_rad = 0.01;         // rotation, in the least certain direction
  double min_score_margin = 0.1;       // score margin: 1 - second-best score / best score
  double max_disagreement_m = 0.01;    // between forward and backward registration
  double max_disagreement_rad = 0.01;  // pi or more: no backward registration

  void Visit(OptionVisitor& visitor);
};

// Result of the verification: the first violated criterion, or kAccepted.
enum class GlobalRegistrationReason {
  kNoView,              // VerifyLoop(): a view is empty, for example removed to limit memory
  kNoStart,             // too few consistent features, and no initial pose from elsewhere
  kNotRegistered,       // registration failed from all initial poses
  kDegenerate,          // the pose is unobservable or weakly constrained
  kLittleOverlap,       // overlap below min_overlap_ratio
  kPoorFit,             // RMSE too high or too few inliers
  kFreeSpaceViolation,  // too many free-space violations
  kLooksDifferent,      // different images in the overlap, or missing colour
  kAmbiguous,           // score margin below min_score_margin
  kInconsistent,        // backward registration gives a different pose
  kAccepted,
};

// "no_view", "no_start", ..., "accepted".
std::string ToString(GlobalRegistrationReason reason);
std::vector<GlobalRegistrationReason> GlobalRegistrationReasons();

// Verification result with its evidence. Values that were not computed are 0.
struct GlobalRegistrationResult {
  GlobalRegistrationReason reason = GlobalRegistrationReason::kNoView;
  Rigid3d target_from_source;  // best registration; valid only if accepted
  // Information of the left perturbation (1/rad^2, 1/m^2). 0 if not verified or not accepted.
  Matrix6d information = Matrix6d::Zero();
  int matches = 0;            // matched features
  int agreeing_features = 0;  // inliers of the best pose hypothesis
  double inlier_ratio = 0;
  double rmse_m = 0;
  double overlap_ratio = 0;
  double free_space_violation_ratio = 0;  // 0 if all registrations failed by ICP
  double value_correlation = 0;
  double detail_correlation = 0;
  double score_margin = 0;
  double sigma_m = 0, sigma_rad = 0;                // largest standard deviations of the pose
  double disagreement_m = 0, disagreement_rad = 0;  // rad: pi if backward registration failed
  Rigid3d start;                                    // initial pose of the best registration
  IcpResult icp;  // last registration from `start`; a failure if all failed

  bool accepted() const { return reason == GlobalRegistrationReason::kAccepted; }
};

// Violated criterion with value and limit. Empty for kAccepted, kNoView, kNoStart, kNotRegistered,
// and for kDegenerate without standard deviations, because the pose is unobservable. If ICP itself
// failed by kFreeSpaceViolation, the value is 0.
std::string ViolatedCriterion(const GlobalRegistrationResult& verdict, const FitCriteria& criteria);

// Options for the initial pose of the registration of two frames, and its verification.
struct InitializeOptions {
  // Source of the initial pose:
  // - identity: no motion; the result is not verified.
  // - features: best pose from feature matches and from a grid of rotations on the coarsest level.
  std::string method = "identity";
  FitCriteria fit = FrameCriteria();

  // Criteria for two frames that are far apart. ICP then checks free space at full resolution, so
  // the criteria can be weaker than those for loops. FarPairsSweep has 100 frame pairs at a
  // distance of 90 frames with more than 30 % overlap. 95 are registered and accepted, and 68 with
  // the criteria for loops. Correct poses lost by a single criterion for loops: overlap 5, details
  // 7, inlier ratio 4, backward registration 10, free space at half the resolution 15. The
  // brightness criterion for loops would accept 2 more wrong poses. Frames without colour are
  // verified geometrically.
  static FitCriteria FrameCriteria();

  void Visit(OptionVisitor& visitor);
};

// "identity", "features".
std::vector<std::string> InitializeMethods();

// ICP options for two frames with a larger motion than between a frame and the map. Only the
// coarsest and the finest of four levels are used. The coarsest level (80 x 60 pixels for 640 x
// 480) accepts point distances of 0.8 m, almost without a robust kernel. It ends after a step below
// 20 px, a quarter of its width. The finest level converges from there with narrow gates.
// Intermediate levels, or more coarse steps, would hardly improve the result. Free-space violations
// in a kitchen recorded by a Kinect: at most 1.7 % for correct poses, at least 4.1 % for errors of
// 2 cm or more. In the office of ICL-NUIM correct poses have 0.02 %.
IcpOptions GlobalIcpOptions();

// ICP options for an initial pose of the method. Unchanged for `identity`. Other methods do not
// stop at an increase of the RMSE. They have ten times max_iterations and a tenth of
// min_relative_rmse_change, because different initial poses must converge to the same pose. The
// increased max_iterations must be at most 1000. max_free_space_violation_ratio is doubled, because
// calibration errors cause more violations between distant views.
IcpOptions IcpOptionsFromStart(const InitializeOptions& options, const IcpOptions& icp_options);

// Largest motion between two views. The default has no limits.
struct MotionBound {
  double max_m = std::numeric_limits<double>::infinity();
  double max_rad = std::numeric_limits<double>::infinity();

  bool Allows(const Rigid3d& motion) const {
    return motion.translation.norm() <= max_m && RotationAngle(motion.rotation) <= max_rad;
  }
};

// Finds initial poses by the method, registers from the best of them, and verifies the best result.
// The result of `identity` is not verified: kAccepted means that ICP succeeded, and its
// `information` is 0. Other methods abort if a colour image does not have the size of the finest
// level. Initial poses of `features` are within `bound`: a small bound takes less time. Throws
// InputError for invalid options. A rejected registration is a result, not an error.
GlobalRegistrationResult RegisterGlobally(const ColoredView& source, const ColoredView& target,
                                          const InitializeOptions& options,
                                          const IcpOptions& icp_options,
                                          const MotionBound& bound = {});

}  // namespace surfit
