#include "surfit/io/klg_writer.h"

#include "surfit/io/sequence.h"
#include "testing/expect_input_error.h"
#include "testing/read_all.h"
#include "testing/sequence_writer.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::TempFolder;

class KlgWriterTest : public ::testing::Test {
 protected:
  KlgWriterTest() { testing::WriteTumSequence(folder_, 4); }
  std::unique_ptr<FrameSource> Open(const std::string& path) {
    SequenceOptions options;
    options.path = path;
    return OpenSequence(options);
  }
  KlgSummary Write(const KlgOptions& options) {
    return WriteKlg(Open(folder_.path()).get(), folder_ / "a.klg", options);
  }
  TempFolder folder_;
};

TEST_F(KlgWriterTest, FramesComeBackAsTheyWere) {
  const auto expected = testing::ReadAll(Open(folder_.path()).get());
  for (const bool compress : {false, true}) {
    const KlgSummary summary = Write({compress, 0});
    EXPECT_EQ(summary.frames_written, 4);
    EXPECT_EQ(summary.frames_skipped, 0);
    EXPECT_EQ(summary.depths_beyond, 0);
    const auto source = Open(folder_ / "a.klg");
    EXPECT_EQ(source->info().pinhole.fx, 31);
    const auto read = testing::ReadAll(source.get());
    ASSERT_EQ(read.size(), 4u);
    for (int i = 0; i < 4; ++i) {
      EXPECT_DOUBLE_EQ(read[i].stamp_s, expected[i].stamp_s);
      EXPECT_EQ(read[i].frame->depth_m, expected[i].frame->depth_m);
      EXPECT_EQ(read[i].frame->color, expected[i].frame->color);
    }
  }
}

TEST_F(KlgWriterTest, JpegKeepsColourToItsQuality) {
  Write({true, 95});
  const auto read = testing::ReadAll(Open(folder_ / "a.klg").get());
  const Rgb8 color = read[3].frame->color(16, 12);
  EXPECT_NEAR(color.r, 3, 2);
  EXPECT_NEAR(color.g, 20, 2);
  EXPECT_NEAR(color.b, 30, 2);
  const auto jpeg_size = std::filesystem::file_size(folder_ / "a.klg");
  Write({true, 0});
  EXPECT_LT(jpeg_size, std::filesystem::file_size(folder_ / "a.klg") / 2);
}

TEST_F(KlgWriterTest, KeepsTheConventionOfAMirroredSource) {
  folder_.Write("camera.yaml", testing::SmallCameraYaml(-30));
  Write({});
  const auto source = Open(folder_ / "a.klg");
  EXPECT_EQ(source->info().camera.depth.fy, -30);
  EXPECT_TRUE(source->info().mirrored);
}

TEST_F(KlgWriterTest, CountsWhatItLeavesOut) {
  std::filesystem::remove(folder_ / "depth/002.png");
  Image<std::uint16_t> far = testing::NumberedDepth(1);
  far[5] = 0;      // missing
  far[6] = 65534;  // the most that a .klg file can hold
  testing::WriteDepth(folder_ / "depth/001.png", far);
  testing::WriteDepth(folder_ / "depth/003.tiff", Image<float>(32, 24, 65.535f));
  std::filesystem::rename(folder_ / "depth/003.tiff", folder_ / "depth/003.png");
  SequenceOptions options;
  options.path = folder_.path();
  options.prepare.max_depth_m = 100;
  const KlgSummary summary = WriteKlg(OpenSequence(options).get(), folder_ / "a.klg", {});
  EXPECT_EQ(summary.frames_written, 3);
  EXPECT_EQ(summary.frames_skipped, 1);
  EXPECT_EQ(summary.depths_beyond, 32 * 24);
}

TEST_F(KlgWriterTest, RefusesBadOptions) {
  ExpectInputError([&] { Write({true, 101}); }, HasSubstr("jpeg_quality is 101, must be from 0"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.klg"));
}

}  // namespace
}  // namespace surfit
