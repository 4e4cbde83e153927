#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/global_registration.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {

class OptionVisitor;

struct AlignRunOptions {
  SequenceOptions sequence;  // first, last and stride are not used
  int source = 0;            // frame index
  int target = 1;            // frame index
  std::string output;        // output folder, created if missing
  PreprocessOptions preprocess;
  InitializeOptions initialize;
  IcpOptions icp = GlobalIcpOptions();
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// Result of RunAlign(). A rejected registration has errors, too.
struct AlignRunResult {
  GlobalRegistrationResult registration;
  // Errors of the identity and of the result; std::nullopt without ground truth.
  std::optional<PoseError> initial_error;
  std::optional<PoseError> final_error;
};

// Registers two frames of a sequence (RegisterGlobally()).
//
// Files in the output folder:
//   transform.txt            target_from_source, 4 x 4, of the camera frames
//   registration.json        target_from_source, its covariance (CovarianceOfViews()), the
//                            verification result, and the statistics of ICP
//   before.ply, after.ply    both frames in target camera coordinates: source in orange, target in
//   before.png, after.png    blue
// Throws InputError for invalid options, unreadable frames, or results that cannot be written.
AlignRunResult RunAlign(const AlignRunOptions& options);

class OptionVisitor;

struct RegisterRunOptions {
  std::string source;  // clouds: PLY or PCD, m
  std::string target;
  std::string output;  // output folder, created if missing
  CloudStartOptions start;
  // File with a 4 x 4 matrix target_from_source, or tx,ty,tz,qx,qy,qz,qw. Empty: none.
  std::string start_pose;
  CloudSensor sensor = DefaultSensor();
  bool single_view = false;  // both clouds were observed from sensor.viewpoint
  CloudNormalOptions normals;
  RegisterCloudsOptions registration = DefaultRegistration();
  int threads = 2;

  // Gates and standard deviations follow from the clouds: the distance gate is 0, the smallest
  // sigma is 1 micrometre, and the sensor has no depth noise.
  static CloudSensor DefaultSensor();
  static RegisterCloudsOptions DefaultRegistration();
  void Visit(OptionVisitor& visitor);
};

// Statistics of a cloud after preparation.
struct RegisteredCloud {
  std::size_t points = 0;          // finite points
  std::size_t not_finite = 0;      // removed points
  std::size_t duplicates = 0;      // points that are equal to an earlier point: not registered
  std::size_t without_normal = 0;  // registered points without normal
  double normal_radius_m = 0;      // minimum radius of normal estimation; 0: normals of the file
};

struct RegisterRunResult {
  CloudRegistration registration;  // in the frames of the files
  RegisteredCloud source, target;
};

// Registers two clouds and verifies the result. Normals are read from the files, and estimated if
// they are missing or all zero. The sigma of a point is floor_sigma_m of the error model. For
// estimated normals, the deviation of the neighbours from their plane is added in quadrature.
// Registration is computed about the centres of the clouds, so that coordinates of a survey keep
// their precision.
//
// Files in the output folder:
//   transform.txt            target_from_source, 4 x 4
//   registration.json        target_from_source, its covariance, the verification result, and the
//                            statistics of ICP
//   aligned.ply              source in the frame of the target, with normals and colours
//   before.png, after.png    source in orange, target in blue
// Throws InputError for invalid options, unreadable files, clouds without finite points, and
// results that cannot be written.
RegisterRunResult RunRegister(const RegisterRunOptions& options);

}  // namespace surfit
