#include "surfit/io/camera_yaml.h"
#include "surfit/io/sequence.h"
#include "testing/expect_input_error.h"
#include "testing/klg_encoder.h"
#include "testing/read_all.h"

namespace surfit {
namespace {

using ::testing::ElementsAre;
using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::KlgFile;
using testing::LittleEndian;
using testing::TempFolder;

class KlgTest : public ::testing::Test {
 protected:
  KlgTest() { folder_.Write("a.klg.yaml", testing::SmallCameraYaml()); }
  std::unique_ptr<FrameSource> Open(const std::string& bytes) {
    options_.path = folder_.Write("a.klg", bytes);
    return OpenSequence(options_);
  }
  TempFolder folder_;
  SequenceOptions options_;
};

TEST_F(KlgTest, ReadsEveryCodingOfTheSameFrames) {
  for (const bool zlib : {false, true}) {
    for (const std::string color : {"", ".jpg", "none"}) {
      const auto source = Open(KlgFile(3, zlib, color));
      EXPECT_EQ(source->info().format, "klg");
      EXPECT_TRUE(source->info().warnings.empty());
      const auto results = testing::ReadAll(source.get());
      ASSERT_EQ(results.size(), 3u);
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(results[i].frame) << results[i].error;
        EXPECT_DOUBLE_EQ(results[i].stamp_s, 5 + 0.1 * i);
        const auto raw = testing::NumberedDepth(i);
        for (std::size_t k = 0; k < raw.size(); ++k)
          ASSERT_FLOAT_EQ(results[i].frame->depth_m[k], raw[k] * 0.001f);
        const Image<Rgb8>& read = results[i].frame->color;
        if (color == "none") {
          EXPECT_TRUE(read.empty());
        } else if (color == ".jpg") {
          EXPECT_NEAR(read(16, 12).g, 20, 2);
        } else {
          EXPECT_EQ(read, testing::NumberedColor(i));
        }
      }
    }
  }
}

TEST_F(KlgTest, WithoutACameraTheImagesMustTellTheirSize) {
  std::filesystem::remove(folder_ / "a.klg.yaml");
  options_.intrinsics = {31, 30, 15.5, 11.5};
  EXPECT_EQ(Open(KlgFile(2, true, ".jpg"))->info().pinhole.width, 32);
  ExpectInputError([&] { Open(KlgFile(2, true, "")); }, HasSubstr("does not tell the size"));
  options_.intrinsics.reset();
  ExpectInputError([&] { Open(KlgFile(2, true, ".jpg")); },
                   HasSubstr("depth of frame 0 is 32 x 24 pixels, must be 640 x 480"));
}

TEST_F(KlgTest, ReadsTheWholeFramesOfAFileThatEndsEarly) {
  const std::string whole = KlgFile(3, true, ".jpg");
  const auto source = Open(whole.substr(0, whole.size() - 1));
  EXPECT_EQ(testing::ReadAll(source.get()).size(), 2u);
  EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("promises 3 frames, and is damaged")));
}

TEST_F(KlgTest, RefusesFilesWithoutFrames) {
  ExpectInputError([&] { Open(""); }, HasSubstr("a.klg is 0 bytes long and ends before"));
  ExpectInputError([&] { Open(LittleEndian(0)); }, HasSubstr("a.klg lists no frames"));
  ExpectInputError([&] { Open(LittleEndian(-1)); }, HasSubstr("a.klg lists no frames"));
}

TEST_F(KlgTest, NamesTheFrameThatIsDamaged) {
  std::string file = LittleEndian(4) + testing::KlgFrame(1, "not zlib", "");
  file += testing::KlgFrame(2, testing::ZlibBytes(testing::NumberedDepth(1, 16, 12)), "");
  const std::string depth = testing::RawBytes(testing::NumberedDepth(2));
  file += testing::KlgFrame(3, depth, "no picture");
  const auto results = testing::ReadAll(Open(file + testing::KlgFrame(4, depth, "")).get());
  EXPECT_THAT(results[0].error, HasSubstr("a.klg: depth of frame 0 is damaged"));
  EXPECT_THAT(results[1].error, HasSubstr("depth of frame 1 is damaged: its"));
  EXPECT_THAT(results[2].error, HasSubstr("colour of frame 2 is damaged: neither JPEG nor PNG"));
  EXPECT_TRUE(results[3].frame);
}

TEST_F(KlgTest, AFormatThatIsAFileNeedsAFile) {
  options_.format = "klg";
  options_.path = folder_.path();
  ExpectInputError([&] { OpenSequence(options_); }, HasSubstr("is a folder, which klg is not"));
  options_.path = folder_.Write("a.bin", "");
  options_.format = "auto";
  ExpectInputError([&] { OpenSequence(options_); }, HasSubstr("a.bin is no folder, and neither"));
}

}  // namespace
}  // namespace surfit
