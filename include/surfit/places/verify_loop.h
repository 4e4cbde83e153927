#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/preprocess.h"
#include "surfit/places/keyframe.h"
#include "surfit/registration/icp.h"

namespace surfit {

class OptionVisitor;

// What a loop must show to be accepted. All of it must hold: a right loop that is refused costs
// little, since its neighbours will be tried, and a wrong one bends the map.
struct VerifyLoopOptions {
  PreprocessOptions preprocess;  // of the views' normals and coarser levels
  IcpOptions icp = DefaultIcp();
  int min_agreeing_features = 12;  // for a pose that features propose
  double min_inlier_share = 0.4;   // of the points that overlap, within 3 sigmas of their partner
  double max_rmse_m = 0.02;
  double min_overlap_share = 0.3;       // so many points lie on the other view's surface,
  double max_free_space_share = 0.03;   // so few in front of it,
  double min_value_correlation = 0.6;   // the images are so much alike there,
  double min_detail_correlation = 0.2;  // and so are their edges and texture
  double min_lead = 0.1;             // of ViewFit's score over that of any other pose, as its share
  double max_sigma_m = 0.01;         // of the pose's covariance, in the direction held least,
  double max_sigma_rad = 0.01;       // and of its rotation
  double max_disagreement_m = 0.01;  // of the pose found forwards and the one found backwards
  double max_disagreement_rad = 0.01;

  // Symmetric residual, from a coarse level within the reach of what starts it.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// That a loop was accepted, or what first spoke against it.
enum class LoopReason {
  kNoView,           // one view has no depth, or was given up
  kNoStart,          // too few features agree on a pose, and no other is given
  kNotRegistered,    // dense registration failed from all starts
  kDegenerate,       // it leaves directions free, or holds some too loosely
  kLittleOverlap,    // the views hardly show the same surfaces
  kPoorFit,          // or these lie too far from each other
  kFreeSpaceFilled,  // surfaces stand where the other view saw through
  kLooksDifferent,   // the images differ where the surfaces fit, or one is missing
  kAmbiguous,        // another pose fits about as well
  kInconsistent,     // registered the other way round it ends elsewhere
  kAccepted,
};

// "no_view", "no_start", ..., "accepted".
std::string ToString(LoopReason reason);
// All, in their order.
std::vector<LoopReason> LoopReasons();

// A verdict, and what speaks for it: zeros for what was not looked at.
struct LoopVerdict {
  LoopReason reason = LoopReason::kNoView;
  Rigid3d target_from_source;               // of the best fit; of use only if accepted
  Matrix6d information = Matrix6d::Zero();  // of the left increment (1/rad^2, 1/m^2), if accepted
  int matches = 0;                          // features alike in both views
  int agreeing_features = 0;                // those that agree with the best proposal
  double inlier_share = 0;
  double rmse_m = 0;
  double overlap_share = 0;
  double free_space_share = 0;
  double value_correlation = 0;
  double detail_correlation = 0;
  double lead = 0;
  double sigma_m = 0, sigma_rad = 0;  // largest standard deviations
  double disagreement_m = 0, disagreement_rad = 0;

  bool accepted() const { return reason == LoopReason::kAccepted; }
};

// Registers one view of a place to another and judges the fit: poses that features agree on and, if
// given, a prior are refined densely on a coarse level, the best on the finest. Throws InputError
// for impossible options; a loop that is not believed is a verdict, not an error. The same bit for
// bit at any number of threads.
LoopVerdict VerifyLoop(const PlaceView& source, const PlaceView& target,
                       const VerifyLoopOptions& options,
                       const std::optional<Rigid3d>& target_from_source_prior = std::nullopt);

}  // namespace surfit
