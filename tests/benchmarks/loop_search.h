#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"

namespace surfit::testing {

struct LoopSearchOptions {
  SequenceOptions sequence;
  std::string
      trajectory;  // file with the estimated poses, TUM format, in the sequence's convention
  PreprocessOptions preprocess;
  KeyframeOptions keyframes;
  PlaceViewOptions view;
  PlaceIndexOptions index;
  FindLoopsOptions loops;
  std::size_t max_view_bytes = 200'000'000;  // limit of the memory of all views
  // A frame returns to a place if its true pose is near the true pose of an earlier frame.
  int revisit_gap = 300;      // minimum number of frames between both frames
  double revisit_m = 0.3;     // maximum distance
  double revisit_rad = 0.26;  // maximum angle
  // An accepted loop with a larger error is wrong.
  double wrong_m = 0.05;
  double wrong_rad = 0.0524;
};

// A loop candidate with its verification. The errors are empty without ground truth.
struct FoundLoop {
  int source_frame = 0, target_frame = 0;  // indices in the sequence
  LoopVerification attempt;
  std::optional<double> error_m, error_rad;
  bool wrong = false;     // accepted with a large error
  bool disputed = false;  // wrong, but the surfaces fit better than at the true pose
};

struct LoopEvaluation {
  int revisiting = 0;  // frames that return to a place
  int linked = 0;      // revisiting frames with an accepted loop to a frame before `revisit_gap`
  int wrong = 0;       // wrong loops
  // Wrong loops whose surfaces are closer than at the true pose, if registration from the true pose
  // converges to the loop or fails. The ground truth of a recording may be wrong itself.
  int disputed = 0;
  double worst_m = 0, worst_rad = 0;  // largest errors of accepted loops
};

// Loops of a sequence and the CPU time of the search.
struct LoopSearchResult {
  int frames = 0;    // frames with pose and depth
  int left_out = 0;  // frames without pose or depth
  std::vector<Keyframe> keyframes;
  std::vector<FoundLoop> loops;  // accepted and rejected
  int given_up = 0;              // keyframes without a view, because of `max_view_bytes`
  std::size_t view_bytes = 0;    // memory of the remaining views
  double view_ms = 0;            // CPU time to make a view, mean
  double query_ms = 0;           // CPU time to propose the loops of a keyframe, mean
  double verify_ms = 0;          // CPU time to verify a loop, mean
  std::optional<LoopEvaluation> evaluation;  // empty without ground truth
};

// Selects keyframes along a trajectory, proposes loops for each keyframe and verifies them. Throws
// InputError for bad options or unreadable files.
LoopSearchResult SearchLoops(const LoopSearchOptions& options);

}  // namespace surfit::testing
