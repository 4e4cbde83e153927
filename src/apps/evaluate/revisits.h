#pragma once

#include <functional>
#include <string>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

// Which frames count as a return to the same place, by the true poses.
struct RevisitOptions {
  SequenceOptions sequence;  // its stride is that of the frames that are looked at
  std::string estimate;      // trajectory file, TUM format, in the sequence's convention
  int min_gap = 300;         // frames between the two
  double max_distance_m = 0.3;
  double max_angle_rad = 0.26;
  PreprocessOptions preprocess;

  void Visit(OptionVisitor& visitor);
};

// How well a trajectory lays the surfaces of two visits over each other. Nothing is aligned, and no
// other pose is assumed to be true.
struct RevisitAgreement {
  // Of each pair of frames the median of |n . (p' - q)| over projected pixels.
  ErrorStatistics surface_m;
  // How far dense ICP goes from the trajectory's relative pose.
  ErrorStatistics icp_translation_m, icp_rotation_deg;
};

// What the pairs of frames say of both trajectories.
struct RevisitReport {
  int pairs = 0;         // of frames
  int unregistered = 0;  // of these, pairs left out: ICP failed from either trajectory
  int without_pose = 0;  // frames left out
  // Zeros unless a pair is left.
  RevisitAgreement ground_truth, estimate;
};

// Compares estimate and ground truth where the camera returns to where it was. Surfaces that agree
// are no proof of right poses: a trajectory bends to agree with a distorted sensor, before which
// true poses look inconsistent. `progress` is called with the pairs done and all of them. Throws
// InputError for bad options, unreadable files, or a sequence without ground truth.
RevisitReport CompareAtRevisits(const RevisitOptions& options,
                                const std::function<void(int, int)>& progress);

}  // namespace surfit
