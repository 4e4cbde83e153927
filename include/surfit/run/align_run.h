#pragma once

#include <optional>
#include <string>

#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/icp.h"

namespace surfit {

// Which two frames to register, and how.
struct AlignRunOptions {
  SequenceOptions sequence;  // its first, last and stride are not used
  int source = 0;            // index in the sequence
  int target = 1;            // index in the sequence
  std::string output;        // folder for clouds and pictures; made if missing
  PreprocessOptions preprocess;
  IcpOptions icp = DefaultIcp();
  int threads = 2;

  // Two frames may lie farther apart than the next frame from the map. Of four levels the coarsest
  // (80 x 60 of 640 x 480) accepts pairs 0.8 m apart, almost without a robust kernel, and is left
  // after a step of less than a quarter of its width: what remains then is within the reach of the
  // finest level, which does the rest with gates close to the surface. Levels between the two, or
  // more steps of the coarsest, would leave it hardly anything to gain. A right fit puts
  // at most 1.7 % of the points into the other view's free space (a Kinect's kitchen; 0.02 % in the
  // office of ICL-NUIM), one that is off by 2 cm or more at least 4.1 % there.
  static IcpOptions DefaultIcp();

  // Throws InputError naming the option, its value and the constraint.
  void Validate() const;
};

// How far an estimated motion is from the true one.
struct PoseError {
  double translation_m = 0;
  double rotation_deg = 0;
};

struct AlignRunResult {
  IcpResult icp;
  std::optional<PoseError> initial_error;  // of the identity, where there is ground truth
  std::optional<PoseError> final_error;
};

// Registers two frames of a sequence from the identity and writes before.ply, after.ply,
// before.png and after.png into the output folder: both frames' points in the target camera's
// frame, source in orange and target in blue, before and after. Throws InputError for bad options
// or frames that cannot be read.
AlignRunResult RunAlign(const AlignRunOptions& options);

}  // namespace surfit
