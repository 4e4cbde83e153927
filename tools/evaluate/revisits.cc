// Compares an estimate with its pseudo ground truth: agreement of the surfaces of two visits to a
// place.

#include "apps/evaluate/revisits.h"

#include <iostream>

#include "common/console.h"
#include "common/json.h"
#include "common/recorded_flags.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "evaluate/evaluations.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit::tools {
namespace {

struct AllRevisitOptions {
  RevisitOptions revisits;
  std::string run;
  int threads = 2;

  AllRevisitOptions() { revisits.sequence.stride = 5; }

  void Visit(OptionVisitor& v) {
    v.AddPart(revisits, "revisits", "revisits");
    v.Add(run, SharedOption("run", Everyday()));
    v.Add(threads, SharedOption("threads", Everyday()));
  }
};

// Uses the trajectory of the run as estimate.
void TakeRun(AllRevisitOptions* options) {
  if (options->run.empty()) return;
  ApplyRecordedFlags(options->run, TableOf(&options->revisits.sequence), {"stride"});
  options->revisits.estimate = options->run + "/trajectory.txt";
}

void SetFinalFit(const std::string& name, const SurfaceAgreement& agreement, Json* json) {
  Json of_trajectory;
  SetStatistics("surface", "m", &agreement.surface_m, &of_trajectory);
  SetStatistics("icp_translation", "m", &agreement.icp_translation_m, &of_trajectory);
  SetStatistics("icp_rotation", "deg", &agreement.icp_rotation_deg, &of_trajectory);
  (*json)[name] = of_trajectory;
}

void PrintSummary(const std::string& name, const SurfaceAgreement& agreement) {
  std::cerr << name << ": surface distance " << 1000 * agreement.surface_m.median
            << " mm, correction by dense ICP " << 1000 * agreement.icp_translation_m.median
            << " mm and " << agreement.icp_rotation_deg.median << " deg (medians)" << std::endl;
}

int RunRevisits(const AllRevisitOptions& options) {
  const ThreadLimit threads(options.threads);
  ProgressLine line;
  const RevisitReport report = CompareAtRevisits(options.revisits, [&](int done, int all) {
    line.Show(Concat("pair ", done, "/", all), done == all);
  });
  Json json = {{"pairs", report.pairs},
               {"unregistered", report.unregistered},
               {"frames_without_pose", report.without_pose}};
  SetFinalFit("groundtruth", report.ground_truth, &json);
  SetFinalFit("estimate", report.estimate, &json);
  PrintJson(json);
  std::cerr << report.pairs << " frame pairs of the same place, " << report.unregistered
            << " of them not registered, camera: " << NameOfCamera(options.revisits.sequence)
            << std::endl;
  if (report.unregistered == report.pairs) return kAlgorithmFailed;
  PrintSummary("ground truth", report.ground_truth);
  PrintSummary("estimate", report.estimate);
  return kDone;
}

}  // namespace

Mode RevisitEvaluationMode() { return MakeMode("revisits", RunRevisits, TakeRun); }

}  // namespace surfit::tools
