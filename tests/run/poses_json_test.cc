#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "run/results/result_files.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

StampedPose At(double stamp_s, double x, double y) {
  return {stamp_s, Rigid3d(Eigen::Quaterniond::Identity(), {x, y, 0})};
}

// Two poses of another piece are 5 m aside.
TEST(PosesJson, HasErrorsOfTheLargestPieceOnly) {
  const Trajectory truth = {At(0, 0, 0), At(1, 1, 0), At(2, 1, 1), At(3, 2, 1), At(4, 2, 3)};
  Trajectory trajectory = truth;
  trajectory[0] = At(0, 5, 0);
  trajectory[1] = At(1, 6, 0);
  const Trajectory largest(trajectory.begin() + 2, trajectory.end());
  const std::optional<TrajectoryEvaluation> evaluation =
      EvaluateTrajectory(truth, largest, {0, 1, 2, 3, 4}, {});
  const std::vector<int> frames = {10, 11, 12, 13, 14};
  const TempFolder folder;
  const std::string path = folder.path() + "/poses.json";
  const auto written = [&](const Trajectory& piece) {
    WritePosesJson({{}, {}, trajectory, frames, piece, truth, evaluation, {}, {}, {}, {}}, path);
    return nlohmann::json::parse(std::ifstream(path));
  };
  const nlohmann::json json = written(largest);
  EXPECT_EQ(json["largest_piece"], nlohmann::json({12, 13, 14}));
  ASSERT_EQ(json["errors_m"].size(), 3u);
  for (const nlohmann::json& error : json["errors_m"]) EXPECT_NEAR(error[1], 0, 1e-9) << error[0];
  EXPECT_EQ(json["poses"].size(), 5u);
  EXPECT_TRUE(written(trajectory)["largest_piece"].is_null());
}

}  // namespace
}  // namespace surfit::testing
