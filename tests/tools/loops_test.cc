#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/evaluate/revisits.h"
#include "benchmarks/loop_search.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

// A simulated path in one corner of a room, with exact poses and a drifting estimate.
class DriftTest : public ::testing::Test {
 protected:
  DriftTest(int frames, double drift_m, const std::vector<std::string>& flags) {
    std::vector<std::string> all = {"--output=" + sequence_, Concat("--frames=", frames)};
    all.insert(all.end(), flags.begin(), flags.end());
    Succeeded(RunProgram("surfit_simulate", all));
    Trajectory poses = ReadTumTrajectory(sequence_ + "/groundtruth.txt");
    TumTrajectoryWriter writer(estimate_);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].world_from_camera.translation.z() += drift_m * static_cast<double>(i) / frames;
      writer.Append(poses[i]);
    }
  }

  const TempFolder folder_;
  const std::string sequence_ = folder_ / "sequence", run_ = folder_.path() + "/run",
                    estimate_ = folder_ / "run/trajectory.txt";
};

class LoopSearchTest : public DriftTest {
 protected:
  LoopSearchTest() : DriftTest(60, 0.08, {"--downsample=2"}) {}
};

TEST_F(LoopSearchTest, FindsCorrectLoops) {
  LoopSearchOptions options;
  options.sequence.path = sequence_;
  options.trajectory = estimate_;
  options.loops.min_gap = options.revisit_gap = 15;
  const LoopSearchResult result = SearchLoops(options);
  EXPECT_EQ(result.frames, 60);
  EXPECT_EQ(result.left_out, 0);
  ASSERT_TRUE(result.evaluation.has_value());
  EXPECT_EQ(result.evaluation->wrong, 0);
  EXPECT_GE(result.keyframes.size(), 3);
  // The estimate drifts by 2 cm over 15 frames. Loop closures do not contain this error.
  int accepted = 0;
  for (const FoundLoop& loop : result.loops) {
    if (!loop.attempt.verdict.accepted()) continue;
    ++accepted;
    EXPECT_LT(loop.error_m.value(), 0.01);
  }
  EXPECT_GE(accepted, 1);
}

class EvaluateRevisitsTest : public DriftTest {
 protected:
  EvaluateRevisitsTest() : DriftTest(40, kDrift_m, {"--downsample=4", "--sensor=ideal"}) {}
  ProgramResult Evaluate(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--sequence=" + sequence_);
    flags.insert(flags.begin(), "--estimate=" + estimate_);
    flags.insert(flags.begin(), "--what=revisits");
    return RunProgram("surfit_evaluate", flags);
  }

  static constexpr double kDrift_m = 0.04;
};

// The drift over 20 to 40 frames is 20 to 40 mm.
TEST_F(EvaluateRevisitsTest, ErrorIsLargerForDriftingPoses) {
  RevisitOptions options;
  options.sequence.path = sequence_;
  options.sequence.stride = 5;
  options.estimate = estimate_;
  options.min_gap = 20;
  options.max_distance_m = 1;
  options.max_angle_rad = 0.7;
  const RevisitReport report = CompareAtRevisits(options, [](int, int) {});
  EXPECT_GT(report.pairs, 5);
  EXPECT_EQ(report.unregistered, 0);
  EXPECT_EQ(report.without_pose, 0);
  const SurfaceAgreement &truth = report.ground_truth, &estimate = report.estimate;
  EXPECT_LT(truth.icp_translation_m.max, 0.005);
  EXPECT_LT(truth.surface_m.max, 0.003);
  EXPECT_GT(estimate.surface_m.median, 2 * truth.surface_m.median);
  EXPECT_GT(estimate.icp_translation_m.median, 0.5 * kDrift_m - 0.005);
  EXPECT_LT(estimate.icp_translation_m.max, kDrift_m + 0.005);
}

TEST_F(EvaluateRevisitsTest, UsesTheCalibrationOfTheRun) {
  const nlohmann::json summary = {
      {"options", {{"sequence", sequence_}, {"stride", "1"}, {"downsample", "2"}}}};
  WriteBytes(run_ + "/summary.json", summary.dump());
  const auto evaluate = [&](const std::string& flag) {
    return RunProgram("surfit_evaluate",
                      {"--what=revisits", "--run=" + run_, "--revisit_gap=10", flag});
  };
  const ProgramResult own = evaluate("--stride=5");
  ASSERT_EQ(own.exit_code, 0) << own.err;
  EXPECT_THAT(own.err, Not(Names(run_ + "/camera.yaml")));
  const auto json = nlohmann::json::parse(own.out);
  EXPECT_GT(json.at("pairs"), 1);
  EXPECT_EQ(json.at("unregistered"), 0);
  EXPECT_EQ(json.at("frames_without_pose"), 0);
  EXPECT_GT(json.at("estimate").at("icp_translation_max_m"), 0);
  RgbdCamera found = ReadCameraYaml(sequence_ + "/camera.yaml");
  found.depth.fx *= 1.1;
  found.depth.fy *= 1.1;
  WriteCameraYaml(found, run_ + "/camera.yaml");
  const ProgramResult result = evaluate("--stride=5");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, Names(run_ + "/camera.yaml"));
  // A focal length error of 10 % separates surfaces of exact poses.
  const auto median = [](const ProgramResult& of) {
    return nlohmann::json::parse(of.out).at("groundtruth").at("surface_median_m").get<double>();
  };
  EXPECT_GT(median(result), 2 * median(own));
  EXPECT_EQ(evaluate("--camera=").out, own.out);
}

TEST_F(EvaluateRevisitsTest, FailsWithoutRevisits) {
  const ProgramResult result = Evaluate({"--revisit_gap=1000"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, Names(0));
}

TEST_F(EvaluateRevisitsTest, RejectsBadOptions) {
  ExpectRefused(Evaluate({"--revisit_gap=0"}), "revisit_gap", 0);
}

}  // namespace
}  // namespace surfit::testing
