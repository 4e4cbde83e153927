#include "surfit/slam/slam.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "surfit/io/point_cloud.h"
#include "surfit/run/slam_run.h"
#include "testing/matchers.h"
#include "testing/trace_slices.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

TEST_F(SlamTool, WritesTrajectoryMapTablesAndPictures) {
  pictures_ = true;
  const ProgramResult result = Succeeded(Slam(Room(), Output()));
  EXPECT_THAT(result.out, Names("ATE"));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_total"], kFrames);
  EXPECT_EQ(summary["frames_tracked"], kFrames);
  EXPECT_EQ(summary["frames_skipped"], 0);
  EXPECT_EQ(summary["frames_without_intensities"], 0);
  EXPECT_EQ(summary["interrupted"], false);
  EXPECT_EQ(summary["input_points"], kFrames * 160 * 120);
  EXPECT_LE(summary["input_points_valid"], summary["input_points"]);
  EXPECT_EQ(summary["ate_coverage"], 1.0);
  EXPECT_DOUBLE_EQ(summary["compression_ratio"],
                   summary["input_points"].get<double>() / summary["map_points"].get<double>());
  // Pixels are 4 mm wide at 0.5 m and 30 mm at 4 m. The ATE is a fraction of that.
  EXPECT_LT(summary["ate_rmse_m"], 0.015);
  for (const char* key :
       {"match_ratio", "rpe_translation_rmse_m", "rpe_rotation_rmse_deg", "total_s", "frame_ms",
        "stage_ms", "peak_rss_bytes", "residual", "association", "solver", "options", "digest"}) {
    EXPECT_TRUE(summary.contains(key) && !summary[key].is_null()) << key;
  }
  EXPECT_EQ(summary["options"]["sequence"], Room());
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames);
  EXPECT_EQ(Lines(Output() + "/frames.csv").size(), kFrames + 1u);
  EXPECT_EQ(ReadPly(Output() + "/map.ply").points.size(), summary["map_points"]);
  for (const char* name : {"trajectory.png", "map_color.png", "map_normals.png",
                           "map_confidence.png", "map_last_seen.png"}) {
    EXPECT_THAT(ReadBytes(Output() + "/" + name), StartsWith("\x89PNG")) << name;
  }
}

// With given poses both maps have the same geometry. Colours may differ: only the final map knows
// the motion before and after each frame.
TEST_F(SlamTool, FusesTheFinalMapAlongFinalPoses) {
  Succeeded(Slam(Room(), Output("final"), {"--poses=groundtruth"}));
  Succeeded(Slam(Room(), Output("first"), {"--poses=groundtruth", "--nofinal_map"}));
  const nlohmann::json last = Summary(Output("final")), first = Summary(Output("first"));
  EXPECT_GT(last["final_map_s"], 0);
  EXPECT_EQ(first["final_map_s"], nullptr);
  EXPECT_EQ(last["digest"], first["digest"]);
  EXPECT_EQ(first["map_points"], first["surfels_added"].get<std::int64_t>() -
                                     first["surfels_removed"].get<std::int64_t>());
  // Tracking fuses every second frame. The final map contains all frames. It is finer, and has no
  // surfels at depth edges that were observed about once.
  SlamRunOptions fine;
  fine.sequence.path = Room();
  fine.output = Output("fine");
  fine.poses = "groundtruth";
  fine.pictures = fine.final_map = false;
  fine.slam.map_period = 1;
  fine.slam.fusion.max_spacing_m = 0.007f;
  RunSlam(fine, {false}, [](const SlamRunProgress&) {});
  const auto lasting_radii = [&](const char* run) {
    std::vector<float> radii;
    for (const Surfel& surfel : ReadSurfelPly(Output(run) + "/map.ply")) {
      if (surfel.confidence >= 1 && !surfel.from_stereo) radii.push_back(surfel.radius_m);
    }
    std::sort(radii.begin(), radii.end());
    return radii;
  };
  EXPECT_EQ(lasting_radii("final"), lasting_radii("fine"));
  EXPECT_GE(last["map_points"], lasting_radii("final").size());
  EXPECT_LT(last["map_points"], Summary(Output("fine"))["map_points"]);
}

TEST_F(SlamTool, ReportsLoopStatistics) {
  Succeeded(Slam(Room(), Output(), {"--loop_closure", "--norefine"}));
  const nlohmann::json summary = Summary(Output());
  EXPECT_GE(summary["keyframes"], 1);
  for (const char* key : {"loop_candidates", "loops_accepted", "loops_rejected", "relocalisations",
                          "map_corrections", "disconnected_submaps", "surfels_merged_by_loops"}) {
    EXPECT_EQ(summary[key], 0) << key;  // the path is too short for loops
  }
  EXPECT_EQ(summary["submaps"], 1);
  EXPECT_EQ(Lines(Output() + "/loops.csv").size(), 1u);
  EXPECT_EQ(ReadBytes(Output() + "/trajectory.txt"),
            ReadBytes(Output() + "/trajectory_online.txt"));
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames);
}

TEST_F(SlamTool, DigestDoesNotDependOnThreads) {
  std::vector<std::string> digests, maps;
  for (const char* threads : {"--threads=1", "--threads=2", "--threads=2", "--threads=4"}) {
    Succeeded(Slam(Room(), Output(), {threads}));
    digests.push_back(Summary(Output())["digest"]);
    maps.push_back(ReadBytes(Output() + "/map.ply"));
  }
  EXPECT_THAT(digests, Each(digests[0]));
  for (const std::string& map : maps) EXPECT_TRUE(map == maps[0]);
}

TEST_F(SlamTool, DigestDoesNotDependOnInstructionSet) {
  Succeeded(Slam(Room(), Output()));
  const nlohmann::json best = Summary(Output());
  setenv("SURFIT_INSTRUCTIONS", "base", 1);
  const int exit_code = Slam(Room(), Output()).exit_code;
  unsetenv("SURFIT_INSTRUCTIONS");
  ASSERT_EQ(exit_code, 0);
  EXPECT_EQ(Summary(Output())["digest"], best["digest"]);
}

TEST_F(SlamTool, TracesEveryStageOfEveryFrame) {
  const std::string trace = Output() + "/trace.json";
  const ProgramResult result =
      Succeeded(Slam(Room(), Output(), {"--trace=" + trace, "--threads=2", "--nofinal_map"}));
  const std::vector<Slice> slices = ReadSlices(trace);
  ExpectNesting(slices);
  std::map<std::pair<std::string, int>, int> counts;
  for (const Slice& slice : slices) ++counts[{slice.name, slice.frame}];
  std::map<int, std::int64_t> tracked_ns;
  for (const Slice& slice : slices) {  // in order of their end
    if (slice.name == "track") tracked_ns[slice.frame] = slice.end_ns;
    if (slice.name == "draw_ahead" && slice.frame > 0) {
      EXPECT_GE(slice.begin_ns, tracked_ns.at(slice.frame)) << "a pose waited for rendering";
    }
  }
  for (int frame = 0; frame < kFrames; ++frame) {
    for (const char* stage : {"frame", "read", "preprocess", "draw_ahead", "write"}) {
      EXPECT_EQ((counts[{stage, frame}]), 1) << stage << " " << frame;
    }
    EXPECT_EQ((counts[{"fuse", frame}]), frame % 2 == 0 ? 1 : 0) << frame;
    for (const char* stage : {"predict", "track"}) {
      EXPECT_EQ((counts[{stage, frame}]), frame > 0 ? 1 : 0) << stage << " " << frame;
    }
  }
  for (const char* stage : {"read", "preprocess", "predict", "track", "fuse", "write"}) {
    EXPECT_THAT(result.out, ContainsRegex("\n" + std::string(stage) + " ")) << result.out;
    const nlohmann::json times = Summary(Output())["stage_ms"][stage];
    EXPECT_GT(times["share"], 0) << stage;
    EXPECT_LE(times["median"], times["p95"]) << stage;
  }
}

TEST_F(SlamTool, TracksEquallyWithEverySolver) {
  std::vector<double> errors_m;
  for (const char* solver : {"--solver=closed_form_ldlt", "--solver=closed_form_lu",
                             "--solver=closed_form_qr", "--solver=ceres", "--solver=tiny"}) {
    Succeeded(Slam(Room(), Output(), {solver, "--last=9"}));
    errors_m.push_back(Summary(Output())["ate_rmse_m"]);
  }
  // The solvers minimise the same cost. Sums in single and double precision differ in the seventh
  // digit, which can change correspondences at the border of a gate.
  EXPECT_NEAR(errors_m[1], errors_m[0], 1e-4);
  EXPECT_NEAR(errors_m[2], errors_m[0], 1e-4);
  // Levenberg-Marquardt converges to the minimum of each problem, while a Gauss-Newton step stops
  // before. The difference is a tenth of the error.
  EXPECT_NEAR(errors_m[3], errors_m[0], 5e-4);
  EXPECT_NEAR(errors_m[4], errors_m[3], 1e-4);
}

// The flag is in degrees. A gate that differs in the last bit can accept different correspondences.
TEST_F(SlamTool, DefaultGateEqualsTheLibraryBitwise) {
  Succeeded(Slam(Room(), Output(), {"--last=1"}));
  const std::string degrees = Summary(Output())["options"]["max_normal_angle_deg"];
  EXPECT_EQ(std::stod(degrees) * (3.14159265358979323846 / 180),
            SlamOptions().icp.gates.max_normal_angle_rad);
}

TEST_F(SlamTool, HelpShowsCommonFlagsOnTwoScreens) {
  const ProgramResult result = Succeeded(RunProgram("surfit_slam", {"--help"}));
  for (const char* text : {"--sequence", "--output", "--downsample=1", "--solver=closed_form_ldlt",
                           "--flagfile", "--help=GROUP"}) {
    EXPECT_THAT(result.out, Names(text));
  }
  EXPECT_LE(std::count(result.out.begin(), result.out.end(), '\n'), 2 * 30);
}

TEST_F(SlamTool, HelpOnAGroupShowsItsFlags) {
  for (const char* flag : {"--help=map", "--helpon=map"}) {
    EXPECT_THAT(Succeeded(RunProgram("surfit_slam", {flag})).out,
                AllOf(Names("--max_map_points=0"), Not(Names("--sequence"))));
  }
  for (const char* flag : {"--help=all", "--helpfull"}) {
    EXPECT_THAT(Succeeded(RunProgram("surfit_slam", {flag})).out,
                Names("--max_map_points=0", "--sequence"));
  }
  ExpectRefused(RunProgram("surfit_slam", {"--help=magic"}), "--help", "magic", "all", "sequence");
}

TEST_F(SlamTool, PrintsShortHelpAndVersion) {
  EXPECT_EQ(Succeeded(RunProgram("surfit_slam", {"-h"})).out,
            Succeeded(RunProgram("surfit_slam", {"--help"})).out);
  EXPECT_THAT(Succeeded(RunProgram("surfit_slam", {"--version"})).out,
              MatchesRegex("surfit_slam [0-9]+.[0-9]+.[0-9]+\n"));
  for (const char* program : {"surfit_slam", "surfit_convert", "surfit_evaluate"}) {
    ExpectRefused(RunProgram(program, {}), program, "--help");
  }
}

TEST_F(SlamTool, SuggestsSimilarFlags) {
  const auto expect_meant = [](const std::string& argument, const std::string& meant) {
    ExpectRefused(RunProgram("surfit_slam", {argument}), meant);
  };
  expect_meant("--sequenc=x", "--sequence");
  expect_meant("--oupput=x", "--output");
  expect_meant("--noreprot", "--noreport");
  expect_meant("--intr=1,2,3,4", "--intrinsics");  // the only flag with this prefix
  EXPECT_THAT(RunProgram("surfit_slam", {"--zzzzzz=1"}).err, Not(ContainsRegex("--[a-gi-y]")));
  const std::string folder = own_.path();
  ExpectRefused(RunProgram("surfit_slam", {folder}), "--sequence=" + folder);
}

TEST_F(SlamTool, RecordsAllOptions) {
  Succeeded(Slam(Room(), Output(), {"--last=1", "--photometric_weight=0.25"}));
  const auto options = Summary(Output())["options"];
  EXPECT_EQ(options["photometric_weight"], "0.25");
  EXPECT_EQ(options["slam.icp.error_model.kernel.width"], "3");  // no flag
  EXPECT_EQ(options["residual"], SlamOptions().icp.residual);
  EXPECT_EQ(options["slam.icp.min_source_rows"], std::to_string(SlamOptions().icp.min_source_rows));
}

TEST_F(SlamTool, ProcessesFramesAtSensorRate) {
  constexpr double kSlowFps = 2;  // slow enough for sanitizers
  Succeeded(Slam(Room(), Output("free")));
  const ProgramResult result =
      Succeeded(Slam(Room(), Output(), {"--offered_fps=" + std::to_string(kSlowFps)}));
  EXPECT_THAT(result.out, Names("latency"));
  const nlohmann::json summary = Summary(Output()), free = Summary(Output("free"));
  EXPECT_EQ(summary["frames_dropped"], 0);
  EXPECT_EQ(summary["frames_with_longer_map_period"], 0);
  EXPECT_EQ(summary["longest_map_period"], SlamOptions().map_period);
  EXPECT_EQ(summary["digest"], free["digest"]);
  EXPECT_GE(summary["total_s"], (kFrames - 1) / kSlowFps);
  EXPECT_LT(summary["frame_ms"]["median"], 1e3 / kSlowFps);  // without the time between frames
  EXPECT_GT(summary["pose_latency_ms"]["median"], 0);
  EXPECT_LT(summary["pose_latency_ms"]["mean"], summary["latency_ms"]["mean"]);
  EXPECT_TRUE(free["latency_ms"].is_null());
}

TEST_F(SlamTool, CountsDroppedFrames) {
  Succeeded(Slam(Room(), Output(), {"--offered_fps=100000"}));
  const nlohmann::json summary = Summary(Output());
  EXPECT_GT(summary["frames_dropped"], 0);
  EXPECT_EQ(summary["frames_dropped"].get<int>() + summary["frames_total"].get<int>(), kFrames);
}

}  // namespace

}  // namespace surfit::testing
