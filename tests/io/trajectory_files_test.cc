#include "surfit/io/trajectory_files.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <sstream>

#include "io/files/text.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

TEST(RigidFromNumbers, RejectsNanInEveryPlace) {
  for (int i = 0; i < 7; ++i) {
    double numbers[7] = {1, 2, 3, 0, 0, 0, 1};
    EXPECT_NO_THROW(RigidFromNumbers(numbers));
    numbers[i] = std::nan("");
    ExpectInputError([&] { RigidFromNumbers(numbers); }, Names("nan"));
  }
}

Trajectory RandomTrajectory(int count) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> uniform(-3, 3);
  const auto vector = [&] {
    const double x = uniform(rng), y = uniform(rng), z = uniform(rng);
    return Eigen::Vector3d(x, y, z);
  };
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond rotation = QuaternionExp<double>(vector());
    trajectory.push_back({1305031453.359684 + i / 30.0, Rigid3d(rotation, vector())});
  }
  return trajectory;
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(TumTrajectoryWriter, WritesColumnsStampsAndSeparatorsOfTheFormat) {
  const TempFolder dir;
  TumTrajectoryWriter writer(dir / "t.txt");
  for (StampedPose pose : RandomTrajectory(50)) {
    pose.world_from_camera.translation *=
        1e-7;  // small values, for which default formatting uses exponents
    writer.Append(pose);
  }
  const std::string text = ReadBytes(dir / "t.txt");
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(text.find('\r'), text.npos);
  const auto lines = Lines(text);
  ASSERT_EQ(lines.size(), 51u);
  EXPECT_EQ(lines[0], "# timestamp tx ty tz qx qy qz qw");
  const char* const rule = "[0-9]+\\.[0-9]{6,}( -?[0-9]+\\.[0-9]{9}){7}";
  for (std::size_t i = 1; i < lines.size(); ++i) {
    EXPECT_THAT(lines[i], MatchesRegex(rule));
  }
}

TEST(TumTrajectoryWriter, WritesTheRealPartOfTheQuaternionLast) {
  const TempFolder dir;
  TumTrajectoryWriter writer(dir / "t.txt");
  writer.Append({2.5, Rigid3d(Eigen::Quaterniond(0.4, 0.1, 0.2, 0.3), {1, 2, 3})});
  EXPECT_EQ(Lines(ReadBytes(dir / "t.txt"))[1],
            "2.500000 1.000000000 2.000000000 3.000000000 "
            "0.100000000 0.200000000 0.300000000 0.400000000");
}

TEST(TumTrajectoryWriter, FlushesEveryPose) {
  const TempFolder dir;
  TumTrajectoryWriter writer(dir / "t.txt");
  for (std::size_t i = 1; i <= 3; ++i) {
    writer.Append({1.0 * i, Rigid3d()});
    EXPECT_EQ(ReadTumTrajectory(dir / "t.txt").size(), i);
  }
}

TEST(TumTrajectoryWriter, RejectsUnwritableFile) {
  EXPECT_THAT([] { TumTrajectoryWriter writer("/no/such/folder/t.txt"); },
              ThrowsNaming<InputError>("/no/such/folder/t.txt"));
}

TEST(WriteTumTrajectory, WritesTheSameBytesAsTheWriter) {
  const TempFolder dir;
  const Trajectory trajectory = {{1.5, Rigid3d()},
                                 {2, Rigid3d(Eigen::Quaterniond(0, 0, 1, 0), {1, 2, 3})}};
  {
    TumTrajectoryWriter writer(dir / "a.txt");
    for (const StampedPose& pose : trajectory) writer.Append(pose);
  }
  WriteTumTrajectory(trajectory, dir / "b.txt");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), ReadBytes(dir / "b.txt"));
  ExpectInputError([] { WriteTumTrajectory({}, "/nowhere/t.txt"); }, Names("/nowhere/t.txt"));
}

TEST(ReadTumTrajectory, RoundTripsPoses) {
  const TempFolder dir;
  const Trajectory written = RandomTrajectory(50);
  TumTrajectoryWriter writer(dir / "t.txt");
  for (const StampedPose& pose : written) writer.Append(pose);
  const Trajectory read = ReadTumTrajectory(dir / "t.txt");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    // Half of the last decimal, plus the spacing of doubles of this size, 2.4e-7 s.
    EXPECT_NEAR(read[i].stamp_s, written[i].stamp_s, 0.5e-6 + 2.4e-7);
    // Half of the last decimal in 3 and 4 columns. The angle is twice the angle of the quaternion.
    EXPECT_THAT(read[i].world_from_camera,
                RigidNear(written[i].world_from_camera, 0.5e-9 * 1.74, 2 * 0.5e-9 * 2.01));
  }
}

TEST(ReadTumTrajectory, ReadsCommentsTabsCommasAndCarriageReturns) {
  const TempFolder dir;
  const std::string path = dir.Write("t.txt",
                                     "# comment\r\n"
                                     "1.5 1 2 3 0 0 0 1 \r\n"
                                     "\n"
                                     "  2.5\t-1e-3\t2\t3\t0\t0\t0.6\t0.8\n"
                                     "3.5, 1, 2, 3, 0, 0, 0, -1");
  const Trajectory t = ReadTumTrajectory(path);
  ASSERT_EQ(t.size(), 3u);
  EXPECT_EQ(t[0].stamp_s, 1.5);
  EXPECT_EQ(t[1].world_from_camera.translation, Eigen::Vector3d(-1e-3, 2, 3));
  EXPECT_NEAR(t[1].world_from_camera.rotation.z(), 0.6, 1e-15);
  EXPECT_EQ(t[2].world_from_camera.rotation.w(), -1);
}

TEST(ReadTumTrajectory, SortsByTime) {
  const TempFolder dir;
  const Trajectory t =
      ReadTumTrajectory(dir.Write("t.txt", "2 0 0 0 0 0 0 1\n1 5 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n"));
  ASSERT_EQ(t.size(), 3u);
  EXPECT_EQ(t[0].stamp_s, 1);
  EXPECT_EQ(t[0].world_from_camera.translation.x(), 5);
  EXPECT_EQ(t[2].stamp_s, 3);
}

TEST(ReadTumTrajectory, ReturnsEmptyForAFileWithoutPoses) {
  const TempFolder dir;
  EXPECT_TRUE(ReadTumTrajectory(dir.Write("t.txt", "")).empty());
  EXPECT_TRUE(ReadTumTrajectory(dir.Write("t.txt", "# nothing\n\n")).empty());
}

TEST(ReadTumTrajectory, RejectsMalformedLines) {
  const TempFolder dir;
  const auto expect_error = [&](const std::string& line, const auto&... names) {
    const std::string path = dir.Write("t.txt", "# x\n1 0 0 0 0 0 0 1\n" + line + "\n");
    EXPECT_THAT([&] { ReadTumTrajectory(path); }, ThrowsNaming<InputError>(path + ":3", names...));
  };
  expect_error("2 0 0 0 0 0 0", 7, 8);
  expect_error("2 0 0 0 0 0 0 1 9", 9, 8);
  expect_error("2 0 0 x 0 0 0 1", "x");
  expect_error("2 0 0 1.5z 0 0 0 1", "1.5z");
  expect_error("2 0 0 nan 0 0 0 1", "nan");
  expect_error("2 0 0 1e999 0 0 0 1", "1e999");
  expect_error("2 0 0 -1e300 0 0 0 1", "-1e+300");
  expect_error("2 0 0 0 0 0 0 0", 0, 1);
  expect_error("2 0 0 0 0 0 1 1", 1.41421, 1);
}

TEST(ReadTumStamps, ReadsTheFirstColumnOfAnyList) {
  const TempFolder dir;
  const std::string path = dir.Write("rgb.txt", "# x\n2.5 rgb/2.png\n1.25 rgb/1.png\n");
  EXPECT_THAT(ReadTumStamps(path), ElementsAre(1.25, 2.5));
  dir.Write("rgb.txt", "1.25 rgb/1.png\nrgb/2.png\n");
  EXPECT_THAT([&] { ReadTumStamps(path); }, ThrowsNaming<InputError>(path + ":2", "rgb/2.png"));
}

TEST(ReadTumTrajectory, RejectsUnreadableFiles) {
  const TempFolder dir;
  EXPECT_THAT([&] { ReadTumTrajectory(dir / "none.txt"); }, ThrowsNaming<InputError>("none.txt"));
  EXPECT_THAT([&] { ReadTumTrajectory(dir.path()); }, ThrowsNaming<InputError>(dir.path()));
}

TEST(KittiTrajectory, WritesTheUpperThreeRowsOfEachMatrix) {
  const TempFolder folder;
  // Rotation by 90 degrees about z: x becomes y.
  const Eigen::Quaterniond turn(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  WriteKittiTrajectory({{5, Rigid3d()}, {6, Rigid3d(turn, {1.5, -2, 3})}}, folder / "poses.txt");
  std::istringstream file(ReadBytes(folder / "poses.txt"));
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

TEST(TrajectoryFiles, RejectPosesThatAreNotFinite) {
  const TempFolder folder;
  const double nan = std::nan("");
  const Rigid3d placeless(Eigen::Quaterniond::Identity(), {0, nan, 0});
  const auto expect_refused = [&](const StampedPose& pose) {
    ExpectInputError([&] { WriteKittiTrajectory({pose}, folder / "a.txt"); }, Names("finite"));
    ExpectInputError([&] { WriteTumTrajectory({pose}, folder / "a.txt"); }, Names("finite"));
  };
  expect_refused({1, placeless});
  Rigid3d turned;
  turned.rotation.coeffs().setConstant(nan);
  expect_refused({1, turned});
  ExpectInputError(
      [&] {
        WriteTumTrajectory({{nan, Rigid3d()}}, folder / "a.txt");
      },
      Names("finite"));
}

TEST(KittiTrajectory, RejectsUnwritableFile) {
  ExpectInputError([] { WriteKittiTrajectory({}, "/nowhere/poses.txt"); },
                   Names("/nowhere/poses.txt"));
}

}  // namespace
}  // namespace surfit::testing
