#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

class OptionVisitor;

// Jobs of a scan. Files in the folder of a scan:
//   plan.json, fragments/NAME.flags        PlanScan()
//   fragments/NAME/                        output of surfit_slam for a fragment, with places.bin
//   candidates/A_B.json                    loop candidates between the fragments A and B
//   links/A_B.json                         verification results of these candidates
//   graph/                                 poses of all frames, and frames per tile
//                                          (poses_R.txt, ... for each recording R = 0, 1, ...)
//   tiles/NAME.ply                         tiles of the map
//   summary.json, report.html, ...         results
// Each job reads the files of other jobs and writes its own files atomically. Equal input gives
// equal output. All functions throw InputError with the name of the file or option. A fragment
// without places.bin has failed and is skipped.

struct CandidatesOptions {
  std::string scan;  // folder of the plan
  // Output folder for A_B.json, created if missing. Unchanged files keep their modification time.
  // Files of other pairs are deleted.
  std::string output;
  int min_gap = 100;    // minimum index difference of two keyframes of a recording
  int max_similar = 3;  // maximum number of candidates per keyframe
  // Memory limit of the keyframe index. Above this limit, only every n-th keyframe is used.
  std::size_t max_index_bytes = std::size_t{500} << 20;

  void Visit(OptionVisitor& visitor);
};

struct CandidatesResult {
  int fragments = 0, missing = 0, keyframes = 0;
  int looked_up = 0;  // keyframes within the memory limit
  int pairs = 0;      // pairs of fragments
};
CandidatesResult FindCandidates(const CandidatesOptions& options);

struct LinkOptions {
  std::string scan;        // folder of the plan
  std::string candidates;  // candidate file of a pair of fragments
  std::string output;
  int threads = 1;

  void Visit(OptionVisitor& visitor);
};

// Verified keyframe pair of two fragments, by frame index.
struct ScanLink {
  int source_frame = 0, target_frame = 0;
  GlobalRegistrationResult verdict;
};
// Verifies all candidates of two fragments (VerifyLoop()). Then verifies further keyframe pairs
// that are close to each other according to an accepted link.
std::vector<ScanLink> LinkFragments(const LinkOptions& options);

struct GraphOptions {
  std::string scan;    // folder of the plan
  std::string output;  // output folder, created if missing

  void Visit(OptionVisitor& visitor);
};

struct GraphResult {
  int fragments = 0, missing = 0;
  int apart = 0;  // fragments that are not connected to the largest part
  int keyframes = 0, frames = 0;
  int frames_total = 0;                        // of all recordings
  int links_accepted = 0, links_rejected = 0;  // inlier and outlier links
  int tiles = 0;
  // ATE after one alignment of all recordings. Their ground truths must have the same frame.
  std::optional<double> ate_rmse_m;
  // Largest ground-truth error of inlier links between fragments, and of inlier loop closures
  // within fragments.
  std::optional<PoseError> worst_link, worst_loop;
};
// Optimises the pose graph of all keyframes in the largest connected part. Consecutive fragments of
// a recording are connected by the middle frame of their shared frames. Recordings are connected by
// links only. Outlier loops and links are rejected (GNC).
// Writes graph.json and tiles.json, and for each recording R:
// - trajectory_R.txt: TUM format, pose convention of the sequence
// - poses_R.txt: index stamp tx ty tz qx qy qz qw, in the frame of the map
// - trajectory_R.png
GraphResult BuildScanGraph(const GraphOptions& options);

struct TileOptions {
  std::string scan;       // folder of the plan
  std::string tile;       // name in graph/tiles.json
  std::string output;     // output file, .ply
  double margin_m = 0.2;  // margin that is fused as well, for a complete border
  int threads = 1;

  void Visit(OptionVisitor& visitor);
};
// Fuses the frames of all recordings that observe a tile, with the final poses (FusePart()).
// Returns the number of surfels. Tiles are half-open cubes, so each surfel is in one tile.
// FirstFrames() is added to the frame indices of a recording. Calls `progress` with the number of
// fused frames.
std::size_t FuseTile(const TileOptions& options, const std::atomic<bool>& interrupted,
                     const std::function<void(int frames)>& progress);

struct ScanReportOptions {
  std::string scan;  // folder of the plan and of the results

  void Visit(OptionVisitor& visitor);
};
struct ScannedRecording {
  std::string sequence;
  int frames_total = 0, frames = 0;  // `frames`: frames with a pose; 0: not connected
  std::optional<double> ate_rmse_m;  // separate alignment
};
struct ScanSummary {
  std::string digest;                // hash of trajectories and tiles
  int frames_total = 0, frames = 0;  // of all recordings; `frames`: frames with a pose
  int fragments = 0, links_accepted = 0, tiles = 0;
  std::optional<double> ate_rmse_m;          // see GraphResult
  std::vector<ScannedRecording> recordings;  // empty: no graph
  std::vector<std::string> failed;           // failed jobs with their errors
};
// Writes summary.json, trajectory.txt (for several recordings: trajectory_0.txt, trajectory_1.txt,
// ...), pictures of the map and report.html. Deletes trajectories and tiles of a former plan.
// Without a graph, all counts are 0 except the number of fragments.
ScanSummary ReportScan(const ScanReportOptions& options);
ScanSummary ReadScanSummary(const std::string& scan);

// Deletes the receipts of jobs to repeat: successful jobs with missing product, failed jobs if
// `retry_failed` is set, and the jobs that depend on them.
void DeleteStaleReceipts(const std::string& scan, bool retry_failed);

}  // namespace surfit
