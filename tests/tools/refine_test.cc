#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

constexpr double kOffset = 0.02 / 3;  // 1/m: 2 % at 3 m

// Simulates a sequence with a depth error, at 640 x 480 pixels divided by `downsample`. `settings`
// are more settings of the sensor.
void Simulate(const std::string& folder, int frames, int downsample, int seed,
              double offset_per_m = kOffset, const std::string& settings = "") {
  Succeeded(RunProgram(
      "surfit_simulate",
      {"--output=" + folder, "--frames=" + std::to_string(frames),
       "--downsample=" + std::to_string(downsample), "--seed=" + std::to_string(seed),
       "--surface_grid_m=0.05",
       "--sensor_settings=inverse_depth_offset=" + std::to_string(offset_per_m) + ";" + settings}));
}

TEST(RefineTool, RefinesASimulatedRunAndWritesReadableFiles) {
  const TempFolder folder;
  Simulate(folder / "in", 60, 4, 7);
  Succeeded(RunProgram("surfit_slam", {"--sequence=" + folder / "in", "--output=" + folder / "out",
                                       "--pictures=false", "--nofinal_map", "--last=55"}));
  Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));

  const std::string refined = folder / "out/refined";
  const Trajectory before = ReadTumTrajectory(folder / "out/trajectory.txt");
  const Trajectory after = ReadTumTrajectory(refined + "/trajectory.txt");
  ASSERT_EQ(after.size(), 56u);  // with --last of the run
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].stamp_s, before[i].stamp_s);
  EXPECT_GT(ReadSurfelPly(refined + "/map.ply").size(), 1000u);
  const auto json = nlohmann::json::parse(ReadBytes(refined + "/refinement.json"));
  EXPECT_LT(json["ate_rmse_m"]["after"], json["ate_rmse_m"]["before"]);
  EXPECT_EQ(json["options"]["last"], "55");
  const RgbdCamera camera = ReadCameraYaml(refined + "/camera.yaml");
  EXPECT_EQ(camera.depth.width, 160);
  EXPECT_EQ(camera.depth.fx, json["calibration"]["after"]["fx"]);
  EXPECT_EQ(ReadInverseDepthField(refined + "/camera.yaml").coefficients[0],
            json["calibration"]["after"]["inverse_depth_field"][0]);
}

TEST(RefineTool, FindsTheFramesOfTheRunByTheirTimestamps) {
  const TempFolder folder;
  Simulate(folder / "in", 20, 4, 7);
  RgbdCamera sensor = ReadCameraYaml(folder / "in/camera.yaml");
  sensor.latency_s = 0.02;
  WriteCameraYaml(sensor, folder / "in/camera.yaml");
  Succeeded(RunProgram("surfit_slam", {"--sequence=" + folder / "in", "--output=" + folder / "out",
                                       "--pictures=false", "--nofinal_map"}));
  Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));
  const std::string refined = folder / "out/refined";
  const Trajectory before = ReadTumTrajectory(folder / "out/trajectory.txt");
  const Trajectory after = ReadTumTrajectory(refined + "/trajectory.txt");
  ASSERT_EQ(after.size(), 20u);
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].stamp_s, before[i].stamp_s);
  EXPECT_NEAR(after[3].stamp_s, 3 / 30. - 0.02, 1e-6);
  EXPECT_EQ(ReadCameraYaml(refined + "/camera.yaml").latency_s, 0.02);
}

TEST(RefineTool, UsesThePriorOfCameraYaml) {
  const TempFolder folder;
  Simulate(folder / "in", 20, 4, 7);
  RgbdCamera sensor = ReadCameraYaml(folder / "in/camera.yaml");
  sensor.prior.focal_relative_sigma = 1e-6;
  WriteCameraYaml(sensor, folder / "in/camera.yaml");
  Succeeded(RunProgram("surfit_slam", {"--sequence=" + folder / "in", "--output=" + folder / "out",
                                       "--pictures=false", "--nofinal_map"}));
  Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));
  const auto json = nlohmann::json::parse(ReadBytes(folder / "out/refined/refinement.json"));
  EXPECT_EQ(json["options"]["refinement.prior.focal_relative_sigma"], "1e-06");
  EXPECT_EQ(json["options"]["refinement.prior.aspect_relative_sigma"], "0.001");
  EXPECT_EQ(ReadCameraYaml(folder / "out/refined/camera.yaml").prior.focal_relative_sigma, 1e-6);
}

// A rolling shutter that is not in camera.yaml.
TEST(RefineTool, EstimatesTheReadoutTime) {
  const double readout_s = 0.033;
  for (const int seed : {4, 7, 11}) {
    const TempFolder folder;
    Simulate(folder / "in", 150, 4, seed, 0, "readout_s=" + std::to_string(readout_s));
    RgbdCamera sensor = ReadCameraYaml(folder / "in/camera.yaml");
    sensor.prior.readout_s = 0.03;
    WriteCameraYaml(sensor, folder / "in/camera.yaml");
    Succeeded(RunProgram("surfit_slam",
                         {"--sequence=" + folder / "in", "--nocalibrate",
                          "--output=" + folder / "out", "--pictures=false", "--nofinal_map"}));
    Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));
    const auto json = nlohmann::json::parse(ReadBytes(folder / "out/refined/refinement.json"));
    const double found = json["calibration"]["after"]["readout_s"];
    const double sigma = json["calibration"]["standard_deviations"]["readout_s"];
    const double before = json["ate_rmse_m"]["before"], after = json["ate_rmse_m"]["after"];
    std::printf("seed %d: readout %.1f +- %.1f ms, ATE %.2f -> %.2f mm\n", seed, 1000 * found,
                1000 * sigma, 1000 * before, 1000 * after);
    EXPECT_NEAR(found, readout_s, 3 * sigma);
    EXPECT_LT(sigma, readout_s / 10);
    EXPECT_LT(after, before);
    EXPECT_NEAR(ReadCameraYaml(folder / "out/refined/camera.yaml").readout_s, found, 1e-9);
  }
}

TEST(RefineTool, CorrectsAWrongCalibrationToAThirdOfTheError) {
  for (const int seed : {4, 7, 11}) {
    const TempFolder folder;
    Simulate(folder / "in", 300, 2, seed);
    const double focal = 262.5;
    const std::string wrong = std::to_string(1.01 * focal);
    Succeeded(RunProgram("surfit_slam",
                         {"--sequence=" + folder / "in", "--output=" + folder / "out",
                          "--nofinal_map", "--intrinsics=" + wrong + "," + wrong + ",159.75,119.75",
                          "--nocalibrate", "--pictures=false"}));
    Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));
    const auto json = nlohmann::json::parse(ReadBytes(folder / "out/refined/refinement.json"));
    const auto& found = json["calibration"]["after"];
    const double fx = found["fx"], fy = found["fy"], offset = found["inverse_depth_field"][0];
    const double before = json["ate_rmse_m"]["before"], after = json["ate_rmse_m"]["after"];
    std::printf(
        "seed %d: focal length off by %.3f and %.3f %%, depth at 3 m by %.3f %%, ATE %.1f -> %.1f "
        "mm\n",
        seed, 100 * (fx / focal - 1), 100 * (fy / focal - 1), 300 * (offset + kOffset),
        1000 * before, 1000 * after);
    EXPECT_NEAR(fx, focal, 0.001 * focal);
    EXPECT_NEAR(fy, focal, 0.001 * focal);
    EXPECT_NEAR(offset, -kOffset, 0.002 / 3);
    EXPECT_LT(after, before / 3);
  }
}

TEST(RefineTool, KeepsACorrectCalibrationWithoutALargerError) {
  for (const int seed : {4, 7, 11}) {
    const TempFolder folder;
    Simulate(folder / "in", 300, 2, seed, 0);
    Succeeded(
        RunProgram("surfit_slam", {"--sequence=" + folder / "in", "--output=" + folder / "out",
                                   "--nofinal_map", "--pictures=false"}));
    Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));
    const auto json = nlohmann::json::parse(ReadBytes(folder / "out/refined/refinement.json"));
    const double before = json["ate_rmse_m"]["before"], after = json["ate_rmse_m"]["after"];
    std::printf("seed %d: squared distance %.1f of %.1f, ATE %.2f -> %.2f mm\n", seed,
                json["calibration"]["squared_distance"].get<double>(),
                json["calibration"]["limit"].get<double>(), 1000 * before, 1000 * after);
    EXPECT_EQ(json["calibration"]["kept"], true);
    EXPECT_EQ(json["calibration"]["after"], json["calibration"]["before"]);
    EXPECT_LE(after, before);
  }
}

TEST(RefineTool, EstimatesTheDepthErrorField) {
  const InverseDepthField error = {{kOffset, 0.002, -0.002, 0.008, 0.002, 0.006}};
  for (const int seed : {4, 7, 11}) {
    const TempFolder folder;
    Simulate(folder / "in", 300, 2, seed, kOffset,
             "inverse_depth_distortion=0.002,-0.002,0.008,0.002,0.006");
    Succeeded(
        RunProgram("surfit_slam", {"--sequence=" + folder / "in", "--output=" + folder / "out",
                                   "--pictures=false", "--nofinal_map", "--nocalibrate"}));
    Succeeded(RunProgram("surfit_refine", {"--run=" + folder / "out"}));
    const std::string refined = folder / "out/refined";
    const auto json = nlohmann::json::parse(ReadBytes(refined + "/refinement.json"));
    const double before = json["ate_rmse_m"]["before"], after = json["ate_rmse_m"]["after"];
    const PinholeCamera camera = ReadCameraYaml(refined + "/camera.yaml").depth;
    const InverseDepthField found = ReadInverseDepthField(refined + "/camera.yaml");
    double largest = 0;  // largest relative error of depth at 3 m in the image
    for (const auto [u, v] : PixelsOf(camera)) {
      const Eigen::Vector3d ray = camera.Ray(u, v);
      const double left = found.At(ray.x(), ray.y()) + error.At(ray.x(), ray.y());
      largest = std::max(largest, 3 * std::abs(left));
    }
    std::printf("seed %d: depth at 3 m off by up to %.3f %%, ATE %.1f -> %.2f mm\n", seed,
                100 * largest, 1000 * before, 1000 * after);
    EXPECT_LT(largest, 0.002);
    EXPECT_LT(after, before / 3);
  }
}

// fx of the depth camera before refinement.
double GivenFx(const std::string& run, const std::vector<std::string>& more,
               std::string* messages) {
  std::vector<std::string> flags = {"--run=" + run, "--fix=intrinsics,depth_offset,depth_field"};
  flags.insert(flags.end(), more.begin(), more.end());
  const ProgramResult result = Succeeded(RunProgram("surfit_refine", flags));
  *messages = result.err;
  const auto json = nlohmann::json::parse(ReadBytes(run + "/refined/refinement.json"));
  return json["calibration"]["before"]["fx"];
}

TEST(RefineTool, UsesTheCalibrationOfTheRun) {
  const TempFolder folder;
  const std::string run = folder / "out";
  Simulate(folder / "in", 20, 4, 7, 0);
  Succeeded(RunProgram("surfit_slam",
                       {"--sequence=" + folder / "in", "--output=" + run, "--pictures=false",
                        "--nofinal_map", "--nocalibrate", "--intrinsics=132,132,79.5,59.5"}));
  std::string messages;
  EXPECT_EQ(GivenFx(run, {}, &messages), 132);  // no calibration by the run: its input calibration
  EXPECT_THAT(messages, Not(Names(run + "/camera.yaml")));

  RgbdCamera found = ReadCameraYaml(folder / "in/camera.yaml");
  found.depth.fx = 131;
  WriteCameraYaml(found, run + "/camera.yaml");
  EXPECT_EQ(GivenFx(run, {}, &messages), 131);
  EXPECT_THAT(messages, Names(run + "/camera.yaml"));
  // Version 0.1 recorded one flag per topic of a ROS bag.
  nlohmann::json summary = nlohmann::json::parse(ReadBytes(run + "/summary.json"));
  summary["options"].erase("topics");
  summary["options"]["depth_topic"] = "/depth";
  summary["options"]["color_topic"] = "/rgb";
  WriteBytes(run + "/summary.json", summary.dump());
  EXPECT_EQ(GivenFx(run, {}, &messages), 131);
  const auto refined = nlohmann::json::parse(ReadBytes(run + "/refined/refinement.json"));
  EXPECT_EQ(refined["options"]["topics"], "/depth,/rgb");
  // Flags override the calibration of the run.
  EXPECT_EQ(GivenFx(run, {"--intrinsics=130,130,79.5,59.5"}, &messages), 130);
  EXPECT_EQ(GivenFx(run, {"--camera="}, &messages), 132);
  EXPECT_THAT(messages, Not(Names(run + "/camera.yaml")));
}

TEST(RefineTool, RejectsBadInput) {
  const TempFolder folder;
  EXPECT_EQ(RunProgram("surfit_refine", {}).exit_code, 1);
  ExpectRefused(RunProgram("surfit_refine", {"--run=" + folder / "none"}), "none/summary.json");
  WriteBytes(folder / "summary.json", "{}");
  ExpectRefused(RunProgram("surfit_refine", {"--run=" + folder.path()}), "summary.json", "options");
}

}  // namespace
}  // namespace surfit::testing
