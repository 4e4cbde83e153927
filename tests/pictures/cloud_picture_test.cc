#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "pictures/picture_file.h"
#include "surfit/pictures/pictures.h"
#include "testing/expect_input_error.h"
#include "testing/temp_folder.h"

namespace surfit {
namespace {

using testing::CountPixels;
using testing::ReadPicture;
using Cloud = std::vector<Eigen::Vector3f>;

constexpr Rgb8 kSourceColor = {240, 120, 0}, kTargetColor = {20, 90, 210};

// 2 m x 1.5 m, facing the camera, 5 mm between points.
Cloud Wall(float z, float left) {
  Cloud cloud;
  for (int i = 0; i < 400; ++i) {
    for (int j = 0; j < 300; ++j) {
      cloud.emplace_back(left + 0.005f * i, 0.005f * j - 0.75f, z);
    }
  }
  return cloud;
}

TEST(WriteTwoCloudPicture, TheNearerCloudHidesTheFarther) {
  const testing::TempFolder folder;
  WriteTwoCloudPicture(Wall(2, -1), Wall(2.2f, -1), folder / "p.png");
  const Image<Rgb8> picture = ReadPicture(folder / "p.png");
  EXPECT_EQ(picture.width(), 1608);
  EXPECT_EQ(picture.height(), 76 + 600 + 34);
  EXPECT_EQ(picture(400, 376), kSourceColor);
  WriteTwoCloudPicture(Wall(2.2f, -1), Wall(2, -1), folder / "p.png");
  EXPECT_EQ(ReadPicture(folder / "p.png")(400, 376), kTargetColor);
}

TEST(WriteTwoCloudPicture, IsNotMirrored) {
  const testing::TempFolder folder;
  WriteTwoCloudPicture(Wall(2, -2), Wall(2, 0.05f), folder / "p.png");  // source left, target right
  const Image<Rgb8> picture = ReadPicture(folder / "p.png");
  EXPECT_EQ(picture(200, 376), kSourceColor);
  EXPECT_EQ(picture(600, 376), kTargetColor);
}

TEST(WriteTwoCloudPicture, CloudsThatCoincideMingle) {
  const testing::TempFolder folder;
  Cloud source = Wall(2, -1), target = source;
  for (std::size_t i = 0; i < source.size(); ++i) (i % 2 ? source : target)[i].z() += 1e-4f;
  WriteTwoCloudPicture(source, target, folder / "p.png");
  const Image<Rgb8> picture = ReadPicture(folder / "p.png");
  int blue = 0, orange = 0;
  for (int v = 326; v < 426; ++v) {
    for (int u = 350; u < 450; ++u) ++(picture(u, v).b > picture(u, v).r ? blue : orange);
  }
  EXPECT_GT(blue, 1000);  // of 10000, half and half but for mixed pixels
  EXPECT_GT(orange, 1000);
}

TEST(WriteTwoCloudPicture, TakesEmptyClouds) {
  const testing::TempFolder folder;
  EXPECT_NO_THROW(WriteTwoCloudPicture({}, {}, folder / "p.png"));
  EXPECT_NO_THROW(WriteTwoCloudPicture(Wall(2, -1), {}, folder / "p.png"));
}

TEST(WriteTwoCloudPicture, NamesTheFileItCannotWrite) {
  testing::ExpectInputError([] { WriteTwoCloudPicture({}, {}, "/nonexistent/p.png"); },
                            ::testing::HasSubstr("/nonexistent/p.png"));
}

}  // namespace
}  // namespace surfit
