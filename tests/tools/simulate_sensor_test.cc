// The sensor model of surfit_simulate, and the parameters that it writes.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

constexpr int kSensorFrames = 4;
constexpr int kSensorSeed = 3;

class SimulateSensorTest : public ::testing::Test {
 protected:
  std::string Simulate(const std::string& name, const std::vector<std::string>& flags) const {
    return SimulateAs("ideal", name, flags);
  }
  // Later flags take precedence.
  std::string SimulateAs(const std::string& sensor, const std::string& name,
                         const std::vector<std::string>& more) const {
    std::vector<std::string> flags = {
        "--output=" + (folder_ / name), "--frames=" + std::to_string(kSensorFrames),
        "--seed=" + std::to_string(kSensorSeed), "--downsample=8", "--sensor=" + sensor};
    flags.insert(flags.end(), more.begin(), more.end());
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
  ASSERT_EQ(Simulate("off", {"--sensor_settings=camera_yaml_focal_error=0.01,-0.02;"
                             "camera_yaml_center_error=1.5,-2;inverse_depth_offset=0.006"}),
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
  ASSERT_EQ(Simulate("late", {"--sensor_settings=latency_s=0.02"}), "");
  ASSERT_EQ(Simulate("known", {"--sensor_settings=latency_s=0.02;color_latency_s=0.004;"
                               "camera_yaml_times=latency_s,color_latency_s"}),
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
  ASSERT_EQ(Simulate("moving",
                     {"--sensor_settings=readout_s=0.03;color_readout_s=0.02;color_latency_s=0.01;"
                      "exposure_s=0.02;auto_exposure_lag_s=0.1;auto_white_balance_lag_s=0.2;"
                      "channel_gains=1.2,1,0.8"}),
            "");
  RgbdCamera camera = ReadCameraYaml(folder_ / "moving/truth_camera.yaml");
  EXPECT_EQ(camera.readout_s, 0.03);
  EXPECT_EQ(camera.color_latency_s, 0.01);
  EXPECT_EQ(ReadCameraYaml(folder_ / "moving/camera.yaml").readout_s, 0);
  ColorOptions options;
  options.color_readout_s = 0.02;
  options.exposure_s = 0.02;
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
    ASSERT_EQ(Simulate(threads, {"--threads=" + threads,
                                 "--sensor_settings=readout_s=0.03;exposure_s=0.02;"
                                 "auto_exposure_lag_s=0.1"}),
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
  ASSERT_EQ(Simulate("rolling", {"--sensor_settings=readout_s=0.03"}), "");
  ASSERT_EQ(Simulate("still", {}), "");
  EXPECT_NE(Text("rolling/surface.ply"), Text("still/surface.ply"));
  const Scene scene = MakeScene("room", kSensorSeed);
  const PointCloud surface = ReadPly(folder_ / "rolling/surface.ply");
  for (const Eigen::Vector3f& point : surface.points) {
    ASSERT_LT(std::abs(scene.Distance(point.cast<double>())),
              2e-6);  // rounding of floats up to 8 m
  }
}

TEST_F(SimulateSensorTest, SizeScalesTheIntrinsics) {
  ASSERT_EQ(Simulate("room", {"--downsample=1", "--size=160x96", "--frames=1"}), "");
  const PinholeCamera camera = ReadCameraYaml(folder_ / "room/camera.yaml").depth;
  EXPECT_EQ(camera.width, 160);
  EXPECT_EQ(camera.height, 96);
  EXPECT_DOUBLE_EQ(camera.fx, 525 / 4.);
  EXPECT_DOUBLE_EQ(camera.fy, 525 / 5.);
  EXPECT_DOUBLE_EQ(camera.cx, 79.5);  // the centre of the image stays the centre
  EXPECT_DOUBLE_EQ(camera.cy, 47.5);
  const auto frames = Frames("room");
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].depth_m.width(), 160);
  EXPECT_EQ(frames[0].depth_m.height(), 96);
}

TEST_F(SimulateSensorTest, SensorsHaveExactGroundTruthAndTheirNoise) {
  ASSERT_EQ(Simulate("ideal", {}), "");
  const Scene scene = MakeScene("room", kSensorSeed);
  for (const std::string sensor : {"stereo", "tof", "lidar"}) {
    ASSERT_EQ(SimulateAs(sensor, sensor, {"--downsample=4"}), "");
    EXPECT_EQ(Text(sensor + "/groundtruth.txt"), Text("ideal/groundtruth.txt")) << sensor;
    const PointCloud surface = ReadPly(folder_ / (sensor + "/surface.ply"));
    EXPECT_GT(surface.points.size(), 100u);
    for (const Eigen::Vector3f& point : surface.points) {
      ASSERT_LT(std::abs(scene.Distance(point.cast<double>())), 2e-6);  // floats of up to 8 m
    }
    // The noise estimate uses all frames.
    const RgbdCamera camera = ReadCameraYaml(folder_ / (sensor + "/camera.yaml"));
    const Trajectory path = MakePath(scene, kSensorFrames, kSensorSeed);
    const auto frames = Frames(sensor);
    double squares = 0, count = 0;
    for (int i = 0; i < kSensorFrames; ++i) {
      const Rendering exact = Render(scene, camera.depth, path[i].world_from_camera);
      const std::uint64_t seed = (std::uint64_t{kSensorSeed} << 32) + i;
      const SensorImage expected = sensor == "stereo" ? StereoDepth(exact, camera.depth, seed)
                                   : sensor == "tof"  ? TofDepth(exact, camera.depth, seed)
                                                      : LidarDepth(exact, camera.depth, seed);
      for (std::size_t k = 0; k < expected.depth_m.size(); ++k) {
        if (expected.depth_m[k] == 0) continue;
        // Depth of low confidence is missing.
        if (sensor != "lidar" || frames[i].depth_m[k] != 0) {
          ASSERT_NEAR(frames[i].depth_m[k], expected.depth_m[k], 0.5 / 5000 + 1e-6) << sensor;
        }
        squares += std::pow(expected.inverse_depth_sigma[k], 2);
        ++count;
      }
    }
    const double sigma = std::sqrt(squares / count);
    EXPECT_NEAR(camera.noise.inverse_depth_sigma, sigma, 0.0006 * sigma) << sensor;  // four digits
  }
  EXPECT_EQ(ReadCameraYaml(folder_ / "ideal/camera.yaml").noise.inverse_depth_sigma,
            DepthNoise().inverse_depth_sigma);
}

TEST_F(SimulateSensorTest, LidarWritesConfidence) {
  ASSERT_EQ(SimulateAs("lidar", "phone", {"--downsample=1", "--frames=2"}), "");
  EXPECT_EQ(ReadCameraYaml(folder_ / "phone/camera.yaml").depth.width, 256);
  std::istringstream depths(Text("phone/depth.txt")), confidences(Text("phone/confidence.txt"));
  std::string depth, confidence;
  int counts[3] = {};
  while (std::getline(depths, depth)) {
    ASSERT_TRUE(std::getline(confidences, confidence));
    if (depth[0] == '#') {
      EXPECT_EQ(confidence, "# timestamp filename");
      continue;
    }
    EXPECT_EQ(confidence.substr(0, confidence.find(' ')), depth.substr(0, depth.find(' ')));
    const std::string file = confidence.substr(confidence.find(' ') + 1);
    EXPECT_THAT(file, StartsWith("confidence/"));
    const cv::Mat image = cv::imread(folder_ / ("phone/" + file), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(image.type(), CV_8UC1);
    ASSERT_EQ(image.cols, 256);
    ASSERT_EQ(image.rows, 192);
    for (const auto [u, v] : PixelsOf(image.cols, image.rows)) {
      ASSERT_LE(image.at<std::uint8_t>(v, u), 2);
      ++counts[image.at<std::uint8_t>(v, u)];
    }
  }
  EXPECT_FALSE(std::getline(confidences, confidence));
  for (const int count : counts) EXPECT_GT(count, 0);
  ASSERT_EQ(SimulateAs("kinect", "phone", {}), "");  // replaces the simulation
  EXPECT_FALSE(Exists("phone/confidence.txt"));
  EXPECT_FALSE(Exists("phone/confidence"));
}

TEST_F(SimulateSensorTest, RejectsLatencyOfNumberedFrames) {
  EXPECT_THAT(Simulate("up", {"--format=icl_nuim", "--sensor_settings=latency_s=0.02"}),
              Names("latency_s", "--sensor_settings", "--format=icl_nuim"));
  EXPECT_THAT(Simulate("up", {"--format=icl_nuim", "--imu"}), Names("--imu"));
  ASSERT_EQ(Simulate("up", {"--format=icl_nuim", "--sensor_settings=readout_s=0.02"}), "");
  const RgbdCamera truth = ReadCameraYaml(folder_ / "up/truth_camera.yaml");
  EXPECT_LT(truth.depth.fy, 0);
  EXPECT_EQ(truth.readout_s, 0.02);
}

TEST_F(SimulateSensorTest, RejectsBadSettingsByName) {
  // The message ends with the setting and its constraint, after the text of the flag.
  const auto refuses = [&](const std::string& settings, const std::vector<std::string>& names) {
    const std::string flag = "--sensor_settings", error = Simulate("room", {flag + "=" + settings});
    const std::string text = flag + " is '" + settings + "'";
    ASSERT_THAT(error, StartsWith("error: " + text));
    EXPECT_THAT(error.substr(7 + text.size()), NamesMatcher(names));
  };
  refuses("camera_yaml_times=readout", {"camera_yaml_times", "readout", "readout_s"});
  refuses("camera_yaml_times=readout_s,readout_s", {"camera_yaml_times", "readout_s", "latency_s"});
  EXPECT_THAT(Simulate("room", {"--sensor_settings=camera_yaml_focal_error=-1,0"}),
              Names("camera.yaml"));
  refuses("camera_yaml_center_error=3", {"camera_yaml_center_error", "3", "2"});
  refuses("channel_gains=1,0,1", {"channel_gains", "1,0,1"});
  refuses("readout_s=-1", {"readout_s", "-1", "0", "1"});
  refuses("inverse_depth_offset=0.2", {"inverse_depth_offset", "0.2", "-0.1", "0.1"});
  refuses("inverse_depth_distortion=1,2", {"inverse_depth_distortion", "1,2"});
  refuses("inverse_depth_distortion=0,0,0.2,0,0", {"inverse_depth_distortion", "0,0,0.2,0,0"});
  refuses("inverse_depth_distortion=0,0,nan,0,0", {"inverse_depth_distortion", "0,0,nan,0,0"});
  refuses("camera_from_imu=0,0,0,1,1,0,0", {"camera_from_imu", "0,0,0,1,1,0,0", "1"});
  refuses("rolling=1", {"rolling", "readout_s", "camera_yaml_imu"});
}

}  // namespace
}  // namespace surfit::testing
