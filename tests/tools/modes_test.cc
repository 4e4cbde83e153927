// Modes of programs, and removed names of version 0.1.
#include <gmock/gmock.h>

#include "testing/matchers.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

TEST(Modes, RejectsFlagOfAnotherMode) {
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=map", "--every=3"}), "--every", "--what=map",
                "--what=views");
  ExpectRefused(RunProgram("surfit_evaluate", {"--reference=a.ply"}), "--reference",
                "--what=trajectory", "--what=map");
  ExpectRefused(RunProgram("surfit_scan", {"--step=graph", "--nopictures"}), "--pictures",
                "--step=graph", "--step=all", "plan");
}

TEST(Modes, RejectsUnknownMode) {
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=maps"}), "--what", "maps", "trajectory",
                "map", "views", "revisits");
  ExpectRefused(RunProgram("surfit_scan", {"--step", "tiles"}), "--step", "tiles");
}

TEST(Modes, ReadTheModeFromAFlagFile) {
  const TempFolder folder;
  const std::string flags = folder.Write("flags", "--what=map\n");
  ExpectRefused(RunProgram("surfit_evaluate", {"--flagfile=" + flags}), "--map");
}

TEST(Modes, ShowHelpOfTheSelectedModeAndOfAll) {
  const std::string map =
      Succeeded(RunProgram("surfit_evaluate", {"--what=map", "--help=all"})).out;
  EXPECT_THAT(map, AllOf(Names("--reference="), Not(Names("--every="))));
  const std::string all = Succeeded(RunProgram("surfit_evaluate", {"--help=all"})).out;
  EXPECT_THAT(all, Names("--reference=", "--every=", "[views]", "revisits=5]"));
  const std::string words = Succeeded(RunProgram("surfit_scan", {"--help=words"})).out;
  EXPECT_THAT(words, Names("--step=tile", "--tile="));
}

TEST(RemovedFlags, NameTheirReplacement) {
  ExpectRefused(RunProgram("surfit_record", {"--frames=3"}), "--frames", "--max_frames");
  ExpectRefused(RunProgram("surfit_align", {"--initialize=so3"}), "--initialize", "--start");
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=revisits", "--min_gap=3"}), "--min_gap",
                "--revisit_gap");
  EXPECT_THAT(Succeeded(RunProgram("surfit_record", {"--help=all"})).out, Not(Names("--frames=")));
}

TEST(RenamedFlags, WorkWithAWarning) {
  const ProgramResult refine = RunProgram("surfit_refine", {"--nofree_readout", "--help=words"});
  EXPECT_EQ(refine.exit_code, 0) << refine.err;
  EXPECT_THAT(refine.err, HasWarning("--nofree_readout", "--noestimate_readout"));
  const ProgramResult slam = RunProgram("surfit_slam", {"--max_dormant_frames=7", "--help=words"});
  EXPECT_EQ(slam.exit_code, 0) << slam.err;
  EXPECT_THAT(slam.err, HasWarning("--max_dormant_frames", "--max_inactive_frames"));
  EXPECT_THAT(slam.out, Not(Names("--max_dormant_frames=")));
}

// The new program runs: it names its missing flags and files.
TEST(OldNames, PrintTheNewCommandLineAndRunIt) {
  const auto expect_renamed = [](const ProgramResult& result, const auto&... words) {
    EXPECT_NE(result.exit_code, 0);
    EXPECT_THAT(result.err, HasWarning("renamed", words...));
    return result.err;
  };
  EXPECT_THAT(expect_renamed(RunProgram("surfit_plan", {"--sequence=a b", "--output=scan"}),
                             "surfit_scan", "--step=plan", "--sequence=a\\ b", "--output=scan"),
              HasSubstr("a b is neither"));
  expect_renamed(RunProgram("surfit_scan_tile", {"--tile=0_0_0"}), "surfit_scan", "--step=tile",
                 "--tile=0_0_0");
  EXPECT_THAT(expect_renamed(RunProgram("surfit_evaluate_map", {"--map=a.ply"}), "surfit_evaluate",
                             "--what=map", "--map=a.ply"),
              HasSubstr("--reference"));
  expect_renamed(RunProgram("surfit_evaluate_views", {"--run=out", "--pictures=3"}),
                 "surfit_evaluate", "--what=views", "--run=out", "--view_pictures=3");
  expect_renamed(RunProgram("surfit_evaluate_revisits", {"--min_gap=9", "--max_angle_deg=4"}),
                 "surfit_evaluate", "--what=revisits", "--revisit_gap=9", "--revisit_angle_deg=4");
  ExpectRefused(RunProgram("surfit_find_loops", {}), "surfit_slam", "--loop_closure");
}

}  // namespace
}  // namespace surfit::testing
