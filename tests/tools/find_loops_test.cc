#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "surfit/io/g2o.h"
#include "surfit/io/trajectory_files.h"
#include "testing/run_program.h"

namespace surfit {
namespace {

using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;
using ::testing::StartsWith;
using testing::TempFolder;

// A simulated path that stays in a corner of the room, and an estimate that drifts from its poses.
class FindLoopsTest : public ::testing::Test {
 protected:
  FindLoopsTest() {
    const ProgramResult simulated = RunProgram(
        "surfit_simulate",
        {"--output=" + sequence_, "--frames=" + std::to_string(kFrames), "--downsample=2"});
    EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
    Trajectory poses = ReadTumTrajectory(sequence_ + "/groundtruth.txt");
    TumTrajectoryWriter writer(folder_ / "run/trajectory.txt");
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].world_from_camera.translation.z() += kDrift_m * static_cast<double>(i) / kFrames;
      writer.Append(poses[i]);
    }
  }
  ProgramResult Find(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--sequence=" + sequence_);
    flags.insert(flags.begin(), "--output=" + folder_.path() + "/loops");
    return RunProgram("surfit_find_loops", flags);
  }

  static constexpr int kFrames = 60;
  static constexpr double kDrift_m = 0.08;
  const TempFolder folder_;
  const std::string sequence_ = folder_ / "sequence", run_ = folder_.path() + "/run";
};

TEST_F(FindLoopsTest, FindsRightLoopsAndWritesThem) {
  const ProgramResult result =
      Find({"--run=" + run_, "--loop_gap=15", "--revisit_gap=15", "--threads=1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
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
  EXPECT_THAT(testing::ReadBytes(folder_.path() + "/loops/loops.csv"),
              StartsWith("source,target,similarity,prior,reason,"));
}

TEST_F(FindLoopsTest, RefusesImpossibleInput) {
  EXPECT_THAT(Find({}).err, HasSubstr("one of --run and --trajectory must be given"));
  EXPECT_EQ(Find({"--run=" + run_, "--trajectory=" + run_ + "/trajectory.txt"}).exit_code, 1);
  const ProgramResult result = Find({"--run=" + run_, "--loop_gap=0"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("--loop_gap is 0, must be at least 1"));
}

}  // namespace
}  // namespace surfit
