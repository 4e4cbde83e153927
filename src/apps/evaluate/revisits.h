#pragma once

#include <functional>
#include <string>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

// Two frames are a revisit if their true poses are within both limits.
struct RevisitOptions {
  SequenceOptions sequence;  // `stride` selects the compared frames
  std::string estimate;      // trajectory file, TUM format, in the pose convention of the sequence
  int min_gap = 300;         // minimum frame index difference
  double max_distance_m = 0.3;
  double max_angle_rad = 0.26;
  PreprocessOptions preprocess;

  void Visit(OptionVisitor& visitor);
};

// Surface distances between two visits at their relative pose.
struct SurfaceAgreement {
  // Statistics over pairs: median of |n . (p' - q)| over the pixels of a pair.
  ErrorStatistics surface_m;
  // Change of the relative pose of a pair by ICP.
  ErrorStatistics icp_translation_m, icp_rotation_deg;
};

struct RevisitReport {
  int pairs = 0;         // number of revisits, including skipped pairs
  int unregistered = 0;  // skipped pairs: no overlap or failed ICP at one of both poses
  int without_pose = 0;  // skipped frames: unreadable, or without estimated or true pose
  // 0 if no pair has a result.
  SurfaceAgreement ground_truth, estimate;
};

// Compares the surface agreement of estimate and ground truth at revisits. With a distorted
// sensor, wrong poses can agree better than the ground truth. `progress` must not be empty. It
// receives the number of processed pairs and of all pairs. Throws InputError for invalid
// options, unreadable files, or a sequence without ground truth.
RevisitReport CompareAtRevisits(const RevisitOptions& options,
                                const std::function<void(int, int)>& progress);

}  // namespace surfit
