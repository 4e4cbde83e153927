// Recordings of an Azure Kinect, in the form of k4arecord.
#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "io/images/image_files.h"
#include "surfit/core/error.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/io/sequence.h"
#include "testing/largest_allocation.h"
#include "testing/matchers.h"
#include "testing/mkv_writer.h"
#include "testing/mutations.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Camera of the made-up recording, as fractions of the sensor size.
struct Lens {
  double cx, cy, fx, fy;
  double k1, k2, k3, k4, k5, k6, p2, p1;

  std::string Parameters() const {
    std::string text;
    for (const double number : {cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, 0., 0., p2, p1})
      text += (text.empty() ? "" : ", ") + std::to_string(number);
    return "[" + text + "]";
  }
  // OpenCV's rational model.
  Eigen::Vector2d Bent(const Eigen::Vector2d& ray) const {
    const double x = ray.x(), y = ray.y(), r = x * x + y * y;
    const double k =
        (1 + k1 * r + k2 * r * r + k3 * r * r * r) / (1 + k4 * r + k5 * r * r + k6 * r * r * r);
    return {x * k + 2 * p1 * x * y + p2 * (r + 2 * x * x),
            y * k + p1 * (r + 2 * y * y) + 2 * p2 * x * y};
  }
  // Inverse of Bent(), by fixed-point iteration.
  Eigen::Vector2d Straight(const Eigen::Vector2d& bent) const {
    Eigen::Vector2d ray = bent;
    for (int i = 0; i < 100; ++i) ray += 0.5 * (bent - Bent(ray));
    return ray;
  }
};

// Distortion of real cameras: up to 40 px in the corners of the depth image.
constexpr Lens kDepthLens = {0.5102, 0.5003, 0.4935, 0.4937, 0.4361,   0.0683,
                             0.0044, 0.7732, 0.1479, 0.0201, 0.000064, -0.00009};
constexpr Lens kColorLens = {0.5064, 0.5013, 0.4732,  0.6306, 0.6688,    -2.7474,
                             1.5317, 0.5454, -2.5779, 1.4640, -0.000086, 0.000833};

Rigid3d ColorFromDepth() {
  return Rigid3d(Eigen::Quaterniond(Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitX())),
                 {-0.032, -0.002, 0.004});
}

std::string CameraJson(const char* location, const Lens& lens, const Rigid3d& pose, int width,
                       int height) {
  const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
  std::string rotation, translation;
  for (int i = 0; i < 9; ++i) rotation += (i ? ", " : "") + std::to_string(r(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) translation += (i ? ", " : "") + std::to_string(pose.translation[i]);
  return Concat(
      R"({"Intrinsics": {"ModelParameterCount": 14, "ModelParameters": )", lens.Parameters(),
      R"(, "ModelType": "CALIBRATION_LensDistortionModelBrownConrady"}, "Location": ")", location,
      R"(", "MetricRadius": 1.7, "Rt": {"Rotation": [)", rotation, R"(], "Translation": [)",
      translation, R"(]}, "SensorHeight": )", height, R"(, "SensorWidth": )", width, "}");
}

std::string CalibrationJson() {
  return Concat(
      R"({"CalibrationInformation": {"Cameras": [)",
      CameraJson("CALIBRATION_CameraLocationD0", kDepthLens, {}, 1024, 1024), ", ",
      CameraJson("CALIBRATION_CameraLocationPV0", kColorLens, ColorFromDepth(), 4096, 3072),
      R"(], "InertialSensors": []}})");
}

// Mode of the depth camera: narrow and binned. The colour images are the middle of 320 x 240
// pixels.
constexpr int kDepthWidth = 320, kDepthHeight = 288, kColorWidth = 320, kColorHeight = 180;

// The plane n . X = 1.5 m in the frame of the depth camera, and its colour.
const Eigen::Vector3d kNormal(0.2, -0.1, 1);
double DepthOf(const Eigen::Vector3d& ray) { return 1.5 / kNormal.dot(ray); }
Rgb8 ColorOf(const Eigen::Vector3d& point) {
  const auto wave = [](double phase) {
    return static_cast<std::uint8_t>(std::lround(128 + 100 * std::sin(phase)));
  };
  return {wave(4 * point.x()), wave(4 * point.y()), wave(3 * (point.x() + point.y()))};
}

Image<std::uint16_t> MakeDepth() {
  Image<std::uint16_t> depth(kDepthWidth, kDepthHeight);
  for (const auto [u, v] : PixelsOf(depth)) {
    const Eigen::Vector2d bent((u + 96 + 0.5 - 512 * kDepthLens.cx) / (512 * kDepthLens.fx),
                               (v + 90 + 0.5 - 512 * kDepthLens.cy) / (512 * kDepthLens.fy));
    depth(u, v) = static_cast<std::uint16_t>(
        std::lround(1000 * DepthOf(kDepthLens.Straight(bent).homogeneous())));
  }
  return depth;
}

Image<Rgb8> MakeColor() {
  const Rigid3d depth_from_color = ColorFromDepth().Inverse();
  Image<Rgb8> color(kColorWidth, kColorHeight);
  for (const auto [u, v] : PixelsOf(color)) {
    const Eigen::Vector2d bent((u + 0.5 - 320 * kColorLens.cx) / (320 * kColorLens.fx),
                               (v + 30 + 0.5 - 240 * kColorLens.cy) / (240 * kColorLens.fy));
    const Eigen::Vector3d ray = depth_from_color.rotation * kColorLens.Straight(bent).homogeneous();
    const Eigen::Vector3d origin = depth_from_color.translation;
    color(u, v) = ColorOf(origin + (1.5 - kNormal.dot(origin)) / kNormal.dot(ray) * ray);
  }
  return color;
}

const Image<std::uint16_t>& RecordedDepth() {
  static const auto* const depth = new Image<std::uint16_t>(MakeDepth());
  return *depth;
}
const Image<Rgb8>& RecordedColor() {
  static const auto* const color = new Image<Rgb8>(MakeColor());
  return *color;
}

std::string BigEndian(const Image<std::uint16_t>& depth) {
  std::string bytes;
  for (const std::uint16_t value : depth) {
    bytes += static_cast<char>(value >> 8);
    bytes += static_cast<char>(value);
  }
  return bytes;
}

class AzureKinect : public ::testing::Test {
 protected:
  void SetUp() override {
    depth_track_ = writer_.AddTrack("DEPTH", kDepthWidth, kDepthHeight, "b16g");
    ir_track_ = writer_.AddTrack("IR", kDepthWidth, kDepthHeight, "b16g");
    writer_.AddTag("K4A_DEPTH_MODE", "NFOV_2X2BINNED");
    writer_.AddTag("K4A_START_OFFSET_NS", "7000000000");
  }
  void AddColorTrack(const std::string& fourcc) {
    color_track_ = writer_.AddTrack("COLOR", kColorWidth, kColorHeight, fourcc);
  }
  // Frame i at 1 / 30 s, colour 1 ms later.
  void AddFrame(int i, const std::string& depth, const std::string& color) {
    const auto time_us = static_cast<std::uint64_t>(33333 * i);
    writer_.BeginCluster(time_us);
    if (!depth.empty()) writer_.AddFrame(depth_track_, time_us, depth, i % 2 == 1);
    writer_.AddFrame(ir_track_, time_us, std::string(2 * kDepthWidth * kDepthHeight, '\1'));
    if (!color.empty()) writer_.AddFrame(color_track_, time_us + 1000, color);
  }
  std::unique_ptr<FrameSource> Open() {
    return OpenSequence(OptionsOf(folder_.Write("room.mkv", writer_.File())));
  }

  TempFolder folder_;
  MkvWriter writer_;
  int depth_track_ = 0, ir_track_ = 0, color_track_ = 0;
};

// Rounding to mm and to the nearest pixel give up to 3 mm: the depth changes by 3 mm per pixel.
TEST_F(AzureKinect, IsReadUndistortedAndRegistered) {
  AddColorTrack("MJPG");
  const std::string depth = BigEndian(RecordedDepth()), color = EncodeJpeg(RecordedColor(), 95);
  for (int i = 0; i < 3; ++i) AddFrame(i, depth, color);
  AddFrame(3, "", color);
  writer_.AddAttachment("calibration.json", CalibrationJson() + std::string(1, '\0'));
  const auto source = Open();
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "mkv");
  EXPECT_TRUE(info.has_clock);
  EXPECT_FALSE(info.camera_is_guessed);
  EXPECT_NEAR(info.unpaired_ratio, 1. / 7, 1e-9);
  EXPECT_NEAR(info.pinhole.fx, 512 * kDepthLens.fx, 1e-3);
  EXPECT_GT(info.pinhole.width, kDepthWidth);  // without distortion, the view is wider
  EXPECT_LE(info.pinhole.width, 2 * kDepthWidth);
  const std::vector<ReadResult> frames = ReadAll(source.get());
  ASSERT_EQ(frames.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(frames[i].frame) << frames[i].error;
    EXPECT_NEAR(frames[i].stamp_s, 7 + 0.033333 * i, 1e-9);
    EXPECT_NEAR(frames[i].frame->color_stamp_s - frames[i].stamp_s, 0.001, 1e-9);
  }
  const RgbdFrame& frame = *frames[1].frame;
  double worst_m = 0;
  int covered = 0, colored = 0, wrong = 0;
  for (const auto [u, v] : PixelsOf(frame.depth_m)) {
    const double z = frame.depth_m(u, v);
    if (!(z > 0)) continue;
    ++covered;
    const Eigen::Vector3d ray = info.pinhole.Ray(u, v);
    worst_m = std::max(worst_m, std::abs(z - DepthOf(ray)));
    const Rgb8 seen = frame.color(u, v), expected = ColorOf(DepthOf(ray) * ray);
    if (seen == Rgb8()) continue;
    ++colored;
    wrong += std::abs(seen.r - expected.r) > 8 || std::abs(seen.g - expected.g) > 8;
  }
  EXPECT_LT(worst_m, 0.004);
  EXPECT_GT(covered, 0.95 * kDepthWidth * kDepthHeight);
  EXPECT_GT(colored, 0.6 * covered);  // the colour camera sees less above and below
  EXPECT_LT(wrong, 0.01 * colored);
}

TEST_F(AzureKinect, ReadsUncompressedColor) {
  AddColorTrack("BGRA");
  std::string bgra;
  for (int i = 0; i < kColorWidth * kColorHeight; ++i) bgra += std::string("\x0a\x14\x1e\xff", 4);
  AddFrame(0, BigEndian(RecordedDepth()), bgra);
  writer_.AddAttachment("calibration.json", CalibrationJson());
  const auto frames = ReadAll(Open().get());
  ASSERT_TRUE(frames.at(0).frame) << frames[0].error;
  const Image<Rgb8>& color = frames[0].frame->color;
  EXPECT_EQ(color(color.width() / 2, color.height() / 2), (Rgb8{30, 20, 10}));
}

TEST_F(AzureKinect, MayLackColor) {
  AddFrame(0, BigEndian(RecordedDepth()), "");
  writer_.AddAttachment("calibration.json", CalibrationJson());
  const auto frames = ReadAll(Open().get());
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_TRUE(frames[0].frame->color.empty());
}

// Without calibration, the images and the options belong to the recorded images.
TEST_F(AzureKinect, WithoutCalibrationRequiresACamera) {
  AddFrame(0, BigEndian(RecordedDepth()), "");
  ExpectInputError([&] { Open(); }, Names("room.mkv", "calibration.json", "intrinsics"));
  SequenceOptions options = OptionsOf(folder_ / "room.mkv");
  options.intrinsics = {252, 252, 165, 166};
  const auto source = OpenSequence(options);
  EXPECT_EQ(source->info().pinhole.width, kDepthWidth);
  EXPECT_EQ(source->info().pinhole.fx, 252);
  EXPECT_TRUE(source->Next()->frame);
  AddColorTrack("MJPG");
  writer_.AddFrame(color_track_, 0, EncodeJpeg(RecordedColor(), 95));
  folder_.Write("room.mkv", writer_.File());
  ExpectInputError([&] { OpenSequence(options); }, Names("room.mkv", "color_intrinsics"));
}

TEST_F(AzureKinect, TruncatedGivesItsCompleteFrames) {
  const std::string depth = BigEndian(RecordedDepth());
  for (int i = 0; i < 3; ++i) AddFrame(i, depth, "");
  writer_.AddAttachment("calibration.json", CalibrationJson());
  const std::string file = writer_.File();
  const std::string path =
      folder_.Write("room.mkv", file.substr(0, file.size() - 3 * depth.size() / 2));
  const auto source = OpenSequence(OptionsOf(path));
  EXPECT_EQ(source->info().frame_count, 2);
  EXPECT_THAT(source->info().warnings, ::testing::Contains(Names("room.mkv", "truncated", 2)));
}

TEST_F(AzureKinect, RejectsOtherFormats) {
  AddColorTrack("NV12");
  AddFrame(0, BigEndian(RecordedDepth()), "abc");
  ExpectInputError([&] { Open(); }, Names("room.mkv", "COLOR", "NV12", "MJPG"));
  folder_.Write("room.mkv", "no recording");
  ExpectInputError([&] { OpenSequence(OptionsOf(folder_ / "room.mkv")); }, Names("room.mkv"));
}

TEST_F(AzureKinect, RejectsBadCalibration) {
  AddFrame(0, BigEndian(RecordedDepth()), "");
  const auto expect = [&](const std::string& from, const std::string& to, const char* named) {
    std::string json = CalibrationJson();
    ASSERT_NE(json.find(from), json.npos);
    json.replace(json.find(from), from.size(), to);
    MkvWriter writer = writer_;
    writer.AddAttachment("calibration.json", json);
    const std::string path = folder_.Write("room.mkv", writer.File());
    ExpectInputError([&] { OpenSequence(OptionsOf(path)); },
                     Names("room.mkv", "calibration.json", named));
  };
  expect("Cameras", "Kameras", "Cameras");
  expect("LocationD0", "LocationX", "CALIBRATION_CameraLocationD0");
  expect("BrownConrady", "Theta", "CALIBRATION_LensDistortionModelTheta");
  expect("0.493500", "-0.493500", "fx");
  expect("0.510200", "\"x\"", "number");
}

// The data of one frame are 184 kB, and an undistorted image has at most 4 times as many pixels.
TEST_F(AzureKinect, MutatedFilesAreReadOrRejected) {
  AddColorTrack("MJPG");
  for (int i = 0; i < 2; ++i)
    AddFrame(i, BigEndian(RecordedDepth()), EncodeJpeg(RecordedColor(), 50));
  writer_.AddAttachment("calibration.json", CalibrationJson());
  const std::string file = writer_.File();
  // Frames are not mutated: most bytes would be depth.
  const std::size_t head = file.find(BigEndian(RecordedDepth()).substr(0, 64));
  ASSERT_LT(head, 10000u);
  Random random(5);
  int read = 0;
  for (int i = 0; i < 300; ++i) {
    const std::string bytes = Mutated(file.substr(0, head), &random) + file.substr(head);
    const std::string path = folder_.Write("mutated.mkv", bytes);
    ResetLargestAllocation();
    try {
      for (const ReadResult& result : ReadAll(OpenSequence(OptionsOf(path)).get()))
        read += result.frame.has_value();
    } catch (const InputError& error) {
      EXPECT_STRNE(error.what(), "");
    }
    ASSERT_LE(LargestAllocation(), 32 * bytes.size()) << i;
  }
  EXPECT_GT(read, 10);
  EXPECT_LT(read, 600);
}

}  // namespace
}  // namespace surfit::testing
