#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"

namespace surfit {

class OptionVisitor;

// Which sequence to look for loops in, and how.
struct FindLoopsRunOptions {
  SequenceOptions sequence;
  std::string
      trajectory;      // file with the estimated poses, TUM format, in the sequence's convention
  std::string output;  // folder for loops.csv and loops.g2o; made if missing
  PreprocessOptions preprocess;
  KeyframeOptions keyframes;
  PlaceViewOptions view;
  PlaceIndexOptions index;
  FindLoopsOptions loops;
  std::size_t max_view_bytes = 200'000'000;  // of all keyframes' views: about 750 of 640 x 480
  // A frame returns if its true pose is so near to that of a frame so much earlier.
  int revisit_gap = 300;
  double revisit_m = 0.3;
  double revisit_rad = 0.26;
  // An accepted loop is wrong if it is farther than this from the truth.
  double wrong_m = 0.05;
  double wrong_rad = 0.0524;
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// A loop that was tried, and how far it is from the true relative pose, where that is known.
struct FoundLoop {
  int source_frame = 0, target_frame = 0;  // indices in the sequence
  LoopAttempt attempt;
  std::optional<double> error_m, error_rad;
  std::optional<double> squared_error;  // in sigmas, by the information of an accepted loop
  bool wrong = false;                   // accepted, but too far from the truth
  bool disputed = false;  // wrong, but the surfaces speak for the loop: LoopEvaluation
};

// What the ground truth says of the loops.
struct LoopEvaluation {
  int revisiting = 0;  // frames that return
  int linked = 0;      // of these, whose keyframe is joined to one at least revisit_gap earlier
  int wrong = 0;       // accepted loops that are wrong
  // Of these, loops where the surfaces of both views lie nearer to each other than at the true
  // pose, and registration from there comes to the loop as well or is refused: where the ground
  // truth is another system's estimate, it may be what is wrong.
  int disputed = 0;
  double worst_m = 0, worst_rad = 0;  // the largest errors of accepted loops
};

// The outcome of a run.
struct FindLoopsRunResult {
  int frames = 0;    // with pose and depth
  int left_out = 0;  // frames without either
  std::vector<Keyframe> keyframes;
  std::vector<FoundLoop> loops;              // accepted and refused
  int given_up = 0;                          // keyframes whose views were given up
  std::size_t view_bytes = 0;                // of the views that are left
  double view_ms = 0;                        // CPU time to make a keyframe's view, on average
  double query_ms = 0;                       // to propose its loops
  double verify_ms = 0;                      // to verify one
  std::optional<LoopEvaluation> evaluation;  // where there is ground truth
};

// Chooses keyframes along a trajectory, looks for loops with each, and writes loops.csv (all that
// were tried, with the reason) and loops.g2o (keyframes as last estimated, and the accepted loops)
// into the output folder, frames right-handed as in SequenceInfo. `progress` is called with the
// frames done. Throws InputError for bad options or unreadable files.
FindLoopsRunResult RunFindLoops(const FindLoopsRunOptions& options,
                                const std::function<void(int frames)>& progress);

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
