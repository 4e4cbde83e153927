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

// Where registration starts, and what a fit must show that started from afar.
struct InitializeOptions {
  // identity: the identity, unverified.
  // so3: the rotation about the camera's centre that makes the coarsest images most alike.
  // features: poses that matched image features agree on, and poses that shapes and brightness of
  //   the coarsest level descend to from rotations all over a grid; the best of them.
  std::string method = "identity";
  // From so3 and features ICP goes on for so many times its max_iterations, until RMSE changes by
  // so much less than its min_relative_rmse_change: from different starts it shall come to one end.
  int iteration_growth = 10;
  // A fit from there is believed only if
  double min_overlap_share = 0.15;       // so many points lie on the other view's surface,
  double min_value_correlation = 0.8;    // the images are so much alike there,
  double min_detail_correlation = 0.05;  // and so are their edges and texture,
  double min_lead = 0.14;        // it tells so much more than any other pose, nats per pixel,
  double free_space_growth = 2;  // and the free-space share is at most max_free_space_share times
                                 // this: views from far apart show errors of calibration

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

// A registration and, unless it started from the identity, what speaks for it.
struct InitializedIcpResult {
  IcpResult icp;  // kNotVerified if ICP succeeded but its fit is not believed
  Rigid3d start;  // where ICP started
  double overlap_share = 0;
  double value_correlation = 0;
  double detail_correlation = 0;
  // How much more this pose explains than the best different one that was tried, in nats for each
  // pixel that overlaps.
  double lead = 0;
};

// Finds starts by the method of the options, registers from the best of them, and verifies the
// best result. Registration fails as Register() does, or with kNotVerified or kFreeSpaceFilled.
// Throws InputError for impossible options.
InitializedIcpResult InitializeAndRegister(const ColoredView& source, const ColoredView& target,
                                           const InitializeOptions& options,
                                           const IcpOptions& icp_options);

}  // namespace surfit
