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
  // Output folder for A_B.json, created if missing. Other .json files in this folder are
  // deleted. Unchanged files keep their modification time.
  std::string output;

  void Visit(OptionVisitor& visitor);
};

// Statistics of FindCandidates(). `missing`: failed fragments, `pairs`: fragment pairs with
// candidates.
struct CandidatesResult {
  int fragments = 0, missing = 0, keyframes = 0;
  int looked_up = 0;  // used keyframes
  int pairs = 0;
};
// Finds similar keyframes of different fragments, and writes one file per fragment pair. Does not
// verify them.
CandidatesResult FindCandidates(const CandidatesOptions& options);

struct LinkOptions {
  std::string scan;        // folder of the plan
  std::string candidates;  // file of the candidates, from FindCandidates()
  std::string output;      // file of the results
  int threads = 1;

  void Visit(OptionVisitor& visitor);
};

// Verification result of a keyframe pair, by frame indices.
struct ScanLink {
  int source_frame = 0, target_frame = 0;
  GlobalRegistrationResult verdict;
};
// Verifies all candidates of two fragments (VerifyLoop()). Then verifies further keyframe pairs
// that are near each other according to an accepted link. Writes all results, also rejected pairs.
// Throws InputError if a fragment has no places.bin, or if a candidate is not a keyframe.
std::vector<ScanLink> LinkFragments(const LinkOptions& options);

struct GraphOptions {
  std::string scan;    // folder of the plan
  std::string output;  // output folder, created if missing

  void Visit(OptionVisitor& visitor);
};

// Result of BuildScanGraph(). `missing`: failed fragments.
struct GraphResult {
  int fragments = 0, missing = 0;
  int apart = 0;  // disconnected fragments
  int keyframes = 0, frames = 0;
  int frames_total = 0;                        // frames of all recordings
  int links_accepted = 0, links_rejected = 0;  // inliers and outliers
  int tiles = 0;
  // ATE with one alignment of all recordings. Only meaningful if their ground truths have the
  // same frame.
  std::optional<double> ate_rmse_m;
  // Largest ground-truth error of inlier links, and of inlier loop closures within fragments. Links
  // between recordings are not compared. std::nullopt without ground truth.
  std::optional<PoseError> worst_link, worst_loop;
};
// Optimises the pose graph of the largest connected part (ScanGraph). Consecutive fragments of a
// recording are connected by a shared frame, recordings by links only. Outliers are rejected if
// LoopOptions::graph selects "gnc". Throws InputError if the graph cannot be solved. Writes
// graph.json and tiles.json, and for each recording R:
// - trajectory_R.txt: TUM format, pose convention of the sequence
// - poses_R.txt: index stamp tx ty tz qx qy qz qw, in the frame of the map
// - trajectory_R.png
GraphResult BuildScanGraph(const GraphOptions& options);

struct TileOptions {
  std::string scan;    // folder of the plan
  std::string tile;    // tile name in graph/tiles.json
  std::string output;  // output file, .ply
  int threads = 1;

  void Visit(OptionVisitor& visitor);
};
// Fuses all frames that observe a tile, at the optimised poses (FusePart()). Returns the number of
// surfels. Tiles are half-open cubes, so each surfel is in one tile. Frame indices of surfels
// include FirstFrames(). `progress` must not be empty. It receives the progress in frames, see
// FinalMapProgress. Throws InputError if interrupted.
std::size_t FuseTile(const TileOptions& options, const std::atomic<bool>& interrupted,
                     const std::function<void(int frames)>& progress);

struct ScanReportOptions {
  std::string scan;  // folder of the plan

  void Visit(OptionVisitor& visitor);
};
// Unknown errors are std::nullopt.
struct ScannedRecording {
  std::string sequence;
  int frames_total = 0, frames = 0;  // frames: with a pose
  std::optional<double> ate_rmse_m;  // with separate alignment
};
// Content of summary.json of a scan.
struct ScanSummary {
  std::string digest;                // hash of trajectories and tiles, hexadecimal
  int frames_total = 0, frames = 0;  // frames: with a pose
  int fragments = 0, links_accepted = 0, tiles = 0;
  std::optional<double> ate_rmse_m;
  std::vector<ScannedRecording> recordings;  // empty: no graph
  std::vector<std::string> failed;           // JOB: ERROR
};
// Writes summary.json, report.html, pictures of the map (if ScanPlan::pictures), and trajectory.txt
// (or trajectory_R.txt for several recordings). Deletes trajectories and tiles of a former plan.
// Without graph.json, all values of the graph are 0 or empty.
ScanSummary ReportScan(const ScanReportOptions& options);
// Reads summary.json.
ScanSummary ReadScanSummary(const std::string& scan);

// Deletes receipts, so that the workflow repeats these jobs: successful jobs without their product,
// and failed jobs if `retry_failed` is true. Also deletes summary.json, and the receipts of
// dependent jobs for fragments, candidates and graph.
void DeleteStaleReceipts(const std::string& scan, bool retry_failed);

}  // namespace surfit
