#include <limits>

#include "surfit/io/sequence.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SensTest : public ::testing::Test {
 protected:
  std::unique_ptr<FrameSource> Open(const std::string& bytes) {
    options_.path = folder_.Write("a.sens", bytes);
    return OpenSequence(options_);
  }
  TempFolder folder_;
  SequenceOptions options_;
  SensEncoder encoder_;
};

TEST_F(SensTest, ReadsEveryCodingOfTheSameFrames) {
  encoder_.registered = true;
  for (encoder_.depth_coding = 0; encoder_.depth_coding < 2; ++encoder_.depth_coding) {
    for (const char* color : {"", ".png", ".jpg", "none"}) {
      encoder_.color_coding = color;
      const auto results = ReadAll(Open(encoder_.File(3)).get());
      ASSERT_EQ(results.size(), 3u);
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(results[i].frame) << results[i].error;
        EXPECT_DOUBLE_EQ(results[i].stamp_s, 5 + 0.1 * i);
        const auto raw = NumberedDepth(i);
        for (std::size_t k = 0; k < raw.size(); ++k)
          ASSERT_FLOAT_EQ(results[i].frame->depth_m[k], raw[k] * 0.001f);
        const Image<Rgb8>& read = results[i].frame->color;
        if (encoder_.color_coding == "none") {
          EXPECT_TRUE(read.empty());
        } else if (encoder_.color_coding == ".jpg") {
          EXPECT_NEAR(read(16, 12).g, 20, 2);
        } else {
          EXPECT_EQ(read, NumberedColor(i));
        }
      }
    }
  }
}

TEST_F(SensTest, TakesCamerasAndPosesFromTheFile) {
  encoder_.color_extrinsics = TranslationMatrix(0.5f, 0, 0);
  const float inf = std::numeric_limits<float>::infinity();
  encoder_.poses = {TranslationMatrix(7, 8, 9), TranslationMatrix(-inf, 0, 0)};
  const SequenceInfo info = Open(encoder_.File(3))->info();
  EXPECT_EQ(info.format, "sens");
  EXPECT_EQ(info.camera.depth.fy, 30);
  EXPECT_EQ(info.camera.depth.cx, 15.5);
  EXPECT_EQ(info.camera.depth_units_per_metre, 1000);
  EXPECT_FALSE(info.camera.color_is_registered);
  EXPECT_EQ(info.camera.color.width, 64);
  EXPECT_EQ(info.camera.color.fx, 62);
  EXPECT_EQ(info.camera.color_from_depth.translation, Eigen::Vector3d(0.5, 0, 0));
  ASSERT_EQ(info.ground_truth.size(), 2u);  // the second frame has none
  EXPECT_EQ(info.ground_truth[0].world_from_camera.translation, Eigen::Vector3d(7, 8, 9));
  EXPECT_DOUBLE_EQ(info.ground_truth[1].stamp_s, 5.2);
}

TEST_F(SensTest, CountsTimeWhereThereAreNoStamps) {
  encoder_.has_stamps = false;
  options_.frames_per_second = 20;
  const auto results = ReadAll(Open(encoder_.File(3)).get());
  EXPECT_DOUBLE_EQ(results[2].stamp_s, 0.1);
}

TEST_F(SensTest, ReadsTheWholeFramesOfAFileThatEndsEarly) {
  const std::string file = encoder_.Header(5) + encoder_.Frame(0) + encoder_.Frame(1);
  const auto source = Open(file + encoder_.Frame(2).substr(0, 200));
  EXPECT_EQ(ReadAll(source.get()).size(), 2u);
  EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("claims 5 frames, but is damaged")));
}

TEST_F(SensTest, RefusesWhatItCannotRead) {
  const auto expect = [&](const std::string& bytes, const char* message) {
    ExpectInputError([&] { Open(bytes); },
                     ::testing::AllOf(HasSubstr("a.sens"), HasSubstr(message)));
  };
  const std::string file = encoder_.File(1);
  expect("", "is 0 bytes long");
  expect("\3" + file.substr(1), "has version 3, must be 4");
  expect(file.substr(0, 4) + LittleEndian(std::uint64_t{1} << 60) + file.substr(12),
         "the sensor's name has 1152921504606846976 bytes");
  expect(file.substr(0, 100), "ends before");
  expect(encoder_.Header(0), "lists no frames");
  const std::size_t depth_width_at = 4 + 8 + 6 + 4 * 64 + 2 * 4 + 2 * 4;
  std::string huge = file;
  huge.replace(depth_width_at, 4, LittleEndian(2000000000));
  expect(huge, "depth is 2000000000 x 24 pixels, must be from 1 x 1");
  huge.replace(depth_width_at, 4, LittleEndian(16000));
  expect(huge, "depth of frame 0 is damaged: its");
  encoder_.color_extrinsics[0] = 3;
  expect(encoder_.File(1), "extrinsics of colour: the matrix is not a rigid transform");
  encoder_.color_extrinsics[0] = 1;
  encoder_.depth_coding = 2;
  expect(encoder_.File(1), "compression of depth is 2 (occi), must be 0 (raw) or 1 (zlib)");
}

}  // namespace
}  // namespace surfit::testing
