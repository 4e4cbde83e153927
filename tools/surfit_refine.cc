// Refines a run of surfit_slam: poses, surfels and the camera's calibration, all at once.

#include "apps/solvers/refine_run.h"
#include "common/outcomes.h"
#include "common/recorded_run.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string run;
  RefineRunOptions refine;

  void Visit(OptionVisitor& v) {
    v.Group("run");
    v.Add(run, "run",
          "output folder of surfit_slam; its summary.json says which sequence it read and how, and "
          "its camera.yaml what camera it found, where flags do not",
          Everyday());
    v.AddPart(refine, "refine", "how it is refined");
  }
  void TakeWhatTheRunRead() {
    RequireFlag("run", run);
    TakeRecordedFlags(run, TableOf(&refine.sequence));
    refine.trajectory = run + "/trajectory.txt";
    refine.output = run + "/refined";
  }
};

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::Options options;
  return surfit::tools::ToolMain(
      argc, argv,
      "refines a run of surfit_slam: the poses of keyframes, the surfels that they share and the "
      "camera's calibration by joint least squares; moves the other poses along and fuses the map "
      "anew.",
      surfit::TableOf(&options), [&] { return surfit::tools::RefineAndPrint(options.refine); },
      [&] { options.TakeWhatTheRunRead(); });
}
