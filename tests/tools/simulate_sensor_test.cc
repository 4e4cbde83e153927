// The sensor model of surfit_simulate, and the parameters that it writes.
#include <gmock/gmock.h>

#include <filesystem>
#include <sstream>

#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

constexpr int kSensorFrames = 4;
constexpr int kSensorSeed = 3;

class SimulateSensorTest : public ::testing::Test {
 protected:
  std::string Simulate(const std::string& name, std::vector<std::string> flags) const {
    flags.insert(flags.end(),
                 {"--output=" + (folder_ / name), "--frames=" + std::to_string(kSensorFrames),
                  "--seed=" + std::to_string(kSensorSeed), "--downsample=8", "--sensor=ideal"});
    const ProgramResult result = RunProgram("surfit_simulate", flags);
    return result.exit_code == 0 ? "" : result.err;
  }
  std::vector<RgbdFrame> Frames(const std::string& name) const {
    SequenceOptions options;
    options.path = folder_ / name;
    std::vector<RgbdFrame> frames;
    const auto source = OpenSequence(options);
    while (auto read = source->Next()) frames.push_back(std::move(read->frame).value());
    return frames;
  }
  std::string Text(const std::string& file) const { return ReadBytes(folder_ / file); }
  bool Exists(const std::string& file) const { return std::filesystem::exists(folder_ / file); }

  TempFolder folder_;
};

TEST_F(SimulateSensorTest, HasNoErrorsByDefault) {
  ASSERT_EQ(Simulate("room", {}), "");
  EXPECT_FALSE(Exists("room/truth_camera.yaml"));
  EXPECT_FALSE(Exists("room/truth_color.txt"));
}

TEST_F(SimulateSensorTest, WritesAWrongCameraAndTheTrueCamera) {
  ASSERT_EQ(Simulate("room", {}), "");
  ASSERT_EQ(Simulate("off", {"--camera_yaml_focal_error=0.01,-0.02",
                             "--camera_yaml_center_error=1.5,-2", "--inverse_depth_offset=0.006"}),
            "");
  const PinholeCamera truth = ReadCameraYaml(folder_ / "room/camera.yaml").depth;
  const PinholeCamera given = ReadCameraYaml(folder_ / "off/camera.yaml").depth;
  EXPECT_DOUBLE_EQ(given.fx, 1.01 * truth.fx);
  EXPECT_DOUBLE_EQ(given.fy, 0.98 * truth.fy);
  EXPECT_DOUBLE_EQ(given.cx, truth.cx + 1.5);
  EXPECT_DOUBLE_EQ(given.cy, truth.cy - 2);
  const PinholeCamera told = ReadCameraYaml(folder_ / "off/truth_camera.yaml").depth;
  EXPECT_EQ(told.fx, truth.fx);
  EXPECT_EQ(told.cy, truth.cy);
  // The correction is the negative of the added error.
  EXPECT_TRUE(ReadInverseDepthField(folder_ / "off/camera.yaml").IsZero());
  EXPECT_EQ(ReadInverseDepthField(folder_ / "off/truth_camera.yaml").coefficients[0], -0.006);
  // Images are rendered with the true camera.
  EXPECT_EQ(Text("off/groundtruth.txt"), Text("room/groundtruth.txt"));
  EXPECT_TRUE(Frames("off")[1].color == Frames("room")[1].color);
}

TEST_F(SimulateSensorTest, DelaysStampsAndWritesKnownLatency) {
  ASSERT_EQ(Simulate("late", {"--latency_s=0.02"}), "");
  ASSERT_EQ(Simulate("known", {"--latency_s=0.02", "--color_latency_s=0.004",
                               "--camera_yaml_times=latency_s,color_latency_s"}),
            "");
  const Trajectory truth = ReadTumTrajectory(folder_ / "late/groundtruth.txt");
  const auto late = Frames("late"), known = Frames("known");
  ASSERT_EQ(late.size(), std::size_t{kSensorFrames});
  for (int i = 0; i < kSensorFrames; ++i) {  // timestamps have six decimals
    EXPECT_NEAR(truth[i].stamp_s, i / 30., 1e-6);
    EXPECT_NEAR(late[i].stamp_s, truth[i].stamp_s + 0.02, 2e-6);
    EXPECT_NEAR(known[i].stamp_s, truth[i].stamp_s, 2e-6);
    EXPECT_NEAR(known[i].color_stamp_s, truth[i].stamp_s - 0.004, 2e-6);
  }
  EXPECT_EQ(ReadCameraYaml(folder_ / "late/camera.yaml").latency_s, 0);
  EXPECT_EQ(ReadCameraYaml(folder_ / "late/truth_camera.yaml").latency_s, 0.02);
  EXPECT_EQ(ReadCameraYaml(folder_ / "known/camera.yaml").latency_s, 0.02);
}

TEST_F(SimulateSensorTest, RendersRowsOfAMovingCamera) {
  ASSERT_EQ(
      Simulate("moving", {"--readout_s=0.03", "--color_readout_s=0.02", "--color_latency_s=0.01",
                          "--exposure_s=0.02", "--exposure_samples=3", "--auto_exposure_lag_s=0.1",
                          "--auto_white_balance_lag_s=0.2", "--channel_gains=1.2,1,0.8"}),
      "");
  RgbdCamera camera = ReadCameraYaml(folder_ / "moving/truth_camera.yaml");
  EXPECT_EQ(camera.readout_s, 0.03);
  EXPECT_EQ(camera.color_latency_s, 0.01);
  EXPECT_EQ(ReadCameraYaml(folder_ / "moving/camera.yaml").readout_s, 0);
  ColorOptions options;
  options.color_readout_s = 0.02;
  options.exposure_s = 0.02;
  options.exposure_samples = 3;
  options.auto_exposure_lag_s = 0.1;
  options.auto_white_balance_lag_s = 0.2;
  options.channel_gains = {1.2, 1, 0.8};
  const Scene scene = MakeScene("room", kSensorSeed);
  const MovingCamera moving(scene, camera, MakePath(scene, kSensorFrames, kSensorSeed), options);
  const auto frames = Frames("moving");
  std::istringstream truth(Text("moving/truth_color.txt"));
  std::string line;
  std::getline(truth, line);
  for (int i = 0; i < kSensorFrames; ++i) {
    const Rendering expected = moving.Frame(i);
    EXPECT_TRUE(frames[i].color == expected.color);
    for (std::size_t k = 0; k < expected.depth_m.size(); ++k) {
      EXPECT_NEAR(frames[i].depth_m[k], expected.depth_m[k], 0.5 / 5000 + 1e-6);
    }
    std::string image;
    double moment_s, exposure_s, readout_s;
    Eigen::Vector3f gains;
    ASSERT_TRUE(truth >> image >> moment_s >> exposure_s >> readout_s >> gains.x() >> gains.y() >>
                gains.z());
    EXPECT_TRUE(Exists("moving/" + image)) << image;
    EXPECT_EQ(moment_s, i / 30. - 0.01);
    EXPECT_EQ(exposure_s, 0.02);
    EXPECT_EQ(readout_s, 0.02);
    EXPECT_EQ(gains, moving.gains(i));
  }
}

TEST_F(SimulateSensorTest, ImagesDoNotDependOnThreads) {
  for (const std::string threads : {"1", "3"}) {
    ASSERT_EQ(Simulate(threads, {"--threads=" + threads, "--readout_s=0.03", "--exposure_s=0.02",
                                 "--auto_exposure_lag_s=0.1"}),
              "");
  }
  for (const char* const file : {"surface.ply", "truth_color.txt", "truth_camera.yaml"}) {
    EXPECT_EQ(Text(std::string("1/") + file), Text(std::string("3/") + file)) << file;
  }
  const auto one = Frames("1"), three = Frames("3");
  ASSERT_EQ(one.size(), std::size_t{kSensorFrames});
  for (int i = 0; i < kSensorFrames; ++i) {
    EXPECT_TRUE(one[i].color == three[i].color);
    EXPECT_TRUE(one[i].depth_m == three[i].depth_m);
  }
}

TEST_F(SimulateSensorTest, SurfaceIsExactWithRollingShutter) {
  ASSERT_EQ(Simulate("rolling", {"--readout_s=0.03"}), "");
  ASSERT_EQ(Simulate("still", {}), "");
  EXPECT_NE(Text("rolling/surface.ply"), Text("still/surface.ply"));
  const Scene scene = MakeScene("room", kSensorSeed);
  const PointCloud surface = ReadPly(folder_ / "rolling/surface.ply");
  for (const Eigen::Vector3f& point : surface.points) {
    ASSERT_LT(std::abs(scene.Distance(point.cast<double>())),
              2e-6);  // rounding of floats up to 8 m
  }
}

TEST_F(SimulateSensorTest, RejectsLatencyOfNumberedFrames) {
  EXPECT_THAT(Simulate("up", {"--image_y_up", "--latency_s=0.02"}), Names("--latency_s"));
  ASSERT_EQ(Simulate("up", {"--image_y_up", "--readout_s=0.02"}), "");
  const RgbdCamera truth = ReadCameraYaml(folder_ / "up/truth_camera.yaml");
  EXPECT_LT(truth.depth.fy, 0);
  EXPECT_EQ(truth.readout_s, 0.02);
}

TEST_F(SimulateSensorTest, RejectsBadFlagsByName) {
  EXPECT_THAT(Simulate("room", {"--camera_yaml_times=readout"}),
              Names("--camera_yaml_times", "readout"));
  EXPECT_THAT(Simulate("room", {"--camera_yaml_times=readout_s,readout_s"}),
              Names("--camera_yaml_times", "readout_s"));
  EXPECT_THAT(Simulate("room", {"--camera_yaml_focal_error=-1,0"}), Names("camera.yaml"));
  EXPECT_THAT(Simulate("room", {"--camera_yaml_center_error=3"}),
              Names("camera_yaml_center_error"));
  EXPECT_THAT(Simulate("room", {"--channel_gains=1,0,1"}), Names("channel_gains"));
  EXPECT_THAT(Simulate("room", {"--readout_s=-1"}), Names("readout_s", -1));
}

}  // namespace
}  // namespace surfit::testing
