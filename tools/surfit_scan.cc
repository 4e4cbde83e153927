// Scan of any length: plans its jobs, which Snakemake runs. Each job is a step.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "common/console.h"
#include "common/settings_text.h"
#include "common/tool_main.h"
#include "common/workflow.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

struct PlanOptions {
  ScanPlanOptions plan;
  bool calibrate = true;

  void Visit(OptionVisitor& v) {
    v.AddPart(plan, "plan", "fragments");
    v.Group("fragments");
    PairText frames(Option("fragment_frames", "", AtLeast(2)), &plan.fragment_frames,
                    Option("overlap_frames", "", AtLeast(1)), &plan.overlap_frames);
    v.AddText(frames, Option("fragment_frames",
                             "FRAMES,OVERLAP: maximum number of frames of a fragment, and number "
                             "of frames shared by consecutive fragments",
                             Everyday()));
    v.Add(calibrate, SharedOption("calibrate"));
  }

  ScanPlanOptions Plan() const {
    ScanPlanOptions result = plan;
    if (!calibrate) result.camera_frames = 0;
    return result;
  }
};

struct ScanOptions {
  PlanOptions plan;
  WorkflowOptions workflow;

  void Visit(OptionVisitor& v) {
    v.AddPart(plan, "plan", "plan");
    v.AddPart(workflow, "workflow", "jobs");
  }
};

int RunAll(const ScanOptions& options) {
  const std::string& scan = options.plan.plan.run.output;
  const Workflow workflow(options.workflow, scan, "Snakefile");
  workflow.Lock();
  const ScanPlan plan = PlanScan(options.plan.Plan());
  std::cout << plan.fragments.size() << " fragments" << std::endl;
  DeleteStaleReceipts(scan, options.workflow.retry_failed);
  if (!workflow.Run()) return kBadInput;
  const ScanSummary summary = ReadScanSummary(scan);
  std::cout << summary.frames << " of " << summary.frames_total << " frames have a pose";
  if (summary.ate_rmse_m) std::cout << ", ATE " << 1000 * *summary.ate_rmse_m << " mm";
  std::cout << "; " << summary.tiles << " tiles; " << scan << "/report.html" << std::endl;
  for (const ScannedRecording& recording : summary.recordings) {
    if (recording.frames > 0) continue;
    std::cerr << "warning: " << recording.sequence << ": no frame has a pose\n";
  }
  for (const std::string& failed : summary.failed) std::cerr << "warning: " << failed << '\n';
  if (!summary.failed.empty()) {
    std::cerr << "warning: set --retry_failed to repeat the failed jobs" << std::endl;
  }
  return summary.frames == 0 || 2 * summary.frames < summary.frames_total ? kAlgorithmFailed
                                                                          : kDone;
}

int RunPlan(const PlanOptions& options) {
  const ScanPlan plan = PlanScan(options.Plan());
  for (const ScanFragment& fragment : plan.fragments) {
    std::cout << fragment.name << ": " << plan.recordings[fragment.recording].path << ", frames "
              << fragment.first << " to " << fragment.last << '\n';
  }
  std::cout << options.plan.run.output << "/plan.json: " << plan.fragments.size() << " fragments"
            << std::endl;
  return kDone;
}

int RunCandidates(const CandidatesOptions& options) {
  const CandidatesResult result = FindCandidates(options);
  std::cout << result.fragments << " fragments (" << result.missing << " missing), "
            << result.keyframes << " keyframes (" << result.looked_up << " used): " << result.pairs
            << " pairs of fragments have candidates" << std::endl;
  return kDone;
}

int RunLink(const LinkOptions& options) {
  int accepted = 0;
  const std::vector<ScanLink> links = LinkFragments(options);
  for (const ScanLink& link : links) accepted += link.verdict.accepted();
  std::cout << accepted << " of " << links.size() << " keyframe pairs are verified" << std::endl;
  return kDone;
}

int RunGraph(const GraphOptions& options) {
  const GraphResult result = BuildScanGraph(options);
  std::cout << result.fragments << " fragments (" << result.missing << " missing, " << result.apart
            << " disconnected), " << result.keyframes << " keyframes, " << result.frames
            << " frames; " << result.links_accepted << " links, " << result.links_rejected
            << " outliers; " << result.tiles << " tiles";
  if (result.ate_rmse_m) std::cout << "; ATE " << 1000 * *result.ate_rmse_m << " mm";
  std::cout << std::endl;
  return kDone;
}

int RunTile(const TileOptions& options) {
  ProgressLine line;
  const std::size_t points = FuseTile(options, CatchInterruptions(), [&](int frames) {
    line.Show(Concat("frame ", frames), /*last=*/false);
  });
  std::cout << options.output << ": " << points << " surfels" << std::endl;
  return kDone;
}

int RunReport(const ScanReportOptions& options) {
  const ScanSummary summary = ReportScan(options);
  std::cout << options.scan << "/report.html: " << summary.frames << " of " << summary.frames_total
            << " frames have a pose, " << summary.failed.size() << " jobs failed" << std::endl;
  return kDone;
}

int Main(int argc, char** argv) {
  return ToolMain(
      argc, argv,
      "turns recordings of one place, of any length, into trajectories and a map in tiles: splits "
      "them into fragments, and runs the jobs with Snakemake on this machine or a cluster. Each "
      "--sequence is a recording. The same command continues an interrupted scan.",
      {"step",
       "all: the whole scan; other steps are jobs that Snakemake runs; plan: split the "
       "recordings into overlapping fragments; candidates: find loop candidates between fragments; "
       "link: verify the candidates of two fragments; graph: optimise the pose graph of all "
       "fragments; tile: fuse one tile of the map; report: write summary.json, trajectory.txt, "
       "pictures and report.html"},
      {MakeMode("all", RunAll), MakeMode("plan", RunPlan), MakeMode("candidates", RunCandidates),
       MakeMode("link", RunLink), MakeMode("graph", RunGraph), MakeMode("tile", RunTile),
       MakeMode("report", RunReport)});
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) { return surfit::tools::Main(argc, argv); }
