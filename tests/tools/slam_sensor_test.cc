// surfit_slam with simulated sensor errors, compared with exact ground truth.
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "surfit/io/camera_files.h"
#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Simulates a Kinect that moves through a room, at 320 x 240 pixels.
void SimulateRoom(const std::string& folder, int seed, int frames,
                  std::vector<std::string> sensor) {
  sensor.insert(sensor.begin(),
                {"--output=" + folder, "--frames=" + std::to_string(frames), "--downsample=2",
                 "--seed=" + std::to_string(seed), "--surface_grid_m=0.05"});
  Succeeded(RunProgram("surfit_simulate", sensor));
}

nlohmann::json SummaryOf(const std::string& sequence, const std::string& output,
                         std::vector<std::string> flags) {
  flags.insert(flags.begin(), {"--sequence=" + sequence, "--output=" + output, "--nopictures"});
  Succeeded(RunProgram("surfit_slam", flags));
  return nlohmann::json::parse(ReadBytes(output + "/summary.json"));
}

TEST(SlamSensor, KnownRollingShutterReducesTheErrorToAFifth) {
  for (const int seed : {4, 11}) {
    const TempFolder folder;
    SimulateRoom(folder / "in", seed, 150,
                 {"--sensor_settings=readout_s=0.033;camera_yaml_times=readout_s"});
    const auto ate_mm = [&](const std::string& name, const std::string& flag) -> double {
      return 1000 * SummaryOf(folder / "in", folder / name,
                              {"--nocalibrate", "--nofinal_map", flag})["ate_rmse_m"]
                        .get<double>();
    };
    RgbdCamera camera = ReadCameraYaml(folder / "in/camera.yaml");
    camera.readout_s = 0;
    WriteCameraYaml(camera, folder / "global_shutter.yaml");
    const double ignored = ate_mm("ignored", "--camera=" + folder / "global_shutter.yaml"),
                 known = ate_mm("known", "--stride=1");
    std::printf("seed %d: ATE %.2f -> %.2f mm\n", seed, ignored, known);
    EXPECT_LT(known, ignored / 5) << seed;
  }
}

// Colour is captured with depth, or earlier with the timestamp of depth.
TEST(SlamSensor, EstimatesTheColourLatency) {
  for (const double latency_s : {0., 0.02}) {
    const TempFolder folder;
    SimulateRoom(folder / "in", 4, 150,
                 {"--sensor_settings=color_latency_s=" + std::to_string(latency_s)});
    const nlohmann::json last =
        SummaryOf(folder / "in", folder / "out", {"--nofinal_map"})["calibrations"].back();
    const double found_s = last["color_latency_s"];
    const double sigma_s = last["color_latency_standard_deviation"];
    std::printf("%.0f ms: found %.1f +- %.1f ms\n", 1000 * latency_s, 1000 * found_s,
                1000 * sigma_s);
    EXPECT_LT(sigma_s, 0.003);
    if (latency_s == 0) {
      EXPECT_EQ(found_s, 0);  // the input value
    } else {
      EXPECT_NEAR(found_s, latency_s, 3 * sigma_s);
      EXPECT_EQ(ReadCameraYaml(folder / "out/camera.yaml").color_latency_s, found_s);
    }
  }
}

TEST(SlamSensor, RefinesCameraAndPosesAtTheEnd) {
  const TempFolder folder;
  // In this room, the gain of held-out keyframes is twice the limit.
  SimulateRoom(folder / "in", 3, 150,
               {"--sensor_settings=camera_yaml_center_error=2,-1.5;"
                "inverse_depth_distortion=0.015,0,0,0,0"});
  const nlohmann::json refined = SummaryOf(folder / "in", folder / "refined", {"--threads=1"}),
                       given = SummaryOf(folder / "in", folder / "given", {"--norefine"});
  SummaryOf(folder / "in", folder / "other", {"--threads=2"});
  EXPECT_EQ(refined["refinement"]["termination"], "converged");
  EXPECT_EQ(given["refinement"], nullptr);
  const double refined_m = refined["ate_rmse_m"], given_m = given["ate_rmse_m"];
  std::printf("ATE %.2f -> %.2f mm\n", 1000 * given_m, 1000 * refined_m);
  EXPECT_LT(refined_m, given_m);
  EXPECT_EQ(ReadCameraYaml(folder / "refined/camera.yaml").depth.fx,
            refined["refinement"]["found"]["fx"]);
  for (const char* name : {"/trajectory.txt", "/map.ply", "/camera.yaml"}) {
    EXPECT_EQ(ReadBytes(folder / "refined" + name), ReadBytes(folder / "other" + name)) << name;
    EXPECT_NE(ReadBytes(folder / "refined" + name), ReadBytes(folder / "given" + name)) << name;
  }
  EXPECT_EQ(ReadBytes(folder / "refined/trajectory_online.txt"),
            ReadBytes(folder / "given/trajectory_online.txt"));
}

TEST(SlamSensor, KeepsACorrectCamera) {
  const TempFolder folder;
  SimulateRoom(folder / "in", 4, 60, {});
  EXPECT_EQ(SummaryOf(folder / "in", folder / "out", {})["refinement"], nullptr);
}

// Expects an error of at most three standard deviations.
void ExpectFound(const nlohmann::json& found, const nlohmann::json& sigma, double truth,
                 const std::string& what) {
  EXPECT_NEAR(found.get<double>(), truth, 3 * sigma.get<double>()) << what;
}

// Compares a calibration in JSON with the undistorted camera, by its standard deviations.
void ExpectTrueCalibration(const nlohmann::json& found, const nlohmann::json& sigma) {
  const std::vector<std::pair<const char*, double>> truth = {
      {"fx", 262.5}, {"fy", 262.5}, {"cx", 159.75}, {"cy", 119.75}, {"readout_s", 0.033}};
  for (const auto& [name, value] : truth) ExpectFound(found[name], sigma[name], value, name);
  const auto &field = found["inverse_depth_field"], &field_sigma = sigma["inverse_depth_field"];
  for (int i = 0; i < 6; ++i) {
    ExpectFound(field[i], field_sigma[i], i == 1 ? -0.015 : 0, "field " + std::to_string(i));
  }
}

// Focal length, principal point, depth, readout and colour latency are wrong. camera.yaml only
// states that the readout is unknown.
// The depth of a phone is interpolated, so colour has the details. Depth alone has an error of
// 37 mm.
TEST(SlamSensor, TracksAPhoneByColourToo) {
  const TempFolder folder;
  Succeeded(RunProgram("surfit_simulate",
                       {"--output=" + (folder / "in"), "--frames=200", "--downsample=1", "--seed=4",
                        "--sensor=lidar", "--surface_grid_m=0.05"}));
  const nlohmann::json summary = SummaryOf(folder / "in", folder / "out", {"--nofinal_map"});
  EXPECT_EQ(summary["frames_tracked"], 200);
  EXPECT_LT(summary["ate_rmse_m"], 0.012);
}

TEST(SlamSensorSweep, CalibratesAllParameters) {
  for (const int seed : {2, 3, 4, 5, 11}) {
    SCOPED_TRACE(seed);
    const TempFolder folder;
    SimulateRoom(folder / "in", seed, 300,
                 {"--sensor_settings=readout_s=0.033;color_readout_s=0.033;color_latency_s=0.02;"
                  "camera_yaml_focal_error=0.01,0.01;camera_yaml_center_error=2,-1.5;"
                  "inverse_depth_distortion=0.015,0,0,0,0"});
    RgbdCamera given = ReadCameraYaml(folder / "in/camera.yaml");
    given.prior.readout_s = 0.03;
    WriteCameraYaml(given, folder / "in/camera.yaml");
    const double wrong_m = SummaryOf(folder / "in", folder / "wrong",
                                     {"--nocalibrate", "--nofinal_map"})["ate_rmse_m"];
    const nlohmann::json summary = SummaryOf(folder / "in", folder / "out", {});
    const nlohmann::json& refined = summary["refinement"];
    const double found_m =
        SummaryOf(folder / "in", folder / "online", {"--nofinal_map"})["ate_rmse_m"];
    const double refined_m = summary["ate_rmse_m"];
    std::printf("seed %d: ATE %.2f -> %.2f mm, refined %.2f mm\n", seed, 1000 * wrong_m,
                1000 * found_m, 1000 * refined_m);
    const nlohmann::json last = summary["calibrations"].back();
    ExpectTrueCalibration(last["found"], last["standard_deviations"]);
    ExpectFound(last["color_latency_s"], last["color_latency_standard_deviation"], 0.02, "colour");
    ExpectTrueCalibration(refined["found"], refined["standard_deviations"]);
    EXPECT_LT(found_m, wrong_m / 3);
    EXPECT_LT(refined_m, found_m);
  }
}

}  // namespace
}  // namespace surfit::testing
