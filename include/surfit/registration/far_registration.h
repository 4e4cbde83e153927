#pragma once

#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/icp.h"

namespace surfit {

class OptionVisitor;

// A frame that may be registered from an unknown start.
struct ColoredView {
  FramePyramid pyramid;
  Image<Rgb8> color;  // of the pixels of the finest level; empty where there is none
};

// What a fit must show that may have started far from the truth. All of it must hold: a right one
// that is refused costs little, a wrong one bends the map.
struct FitCriteria {
  double min_overlap_share = 0.3;       // so many points lie on the other view's surface,
  double max_free_space_share = 0.03;   // so few in front of it; 1 = off
  bool needs_color = true;              // both views show colours, and where they do
  double min_value_correlation = 0.6;   // the images are so much alike there,
  double min_detail_correlation = 0.2;  // and so are their edges and texture
  double min_inlier_share = 0.4;        // of the points that overlap, within 3 sigmas of their pair
  double max_rmse_m = 0.02;
  double max_sigma_m = 0.01;         // of the pose's covariance, in the direction held least,
  double max_sigma_rad = 0.01;       // and of its rotation
  double min_lead = 0.1;             // of ViewFit's score over that of any other pose, as its share
  double max_disagreement_m = 0.01;  // of the pose found forwards and the one found backwards
  double max_disagreement_rad = 0.01;  // pi = not looked at

  void Visit(OptionVisitor& visitor);
};

// That a fit was accepted, or what first spoke against it.
enum class FarReason {
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
std::string ToString(FarReason reason);
// All, in their order.
std::vector<FarReason> FarReasons();

// A verdict, and what speaks for it: zeros for what was not looked at.
struct FarVerdict {
  FarReason reason = FarReason::kNoView;
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
  Rigid3d start;  // where the best registration started
  IcpResult icp;  // the last that was looked at of that start, a failure if all failed

  bool accepted() const { return reason == FarReason::kAccepted; }
};

// What a fit lacks to be accepted, with value and constraint; empty where it is, or where nothing
// but the registration's own termination tells.
std::string Doubt(const FarVerdict& verdict, const FitCriteria& criteria);

// Where the registration of two frames starts, and what it must show.
struct InitializeOptions {
  // identity: the identity, unverified.
  // so3: the rotation about the camera's centre that makes the coarsest images most alike.
  // features: poses that matched image features agree on, and poses that shapes and brightness of
  //   the coarsest level descend to from rotations all over a grid; the best of them.
  std::string method = "identity";
  // From so3 and features ICP goes on for so many times its max_iterations, until RMSE changes by
  // so much less than its min_relative_rmse_change: from different starts it shall come to one end.
  int iteration_growth = 10;
  // Its max_free_space_share may be so many times as large: views from far apart show errors of
  // calibration.
  double free_space_growth = 2;
  FitCriteria fit = FrameCriteria();

  // Those of frames far apart, whose ICP checks free space at full resolution. Of 100 pairs 90
  // frames apart that overlap by more than 30 % (FarPairsSweep), 95 are right and believed; by
  // those of loops 68. Of these alone the overlap would lose 5, the detail 7, the inlier share 4,
  // the way back 10 and free space at half the resolution 15; the brightness would let pass 2 wrong
  // ones more. Without colours shapes must do.
  static FitCriteria FrameCriteria();

  void Visit(OptionVisitor& visitor);
};

// identity, so3, features.
std::vector<std::string> InitializeMethods();

// The options of ICP for two frames that may lie farther apart than the next frame from the map. Of
// four levels the coarsest (80 x 60 of 640 x 480) accepts pairs 0.8 m apart, almost without a
// robust kernel, and is left after a step of less than a quarter of its width: what remains then is
// within the reach of the finest level, which does the rest with gates close to the surface. Levels
// between the two, or more steps of the coarsest, would leave it hardly anything to gain. A right
// fit puts at most 1.7 % of the points into the other view's free space (a Kinect's kitchen; 0.02 %
// in the office of ICL-NUIM), one that is off by 2 cm or more at least 4.1 % there.
IcpOptions FarIcpOptions();

// The options of ICP from a start that the method finds: with iteration_growth and
// free_space_growth, and through a passing rise of RMSE; unchanged for the identity.
IcpOptions IcpOptionsFromStart(const InitializeOptions& options, const IcpOptions& icp_options);

// Finds starts by the method of the options, registers from the best of them, and verifies the
// best result. Throws InputError for impossible options; a fit that is not believed is a verdict,
// not an error.
FarVerdict RegisterFar(const ColoredView& source, const ColoredView& target,
                       const InitializeOptions& options, const IcpOptions& icp_options);

// Two views of one camera: pyramids of as many levels, and the colours of their finest pixels;
// empty where there are none.
struct ViewPair {
  const FramePyramid& source;
  const Image<Rgb8>& source_color;
  const FramePyramid& target;
  const Image<Rgb8>& target_color;
};

// Turns a pose about the target's camera until the coarsest levels of both views are most alike in
// brightness and shape (Gauss-Newton; the SO(3) pre-alignment of Whelan et al., ElasticFusion,
// RSS 2015). A cheap start for registration where the camera turns fast: it follows rotations of
// some ten degrees. Without colours it goes by the shapes alone.
Rigid3d AlignRotation(const ViewPair& views, const Rigid3d& target_from_source_initial);

}  // namespace surfit
