// Tells whether an estimate or its pseudo ground truth lays the surfaces of two visits to one place
// better over each other.

#include <iostream>

#include "apps/evaluate/revisits.h"
#include "common/console.h"
#include "common/json.h"
#include "common/recorded_run.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit::tools {
namespace {

struct Options {
  RevisitOptions revisits;
  std::string run;
  int threads = 2;

  void Visit(OptionVisitor& v) {
    v.AddPart(revisits, "revisits", "what is compared");
    v.Add(run, "run",
          "output folder of surfit_slam: its trajectory is the estimate, its summary.json says "
          "which sequence it read and how, and its camera.yaml what camera it found, where flags "
          "do not",
          Everyday());
    v.Add(threads, "threads", "threads that compute at the same time", Between(1, 1024),
          Everyday());
  }
  void TakeWhatTheRunRead() {
    if (run.empty()) return;
    TakeRecordedFlags(run, TableOf(&revisits.sequence), {"stride"});
    revisits.estimate = run + "/trajectory.txt";
  }
};

void SetAgreement(const std::string& name, const RevisitAgreement& agreement, Json* json) {
  Json of_trajectory;
  SetStatistics("surface", "m", &agreement.surface_m, &of_trajectory);
  SetStatistics("icp_translation", "m", &agreement.icp_translation_m, &of_trajectory);
  SetStatistics("icp_rotation", "deg", &agreement.icp_rotation_deg, &of_trajectory);
  (*json)[name] = of_trajectory;
}

void PrintSummary(const std::string& name, const RevisitAgreement& agreement) {
  std::cerr << name << ": surfaces " << 1000 * agreement.surface_m.median
            << " mm apart, dense ICP goes " << 1000 * agreement.icp_translation_m.median
            << " mm and " << agreement.icp_rotation_deg.median << " deg (medians)" << std::endl;
}

int Run(const Options& options) {
  const ThreadLimit threads(options.threads);
  ProgressLine line;
  const RevisitReport report = CompareAtRevisits(options.revisits, [&](int done, int all) {
    line.Show(Concat("pair ", done, "/", all), done == all);
  });
  Json json = {{"pairs", report.pairs},
               {"unregistered", report.unregistered},
               {"frames_without_pose", report.without_pose}};
  SetAgreement("groundtruth", report.ground_truth, &json);
  SetAgreement("estimate", report.estimate, &json);
  PrintJson(json);
  std::cerr << report.pairs << " pairs of frames of the same place, " << report.unregistered
            << " of them not registered, seen by " << NameOfCamera(options.revisits.sequence)
            << std::endl;
  if (report.unregistered == report.pairs) return kAlgorithmFailed;
  PrintSummary("ground truth", report.ground_truth);
  PrintSummary("estimate", report.estimate);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::Options options;
  options.revisits.sequence.stride = 5;
  return surfit::tools::ToolMain(
      argc, argv,
      "compares an estimated trajectory and the sequence's own poses where the camera returns to "
      "where it was: how far apart the surfaces of both visits lie, and how far dense ICP goes "
      "from the relative pose. Prints JSON on stdout and a summary on stderr.",
      surfit::TableOf(&options), [&] { return surfit::tools::Run(options); },
      [&] { options.TakeWhatTheRunRead(); });
}
