#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/g2o.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

// A simulated path that stays in a corner of the room, and an estimate that drifts from its poses.
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

class FindLoopsTest : public DriftTest {
 protected:
  FindLoopsTest() : DriftTest(60, 0.08, {"--downsample=2"}) {}
  ProgramResult Find(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--sequence=" + sequence_);
    flags.insert(flags.begin(), "--output=" + folder_.path() + "/loops");
    return RunProgram("surfit_find_loops", flags);
  }
};

TEST_F(FindLoopsTest, FindsRightLoopsAndWritesThem) {
  const ProgramResult result =
      Succeeded(Find({"--run=" + run_, "--loop_gap=15", "--revisit_gap=15", "--threads=1"}));
  EXPECT_THAT(result.out, HasSubstr("60 frames (0 left out"));
  EXPECT_THAT(result.out, HasSubstr("wrong loops accepted: 0"));
  const PoseGraph graph = ReadG2o(folder_.path() + "/loops/loops.g2o").graph;
  EXPECT_GE(graph.poses.size(), 3);
  ASSERT_GE(graph.edges.size(), 1);
  // The estimate's drift over 15 frames or more, 2 cm, is no more in the loops.
  const Trajectory truth = ReadTumTrajectory(sequence_ + "/groundtruth.txt");
  for (const PoseGraphEdge& edge : graph.edges) {
    const auto pose = [&](std::size_t i) { return truth[graph.poses[i].id].world_from_camera; };
    const Rigid3d off = (pose(edge.a).Inverse() * pose(edge.b)).Inverse() * edge.a_from_b;
    EXPECT_LT(off.translation.norm(), 0.01);
  }
  EXPECT_THAT(ReadBytes(folder_.path() + "/loops/loops.csv"),
              StartsWith("source,target,similarity,prior,reason,"));
}

TEST_F(FindLoopsTest, RefusesImpossibleInput) {
  EXPECT_THAT(Find({}).err, HasSubstr("one of --run and --trajectory must be given"));
  EXPECT_EQ(Find({"--run=" + run_, "--trajectory=" + run_ + "/trajectory.txt"}).exit_code, 1);
  ExpectRefused(Find({"--run=" + run_, "--loop_gap=0"}), "--loop_gap is 0, must be at least 1");
}

class EvaluateRevisitsTest : public DriftTest {
 protected:
  EvaluateRevisitsTest() : DriftTest(40, kDrift_m, {"--downsample=4", "--sensor=ideal"}) {}
  ProgramResult Evaluate(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--sequence=" + sequence_);
    flags.insert(flags.begin(), "--estimate=" + estimate_);
    return RunProgram("surfit_evaluate_revisits", flags);
  }

  static constexpr double kDrift_m = 0.04;
};

// Frames 20 to 40 apart have drifted by 20 to 40 mm.
TEST_F(EvaluateRevisitsTest, TellsWhichPosesLaySurfacesOverEachOther) {
  const ProgramResult result =
      Succeeded(Evaluate({"--min_gap=20", "--max_distance_m=1", "--max_angle_deg=40"}));
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_GT(json.at("pairs"), 5);
  EXPECT_EQ(json.at("unregistered"), 0);
  EXPECT_EQ(json.at("frames_without_pose"), 0);
  const auto &truth = json.at("groundtruth"), &estimate = json.at("estimate");
  EXPECT_LT(truth.at("icp_translation_max_m"), 0.005);
  EXPECT_LT(truth.at("surface_max_m"), 0.003);
  EXPECT_GT(estimate.at("surface_median_m"), 2 * truth.at("surface_median_m").get<double>());
  EXPECT_GT(estimate.at("icp_translation_median_m"), 0.5 * kDrift_m - 0.005);
  EXPECT_LT(estimate.at("icp_translation_max_m"), kDrift_m + 0.005);
  EXPECT_THAT(result.err, HasSubstr("dense ICP goes"));
}

TEST_F(EvaluateRevisitsTest, SeesByTheCameraThatTheRunFound) {
  const nlohmann::json summary = {
      {"options", {{"sequence", sequence_}, {"stride", "1"}, {"downsample", "2"}}}};
  WriteBytes(run_ + "/summary.json", summary.dump());
  const auto evaluate = [&](const std::string& flag) {
    return RunProgram("surfit_evaluate_revisits", {"--run=" + run_, "--min_gap=20", flag,
                                                   "--max_distance_m=1", "--max_angle_deg=40"});
  };
  const ProgramResult own = evaluate("--stride=5");
  ASSERT_EQ(own.exit_code, 0) << own.err;
  EXPECT_THAT(own.err, HasSubstr("seen by the sequence's own camera"));
  RgbdCamera found = ReadCameraYaml(sequence_ + "/camera.yaml");
  found.depth.fx *= 1.1;
  found.depth.fy *= 1.1;
  WriteCameraYaml(found, run_ + "/camera.yaml");
  const ProgramResult result = evaluate("--stride=5");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("seen by the camera " + run_ + "/camera.yaml"));
  // A tenth off, it lays exact surfaces apart.
  const auto median = [](const ProgramResult& of) {
    return nlohmann::json::parse(of.out).at("groundtruth").at("surface_median_m").get<double>();
  };
  EXPECT_GT(median(result), 2 * median(own));
  EXPECT_EQ(evaluate("--camera=").out, own.out);
}

TEST_F(EvaluateRevisitsTest, FailsWhereNothingIsSeenAgain) {
  const ProgramResult result = Evaluate({"--min_gap=1000"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("0 pairs"));
}

TEST_F(EvaluateRevisitsTest, RefusesImpossibleOptions) {
  ExpectRefused(Evaluate({"--min_gap=0"}), "min_gap is 0, must be at least 1");
}

}  // namespace
}  // namespace surfit::testing
