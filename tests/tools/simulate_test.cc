#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "surfit/geometry/sensor.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

constexpr int kFrames = 7;
constexpr double kUnit_m = 1.0 / 5000;

class SimulateTest : public ::testing::Test {
 protected:
  ProgramResult Simulate(const std::string& name, std::vector<std::string> flags) const {
    flags.push_back("--output=" + (folder_ / name));
    flags.push_back("--frames=" + std::to_string(kFrames));
    flags.push_back("--downsample=8");
    return RunProgram("surfit_simulate", flags);
  }
  // Contents of all files of a folder, by relative path.
  std::map<std::string, std::string> Files(const std::string& name) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / name)) {
      if (!entry.is_regular_file()) continue;
      const auto path = std::filesystem::relative(entry.path(), folder_ / name).string();
      files[path] = ReadBytes(entry.path().string());
    }
    return files;
  }
  std::unique_ptr<FrameSource> Open(const std::string& name) const {
    SequenceOptions options;
    options.path = folder_ / name;
    return OpenSequence(options);
  }
  TempFolder folder_;
};

TEST_F(SimulateTest, WritesTheRenderedFramesAsATumFolder) {
  Succeeded(Simulate("room", {"--sensor=ideal", "--seed=3"}));
  const auto source = Open("room");
  EXPECT_EQ(source->info().format, "tum");
  EXPECT_EQ(source->info().frame_count, kFrames);
  const Scene scene = MakeScene("room", 3);
  const Trajectory path = MakePath(scene, kFrames, 3);
  for (int i = 0; i < kFrames; ++i) {
    const Rigid3d& pose = path[i].world_from_camera;
    const auto read = source->Next();
    ASSERT_TRUE(read && read->frame) << read->error;
    EXPECT_NEAR(read->stamp_s, i / 30.0, 1e-6);
    // Poses in files have nine decimals.
    EXPECT_THAT(source->info().ground_truth[i].world_from_camera, RigidNear(pose, 2e-9, 4e-9));
    const RgbdFrame expected = RenderFrame(scene, source->info().pinhole, pose);
    EXPECT_TRUE(read->frame->color == expected.color);
    for (std::size_t k = 0; k < expected.depth_m.size(); ++k) {
      EXPECT_NEAR(read->frame->depth_m[k], expected.depth_m[k], kUnit_m / 2 + 1e-6);
    }
  }
}

TEST_F(SimulateTest, KinectDepthHasHolesAndSteps) {
  Succeeded(Simulate("room", {"--sensor=kinect"}));
  const auto read = Open("room")->Next();
  ASSERT_TRUE(read && read->frame);
  int missing = 0;
  for (const float depth : read->frame->depth_m) {
    if (depth == 0) {
      ++missing;
      continue;
    }
    const double disparity = 351.3 / depth;  // an integer, except for the rounding of depth
    const double rounding = 0.6 * kUnit_m * 351.3 / (depth * depth);
    if (rounding < 0.4) {
      EXPECT_NEAR(disparity, std::round(disparity), rounding);
    }
  }
  EXPECT_GT(missing, 0);
}

// The convention of ICL-NUIM: u = fx x/z + cx, v = fy y/z + cy with fy < 0, in mirrored camera and
// world frames. S = diag(1, -1, 1) must map both to the original scene.
TEST_F(SimulateTest, ImageYUpMirrorsTheWorld) {
  Succeeded(Simulate("up", {"--seed=1", "--sensor=ideal", "--format=icl_nuim"}));
  Succeeded(Simulate("down", {"--seed=1", "--sensor=ideal"}));
  const PinholeCamera camera = ReadCameraYaml(folder_ / "up/camera.yaml").depth;
  EXPECT_LT(camera.fy, 0);
  EXPECT_EQ(ReadBytes(folder_ / "up/groundtruth.txt"),
            ReadBytes(folder_ / "up/simulated.gt.freiburg"));
  const Trajectory mirrored = ReadTumTrajectory(folder_ / "up/groundtruth.txt");
  const Trajectory upright = ReadTumTrajectory(folder_ / "down/groundtruth.txt");
  ASSERT_EQ(mirrored.size(), std::size_t{kFrames});
  const Scene scene = MakeScene("room", 1);
  const Eigen::DiagonalMatrix<double, 3> mirror(1, -1, 1);
  const auto names = Files("down/rgb");
  auto name = names.begin();
  for (int i = 0; i < kFrames; ++i, ++name) {
    EXPECT_EQ(mirrored[i].stamp_s, i);
    const std::string file = std::to_string(i) + ".png";
    EXPECT_EQ(ReadBytes(folder_ / ("up/rgb/" + file)), name->second);
    const cv::Mat depth = cv::imread(folder_ / ("up/depth/" + file), cv::IMREAD_UNCHANGED);
    for (const auto [u, v] : PixelsOf(depth.cols, depth.rows)) {
      const double z = depth.at<std::uint16_t>(v, u) * kUnit_m;
      const Vector3d point_in_camera(z * (u - camera.cx) / camera.fx,
                                     z * (v - camera.cy) / camera.fy, z);
      const Vector3d point_in_mirrored_world = mirrored[i].world_from_camera * point_in_camera;
      // Rounding by half a depth unit along a ray of length 1.3.
      EXPECT_LT(std::abs(scene.Distance(mirror * point_in_mirrored_world)), 0.65 * kUnit_m + 1e-6);
    }
    EXPECT_THAT(Mirrored(mirrored[i].world_from_camera),
                RigidNear(upright[i].world_from_camera, 4e-9, 8e-9));
  }
}

TEST_F(SimulateTest, ImageYUpReadsBackAsTheOriginalSequence) {
  Succeeded(Simulate("up", {"--format=icl_nuim"}));
  Succeeded(Simulate("down", {}));
  const auto up = Open("up"), down = Open("down");
  EXPECT_EQ(up->info().format, "icl_nuim");
  EXPECT_TRUE(up->info().mirrored);
  EXPECT_FALSE(down->info().mirrored);
  for (int i = 0; i < kFrames; ++i) {
    const auto a = up->Next(), b = down->Next();
    ASSERT_TRUE(a->frame && b->frame);
    EXPECT_TRUE(a->frame->depth_m == b->frame->depth_m);
    EXPECT_TRUE(a->frame->color == b->frame->color);
    EXPECT_THAT(up->info().ground_truth[i].world_from_camera,
                RigidNear(down->info().ground_truth[i].world_from_camera, 4e-9, 8e-9));
  }
  EXPECT_EQ(Files("up")["surface.ply"], Files("down")["surface.ply"]);
}

TEST_F(SimulateTest, SurfaceIsExactAndDense) {
  Succeeded(Simulate("room", {"--seed=2", "--sensor=ideal", "--surface_grid_m=0.02"}));
  const PointCloud surface = ReadPly(folder_ / "room/surface.ply");
  ASSERT_EQ(surface.normals.size(), surface.points.size());
  ASSERT_EQ(surface.colors.size(), surface.points.size());
  ASSERT_GT(surface.points.size(), 1000u);
  const Scene scene = MakeScene("room", 2);
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Vector3d point = surface.points[i].cast<double>();
    EXPECT_LT(std::abs(scene.Distance(point)), 2e-6);  // rounding of floats up to 8 m
    // A point 1 mm along the normal is outside, at most 1 mm from the surface.
    const Vector3d outward = point + 1e-3 * surface.normals[i].cast<double>();
    EXPECT_LE(scene.Distance(outward), 1e-3 + 2e-6);
  }
  // Every pixel of the first frame has a surface point in its grid cell, within the cell diagonal.
  const auto source = Open("room");
  const auto read = source->Next();
  ASSERT_TRUE(read && read->frame);
  const Image<float>& depth_m = read->frame->depth_m;
  const Rigid3d pose = source->info().ground_truth[0].world_from_camera;
  const double diagonal_m = 0.02 * std::sqrt(3.0) + kUnit_m;
  for (int v = 0; v < depth_m.height(); v += 5) {
    for (int u = 0; u < depth_m.width(); u += 5) {
      const Vector3d point = pose * (depth_m(u, v) * source->info().pinhole.Ray(u, v));
      double nearest = 1e9;
      for (const auto& p : surface.points) {
        nearest = std::min(nearest, (p.cast<double>() - point).norm());
      }
      EXPECT_LT(nearest, diagonal_m);
    }
  }
}

TEST_F(SimulateTest, FilesDependOnlyOnTheSeed) {
  Succeeded(Simulate("a", {"--threads=1"}));
  Succeeded(Simulate("b", {"--threads=3"}));
  Succeeded(Simulate("c", {"--seed=2"}));
  EXPECT_TRUE(Files("a") == Files("b"));
  EXPECT_NE(Files("a")["surface.ply"], Files("c")["surface.ply"]);
  EXPECT_NE(Files("a")["groundtruth.txt"], Files("c")["groundtruth.txt"]);
}

TEST_F(SimulateTest, JoinedPartsEqualOneSimulation) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{},
                                               {"--format=icl_nuim"},
                                               {"--sensor_settings=exposure_s=0.01"},
                                               {"--sensor=lidar"}}) {
    const auto simulate = [&](const std::string& name, std::vector<std::string> flags) {
      flags.insert(flags.end(), more.begin(), more.end());
      return Simulate(name, flags);
    };
    Succeeded(simulate("whole", {}));
    for (const char* const part : {"2", "1", "3"}) {
      Succeeded(simulate("parts", {"--part=" + std::string(part) + "/3"}));
    }
    Succeeded(simulate("parts", {"--part=join/3"}));
    EXPECT_TRUE(Files("whole") == Files("parts"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "parts.1"));
  }
}

TEST_F(SimulateTest, IsRenderedByTheWorkflow) {
  if (RunShell("command -v snakemake").exit_code != 0) GTEST_SKIP() << "Snakemake is not installed";
  const std::string tools = SURFIT_TOOLS_DIR, workflow = tools + "/workflow";
  Succeeded(Simulate("whole", {}));
  std::filesystem::create_directory(folder_ / "work");
  Succeeded(RunShell("snakemake --snakefile=" + workflow + "/simulate.smk --profile=" + workflow +
                     "/local --cores=2 --directory=" + (folder_ / "work") + " --config tools=" +
                     tools + " parts=3 flags='--frames=7 --downsample=8' 2>&1"));
  EXPECT_TRUE(Files("whole") == Files("work/sequence"));
}

TEST_F(SimulateTest, NamesTheMissingPart) {
  Succeeded(Simulate("parts", {"--part=2/2"}));
  const ProgramResult result = Simulate("parts", {"--part=join/2"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, Names("parts.1/surface.ply"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "parts.2/surface.ply"));
  Succeeded(Simulate("parts", {"--part=1/2"}));
  std::filesystem::remove(folder_ / "parts.1/rgb/0.000000.png");
  EXPECT_THAT(Simulate("parts", {"--part=join/2"}).err, Names("parts.1", 5, 6));
  Succeeded(Simulate("parts", {"--part=1/2"}));
  Succeeded(Simulate("parts", {"--part=join/2"}));  // succeeds after the failures
  EXPECT_THAT(Simulate("parts", {"--part=3/2"}).err, Names("--part", "3/2", "join/N"));
}

TEST_F(SimulateTest, ReplacesOnlyFormerSimulations) {
  Succeeded(Simulate("room", {"--format=icl_nuim"}));
  Succeeded(Simulate("room", {}));
  EXPECT_EQ(Files("room").count("simulated.gt.freiburg"), 0u);
  folder_.Write("mine/thesis.tex", "irreplaceable");
  const ProgramResult refused = Simulate("mine", {});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, Names("mine"));
  EXPECT_EQ(ReadBytes(folder_ / "mine/thesis.tex"), "irreplaceable");
}

TEST_F(SimulateTest, AddsAnInverseDepthField) {
  const InverseDepthField error = {{0.006, 0.002, -0.003, 0.008, 0.004, 0.006}};
  Succeeded(Simulate("exact", {"--sensor=ideal"}));
  Succeeded(Simulate("off", {"--sensor=ideal",
                             "--sensor_settings=inverse_depth_offset=0.006;"
                             "inverse_depth_distortion=0.002,-0.003,0.008,0.004,0.006"}));
  const auto source = Open("exact");
  const PinholeCamera camera = source->info().pinhole;
  const Image<float> exact = source->Next()->frame->depth_m;
  const Image<float> off = Open("off")->Next()->frame->depth_m;
  for (const auto [u, v] : PixelsOf(camera)) {
    const Eigen::Vector3d ray = camera.Ray(u, v);
    // Depth in both files is quantised by kUnit_m.
    EXPECT_NEAR(off(u, v), error.Corrected(exact(u, v), ray.x(), ray.y()), 1.1 * kUnit_m);
  }
}

TEST_F(SimulateTest, WritesInertialSensorWithItsCalibration) {
  Succeeded(
      Simulate("room", {"--imu",
                        "--sensor_settings=imu_rate_hz=100;imu_time_offset_s=0.05;"
                        "camera_from_imu=0.01,0.02,0.03,0.5,-0.5,0.5,-0.5;camera_yaml_imu=true"}));
  SequenceOptions options;
  options.path = folder_ / "room";
  const auto imu = ReadImu(options, "tum");
  ASSERT_TRUE(imu);
  // Seven frames at 30 Hz take 0.2 s.
  ASSERT_EQ(imu->samples.size(), 21u);
  EXPECT_NEAR(imu->samples[0].stamp_s, 0.05, 1e-9);
  EXPECT_THAT(
      imu->calibration.camera_from_imu,
      RigidNear(Rigid3d(Eigen::Quaterniond(-0.5, 0.5, -0.5, 0.5), {0.01, 0.02, 0.03}), 1e-9, 1e-9));
  EXPECT_EQ(imu->calibration.time_offset_s, 0.05);
  const std::string noisy = ReadBytes(folder_ / "room/imu.csv");
  EXPECT_NE(noisy, ReadBytes(folder_ / "room/imu_exact.csv"));
  Succeeded(Simulate("other", {"--imu"}));
  options.path = folder_ / "other";
  EXPECT_TRUE(std::isinf(ReadImu(options, "tum")->calibration.rotation_sigma_rad));
}

TEST_F(SimulateTest, RejectsBadFlagsByName) {
  const RefusedFlags cases = {
      {{"--scene=kitchen"}, {"scene", "kitchen", "building", "corridor", "room"}},
      {{"--sensor=radar"}, {"--sensor", "radar", "ideal", "kinect", "lidar", "stereo", "tof"}},
      {{"--size=-1x480"}, {"--size", "-1x480"}},
      {{"--size=640x20000"}, {"--size", "640x20000", "16384"}},
      {{"--size=640"}, {"--size", "640", "WIDTHxHEIGHT"}},
      {{"--size=640x480x3"}, {"--size", "640x480x3"}},
      {{"--step_m=0.02,0.01"}, {"--step_m", "0.02,0.01", "MIN,MAX"}},
      {{"--step_m=0,0.01"}, {"--step_m", "0,0.01"}},
      {{"--step_m=0.01"}, {"--step_m", "0.01"}},
      {{"--format=klg"}, {"--format", "klg", "tum", "icl_nuim"}},
      {{"--seed=-1"}, {"--seed", "-1"}},
      {{"--surface_grid_m=0"}, {"--surface_grid_m", "0", "0.001"}},
      {{"--threads=-2"}, {"threads", "-2"}},
      {{"--sensor_settings=readout_s"}, {"--sensor_settings", "readout_s", "name=value"}},
      {{"--readout_s=0.03"}, {"--readout_s", "--sensor_settings=readout_s=VALUE"}},
      {{"--image_y_up"}, {"--image_y_up", "--format=icl_nuim"}},
      {{"--colour=red"}, {"colour"}}};
  for (const auto& [flags, names] : cases)
    ExpectRefused(Simulate("room", flags), NamesMatcher(names));
  ExpectRefused(RunProgram("surfit_simulate", {}), "--output");
  for (const std::string flag : {"--frames=0", "--downsample=17", "--output="}) {
    ExpectRefused(RunProgram("surfit_simulate", {"--output=/nowhere", flag}),
                  flag.substr(0, flag.find('=')));
  }
  ExpectRefused(RunProgram("surfit_simulate", {"--output=/dev/null/room", "--frames=1"}),
                "/dev/null/room");
}

TEST_F(SimulateTest, HelpListsTheFlagsWithTheirDefaults) {
  const ProgramResult help = Succeeded(RunProgram("surfit_simulate", {"--help"}));
  for (const char* const flag : {"--output", "--scene=room", "--frames=200", "--seed", "--sensor",
                                 "--surface_grid_m=0.005"}) {
    EXPECT_THAT(help.out, Names(flag));
  }
}

}  // namespace
}  // namespace surfit::testing
