#include <gmock/gmock.h>

#include <algorithm>

#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

TEST(ConvertTool, WritesASequenceAsKlg) {
  const TempFolder folder;
  WriteTumSequence(folder, 5);
  const ProgramResult result =
      Succeeded(RunProgram("surfit_convert", {"--sequence=" + folder.path(), "--stride=2",
                                              "--output=" + (folder / "a.klg")}));
  EXPECT_THAT(result.out, Names("a.klg", 3, 0));
  const auto frames = ReadAll(OpenSequence(OptionsOf(folder / "a.klg")).get());
  ASSERT_EQ(frames.size(), 3u);
  // Depth is exact, and colour is JPEG.
  for (std::size_t i = 0; i < frames[2].frame->depth_m.size(); ++i) {
    ASSERT_FLOAT_EQ(frames[2].frame->depth_m[i], 0.001f * NumberedDepth(4)[i]);
    ASSERT_NEAR(frames[2].frame->color[i].r, 4, 3);
    ASSERT_NEAR(frames[2].frame->color[i].g, 20, 3);
    ASSERT_NEAR(frames[2].frame->color[i].b, 30, 3);
  }
  EXPECT_DOUBLE_EQ(frames[2].stamp_s, 5.403);
}

// Confidence is low in the left quarter of each image.
TEST(ConvertTool, ReportsDepthOfLowConfidence) {
  const TempFolder folder;
  WriteTumSequence(folder, 2);
  Image<std::uint8_t> confidence(32, 24, 2);
  for (int v = 0; v < 24; ++v) std::fill_n(confidence.row(v), 8, std::uint8_t{0});
  for (int i = 0; i < 2; ++i)
    WriteConfidence(folder / Format("confidence/%03d.png", i), confidence);
  const auto convert = [&](const std::string& flag) {
    return Succeeded(RunProgram(
        "surfit_convert", {"--sequence=" + folder.path(), "--output=" + (folder / "a.klg"), flag}));
  };
  const ProgramResult with = convert("--confidence=true"), without = convert("--confidence=false");
  EXPECT_THAT(with.err, Names("confidence", "25"));
  EXPECT_THAT(with.out, Names("confidence"));
  EXPECT_THAT(without.err, Not(Names("confidence")));
  EXPECT_THAT(without.out, Not(Names("confidence")));
}

TEST(ConvertTool, WritesACameraYamlWithTheAssumedCamera) {
  const TempFolder folder;
  WriteColor(folder / "color/1.png", NumberedColor(1, 640, 480));
  WriteDepth(folder / "depth/1.png", NumberedDepth(1, 640, 480));
  const std::string sequence = "--sequence=" + folder.path();
  const ProgramResult made =
      Succeeded(RunProgram("surfit_convert", {sequence, "--to=camera_yaml"}));
  EXPECT_THAT(made.out, Names(folder.path() + "/camera.yaml", "redwood", 1));
  EXPECT_THAT(made.err, HasWarning(folder.path()));
  const auto info = OpenSequence(OptionsOf(folder.path()))->info();
  EXPECT_EQ(info.camera_from, folder.path() + "/camera.yaml");
  EXPECT_EQ(info.camera.depth.fx, 525);
  EXPECT_EQ(info.camera.depth.width, 640);
  EXPECT_THAT(info.warnings, IsEmpty());
  ExpectRefused(RunProgram("surfit_convert", {sequence, "--to=camera_yaml"}), "camera.yaml");
  Succeeded(RunProgram("surfit_convert", {sequence, "--to=camera_yaml", "--intrinsics=500,501,3,4",
                                          "--output=" + (folder / "other.yaml")}));
  EXPECT_EQ(ReadCameraYaml(folder / "other.yaml").depth.fy, 501);
}

TEST(ConvertTool, WritesCloudsAsPcdAndPly) {
  const TempFolder folder;
  const PointCloud cloud = {{{1, 2, 3}}, {{0, 0, 1}}, {{4, 5, 6}}};
  WritePly(cloud, folder / "map.ply");
  std::string from = folder / "map.ply";
  for (const char* name : {"a.pcd", "b.ply"}) {
    const ProgramResult result =
        Succeeded(RunProgram("surfit_convert", {"--map=" + from, "--output=" + (folder / name)}));
    EXPECT_THAT(result.out, Names(1));
    from = folder / name;
    const PointCloud read = ReadPointCloud(from);
    EXPECT_EQ(read.points, cloud.points);
    EXPECT_EQ(read.normals, cloud.normals);
    EXPECT_EQ(read.colors, cloud.colors);
  }
  EXPECT_EQ(ReadBytes(folder / "a.pcd").substr(0, 6), "# .PCD");
}

TEST(ConvertTool, WritesTrajectoriesAsKittiPoses) {
  const TempFolder folder;
  const std::string path = folder.Write("t.txt", "1.5 7 8 9 0 0 0 1\n");
  Succeeded(
      RunProgram("surfit_convert", {"--estimate=" + path, "--output=" + (folder / "poses.txt")}));
  EXPECT_THAT(ReadBytes(folder / "poses.txt"), Names("0.000000000 1.000000000 9.000000000"));
}

TEST(ConvertTool, CountsFramesThatKittiPosesLack) {
  const TempFolder folder;
  std::string lines;
  for (const int i : {0, 1, 2, 5, 6, 8}) lines += std::to_string(0.1 * i) + " 7 8 9 0 0 0 1\n";
  const ProgramResult result =
      Succeeded(RunProgram("surfit_convert", {"--estimate=" + folder.Write("t.txt", lines),
                                              "--output=" + (folder / "poses.txt")}));
  EXPECT_THAT(result.err, ::testing::HasSubstr("about 3 frames have no pose"));
}

TEST(ConvertTool, RejectsBadInput) {
  const auto expect = [](const std::vector<std::string>& flags, const auto&... names) {
    ExpectRefused(RunProgram("surfit_convert", flags), names...);
  };
  expect({}, "--sequence", "--map", "--estimate", "surfit_convert", "--help");
  expect({"--map=b"}, "--output");
  expect({"--map=b", "--to=camera_yaml"}, "--to=camera_yaml", "--sequence");
  expect({"--map=b", "--to=colmap"}, "--to=colmap", "--run");
  expect({"--output=a", "--to=ply"}, "--to", "ply", "colmap", "camera_yaml");
  expect({"--output=a", "--cloud=b"}, "--cloud", "--map");
  expect({"--output=a"}, "--sequence", "--map", "--estimate");
  expect({"--output=a", "--map=b", "--estimate=c"}, "--sequence", "--map", "--estimate");
  expect({"--output=a.ply", "--sequence=b"}, "--output", "a.ply", ".klg");
  expect({"--output=a.klg", "--map=b"}, "--output", "a.klg", ".pcd", ".ply");
}

}  // namespace
}  // namespace surfit::testing
