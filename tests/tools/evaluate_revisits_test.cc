#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "surfit/io/trajectory_files.h"
#include "testing/run_program.h"

namespace surfit {
namespace {

using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;
using testing::TempFolder;

// A simulated path that stays in a corner of the room, and an estimate that drifts from its poses.
class EvaluateRevisitsTest : public ::testing::Test {
 protected:
  EvaluateRevisitsTest() {
    const ProgramResult simulated = RunProgram(
        "surfit_simulate", {"--output=" + sequence_, "--frames=" + std::to_string(kFrames),
                            "--downsample=4", "--sensor=ideal"});
    EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
    Trajectory poses = ReadTumTrajectory(sequence_ + "/groundtruth.txt");
    TumTrajectoryWriter writer(estimate_);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].world_from_camera.translation.z() += kDrift_m * static_cast<double>(i) / kFrames;
      writer.Append(poses[i]);
    }
  }
  ProgramResult Evaluate(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--sequence=" + sequence_);
    flags.insert(flags.begin(), "--estimate=" + estimate_);
    return RunProgram("surfit_evaluate_revisits", flags);
  }

  static constexpr int kFrames = 40;
  static constexpr double kDrift_m = 0.04;
  const TempFolder folder_;
  const std::string sequence_ = folder_ / "sequence", estimate_ = folder_ / "estimate.txt";
};

// Frames 20 to 40 apart have drifted by 20 to 40 mm.
TEST_F(EvaluateRevisitsTest, TellsWhichPosesLaySurfacesOverEachOther) {
  const ProgramResult result =
      Evaluate({"--min_gap=20", "--max_distance_m=1", "--max_angle_deg=40"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
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

TEST_F(EvaluateRevisitsTest, FailsWhereNothingIsSeenAgain) {
  const ProgramResult result = Evaluate({"--min_gap=1000"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("0 pairs"));
}

TEST_F(EvaluateRevisitsTest, RefusesImpossibleOptions) {
  const ProgramResult result = Evaluate({"--min_gap=0"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("min_gap is 0, must be at least 1"));
}

}  // namespace
}  // namespace surfit
