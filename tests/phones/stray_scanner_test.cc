// Recordings of Stray Scanner: a video, depth, confidence and a table of poses and intrinsics.
#include <opencv2/videoio.hpp>

#include "io/phones/mp4_samples.h"
#include "io/sequences/raw_frames.h"
#include "phones/simulated_phone.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr char kHead[] = "timestamp, frame, x, y, z, qx, qy, qz, qw";

std::string TumNumbers(const Rigid3d& pose) {
  std::string text;
  for (const double number :
       {pose.translation.x(), pose.translation.y(), pose.translation.z(), pose.rotation.x(),
        pose.rotation.y(), pose.rotation.z(), pose.rotation.w()})
    text += ", " + Number(number);
  return text;
}

std::string LensNumbers(const PinholeCamera& c) {
  return ", " + Number(c.fx) + ", " + Number(c.fy) + ", " + Number(c.cx) + ", " + Number(c.cy);
}

std::string OdometryRow(const SimulatedFrame& frame, int number) {
  return Number(frame.stamp_s) + Format(", %06d", number) + TumNumbers(frame.world_from_camera) +
         LensNumbers(frame.color_camera) + ", , \n";
}

void WriteVideo(const std::string& path, const std::vector<SimulatedFrame>& frames) {
  cv::VideoWriter writer(path, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 60, {320, 240});
  ASSERT_TRUE(writer.isOpened());
  for (const SimulatedFrame& frame : frames) {
    cv::Mat bgr(240, 320, CV_8UC3);
    for (std::size_t i = 0; i < frame.color.size(); ++i)
      bgr.at<cv::Vec3b>(static_cast<int>(i)) = {frame.color[i].b, frame.color[i].g,
                                                frame.color[i].r};
    writer.write(bgr);
  }
}

// Mean difference of two images, in grey levels.
double Difference(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += std::abs(a[i].r - b[i].r) + std::abs(a[i].g - b[i].g) + std::abs(a[i].b - b[i].b);
  return sum / (3. * a.size());
}

// A recording as the app writes it. Tests change single files.
class StrayScanner : public PhoneTest {
 protected:
  static std::string Odometry() {
    std::string text =
        std::string(kHead) + ", fx, fy, cx, cy, distortion_center_x, distortion_center_y\n";
    for (int i = 0; i < kFrames; ++i) text += OdometryRow(Frames()[i], i);
    return text;
  }
  static std::string CameraMatrix(double fx = 250) {
    return Number(fx) + ", 0.0, 158.5\n0.0, 250.0, 121.5\n0.0, 0.0, 1.0";
  }

  void Write() const {
    folder_.Write("odometry.csv", Odometry());
    folder_.Write("camera_matrix.csv", CameraMatrix());
    folder_.Write("imu.csv", "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n");
    for (int i = 0; i < kFrames; ++i) {
      WriteDepth(folder_ / Format("depth/%06d.png", i), Millimetres(Frames()[i].depth_m));
      WriteConfidence(folder_ / Format("confidence/%06d.png", i), Frames()[i].confidence);
    }
    WriteVideo(folder_ / "rgb.mp4", Frames());
  }
};

TEST_F(StrayScanner, IsTrackedToThePosesOfThePhone) {
  Write();
  const auto source = Open();
  EXPECT_EQ(source->info().format, "stray_scanner");
  EXPECT_FALSE(source->info().camera_is_guessed);
  EXPECT_TRUE(source->info().has_clock);
  EXPECT_TRUE(source->info().ground_truth.empty());
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_LT(TrackingError(Options(folder_)), 0.0014);
}

TEST_F(StrayScanner, PosesOfThePhoneAreNotUsedWithoutRequest) {
  Write();
  EXPECT_FALSE(TrackPhone(Options(folder_), "").evaluation);
}

TEST_F(StrayScanner, DepthOfLowConfidenceIsMissing) {
  Write();
  SequenceOptions without = Options(folder_);
  without.confidence = false;
  const auto used = Open()->Next(), ignored = OpenSequence(without)->Next();
  ASSERT_TRUE(used->frame && ignored->frame);
  const Image<std::uint8_t>& confidence = Frames()[0].confidence;
  for (const auto [u, v] : PixelsOf(confidence)) {
    // Images are resampled, so the borders of regions move by up to one pixel.
    const bool is_border = u % 40 == 0 || u % 40 == 39 || v % 20 == 0 || v % 20 == 19 || u > 155;
    if (is_border || !(Frames()[0].true_depth_m(u, v) > 0)) continue;
    ASSERT_EQ(used->frame->depth_m(u, v) > 0, confidence(u, v) > 0) << u << " " << v;
    ASSERT_GT(ignored->frame->depth_m(u, v), 0) << u << " " << v;
  }
}

// The matrix of the last frame is wrong for the other frames.
TEST_F(StrayScanner, OneLensForAllFramesBendsThePath) {
  Write();
  std::string odometry = std::string(kHead) + "\n";
  for (int i = 0; i < kFrames; ++i)
    odometry += Number(Frames()[i].stamp_s) + Format(", %d", i) +
                TumNumbers(Frames()[i].world_from_camera) + "\n";
  folder_.Write("odometry.csv", odometry);
  const double error_m = ErrorOf(TrackPhone(Options(folder_)), kFrames);
  std::printf("ATE with one lens %.5f m\n", error_m);
  EXPECT_GT(error_m, 0.003);
}

// Depth of all frames is that of one camera, although each frame has a focal length of its own.
TEST_F(StrayScanner, ResamplesFramesToTheMedianLens) {
  Write();
  const auto source = Open();
  const PinholeCamera& lens = source->info().camera.color;
  EXPECT_NEAR(lens.fx, 250, 1);
  EXPECT_THAT(source->info().camera_from, Names("odometry.csv", "median", kFrames));
  const Scene scene = MakeScene("room", 3);
  const Trajectory path = MakePath(scene, kFrames, 3);
  for (int i = 0; i < kFrames; ++i) {
    const auto result = source->Next();
    ASSERT_TRUE(result->frame) << result->error;
    const Image<float> exact_m =
        RenderFrame(scene, source->info().camera.depth, path[i].world_from_camera).depth_m;
    std::vector<double> errors_m;
    for (std::size_t k = 0; k < exact_m.size(); ++k) {
      if (result->frame->depth_m[k] > 0 && exact_m[k] > 0)
        errors_m.push_back(std::abs(result->frame->depth_m[k] - exact_m[k]));
    }
    std::sort(errors_m.begin(), errors_m.end());
    ASSERT_GT(errors_m.size(), exact_m.size() / 2);
    // Counts are rounded to 1 mm twice. Curved surfaces and edges are not interpolated exactly.
    EXPECT_LT(errors_m[errors_m.size() / 2], 0.0007) << i;
    EXPECT_LT(errors_m[errors_m.size() * 9 / 10], 0.0036) << i;
  }
}

TEST_F(StrayScanner, ColorIsTheFrameOfTheVideoWithTheSameNumber) {
  Write();
  for (const char* name : {"depth/000007.png", "depth/000008.png"})
    std::filesystem::remove(folder_ / name);
  const auto source = Open();
  EXPECT_THAT(source->info().warnings,
              ElementsAre(Names("odometry.csv", 2, "depth/"), Names("rgb.mp4", 2)));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), kFrames - 2u);
  ASSERT_TRUE(results[8].frame) << results[8].error;
  EXPECT_NEAR(results[8].stamp_s, Frames()[10].stamp_s, 1e-6);
  const RectifyOptions rectify;
  const auto expected = [&](int i) {
    RgbdCamera camera = source->info().camera;
    return FrameRectifier(camera, rectify)
        .Rectify(Millimetres(Frames()[i].true_depth_m), Frames()[i].color)
        .color;
  };
  const double same = Difference(results[8].frame->color, expected(10));
  EXPECT_LT(same, 0.7 * Difference(results[8].frame->color, expected(8)));
  EXPECT_LT(same, 0.7 * Difference(results[8].frame->color, expected(11)));
}

// The app writes its first frame with a negative time, and decoders do not show it.
TEST_F(StrayScanner, FirstFrameOfTheVideoIsHiddenByItsEditList) {
  Write();
  std::string bytes;
  {
    std::ifstream file(folder_ / "rgb.mp4", std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  const auto samples = ReadMp4Samples(folder_ / "rgb.mp4");
  EXPECT_EQ(samples.total, kFrames);
  EXPECT_EQ(samples.hidden, 0);
  const std::size_t list = bytes.find("elst"), times = bytes.find("stts");
  ASSERT_NE(list, bytes.npos);
  // Entry of the list: duration, start, rate. The start becomes the duration of one frame.
  bytes.replace(list + 16, 4, bytes.substr(times + 16, 4));
  folder_.Write("rgb.mp4", bytes);
  EXPECT_EQ(ReadMp4Samples(folder_ / "rgb.mp4").hidden, 1);
  const auto source = Open();
  EXPECT_THAT(source->info().warnings, ElementsAre(Names("rgb.mp4", 1, "hidden")));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kFrames));
  ASSERT_TRUE(results[0].frame) << results[0].error;
  EXPECT_TRUE(results[0].frame->color.empty());
  const Image<Rgb8>& color = results[5].frame->color;
  const auto expected = [&](int i) {
    return FrameRectifier(source->info().camera, {})
        .Rectify(Millimetres(Frames()[i].true_depth_m), Frames()[i].color)
        .color;
  };
  EXPECT_LT(Difference(color, expected(5)), 0.7 * Difference(color, expected(4)));
  EXPECT_LT(Difference(color, expected(5)), 0.7 * Difference(color, expected(6)));
}

// Versions before 2026 have one camera matrix, and arrays of NumPy before 2022.
TEST_F(StrayScanner, ReadsOlderVersions) {
  const auto frames = RecordWithPhone(kFrames, /*changes_focus=*/false);
  std::string odometry = std::string(kHead) + "\n";
  for (int i = 0; i < kFrames; ++i) {
    const Image<std::uint16_t> depth = Millimetres(frames[i].depth_m);
    std::string npy = "\x93NUMPY\x01";
    std::string header = "{'descr': '<u2', 'fortran_order': False, 'shape': (120, 160), }";
    header += std::string(117 - header.size(), ' ') + "\n";
    npy += std::string("\0v\0", 3) + header;
    npy.append(reinterpret_cast<const char*>(depth.data()), 2 * depth.size());
    folder_.Write(Format("depth/%06d.npy", i), npy);
    WriteConfidence(folder_ / Format("confidence/%06d.png", i), frames[i].confidence);
    odometry += Number(frames[i].stamp_s) + Format(", %06d", i) +
                TumNumbers(frames[i].world_from_camera) + "\n";
  }
  folder_.Write("odometry.csv", odometry);
  folder_.Write("camera_matrix.csv", CameraMatrix());
  WriteVideo(folder_ / "rgb.mp4", frames);
  EXPECT_THAT(Open()->info().camera_from, Not(HasSubstr("median")));
  EXPECT_LT(ErrorOf(TrackPhone(Options(folder_)), kFrames), 0.0014);
}

TEST_F(StrayScanner, UsesDepthAloneWithoutAVideo) {
  Write();
  folder_.Write("rgb.mp4", "not a video");
  // Without the video, the intrinsics are for 1920 x 1440 pixels.
  std::string odometry = std::string(kHead) + "\n";
  for (int i = 0; i < kFrames; ++i)
    odometry += Number(Frames()[i].stamp_s) + Format(", %d", i) +
                TumNumbers(Frames()[i].world_from_camera) + "\n";
  folder_.Write("odometry.csv", odometry);
  folder_.Write("camera_matrix.csv", "1500, 0, 953.5\n0, 1500, 731.5\n0, 0, 1\n");
  const auto source = Open();
  EXPECT_THAT(source->info().warnings, ElementsAre(Names("rgb.mp4", 1920, 1440)));
  EXPECT_NEAR(source->info().camera.depth.fx, 125, 1e-9);
  EXPECT_TRUE(source->Next()->frame->color.empty());
}

TEST_F(StrayScanner, ReportsExtraAndMissingFiles) {
  Write();
  folder_.Write("odometry.csv", Odometry() + OdometryRow(Frames()[3], 3) + "8125.1, 0000");
  WriteDepth(folder_ / "depth/000100.png", Millimetres(Frames()[0].depth_m));
  std::filesystem::remove(folder_ / "confidence/000005.png");
  const auto source = Open();
  EXPECT_THAT(
      source->info().warnings,
      ElementsAre(Names("odometry.csv:43", "incomplete"), Names("odometry.csv", 1, "repeat"),
                  Names("depth", 1, "odometry.csv"), Names(1, "confidence", "000005.png")));
  EXPECT_EQ(source->info().frame_count, kFrames);
}

struct BadStrayFile {
  const char* file;
  std::string content;
  std::vector<std::string> names;
};

TEST_F(StrayScanner, RejectsWrongMetadata) {
  Write();
  const std::string row = "8123.4, 0, 0, 0, 0, 0, 0, 0, 1";
  const std::string head = std::string(kHead) + ", fx, fy, cx, cy\n";
  const std::vector<BadStrayFile> files = {
      {"odometry.csv", "timestamp, x, y, z, qx, qy, qz, qw\n", {"odometry.csv", "column frame"}},
      {"odometry.csv", "", {"odometry.csv", "names of its columns"}},
      {"odometry.csv", head + row + ", 250, 250, 960, 121\n", {"csv:2", "cx is 960", "320"}},
      {"odometry.csv", head + row + ", 0, 250, 158, 121\n", {"csv:2", "fx is 0", "positive"}},
      {"odometry.csv", head + row + ", 250, nan, 158, 121\n", {"csv:2", "fy", "finite"}},
      {"odometry.csv", head + row + ", 250\n", {"csv:2", "fy is missing"}},
      {"odometry.csv",
       head + "8123.4, 0.5, 0, 0, 0, 0, 0, 0, 1, 250, 250, 158, 121\n",
       {"csv:2", "frame is 0.5", "integer"}},
      {"odometry.csv",
       head + "noon, 0, 0, 0, 0, 0, 0, 0, 1, 250, 250, 158, 121\n",
       {"csv:2", "timestamp is 'noon'", "finite"}},
  };
  for (const BadStrayFile& bad : files) {
    folder_.Write(bad.file, bad.content);
    for (const std::string& name : bad.names) ExpectInputError([&] { Open(); }, HasSubstr(name));
  }
  folder_.Write("odometry.csv", std::string(kHead) + "\n" + row + "\n");
  folder_.Write("camera_matrix.csv", "250, 0, 158\n0, 250, 121\n");
  ExpectInputError([&] { Open(); }, Names("camera_matrix.csv", "2 rows", 3));
  folder_.Write("camera_matrix.csv", "250, 0, 158\n1, 250, 121\n0, 0, 1\n");
  ExpectInputError([&] { Open(); }, Names("camera_matrix.csv", "element 2, 1", 0));
  folder_.Write("camera_matrix.csv", CameraMatrix(-250));
  ExpectInputError([&] { Open(); }, Names("camera_matrix.csv", "fx", -250));
}

TEST_F(StrayScanner, LeavesOutInvalidPosesOfThePhone) {
  Write();
  std::string odometry = std::string(kHead) + "\n8123.4, 0, 0, 0, 0, 0, 0, 0, 1\n";
  odometry += "8123.5, 1, 0, 0, 0, 0, 0, 0, 0\n8123.6, 2, 1, 0, 0, 0, 0, 0, nan\n";
  folder_.Write("odometry.csv", odometry);
  EXPECT_EQ(ReadDevicePoses(Options(folder_)).size(), 1u);
  EXPECT_EQ(Open()->info().frame_count, 3);
}

TEST(DevicePoses, NeedAFormatWithPoses) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  ExpectInputError([&] { ReadDevicePoses(Options(folder)); }, Names(folder.path(), "tum"));
}

}  // namespace
}  // namespace surfit::testing
