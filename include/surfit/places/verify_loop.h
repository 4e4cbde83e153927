#pragma once

#include <optional>

#include "surfit/frame/preprocess.h"
#include "surfit/places/keyframe.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

class OptionVisitor;

// How a loop is verified.
struct VerifyLoopOptions {
  PreprocessOptions preprocess;  // of the views' normals and coarser levels
  IcpOptions icp = DefaultIcp();
  int min_agreeing_features = 12;  // for a pose that features propose
  FitCriteria fit;

  // Symmetric residual, from a coarse level within the reach of what starts it.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers one view of a place to another and judges the fit: poses that features agree on and, if
// given, a prior are refined densely on a coarse level, the best on the finest. Throws InputError
// for impossible options; a loop that is not believed is a verdict, not an error. The same bit for
// bit at any number of threads.
FarVerdict VerifyLoop(const PlaceView& source, const PlaceView& target,
                      const VerifyLoopOptions& options,
                      const std::optional<Rigid3d>& target_from_source_prior = std::nullopt);

}  // namespace surfit
