#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "surfit/core/error.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

// The square of tests/evaluation/trajectory_evaluation_test.cc, which derives the figures. One
// corner is lifted by h = 0.001 m: the ATE is h / 4 for every pose, and the step errors are 0, h,
// h.
constexpr char kSquare[] =
    "# timestamp tx ty tz qx qy qz qw\n"
    "1305031453.000000 -1 -1 0 0 0 0 1\n"
    "1305031454.000000 1 -1 0 0 0 0 1\n"
    "1305031455.000000 1 1 0 0 0 0 1\n"
    "1305031456.000000 -1 1 0 0 0 0 1\n";
constexpr char kLifted[] =
    "1305031453.004 -1 -1 0 0 0 0 1\n"
    "1305031454.004 1 -1 0 0 0 0 1\n"
    "1305031455.004 1 1 0.001 0 0 0 1\n"
    "1305031456.004 -1 1 0 0 0 0 1\n";
constexpr double kLift_m = 0.001;

std::string FirstLines(const std::string& text, int count) {
  std::size_t end = 0;
  for (int i = 0; i < count; ++i) end = text.find('\n', end) + 1;
  return text.substr(0, end);
}

class EvaluateTest : public ::testing::Test {
 protected:
  ProgramResult Evaluate(std::vector<std::string> flags) const {
    flags.push_back("--groundtruth=" + (folder_ / "truth.txt"));
    flags.push_back("--estimate=" + (folder_ / "estimate.txt"));
    return RunProgram("surfit_evaluate", flags);
  }
  void Write(const std::string& truth, const std::string& estimate) const {
    folder_.Write("truth.txt", truth);
    folder_.Write("estimate.txt", estimate);
  }
  TempFolder folder_;
};

TEST_F(EvaluateTest, PrintsTheErrorsOfTheLiftedSquare) {
  Write(kSquare, kLifted);
  const ProgramResult result = Succeeded(Evaluate({}));
  const auto json = nlohmann::json::parse(result.out);
  // The figures are exact up to second order in h.
  EXPECT_NEAR(json.at("ate_rmse_m"), kLift_m / 4, kLift_m * kLift_m);
  EXPECT_NEAR(json.at("ate_max_m"), kLift_m / 4, kLift_m * kLift_m);
  EXPECT_EQ(json.at("ate_coverage"), 1);
  EXPECT_NEAR(json.at("rpe_translation_rmse_m"), kLift_m * std::sqrt(2. / 3), 1e-12);
  EXPECT_EQ(json.at("rpe_rotation_rmse_deg"), 0);
  EXPECT_EQ(json.at("rpe_pairs"), 3);
  EXPECT_EQ(json.at("poses_matched"), 4);
  EXPECT_THAT(result.err, Names(4));
}

TEST_F(EvaluateTest, UsesTheStepOfTheFlags) {
  Write(kSquare, kLifted);
  for (const char* delta : {"2", "2s"}) {
    const ProgramResult result = Succeeded(Evaluate({Concat("--delta=", delta)}));
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("options").at("delta"), delta);
    EXPECT_EQ(json.at("rpe_pairs"), 2);
    EXPECT_NEAR(json.at("rpe_translation_rmse_m"), kLift_m * std::sqrt(1. / 2), 1e-12);
  }
}

// Camera with x = 0.2 sin(4 t), sampled at 1 / `period_s`. Timestamps are `late_s` late.
std::string Swing(int count, double period_s, double begin_s, double late_s) {
  std::string lines;
  for (int i = 0; i < count; ++i) {
    const double t = begin_s + i * period_s;
    lines += Concat(std::fixed, t + late_s, " ", 0.2 * std::sin(4 * t), " ", 0.1 * t, " ",
                    0.01 * std::cos(3 * t), " 0 0 0 1\n");
  }
  return lines;
}

TEST_F(EvaluateTest, ReportsTheTimeOffsetAndTheUncorrectedError) {
  Write(Swing(200, 0.01, 0, 0), Swing(45, 1 / 30., 0.2, 0.02));
  const auto plain = nlohmann::json::parse(Evaluate({}).out);
  EXPECT_TRUE(plain.at("time_offset_s").is_null());
  EXPECT_TRUE(plain.at("ate_at_time_offset_rmse_m").is_null());
  for (const char* offset : {"-0.02", "estimate"}) {
    const ProgramResult result = Succeeded(Evaluate({Concat("--time_offset_s=", offset)}));
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("ate_rmse_m"), plain.at("ate_rmse_m"));
    EXPECT_NEAR(json.at("time_offset_s"), -0.02, 2e-4);
    // Error of linear interpolation: 0.2 * 4^2 m/s^2 * (0.01 s)^2 / 8 = 0.04 mm.
    EXPECT_LT(json.at("ate_at_time_offset_rmse_m"), 1e-4);
    EXPECT_GT(json.at("ate_rmse_m"), 1e-3);
    EXPECT_THAT(result.err, ContainsRegex(" -0[.]0[0-9]"));
  }
}

TEST_F(EvaluateTest, ReportsNoStepAsNull) {
  Write(kSquare, kLifted);
  const ProgramResult result = Succeeded(Evaluate({"--delta=10"}));
  EXPECT_TRUE(nlohmann::json::parse(result.out).at("rpe_translation_rmse_m").is_null());
  EXPECT_THAT(result.err, Names(10));
}

TEST_F(EvaluateTest, CoverageCountsTheListedFrames) {
  Write(kSquare, FirstLines(kLifted, 3));
  EXPECT_EQ(nlohmann::json::parse(Evaluate({}).out).at("ate_coverage"), 0.75);
  const std::string frames = folder_.Write(
      "rgb.txt", "1305031453.004 a.png\n1305031454.004 b.png\n1305031455.004 c.png\n");
  const ProgramResult result = Succeeded(Evaluate({"--frame_list=" + frames}));
  EXPECT_EQ(nlohmann::json::parse(result.out).at("ate_coverage"), 1);
}

TEST_F(EvaluateTest, RejectsFewerThanThreeMatches) {
  Write(kSquare, kLifted);
  ExpectRefused(Evaluate({"--max_gap_s=0.05,0.003"}), 0, 0.003, 3);
  Write(kSquare, FirstLines(kLifted, 2));
  ExpectRefused(Evaluate({}), "estimate.txt", 2, "1305031453.004", "1305031454.004");
  Write("# nothing\n", kLifted);
  ExpectRefused(Evaluate({}), "truth.txt");
}

TEST_F(EvaluateTest, RejectsMalformedFilesByLine) {
  Write(kSquare, "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n");
  ExpectRefused(Evaluate({}), "estimate.txt:2", 7, 8);
  Write(std::string("\x89PNG\n"), kLifted);
  ExpectRefused(Evaluate({}), "truth.txt:1");
}

TEST_F(EvaluateTest, RejectsBadFlags) {
  Write(kSquare, kLifted);
  ExpectRefused(Evaluate({"--delta=0"}), "delta", 0);
  ExpectRefused(Evaluate({"--delta=1.5"}), "delta", 1.5, "frames");
  ExpectRefused(Evaluate({"--delta=1m"}), "--delta", "1m", "frames", "seconds");
  ExpectRefused(Evaluate({"--delta=s"}), "--delta", "s", "frames", "seconds");
  ExpectRefused(Evaluate({"--max_gap_s=0.05,-1"}), "max_difference_s", -1);
  ExpectRefused(Evaluate({"--max_gap_s=0.05,abc"}), "max_difference_s", "abc");
  ExpectRefused(Evaluate({"--max_gap_s=2"}), "max_gap_s", 2);
  ExpectRefused(Evaluate({"--max_difference_s=0.02"}), "--max_difference_s", "--max_gap_s");
  ExpectRefused(Evaluate({"--time_offset_s=late"}), "time_offset_s", "late", "estimate");
  ExpectRefused(Evaluate({"--time_offset_s=100"}), "time_offset_s", 100, 3);
  ExpectRefused(Evaluate({"--time_offset_s=estimate"}), "time_offset_s", "estimate", 0.1);
  ExpectRefused(Evaluate({"--no_such_flag=1"}), "no_such_flag");
  ExpectRefused(Evaluate({"word"}), "word");
  ExpectRefused(RunProgram("surfit_evaluate", {}), "--groundtruth");
  ExpectRefused(RunProgram("surfit_evaluate", {"--groundtruth=x"}), "--estimate");
  ExpectRefused(RunProgram("surfit_evaluate", {"--groundtruth=/no/such", "--estimate=x"}),
                "/no/such");
}

TEST_F(EvaluateTest, AcceptsNamesThatAreNotUtf8) {
  Write(kSquare, kLifted);
  const ProgramResult result =
      Succeeded(Evaluate({"--frame_list=" + folder_.Write("\xff.txt", "1305031453 a.png\n")}));
  EXPECT_NO_THROW(nlohmann::json::parse(result.out));
}

TEST_F(EvaluateTest, ReadsAFlagfile) {
  Write(kSquare, kLifted);
  const std::string flags = folder_.Write("flags", "--delta=2\n--max_gap_s=0,0.02\n");
  const ProgramResult result = Succeeded(Evaluate({"--flagfile=" + flags}));
  EXPECT_EQ(nlohmann::json::parse(result.out).at("options").at("max_gap_s"), "0,0.02");
}

TEST_F(EvaluateTest, RejectsBadFlagfiles) {
  const auto expect_refused = [&](const std::string& text, const auto&... names) {
    ExpectRefused(Evaluate({"--flagfile", folder_.Write("flags", text)}), names...);
  };
  expect_refused("# a misspelt flag\n--deltas=2\n", "deltas");
  expect_refused("\n  --delta=much\r\n", "much", "delta");
  expect_refused("delta=2\n", "delta=2");
  expect_refused("--flagfile=other\n", "--flagfile=other");
  ExpectRefused(Evaluate({"--flagfile=" + folder_.path()}), folder_.path());
}

TEST(EvaluateHelp, ShowsEveryDefault) {
  const ProgramResult result = Succeeded(RunProgram("surfit_evaluate", {"--help"}));
  EXPECT_THAT(result.out, Names("--max_gap_s=0.05,0.01", "--delta=1"));
}

// Motion capture at 100 Hz, compared with itself: the error is 0, and all nine frames are covered.
TEST(EvaluateSharedData, ReadsMotionCaptureAndCountsFrames) {
  SURFIT_REQUIRE_SHARED_DATA("tum_fr1_desk_9");
  const std::string folder = SharedData("tum_fr1_desk_9");
  const ProgramResult result =
      Succeeded(RunProgram("surfit_evaluate", {"--groundtruth=" + folder + "/groundtruth.txt",
                                               "--estimate=" + folder + "/groundtruth.txt",
                                               "--frame_list=" + folder + "/rgb.txt"}));
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_LT(json.at("ate_max_m"), 1e-9);
  EXPECT_EQ(json.at("poses_expected"), 9);
  EXPECT_EQ(json.at("ate_coverage"), 1);
}

class EvaluateMapTest : public ::testing::Test {
 protected:
  EvaluateMapTest() {
    // Reference points in a row, 0.25 m apart, with normals along z. Surfels are 1/128 m, 1/128 m
    // and 0.5 m above the first three points.
    PointCloud reference;
    for (int i = 0; i < 4; ++i) {
      reference.points.push_back({0.25f * i, 0, 0});
      reference.normals.push_back({0, 0, 1});
    }
    WritePly(reference, folder_ / "reference.ply");
    SurfelMap map;
    for (int i = 0; i < 3; ++i) {
      Surfel surfel;
      surfel.position_in_world = {0.25f * i, 0, i == 2 ? 0.5f : 0.0078125f};
      map.Append(surfel);
    }
    WriteSurfelPly(map, folder_ / "map.ply");
  }
  ProgramResult Evaluate(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--reference=" + (folder_ / "reference.ply"));
    flags.insert(flags.begin(), "--map=" + (folder_ / "map.ply"));
    flags.insert(flags.begin(), "--what=map");
    return RunProgram("surfit_evaluate", flags);
  }
  TempFolder folder_;
};

TEST_F(EvaluateMapTest, PrintsAccuracyAndCompletenessAsJson) {
  const ProgramResult result = Succeeded(Evaluate({}));
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("accuracy_mean_m"), (2 * 0.0078125 + 0.5) / 3);
  EXPECT_EQ(json.at("accuracy_median_m"), 0.0078125);
  EXPECT_NEAR(json.at("accuracy_p90_m"), 0.0078125 + 0.8 * (0.5 - 0.0078125), 1e-12);
  EXPECT_EQ(json.at("plane_accuracy_max_m"), 0.5);
  EXPECT_EQ(json.at("completeness"),
            0.5);  // two of four points within the default distance of 1 cm
  EXPECT_EQ(json.at("map_points"), 3);
  EXPECT_EQ(json.at("reference_points"), 4);
}

TEST_F(EvaluateMapTest, ReadsAFolderOfTilesAsOneMap) {
  const TempFolder tiles;
  for (int i = 0; i < 3; ++i) {
    SurfelMap map;
    Surfel surfel;
    surfel.position_in_world = {0.25f * i, 0, i == 2 ? 0.5f : 0.0078125f};
    map.Append(surfel);
    WriteSurfelPly(map, tiles / ("tile" + std::to_string(i) + ".ply"));
  }
  tiles.Write("tiles.json", "{}");
  const ProgramResult whole = Succeeded(Evaluate({}));
  auto json = nlohmann::json::parse(Succeeded(Evaluate({"--map=" + tiles.path()})).out),
       expected = nlohmann::json::parse(whole.out);
  json.erase("options"), expected.erase("options");
  EXPECT_EQ(json, expected);
  const TempFolder empty;
  ExpectRefused(Evaluate({"--map=" + empty.path()}), empty.path(), ".ply", ".pcd");
}

// The third point is within 0.5 m (inclusive). The fourth is sqrt(0.25^2 + 0.5^2) m away.
TEST_F(EvaluateMapTest, CompletenessIncludesPointsAtItsDistance) {
  const PointCloud reference = ReadPly(folder_ / "reference.ply");
  const PointCloud map = ReadPly(folder_ / "map.ply");
  EXPECT_EQ(ComputeMapError(map.points, reference.points, reference.normals, {0.5}).completeness,
            0.75);
}

// The frame of the map is rotated by 90 degrees and shifted by 1 m. Without alignment the error
// exceeds 1 m.
TEST_F(EvaluateMapTest, AlignsTheMapByTheTrajectory) {
  const std::string truth =
      folder_.Write("truth.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n");
  const std::string estimate =
      folder_.Write("estimate.txt", "0 0 0 1 0 0 0 1\n1 0 1 1 0 0 0 1\n2 -1 1 1 0 0 0 1\n");
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel surfel;
    surfel.position_in_world = {0, 0.25f * i, 1.0078125f};
    map.Append(surfel);
  }
  WriteSurfelPly(map, folder_ / "map.ply");
  EXPECT_GT(nlohmann::json::parse(Evaluate({}).out).at("accuracy_median_m"), 1);
  const ProgramResult result =
      Succeeded(Evaluate({"--estimate=" + estimate, "--groundtruth=" + truth}));
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_NEAR(json.at("accuracy_max_m"), 0.0078125, 1e-6);  // single precision at 1 m
  EXPECT_EQ(json.at("completeness"), 0.75);
  EXPECT_NEAR(json.at("reference_from_map").at("translation_m").at(2), -1, 1e-12);
}

TEST_F(EvaluateMapTest, RejectsCollinearTrajectories) {
  const std::string straight =
      folder_.Write("straight.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  ExpectRefused(Evaluate({"--estimate=" + straight, "--groundtruth=" + straight}), "straight.txt",
                3);
  ExpectRefused(Evaluate({"--estimate=" + straight}), "--groundtruth");
}

TEST_F(EvaluateMapTest, RejectsBadInput) {
  ExpectRefused(Evaluate({"--completeness_distance_m=0.02"}), "--completeness_distance_m",
                "MapErrorOptions::completeness_distance_m");
  ExpectRefused(Evaluate({"--map=" + folder_.Write("bad.ply", "solid cube")}), "bad.ply", "PLY",
                "PCD");
  ExpectRefused(Evaluate({"--map=" + (folder_ / "none.ply")}), "none.ply");
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=map"}), "--map");
  WriteSurfelPly(SurfelMap(), folder_ / "empty.ply");
  ExpectRefused(Evaluate({"--map=" + (folder_ / "empty.ply")}), "map");
}

}  // namespace
}  // namespace surfit::testing
