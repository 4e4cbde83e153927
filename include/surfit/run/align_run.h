#pragma once

#include <optional>
#include <string>

#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/initialize.h"

namespace surfit {

class OptionVisitor;

// Which two frames to register, and how.
struct AlignRunOptions {
  SequenceOptions sequence;  // its first, last and stride are not used
  int source = 0;            // index in the sequence
  int target = 1;            // index in the sequence
  std::string output;        // folder for clouds and pictures; made if missing
  PreprocessOptions preprocess;
  InitializeOptions initialize;
  IcpOptions icp = FarIcpOptions();
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// How far an estimated motion is from the true one.
struct PoseError {
  double translation_m = 0;
  double rotation_deg = 0;
};

// The outcome of a run.
struct AlignRunResult {
  InitializedIcpResult registration;
  std::optional<PoseError> initial_error;  // of the identity, where there is ground truth
  std::optional<PoseError> final_error;
};

// Registers two frames of a sequence from where the options say and writes before.ply, after.ply,
// before.png and after.png into the output folder: both frames' points in the target camera's
// frame, source in orange and target in blue, before and after. Throws InputError for bad options
// or frames that cannot be read.
AlignRunResult RunAlign(const AlignRunOptions& options);

}  // namespace surfit
