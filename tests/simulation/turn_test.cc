#include "simulation/turn.h"

#include <gtest/gtest.h>

#include "testing/matchers.h"

namespace surfit {
namespace {

using Eigen::Vector3d;
using testing::VectorNear;

TEST(TurnZInto, BringsZIntoTheDirectionTheShortWay) {
  for (const Vector3d& direction :
       {Vector3d(0, 0, 2), Vector3d(0.3, -0.4, 1.2), Vector3d(5, 0, 0), Vector3d(0, -1e-3, -1),
        Vector3d(0.1, 0.2, -3), Vector3d(0, 0, -0.5)}) {
    const Eigen::Quaterniond turn = TurnZInto(direction);
    EXPECT_NEAR(turn.norm(), 1, 1e-15);
    // 1 + cos loses up to 1e-16 of 5e-7, what is left near upside down.
    EXPECT_THAT(turn * Vector3d::UnitZ(), VectorNear(direction.normalized(), 1e-9));
    EXPECT_EQ(turn.z(), 0) << "turns about z as well";
    EXPECT_GE(turn.w(), 0);
  }
}

}  // namespace
}  // namespace surfit
