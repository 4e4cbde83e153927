// Refines a run of surfit_slam: poses, surfels and the camera's calibration, all at once.

#include "apps/solvers/refine_run.h"
#include "common/outcomes.h"
#include "common/recorded_run.h"
#include "common/tool_main.h"
#include "core/shared_options.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string run;
  RefineRunOptions refine;

  void Visit(OptionVisitor& v) {
    v.Group("run");
    v.Add(run, SharedOption("run", Everyday()));
    v.AddPart(refine, "refine", "how it is refined");
  }
};

void TakeRun(Options* options) {
  RequireFlag("run", options->run);
  TakeRecordedFlags(options->run, TableOf(&options->refine.sequence));
  options->refine.trajectory = options->run + "/trajectory.txt";
  options->refine.output = options->run + "/refined";
}

int Run(const Options& options) { return RefineAndPrint(options.refine); }

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "refines a run of surfit_slam: the poses of keyframes, the surfels that they share and the "
      "camera's calibration by joint least squares; moves the other poses along and fuses the map "
      "anew. The sequence is read with the options and the camera of --run unless flags say "
      "otherwise.",
      surfit::tools::Run, surfit::tools::TakeRun);
}
