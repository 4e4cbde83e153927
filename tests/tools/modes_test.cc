// Modes of programs, and the names of programs and flags of version 0.1.
#include <gmock/gmock.h>

#include "testing/matchers.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

TEST(Modes, RejectsFlagOfAnotherMode) {
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=map", "--every=3"}),
                "--every does not belong to --what=map but to --what=views");
  ExpectRefused(RunProgram("surfit_evaluate", {"--reference=a.ply"}),
                "--reference does not belong to --what=trajectory but to --what=map");
  ExpectRefused(RunProgram("surfit_scan", {"--step=graph", "--nopictures"}),
                "--pictures does not belong to --step=graph but to --step=all or plan");
}

TEST(Modes, RejectsUnknownMode) {
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=maps"}),
                "--what is 'maps', must be one of: trajectory, map, views, revisits");
  ExpectRefused(RunProgram("surfit_scan", {"--step", "tiles"}), "--step is 'tiles', must be one");
}

TEST(Modes, TakeTheModeFromAFlagFile) {
  const TempFolder folder;
  const std::string flags = folder.Write("flags", "--what=map\n");
  ExpectRefused(RunProgram("surfit_evaluate", {"--flagfile=" + flags}), "--map is missing");
}

TEST(Modes, ShowHelpOfTheSelectedModeAndOfAll) {
  const std::string map =
      Succeeded(RunProgram("surfit_evaluate", {"--what=map", "--help=all"})).out;
  EXPECT_THAT(map, AllOf(HasSubstr("--reference="), Not(HasSubstr("--every="))));
  const std::string all = Succeeded(RunProgram("surfit_evaluate", {"--help=all"})).out;
  EXPECT_THAT(all, AllOf(HasSubstr("--reference="), HasSubstr("--every="), HasSubstr("[views]"),
                         HasSubstr("revisits=5]")));
  const std::string words = Succeeded(RunProgram("surfit_scan", {"--help=words"})).out;
  EXPECT_THAT(words, AllOf(HasSubstr("--step=tile\n"), HasSubstr("--tile=\n")));
}

TEST(RemovedFlags, NameTheirReplacement) {
  ExpectRefused(RunProgram("surfit_record", {"--frames=3"}),
                "--frames was removed in 0.2: use --max_frames");
  ExpectRefused(RunProgram("surfit_align", {"--initialize=so3"}),
                "--initialize was removed in 0.2: use --start");
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=revisits", "--min_gap=3"}),
                "--min_gap was removed in 0.2: use --revisit_gap");
  EXPECT_THAT(Succeeded(RunProgram("surfit_record", {"--help=all"})).out,
              Not(HasSubstr("--frames=")));
}

TEST(OldNames, PrintTheNewCommandLine) {
  ExpectRefused(RunProgram("surfit_plan", {"--sequence=a b", "--output=scan"}),
                "use surfit_scan --step=plan --sequence=a\\ b --output=scan");
  ExpectRefused(RunProgram("surfit_scan_tile", {"--tile=0_0_0"}),
                "use surfit_scan --step=tile --tile=0_0_0");
  ExpectRefused(RunProgram("surfit_evaluate_map", {"--map=a.ply"}),
                "use surfit_evaluate --what=map --map=a.ply");
  ExpectRefused(RunProgram("surfit_evaluate_views", {"--run=out", "--pictures=3"}),
                "use surfit_evaluate --what=views --run=out --view_pictures=3");
  ExpectRefused(RunProgram("surfit_evaluate_revisits", {"--min_gap=9", "--max_angle_deg=4"}),
                "use surfit_evaluate --what=revisits --revisit_gap=9 --revisit_angle_deg=4");
  ExpectRefused(RunProgram("surfit_find_loops", {}), "surfit_slam --loop_closure");
}

}  // namespace
}  // namespace surfit::testing
