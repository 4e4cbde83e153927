#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/far_registration.h"
#include "surfit/registration/register_clouds.h"

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

// The outcome of a run.
struct AlignRunResult {
  FarVerdict registration;
  std::optional<PoseError> initial_error;  // of the identity, where there is ground truth
  std::optional<PoseError> final_error;
};

// Registers two frames of a sequence from where the options say and writes before.ply, after.ply,
// before.png and after.png into the output folder: both frames' points in the target camera's
// frame, source in orange and target in blue, before and after. Throws InputError for bad options
// or frames that cannot be read.
AlignRunResult RunAlign(const AlignRunOptions& options);

class OptionVisitor;

// Which two clouds to register, and how.
struct RegisterRunOptions {
  std::string source;  // the file of the cloud to be moved: PLY or PCD, metres
  std::string target;  // the file of the cloud to be met
  std::string output;  // folder for the pose, the aligned cloud and pictures; made if missing
  CloudSensor sensor;  // of both
  CloudNormalOptions normals;
  RegisterCloudsOptions registration;
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// What came of a file.
struct RegisteredCloud {
  std::size_t points = 0;
  std::size_t not_finite = 0;      // left out
  std::size_t without_normal = 0;  // of the points
  double normal_radius_m = 0;      // at least; 0 where the normals are the file's
};

// The outcome of a run.
struct RegisterRunResult {
  IcpResult icp;
  RegisteredCloud source, target;
};

// Registers two clouds from the identity. Normals are the files' where they have them, and are
// estimated otherwise; sigma of a point is floor_sigma_m of the error model and, if estimated, the
// deviation of the points around it from their plane. Writes into the output folder:
// transform.txt (target_from_source, 4 x 4), registration.json (the same, how well it is known, and
// how it came about), aligned.ply (the source in the target's frame, with its normals and colours),
// before.png and after.png (source in orange, target in blue).
// Throws InputError for bad options, files that cannot be read and clouds without a finite point.
RegisterRunResult RunRegister(const RegisterRunOptions& options);

}  // namespace surfit
