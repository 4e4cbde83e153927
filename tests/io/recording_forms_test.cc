// Recordings in forms that other programs write.

#include "io/slanted_depth.h"
#include "surfit/io/g2o.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";

class FolderTest : public ::testing::Test {
 protected:
  void WriteFrames(const std::string& depth, const std::string& color) const {
    for (int i = 0; i < 3; ++i) {
      WriteDepth(folder_ / (depth + Format("/frame_%05d.png", i + 1)), SlantedDepth(i));
      WriteColor(folder_ / (color + Format("/frame_%05d.png", i + 1)),
                 NumberedColor(i, kSlantedWidth, kSlantedHeight));
    }
  }
  std::unique_ptr<FrameSource> Open() const { return OpenSequence(Options(folder_)); }

  TempFolder folder_;
};

TEST_F(FolderTest, DecodesAllFrames) {
  for (int i = 0; i < 3; ++i)
    WriteDepth(folder_ / Format("depth/%d.png", i),
               Changed(SlantedDepth(i), [](int count) { return count << 8 | count >> 8; }));
  SequenceOptions options = Options(folder_);
  options.intrinsics = {70, 70, 40, 30};
  const auto source = OpenSequence(options);
  EXPECT_THAT(source->info().warnings, ::testing::Contains(Names("bytes")));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i)
    EXPECT_FLOAT_EQ(results[i].frame->depth_m[0], 0.001f * SlantedDepth(i)[0]);
}

TEST_F(FolderTest, ReadsCameraAndFilesOfNerfstudio) {
  WriteFrames("depth", "images");
  std::string frames;
  for (const int i : {2, 1, 3}) {
    const std::string name = Format("frame_%05d.png", i);
    frames += (frames.empty() ? "" : ",") + std::string("{\"file_path\": \"images/") + name +
              "\", \"depth_file_path\": \"depth/" + name + "\"}";
  }
  folder_.Write(
      "transforms.json",
      "{\"fl_x\": 71, \"fl_y\": 72, \"cx\": 40, \"cy\": 30, \"w\": 80, \"h\": 60, \"k1\": "
      "0.01, \"camera_model\": \"OPENCV\", \"depth_unit_scale_factor\": 0.0005, "
      "\"frames\": [" +
          frames + "]}");
  const auto source = Open();
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "nerfstudio");
  EXPECT_FALSE(info.camera_is_guessed);
  EXPECT_EQ(info.camera.depth.fx, 71);
  EXPECT_EQ(info.camera.depth.fy, 72);
  EXPECT_EQ(info.camera.depth.distortion[0], 0.01);
  EXPECT_DOUBLE_EQ(info.camera.depth_units_per_metre, 2000);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_EQ(results[i].frame->color(40, 30).r, i);
  }
}

TEST_F(FolderTest, RejectsNerfstudioFisheyeByItsModel) {
  WriteFrames("depth", "images");
  folder_.Write("transforms.json",
                "{\"fl_x\": 71, \"cx\": 40, \"cy\": 30, \"w\": 80, \"h\": 60, \"camera_model\": "
                "\"OPENCV_FISHEYE\", \"frames\": []}");
  ExpectInputError([&] { Open(); }, Names("transforms.json", "OPENCV_FISHEYE"));
}

TEST_F(FolderTest, ReadsTheCameraOfInfoText) {
  for (int i = 0; i < 3; ++i)
    WriteDepth(folder_ / Format("frame-%06d.depth.png", i), SlantedDepth(i));
  folder_.Write(
      "_info.txt",
      "m_versionNumber = 4\nm_colorWidth = 80\nm_colorHeight = 60\nm_depthWidth = 80\n"
      "m_depthHeight = 60\nm_depthShift = 2000\nm_calibrationColorIntrinsic = 75 0 40 0 0 "
      "76 30 0 0 0 1 0 0 0 0 1\nm_calibrationDepthIntrinsic = 75 0 40 0 0 76 30 0 0 0 1 0 "
      "0 0 0 1\n");
  const SequenceInfo info = Open()->info();
  EXPECT_EQ(info.format, "seven_scenes");
  EXPECT_EQ(info.camera.depth.fx, 75);
  EXPECT_EQ(info.camera.depth.fy, 76);
  EXPECT_EQ(info.camera.depth_units_per_metre, 2000);
  EXPECT_TRUE(info.camera.color_is_registered);
}

TEST_F(FolderTest, TellsThatTheCameraOfSevenScenesIsGuessedByNames) {
  Image<std::uint16_t> depth(640, 480, 1800);
  for (std::size_t i = 0; i < depth.size(); ++i)
    depth[i] = static_cast<std::uint16_t>(1500 + i % 640);
  WriteDepth(folder_ / "frame-000000.depth.png", depth);
  EXPECT_TRUE(Open()->info().camera_is_guessed);
  SequenceOptions options = Options(folder_);
  options.format = "seven_scenes";
  EXPECT_FALSE(OpenSequence(options)->info().camera_is_guessed);
}

TEST_F(FolderTest, RejectsIntrinsicsThatAreRatiosOfTheImageSize) {
  WriteFrames("depth", "color");
  SequenceOptions options = Options(folder_);
  const std::array<double, 4> refused[] = {
      {0.8, 1.1, 0.5, 0.5}, {0.8, 1.1, 39.5, 29.5}, {70, 70, 0.5, 0.5}, {1.2, 1.2, 0, 0}};
  for (const auto& intrinsics : refused) {
    options.intrinsics = intrinsics;
    ExpectInputError([&] { OpenSequence(options); },
                     Names("fx", intrinsics[0], intrinsics[1], intrinsics[2], 80, 60));
  }
}

TEST_F(FolderTest, NamesAnImageFormatThatIsNotSupported) {
  WriteDepth(folder_ / "depth/1.png", SlantedDepth(0));
  folder_.Write("color/1.webp", std::string("RIFF\x20\0\0\0WEBPVP8 ", 16) + std::string(40, 'x'));
  SequenceOptions options = Options(folder_);
  options.intrinsics = {70, 70, 40, 30};
  ExpectInputError([&] { OpenSequence(options); }, Names("color/1.webp", "WebP"));
}

TEST(ByteOrderMark, IsIgnoredInTextFiles) {
  const TempFolder folder;
  WriteTumSequence(folder, 2);
  for (const char* name : {"depth.txt", "rgb.txt", "groundtruth.txt"}) {
    const std::string text = ReadBytes(folder / name);
    folder.Write(name, kByteOrderMark + text.substr(text.find('\n') + 1));
  }
  EXPECT_EQ(OpenSequence(Options(folder))->info().frame_count, 2);
  EXPECT_EQ(ReadTumTrajectory(folder / "groundtruth.txt").size(), 2u);
  const std::string graph = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  EXPECT_EQ(ReadG2o(folder.Write("a.g2o", kByteOrderMark + graph)).graph.poses.size(), 1u);
}

TEST(G2o, CountsVerticesOfOtherTypesWithTheirFix) {
  const TempFolder folder;
  const std::string point = "VERTEX_TRACKXYZ 0 1 2 3\nFIX 0\n";
  ExpectInputError([&] { ReadG2o(folder.Write("point.g2o", point)); },
                   Names("point.g2o", "VERTEX_TRACKXYZ", "FIX"));
  const G2oFile file =
      ReadG2o(folder.Write("mixed.g2o", point + "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\nFIX 1\n"));
  EXPECT_TRUE(file.graph.poses.at(0).fixed);
  EXPECT_EQ(file.ignored_lines.at("FIX"), 1u);
}

}  // namespace
}  // namespace surfit::testing
