#include "surfit/io/camera_files.h"

#include <sys/stat.h>

#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "testing/shared_data.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

TEST(CameraPreset, EveryNameGivesAValidCamera) {
  EXPECT_EQ(CameraPresetNames().size(), 15u);
  for (const std::string& name : CameraPresetNames()) {
    EXPECT_NO_THROW(CameraPreset(name).Validate(name));
  }
}

// Kinect and Xtion images get their timestamps on arrival. The latency of other sensors is unknown.
TEST(CameraPreset, OnlyTumSensorsHaveALatency) {
  for (const std::string& name : CameraPresetNames()) {
    const bool is_stamped_on_arrival =
        name.rfind("tum_", 0) == 0 || name == "kinect_v1" || name == "xtion";
    EXPECT_EQ(CameraPreset(name).latency_s, is_stamped_on_arrival ? 0.02 : 0) << name;
  }
}

std::array<double, 9> Numbers(const CalibrationPrior& prior) {
  const auto& [focal, aspect, center, depth, latency, color_latency, readout, translation,
               rotation] = prior;
  return {focal, aspect, center, depth, latency, color_latency, readout, translation, rotation};
}

// Calibrated data sets keep the default prior.
TEST(CameraPreset, DataSetsHaveTheDefaultPrior) {
  for (const char* const name :
       {"tum_fr1", "tum_fr2", "tum_fr3", "icl_nuim", "seven_scenes", "redwood", "replica", "klg"}) {
    EXPECT_EQ(Numbers(CameraPreset(name).prior), Numbers(CalibrationPrior())) << name;
  }
}

// TUM's three calibrated sensors deviate from the kinect_v1 preset by at most three sigma. Their
// mean squared deviation is about one variance, so the prior is not too wide.
TEST(CameraPreset, PriorMatchesTheSpreadOfCalibratedSensors) {
  const RgbdCamera series = CameraPreset("kinect_v1");
  double focal = 0, aspect = 0, center = 0;  // mean squared deviations, in variances
  for (const char* const name : {"tum_fr1", "tum_fr2", "tum_fr3"}) {
    const PinholeCamera one = CameraPreset(name).depth;
    const double fx = (one.fx / series.depth.fx - 1) / series.prior.focal_relative_sigma;
    const double fy = (one.fy / series.depth.fy - 1) / series.prior.focal_relative_sigma;
    const double cx = (one.cx - series.depth.cx) / series.prior.center_px;
    const double cy = (one.cy - series.depth.cy) / series.prior.center_px;
    const double ratio = (one.fx / one.fy - 1) / series.prior.aspect_relative_sigma;
    for (const double sigmas : {fx, fy, cx, cy, ratio}) EXPECT_LT(std::abs(sigmas), 3) << name;
    focal += (fx * fx + fy * fy) / 6;
    center += (cx * cx + cy * cy) / 6;
    aspect += ratio * ratio / 3;
  }
  for (const double mean_square : {focal, aspect, center}) EXPECT_NEAR(mean_square, 1, 0.15);
}

// Depth errors from the data sheets and from published tests.
TEST(CameraPreset, DepthErrorsMatchTheDataSheets) {
  const auto error_m = [](const char* name, double z_m) {
    return CameraPreset(name).prior.inverse_depth_sigma * z_m * z_m;
  };
  EXPECT_NEAR(error_m("realsense_d415", 2), 0.02 * 2, 1e-12);
  EXPECT_NEAR(error_m("realsense_d435", 2), 0.02 * 2, 1e-12);
  EXPECT_NEAR(error_m("realsense_d455", 4), 0.02 * 4, 1e-12);
  EXPECT_NEAR(error_m("azure_kinect", 2), 0.011 + 0.001 * 2, 0.002);
}

TEST(CameraPreset, RejectsUnknownNameAndListsKnownNames) {
  ExpectInputError(
      [] { CameraPreset("kinect9"); },
      Names("kinect9", "tum_fr1", "tum_fr2", "tum_fr3", "icl_nuim", "seven_scenes", "redwood"));
}

void ExpectSame(const PinholeCamera& a, const PinholeCamera& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.distortion, b.distortion);
}

void ExpectSamePresetAndFile(const std::string& preset_name, const std::string& sequence) {
  SURFIT_REQUIRE_SHARED_DATA(sequence);
  const RgbdCamera preset = CameraPreset(preset_name);
  const RgbdCamera file = ReadCameraYaml(SharedData(sequence) + "/camera.yaml");
  ExpectSame(preset.depth, file.depth);
  EXPECT_EQ(preset.depth_units_per_metre, file.depth_units_per_metre);
  EXPECT_EQ(preset.color_is_registered, file.color_is_registered);
  if (!file.color_is_registered) ExpectSame(preset.color, file.color);
}

TEST(CameraPreset, TumFr1EqualsTheCameraOfRecordedData) {
  ExpectSamePresetAndFile("tum_fr1", "tum_fr1_desk_9");
}

TEST(CameraPreset, SevenScenesEqualsTheCameraOfRecordedData) {
  ExpectSamePresetAndFile("seven_scenes", "seven_scenes_kitchen");
}

TEST(CameraPreset, IclNuimHasItsImageAxisUp) { EXPECT_EQ(CameraPreset("icl_nuim").depth.fy, -480); }

RgbdCamera SomeCamera() {
  RgbdCamera camera;
  camera.depth = {320, 240, 262.1, -263.2, 159.3, 121.4, {0.1, -0.2, 0.003, -0.004, 0.05}};
  camera.color = {1280, 720, 900.5, -901.5, 640, 360, {}};
  camera.color_is_registered = false;
  camera.color_from_depth = Rigid3d(QuaternionExp<double>({0.1, -0.2, 0.3}), {0.025, -0.01, 0.002});
  camera.depth_units_per_metre = 6553.5;
  camera.noise.inverse_depth_sigma = 0.0031;
  camera.frames_per_second = 29.97;
  camera.latency_s = 0.0213;
  return camera;
}

TEST(CameraYaml, RoundTripsCameras) {
  TempFolder folder;
  const RgbdCamera camera = SomeCamera();
  WriteCameraYaml(camera, folder / "camera.yaml");
  const RgbdCamera read = ReadCameraYaml(folder / "camera.yaml");
  EXPECT_EQ(read.depth.width, 320);
  EXPECT_EQ(read.depth.height, 240);
  EXPECT_EQ(read.depth.fx, camera.depth.fx);
  EXPECT_EQ(read.depth.fy, camera.depth.fy);
  EXPECT_EQ(read.depth.cx, camera.depth.cx);
  EXPECT_EQ(read.depth.cy, camera.depth.cy);
  EXPECT_EQ(read.depth.distortion, camera.depth.distortion);
  EXPECT_FALSE(read.color_is_registered);
  EXPECT_EQ(read.color.width, 1280);
  EXPECT_EQ(read.color.fy, camera.color.fy);
  EXPECT_EQ(read.depth_units_per_metre, camera.depth_units_per_metre);
  EXPECT_EQ(read.noise.inverse_depth_sigma, camera.noise.inverse_depth_sigma);
  EXPECT_EQ(read.frames_per_second, camera.frames_per_second);
  EXPECT_EQ(read.latency_s, camera.latency_s);
  // Files have 17 digits. Reading normalises the quaternion, with a rounding error.
  EXPECT_LT((read.color_from_depth.Matrix() - camera.color_from_depth.Matrix()).norm(), 1e-15);
}

// These keys are written only if they differ from the default.
TEST(CameraYaml, KeepsColorsLatencyAndThePrior) {
  TempFolder folder;
  RgbdCamera camera = SomeCamera();
  camera.color_latency_s = -0.0117;
  camera.prior = {0.011, 0.0012, 5.3, 0.021, 0.012, 0.023, 0.0034, 0.0056, 0.013};
  WriteCameraYaml(camera, folder / "camera.yaml");
  const RgbdCamera read = ReadCameraYaml(folder / "camera.yaml");
  EXPECT_EQ(read.color_latency_s, camera.color_latency_s);
  EXPECT_EQ(Numbers(read.prior), Numbers(camera.prior));
  EXPECT_NE(Numbers(read.prior), Numbers(CalibrationPrior()));
}

TEST(CameraYaml, UsesTheDefaultPriorWithoutPriorKeys) {
  TempFolder folder;
  WriteCameraYaml(SomeCamera(), folder / "camera.yaml");
  const RgbdCamera read = ReadCameraYaml(folder / "camera.yaml");
  EXPECT_EQ(read.color_latency_s, 0);
  EXPECT_EQ(Numbers(read.prior), Numbers(CalibrationPrior()));
}

TEST(CameraYaml, KeepsTheDisparityModel) {
  const TempFolder folder;
  RgbdCamera camera = CameraPreset("tum_fr1");
  camera.disparity = {580, 0.075, -8, 1090.5};
  WriteCameraYaml(camera, folder / "camera.yaml");
  const Disparity read = ReadCameraYaml(folder / "camera.yaml").disparity;
  EXPECT_EQ(read.focal_px, 580);
  EXPECT_EQ(read.baseline_m, 0.075);
  EXPECT_EQ(read.counts_per_px, -8);
  EXPECT_EQ(read.count_at_infinity, 1090.5);
  EXPECT_FALSE(CameraPreset("tum_fr1").disparity.IsGiven());

  const std::string text = ReadBytes(folder / "camera.yaml");
  const auto refused = [&](const std::string& from, const std::string& to, const auto&... names) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    WriteBytes(folder / "changed.yaml", changed);
    ExpectInputError([&] { ReadCameraYaml(folder / "changed.yaml"); },
                     Names("changed.yaml", names...));
  };
  refused("disparity:", "depth_units_per_metre: 1000.\ndisparity:", "disparity",
          "depth_units_per_metre");
  refused("counts_per_px", "count_per_px", "count_per_px");
  refused("-8", "0", "disparity", "counts_per_px", 0);
  refused("580", "-580", "disparity", "focal_px", -580);
}

TEST(CameraYaml, KeepsTheInverseDepthField) {
  TempFolder folder;
  const InverseDepthField field = {{-0.0067, 0.001, -0.002, 0.003, -0.004, 0.005}};
  WriteCameraYaml(SomeCamera(), folder / "camera.yaml", field);
  EXPECT_EQ(ReadInverseDepthField(folder / "camera.yaml").coefficients, field.coefficients);
  EXPECT_EQ(ReadCameraYaml(folder / "camera.yaml").depth.fx, SomeCamera().depth.fx);
  WriteCameraYaml(SomeCamera(), folder / "camera.yaml");
  EXPECT_TRUE(ReadInverseDepthField(folder / "camera.yaml").IsZero());
}

TEST(CameraYaml, WritesNoColorCameraForRegisteredColor) {
  TempFolder folder;
  RgbdCamera camera = SomeCamera();
  camera.color_is_registered = true;
  WriteCameraYaml(camera, folder / "camera.yaml");
  EXPECT_TRUE(ReadCameraYaml(folder / "camera.yaml").color_is_registered);
}

// Replaces `from` by `to` in a valid file. Expects an error with the path and the names.
template <typename... Parts>
void ExpectErrorAfterReplacing(const std::string& from, const std::string& to,
                               const Parts&... names) {
  TempFolder folder;
  const std::string path = folder / "camera.yaml";
  std::string text =
      "%YAML:1.0\n---\n"
      "depth_camera: { width: 640, height: 480, fx: 525., fy: 525., cx: 319.5, cy: 239.5 }\n"
      "color_camera: { width: 640, height: 480, fx: 525., fy: 525., cx: 319.5, cy: 239.5,"
      " distortion: [ 0., 0., 0., 0., 0. ] }\n"
      "color_from_depth: { translation_m: [ 0., 0., 0. ], rotation_xyzw: [ 0., 0., 0., 1. ] }\n"
      "depth_units_per_metre: 5000.\n";
  WriteBytes(path, text);
  EXPECT_NO_THROW(ReadCameraYaml(path));
  ASSERT_NE(text.find(from), std::string::npos);
  WriteBytes(path, text.replace(text.find(from), from.size(), to));
  ExpectInputError([&] { ReadCameraYaml(path); }, Names(path, names...));
}

TEST(CameraYaml, RejectsBadValuesByFileAndKey) {
  ExpectErrorAfterReplacing("fx: 525., ", "", "depth_camera", "fx");
  ExpectErrorAfterReplacing("fx: 525.", "fx: -5.", "fx", -5);
  ExpectErrorAfterReplacing("fx: 525.", "fx: many", "depth_camera", "fx");
  ExpectErrorAfterReplacing("width: 640", "width: 640.5", "width");
  ExpectErrorAfterReplacing("depth_camera", "depth_kamera", "depth_kamera");
  ExpectErrorAfterReplacing("distortion", "distorsion", "distorsion");
  ExpectErrorAfterReplacing("[ 0., 0., 0., 0., 0. ]", "[ 0., 0. ]", "distortion", 5);
  ExpectErrorAfterReplacing("[ 0., 0., 0., 1. ]", "[ 0., 0., 0., 0. ]", 0, 1);
  ExpectErrorAfterReplacing("depth_units_per_metre: 5000.\n", "", "depth_units_per_metre");
  ExpectErrorAfterReplacing("color_camera: {", "color_camera: [");
  ExpectErrorAfterReplacing("5000.", "0.", "depth_units_per_metre", 0);
  ExpectErrorAfterReplacing("5000.", "5000.\ninverse_depth_sigma: 0.", "inverse_depth_sigma", 0);
  ExpectErrorAfterReplacing("5000.", "5000.\nlatency_s: 20.", "latency_s", 20);
  ExpectErrorAfterReplacing("5000.", "5000.\ncolor_latency_s: 2.", "color_latency_s", 2);
  ExpectErrorAfterReplacing("5000.", "5000.\nprior: { focal_relative_sigma: -1. }",
                            "focal_relative_sigma", -1);
  ExpectErrorAfterReplacing("5000.", "5000.\nprior: { focus: 1. }", "focus");
}

TEST(CameraYaml, ReadsBlocksCommentsQuotesAndLineBreaksInBrackets) {
  const TempFolder folder;
  const std::string path = folder.Write("camera.yaml",
                                        "# as by hand\r\n"
                                        "depth_camera:   # in blocks\n"
                                        "  width: 640\n"
                                        "  height: 480\n\n"
                                        "  'fx': 525\n"
                                        "  \"fy\": 5.26e+2\n"
                                        "  cx: 319.5\n"
                                        "  cy: 239.5\n"
                                        "  distortion:\n"
                                        "  - 0.1\n"
                                        "  - -.2\n"
                                        "  - 0\n"
                                        "  - 0\n"
                                        "  - 0\n"
                                        "inverse_depth_field: [ 1., 2.,  # three\n"
                                        "3, 4,\n"
                                        "  5, 6 ]\n"
                                        "depth_units_per_metre: 1000.\n"
                                        "...\n"
                                        "after the end");
  const RgbdCamera camera = ReadCameraYaml(path);
  EXPECT_EQ(camera.depth.fx, 525);
  EXPECT_EQ(camera.depth.fy, 526);
  EXPECT_EQ(camera.depth.distortion, (std::array<double, 5>{0.1, -0.2, 0, 0, 0}));
  EXPECT_EQ(camera.depth_units_per_metre, 1000);
  EXPECT_THAT(ReadInverseDepthField(path).coefficients, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(CameraYaml, RejectsBadSyntaxByFileAndLine) {
  ExpectErrorAfterReplacing("5000.", "5000.\n latency_s: 0.", "camera.yaml:7");
  ExpectErrorAfterReplacing("5000.", "5000. 1.", "depth_units_per_metre");
  ExpectErrorAfterReplacing("5000.", "[ 5000. ] 1.", "camera.yaml:6");
  ExpectErrorAfterReplacing("0., 0., 0. ],", "0. 0., 0. ],", "translation_m", 3);
  ExpectErrorAfterReplacing("fx: 525., fy", "fx: 525. fy", "fx");
  ExpectErrorAfterReplacing("1. ] }", "1. ]", "camera.yaml:6");
  ExpectErrorAfterReplacing("fx: 525.", "fx: 525., fx: 525.", "fx");
  ExpectErrorAfterReplacing("5000.\n", "'5000.\n", "camera.yaml:6");
  std::string many = "5000.";
  for (int i = 0; i < 200; ++i) many += "\nkey" + std::to_string(i) + ": 1";
  ExpectErrorAfterReplacing("5000.", many);
}

TEST(CameraYaml, RejectsNonFiniteNestedAndHugeFiles) {
  const TempFolder dir;
  const std::string path = dir.path() + "/camera.yaml";
  const auto refuse = [&](const std::string& text, const auto&... names) {
    WriteBytes(path, "%YAML:1.0\n---\n" + text);
    ExpectInputError([&] { ReadCameraYaml(path); }, Names(path, names...));
    ExpectInputError([&] { ReadInverseDepthField(path); }, Names(path));
  };
  refuse("depth_camera: " + std::string(100000, '['));
  refuse("depth_camera: " + std::string(50000, '['), 200);
  refuse("depth_camera: x'" + std::string(50000, '{'), 200);
  std::string dashes = "depth_camera:\n  ";
  for (int i = 0; i < 20000; ++i) dashes += "- ";
  refuse(dashes + "1\n", 200);
  refuse("depth_camera:\n   : 1.\n", path + ":4");
  WriteBytes(path, "%YAML:1.0\n---\ninverse_depth_field: [ .Nan, 0., 0., 0., 0., 0. ]\n");
  ExpectInputError([&] { ReadInverseDepthField(path); }, Names("inverse_depth_field"));
}

TEST(CameraYaml, RejectsPipesAndFolders) {
  for (const bool is_pipe : {false, true}) {
    const TempFolder folder;
    WriteTumSequence(folder, 2);
    const std::string path = folder.path() + "/camera.yaml";
    std::filesystem::remove(path);
    if (is_pipe) {
      ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    } else {
      std::filesystem::create_directory(path);
    }
    ExpectInputError([&] { OpenSequence(Options(folder)); }, Names(path));
  }
}

TEST(CameraYaml, RejectsUnreadableAndUnwritableFiles) {
  ExpectInputError([] { ReadCameraYaml("/nowhere/camera.yaml"); }, Names("/nowhere/camera.yaml"));
  ExpectInputError([] { WriteCameraYaml(SomeCamera(), "/nowhere/camera.yaml"); },
                   Names("/nowhere/camera.yaml"));
}

}  // namespace
}  // namespace surfit::testing
