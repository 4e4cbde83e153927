#include "surfit/evaluation/matched_poses.h"

#include <gtest/gtest.h>

#include <limits>

#include "surfit/core/error.h"

namespace surfit {
namespace {

TEST(MatchOptions, ValidateRefusesNonsense) {
  EXPECT_NO_THROW(MatchOptions{0}.Validate());
  EXPECT_THROW(MatchOptions{-0.1}.Validate(), InputError);
  EXPECT_THROW(MatchOptions{1.1}.Validate(), InputError);
  EXPECT_THROW(MatchOptions{std::numeric_limits<double>::quiet_NaN()}.Validate(), InputError);
}

TEST(MatchPoses, CarriesEachSidesPoseAndTheEstimatesStamp) {
  Trajectory ground_truth(2), estimate(1);
  ground_truth[0] = {5.0, Rigid3d(Eigen::Quaterniond::Identity(), {1, 0, 0})};
  ground_truth[1] = {6.0, Rigid3d(Eigen::Quaterniond::Identity(), {2, 0, 0})};
  estimate[0] = {6.005, Rigid3d(Eigen::Quaterniond::Identity(), {3, 0, 0})};
  const auto poses = MatchPoses(ground_truth, estimate, MatchOptions());
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].stamp_s, 6.005);
  EXPECT_EQ(poses[0].ground_truth.translation.x(), 2);
  EXPECT_EQ(poses[0].estimate.translation.x(), 3);
}

}  // namespace
}  // namespace surfit
