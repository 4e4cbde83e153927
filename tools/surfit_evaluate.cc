// Compares results with references: trajectories, maps, views and revisits.

#include "common/tool_main.h"
#include "evaluate/evaluations.h"

int main(int argc, char** argv) {
  using namespace surfit::tools;
  return ToolMain(
      argc, argv,
      "compares results with a reference. Prints JSON on stdout and a summary on stderr, for views "
      "a summary on stdout. Flags take precedence over the options of --run.",
      {"what",
       "type of comparison; trajectory: ATE after rigid alignment without scale, RPE and coverage; "
       "map: distances of map points to a reference surface (accuracy) and of reference points to "
       "the map (completeness), --map may be a folder of tiles; views: PSNR, SSIM and depth error "
       "of "
       "the map of --run, rendered at the poses of frames; revisits: distance between the surfaces "
       "of two visits to a place, with --estimate and with the poses of the sequence"},
      {TrajectoryEvaluationMode(), MapEvaluationMode(), ViewEvaluationMode(),
       RevisitEvaluationMode()});
}
