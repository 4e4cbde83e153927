#include "run/start_poses.h"

#include <gtest/gtest.h>

#include <random>

#include "testing/random_pose.h"

namespace surfit {
namespace {

TEST(StartPoses, CellsAreEachWithEach) {
  const std::vector<GridCell> cells = AllCells(2, 3);
  ASSERT_EQ(cells.size(), 6u);
  EXPECT_EQ(cells[5].rotation, 1);
  EXPECT_EQ(cells[5].translation, 2);
  EXPECT_TRUE(cells[4].on_diagonal());
  EXPECT_FALSE(cells[5].on_diagonal());
}

TEST(StartPoses, AreOffByTheGivenAngleAndDistance) {
  std::mt19937_64 rng(1);
  const Rigid3d pose = testing::RandomPose(1, 1, &rng);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Rigid3d start = Perturbed(pose, 0.3, 0.2, seed);
    const Rigid3d motion = start * pose.Inverse();  // of the target's frame
    EXPECT_NEAR(RotationAngle(motion.rotation), 0.3, 1e-12);
    EXPECT_NEAR(motion.translation.norm(), 0.2, 1e-12);
  }
}

TEST(StartPoses, DependOnTheSeedAlone) {
  const Rigid3d once = Perturbed(Rigid3d(), 0.3, 0.2, 5), again = Perturbed(Rigid3d(), 0.3, 0.2, 5),
                other = Perturbed(Rigid3d(), 0.3, 0.2, 6);
  EXPECT_EQ(once.Matrix(), again.Matrix());
  EXPECT_NE(once.Matrix(), other.Matrix());
  // Larger steps of a seed go the same way.
  const Rigid3d farther = Perturbed(Rigid3d(), 0.3, 0.4, 5);
  EXPECT_LT((farther.translation - 2 * once.translation).norm(), 1e-12);
}

}  // namespace
}  // namespace surfit
