#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

class OptionVisitor;

// The jobs of a scan, whose folder has:
//   plan.json, fragments/NAME.flags        PlanScan()
//   fragments/NAME/                        what surfit_slam writes for a fragment, with places.bin
//   candidates/A_B.json                    which pairs of keyframes of A and B may show one place
//   links/A_B.json                         which of these do
//   graph/                                 the poses of all frames, and which frames see which tile
//                                          (of each recording R = 0, 1, ..., poses_R.txt, ...)
//   tiles/NAME.ply                         the map, tile by tile
//   summary.json, report.html, ...         what came of it
// Each job reads what others wrote and writes its own, whole or not at all; the same input gives
// the same output. All throw InputError naming the file or option at fault. A fragment without
// places.bin has failed, and is left out.

// Which fragments may have seen the same place.
struct CandidatesOptions {
  std::string scan;  // folder of the plan
  // Folder for A_B.json of each pair, made if missing. Files that would say the same stay as they
  // are, others go.
  std::string output;
  int min_gap = 100;  // frames between two keyframes of one recording, by their indices
  int max_alike = 3;  // keyframes of other fragments that look most alike
  // Of the index of all places; with more, only each n-th keyframe is looked up.
  std::size_t max_index_bytes = std::size_t{500} << 20;

  void Visit(OptionVisitor& visitor);
};

// How many there were.
struct CandidatesResult {
  int fragments = 0, missing = 0, keyframes = 0;
  int looked_up = 0;  // of the keyframes: all, but for want of memory
  int pairs = 0;      // of fragments
};
CandidatesResult FindCandidates(const CandidatesOptions& options);

// Two fragments whose keyframes are to be joined.
struct LinkOptions {
  std::string scan;        // folder of the plan
  std::string candidates;  // the pair's file
  std::string output;      // the link's file
  int threads = 1;         // that compute at the same time

  void Visit(OptionVisitor& visitor);
};

// A pair of keyframes that was verified, of two fragments, by the frames' indices.
struct ScanLink {
  int source_frame = 0, target_frame = 0;
  FarVerdict verdict;
};
// Verifies all candidates of a pair, each both ways, and then pairs that are near each other by one
// that was accepted (VerifyLoop).
std::vector<ScanLink> LinkFragments(const LinkOptions& options);

// How fragments and links become one trajectory.
struct GraphOptions {
  std::string scan;    // folder of the plan
  std::string output;  // folder for the results; made if missing

  void Visit(OptionVisitor& visitor);
};

// What the graph has made of them.
struct GraphResult {
  int fragments = 0, missing = 0;
  int apart = 0;  // of those there are: nothing joins them to the largest part
  int keyframes = 0, frames = 0;
  int frames_total = 0;                        // of all recordings
  int links_accepted = 0, links_left_out = 0;  // verified pairs of keyframes; wrong for the others
  int tiles = 0;
  // By one alignment of all recordings to their ground truths, which must have one frame.
  std::optional<double> ate_rmse_m;
  // Of the links between fragments, and of the loops within them, the one that misses the ground
  // truth most; what is left out does not count.
  std::optional<PoseError> worst_link, worst_loop;
};
// The largest part of fragments that shared frames or links join, by the pose graph of all its
// keyframes. Neighbours of one recording are joined by the poses that both give a frame in the
// middle of those they share, recordings by links alone. Loops and links that do not fit the others
// are left out (GNC). Writes of each recording R trajectory_R.txt (TUM format, in the sequence's
// convention), poses_R.txt (index stamp tx ty tz qx qy qz qw, in that of the map) and
// trajectory_R.png; graph.json and tiles.json.
GraphResult BuildScanGraph(const GraphOptions& options);

// One tile of the map.
struct TileOptions {
  std::string scan;       // folder of the plan
  std::string tile;       // its name in graph/tiles.json
  std::string output;     // the .ply file
  double margin_m = 0.2;  // around the tile is fused as well, so that its border is as its inside
  int threads = 1;        // that compute at the same time

  void Visit(OptionVisitor& visitor);
};
// Fuses what frames of all recordings see of the tile along the final poses (FusePart); returns how
// many surfels it has. Tiles are half-open cubes: each surfel is in one. Indices of its frames are
// counted on from one recording to the next (FirstFrames()).
std::size_t FuseTile(const TileOptions& options, const std::atomic<bool>& interrupted,
                     const std::function<void(int frames)>& progress);

// What is said of a scan.
struct ScanReportOptions {
  std::string scan;  // folder of the plan; results are written there

  void Visit(OptionVisitor& visitor);
};
// What came of one recording.
struct ScannedRecording {
  std::string sequence;              // its path
  int frames_total = 0, frames = 0;  // and those with a pose: none if nothing joins it
  std::optional<double> ate_rmse_m;  // by an alignment of its own
};
// What came of a scan.
struct ScanSummary {
  std::string digest;                // of trajectories and tiles
  int frames_total = 0, frames = 0;  // of all recordings, and those with a pose
  int fragments = 0, links_accepted = 0, tiles = 0;
  std::optional<double> ate_rmse_m;          // GraphResult's
  std::vector<ScannedRecording> recordings;  // none where there is no graph
  std::vector<std::string> failed;           // jobs, with their errors
};
// Writes summary.json, trajectory.txt (of several recordings trajectory_0.txt, trajectory_1.txt,
// ...), pictures of the map and report.html, and removes tiles that are none any more. Where there
// is no graph, they say so.
ScanSummary ReportScan(const ScanReportOptions& options);
ScanSummary ReadScanSummary(const std::string& scan);

// Removes the receipts of jobs that are to be done again: of those whose products are gone, if
// asked for of failed ones, and of all that come after one without a receipt.
void ForgetJobs(const std::string& scan, bool retry_failed);

}  // namespace surfit
