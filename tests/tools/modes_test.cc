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
  EXPECT_THAT(words, Names("--step=tile", "--part="));
}

TEST(RemovedFlags, NameTheirReplacement) {
  ExpectRefused(RunProgram("surfit_record", {"--frames=3"}), "--frames", "--last");
  ExpectRefused(RunProgram("surfit_align", {"--initialize=features"}), "--initialize", "--start");
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=revisits", "--min_gap=3"}), "--min_gap",
                "--revisit_gap");
  EXPECT_THAT(Succeeded(RunProgram("surfit_record", {"--help=all"})).out, Not(Names("--frames=")));
}

TEST(RemovedFlags, NameTheOptionThatReplacesThem) {
  ExpectRefused(RunProgram("surfit_mesh", {"--min_component_m=0.2"}), "--min_component_m",
                "MeshOptions::min_component_m");
  const ProgramResult old = RunProgram("surfit_mesh", {"--min_piece_m=0.2"});
  EXPECT_EQ(old.exit_code, 1);
  EXPECT_THAT(old.err, Names("--min_piece_m", "MeshOptions::min_component_m"));
  ExpectRefused(RunProgram("surfit_slam", {"--max_view_shift=0.2"}), "--max_view_shift", "0.2",
                "SlamOptions::max_view_shift");
  ExpectRefused(RunProgram("surfit_slam", {"--noreal_time"}), "--real_time",
                "SlamOptions::real_time");
  ExpectRefused(RunProgram("surfit_batch", {"--color_latency_s=0.2"}), "--color_latency_s",
                "camera.yaml");
  ExpectRefused(RunProgram("surfit_record", {"--device_fps=30"}), "--device_fps", "--device");
}

TEST(RenamedFlags, WorkWithAWarning) {
  const ProgramResult help =
      RunProgram("surfit_optimize", {"--initialization=odometry", "--help=words"});
  EXPECT_EQ(help.exit_code, 0) << help.err;
  EXPECT_THAT(help.err, HasWarning("--initialization", "--start"));
  EXPECT_THAT(help.out, Not(Names("--initialization=")));
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
                 "--part=0_0_0");
  EXPECT_THAT(expect_renamed(RunProgram("surfit_evaluate_map", {"--map=a.ply"}), "surfit_evaluate",
                             "--what=map", "--map=a.ply"),
              HasSubstr("--reference"));
  expect_renamed(RunProgram("surfit_evaluate_views", {"--run=out", "--pictures=3"}),
                 "surfit_evaluate", "--what=views", "--run=out", "--pictures");
  expect_renamed(RunProgram("surfit_evaluate_views", {"--run=out", "--pictures=0"}),
                 "surfit_evaluate", "--what=views", "--run=out", "--nopictures");
  expect_renamed(RunProgram("surfit_evaluate_revisits", {"--min_gap=9"}), "surfit_evaluate",
                 "--what=revisits", "--revisit_gap=9");
  ExpectRefused(RunProgram("surfit_find_loops", {}), "surfit_slam", "--loop_closure");
}

}  // namespace
}  // namespace surfit::testing
