#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {

inline constexpr int kNumberedFrames = 8;

inline std::string Fixed(double value, int decimals) {
  char text[100];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

// Capture time of frame i of a 30 Hz camera, us after the first frame.
inline std::int64_t Micros(int i) { return (100000 * i + 1) / 3; }

// Writes the images of a frame under these names without ending.
inline void WriteFrame(const TempFolder& folder, int i, const std::string& depth,
                       const std::string& color) {
  WriteDepth(folder / ("depth/" + depth + ".png"), NumberedDepth(i));
  WriteColor(folder / ("color/" + color + ".png"), NumberedColor(i));
}

// Number of the images of a frame, which are those of NumberedDepth() and NumberedColor().
inline int ImageNumber(const ReadResult& result) {
  EXPECT_TRUE(result.frame) << result.error;
  if (!result.frame) return -1;
  const int number = static_cast<int>(std::lround((result.frame->depth_m(0, 0) - 1) * 100));
  if (!result.frame->color.empty()) {
    EXPECT_EQ(result.frame->color(3, 3).r, number);
  }
  return number;
}

inline std::vector<int> ImageNumbers(FrameSource* source) {
  std::vector<int> numbers;
  for (const ReadResult& result : ReadAll(source)) numbers.push_back(ImageNumber(result));
  return numbers;
}

inline std::vector<int> Counting(int count) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(i);
  return numbers;
}

class NumberedFolder : public ::testing::Test {
 protected:
  NumberedFolder() { folder_.Write("camera.yaml", SmallCameraYaml()); }
  std::unique_ptr<FrameSource> Open() { return OpenSequence(Options(folder_)); }
  // Expects that each frame has its own images, and the pose with its number as x coordinate.
  void ExpectOwnPoses(const std::vector<int>& numbers) {
    const auto source = Open();
    const Trajectory truth = source->info().ground_truth;
    const auto results = ReadAll(source.get());
    ASSERT_EQ(results.size(), numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_EQ(ImageNumber(results[i]), numbers[i]);
      const auto pose = InterpolatePose(truth, results[i].stamp_s, 0, 0);
      ASSERT_TRUE(pose) << i;
      EXPECT_EQ(pose->translation.x(), numbers[i]);
    }
  }
  TempFolder folder_;
};

using NamedFolder = NumberedFolder;
using PosesOfFolder = NumberedFolder;
using TimesOfNames = NumberedFolder;

}  // namespace surfit::testing
