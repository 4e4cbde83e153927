#include "surfit/evaluation/matched_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "surfit/core/error.h"

namespace surfit {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// "first-second" for each match.
std::vector<std::string> Match(const std::vector<double>& first, const std::vector<double>& second,
                               double max_difference_s) {
  std::vector<std::string> matches;
  for (const StampMatch& m : MatchStamps(first, second, {max_difference_s})) {
    matches.push_back(Concat(m.first, "-", m.second));
  }
  return matches;
}

TEST(MatchStamps, MatchesTheNearestWithinTheLimit) {
  EXPECT_THAT(Match({1, 2, 3}, {0.875, 2.125, 2.5, 3.25}, 0.25), ElementsAre("0-0", "1-1", "2-3"));
  EXPECT_THAT(Match({1, 2, 3}, {0.875, 2.125, 2.5, 3.25}, 0.2), ElementsAre("0-0", "1-1"));
}

TEST(MatchStamps, TakesTheNearestPairFirstAndNoStampTwice) {
  // 10.0 and 10.5 both want 10.375. 10.5 is nearer and takes it; 10.0 is left with 9.75.
  EXPECT_THAT(Match({10, 10.5}, {9.75, 10.375}, 1), ElementsAre("0-0", "1-1"));
  EXPECT_THAT(Match({10, 10.5}, {10.375}, 1), ElementsAre("1-0"));
}

TEST(MatchStamps, IsSymmetric) {
  EXPECT_THAT(Match({9.75, 10.375}, {10, 10.5}, 1), ElementsAre("0-0", "1-1"));
  EXPECT_THAT(Match({10.375}, {10, 10.5}, 1), ElementsAre("0-1"));
}

TEST(MatchStamps, OfNothingIsNothing) {
  EXPECT_THAT(Match({}, {1, 2}, 1), IsEmpty());
  EXPECT_THAT(Match({1, 2}, {}, 1), IsEmpty());
  EXPECT_THAT(Match({1, 2}, {4, 5}, 1), IsEmpty());
}

TEST(MatchStamps, MatchesEqualStampsOnceEach) {
  EXPECT_THAT(Match({1, 1, 2}, {1, 2, 2}, 0), ElementsAre("0-0", "2-1"));
}

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
