#include "surfit/io/kitti_trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "testing/expect_input_error.h"
#include "testing/temp_folder.h"

namespace surfit {
namespace {

TEST(KittiTrajectory, IsTheUpperRowsOfEachMatrix) {
  const testing::TempFolder folder;
  // A quarter turn about z: x goes to y.
  const Eigen::Quaterniond turn(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  WriteKittiTrajectory({{5, Rigid3d()}, {6, Rigid3d(turn, {1.5, -2, 3})}}, folder / "poses.txt");
  std::istringstream file(testing::ReadBytes(folder / "poses.txt"));
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line,
            "1.000000000 0.000000000 0.000000000 0.000000000 0.000000000 1.000000000 0.000000000 "
            "0.000000000 0.000000000 0.000000000 1.000000000 0.000000000");
  std::vector<double> values(12);
  for (double& value : values) file >> value;
  EXPECT_THAT(values, ::testing::Pointwise(::testing::DoubleNear(1e-9),
                                           {0., -1., 0., 1.5, 1., 0., 0., -2., 0., 0., 1., 3.}));
  std::string rest;
  EXPECT_FALSE(file >> rest);
}

TEST(KittiTrajectory, NamesTheFileThatCannotBeWritten) {
  testing::ExpectInputError([] { WriteKittiTrajectory({}, "/nowhere/poses.txt"); },
                            ::testing::HasSubstr("/nowhere/poses.txt"));
}

}  // namespace
}  // namespace surfit
