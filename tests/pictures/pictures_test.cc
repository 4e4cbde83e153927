#include "output/pictures/pictures.h"

#include <gmock/gmock.h>

#include "pictures/picture_file.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/temp_folder.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 1608, kHeight = 1344;
constexpr Rgb8 kGreen = {10, 200, 30};
const char* const kNames[] = {"color", "normals", "confidence", "last_seen"};

// A uniform wall at 2 m that faces the first camera.
SurfelMap Wall() {
  SurfelMap map;
  Surfel surfel;
  surfel.normal_in_world = {0, 0, -1};
  surfel.color = kGreen;
  surfel.radius_m = 0.1f;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      surfel.position_in_world = {0.1f * i, 0.1f * j, 2};
      surfel.confidence = 5.f + i * 0.1f;
      surfel.last_seen = j + 20;
      map.Append(surfel);
    }
  }
  return map;
}

TEST(WriteMapPictures, WritesFourSheetsThatShowTheMap) {
  const TempFolder folder;
  WriteMapPictures(Wall(), Trajectory(3), folder.path());
  for (const char* name : kNames) {
    const Image<Rgb8> picture = ReadPicture(folder / ("map_" + std::string(name) + ".png"));
    EXPECT_EQ(picture.width(), kWidth);
    EXPECT_EQ(picture.height(), kHeight);
    EXPECT_GT(CountColors(picture), 10u) << name;
  }
  const Image<Rgb8> color = ReadPicture(folder / "map_color.png");
  const Image<Rgb8> normals = ReadPicture(folder / "map_normals.png");
  // The third cell begins at (0, 76 + 634). Its camera is 0.4 m (20 % of 2 m) behind the first
  // camera. With a focal length of 0.75 * 800 pixels, +-2 m of wall at 2.4 m are +-500 pixels: the
  // cell is covered.
  for (const int u : {2, 400, 797}) {
    for (const int v : {712, 1000, 1307}) {
      EXPECT_EQ(color(u, v), kGreen);
      EXPECT_EQ(normals(u, v), (Rgb8{128, 128, 0}));
    }
  }
}

// A plate without background: white, black, and a typical grey of walls.
TEST(WriteMapPictures, ShowsWhiteBlackAndGreySurfaces) {
  for (const int grey : {255, 0, 160}) {
    const auto value = static_cast<std::uint8_t>(grey);
    SurfelMap map;
    Surfel surfel;
    surfel.color = {value, value, value};
    surfel.normal_in_world = {0, 0, -1};
    surfel.radius_m = 0.02f;
    surfel.confidence = 20;
    for (int i = -10; i <= 10; ++i) {
      for (int j = -10; j <= 10; ++j) {
        surfel.position_in_world = {0.02f * i, 0.02f * j, 2};
        map.Append(surfel);
      }
    }
    const TempFolder folder;
    WriteMapPictures(map, Trajectory(1), folder.path());
    const Image<Rgb8> picture = ReadPicture(folder / "map_color.png");
    const Rgb8 thing = picture(400, 1000),
               around = picture(2, 712);  // in the cell of the first camera
    EXPECT_EQ(thing, surfel.color);
    const double difference =
        Eigen::Vector3d(thing.r - around.r, thing.g - around.g, thing.b - around.b).norm();
    EXPECT_GT(difference, 60) << grey;  // black and white differ by 441
  }
}

// A grey disc faces the camera. A second disc is turned by 60 degrees.
TEST(WriteMapPictures, ShadesMapsWithoutColour) {
  SurfelMap map;
  Surfel surfel;
  surfel.color = {128, 128, 128};
  surfel.radius_m = 0.5f;
  surfel.confidence = 20;
  surfel.position_in_world = {0, 0, 2};
  surfel.normal_in_world = {0, 0, -1};
  map.Append(surfel);
  surfel.position_in_world = {1, 0, 2};
  surfel.normal_in_world = {-std::sqrt(0.75f), 0, -0.5f};
  map.Append(surfel);
  const TempFolder folder;
  WriteMapPictures(map, Trajectory(1), folder.path());
  const Image<Rgb8> picture = ReadPicture(folder / "map_color.png");
  const Rgb8 facing = picture(400, 1010), turned = picture(640, 1010);
  EXPECT_GT(facing.r, 220);
  EXPECT_LT(turned.r, facing.r - 20);
  EXPECT_EQ(turned.r, turned.b);
}

TEST(WriteMapPictures, HidesUnstableSurfelsExceptInTheConfidencePicture) {
  SurfelMap map = Wall();
  Surfel dust;
  dust.position_in_world = {0, 0, 1};
  dust.normal_in_world = {0, 0, -1};
  dust.color = {255, 0, 0};
  dust.radius_m = 0.05f;
  dust.confidence = 0.1f;
  map.Append(dust);
  const TempFolder folder;
  WriteMapPictures(map, Trajectory(1), folder.path());
  EXPECT_EQ(CountPixels(ReadPicture(folder / "map_color.png"), dust.color), 0u);
  // The centre of the third cell shows unstable surfels in the lowest colour of the scale.
  const Rgb8 middle = ReadPicture(folder / "map_confidence.png")(400, 76 + 634 + 300);
  EXPECT_NEAR(middle.r, 68, 1);
  EXPECT_NEAR(middle.b, 84, 1);
}

// The top view of a table must not show the floor below, at any distance.
TEST(WriteMapPictures, HidesOccludedSurfaces) {
  SurfelMap map;
  Surfel surfel;
  surfel.normal_in_world = {0, -1, 0};
  surfel.confidence = 20;
  for (const auto& [height, color] : {std::pair(0.f, kGreen), {0.7f, Rgb8{200, 10, 10}}}) {
    for (int i = -40; i <= 40; ++i) {
      for (int j = -40; j <= 40; ++j) {
        surfel.position_in_world = {0.025f * i, height, 0.025f * j};
        surfel.radius_m = 0.02f;
        surfel.color = color;
        map.Append(surfel);
      }
    }
  }
  Rigid3d camera;
  camera.translation = {0, -1, -3};
  const TempFolder folder;
  WriteMapPictures(map, {{0, camera}}, folder.path());
  const Image<Rgb8> picture = ReadPicture(folder / "map_color.png");
  int green = 0, red = 0;
  for (const auto [u, v] : PixelsOf(kWidth / 2, kHeight / 2)) {
    green += picture(u, v) == kGreen;
    red += picture(u, v).r > picture(u, v).g + 10;
  }
  EXPECT_GT(green, 10000);
  EXPECT_EQ(red, 0);
}

void SetConfidence(float confidence, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    map->block(id / SurfelBlock::kCapacity).SetConfidence(id % SurfelBlock::kCapacity, confidence);
  }
}

TEST(NoiseConfidence, IsThreeOrATenthOfTheMaximum) {
  SurfelMap map;
  EXPECT_EQ(NoiseConfidence(map), 0);
  map = Wall();
  SetConfidence(2, &map);
  EXPECT_FLOAT_EQ(NoiseConfidence(map), 0.2f);
  SetConfidence(100, &map);
  EXPECT_FLOAT_EQ(NoiseConfidence(map), 3);
}

TEST(WriteMapPictures, IsTheSameAtAnyNumberOfThreads) {
  const TempFolder folder;
  const auto bytes = AtThreads({1, 3}, [&] {
    WriteMapPictures(Wall(), Trajectory(2), folder.path());
    std::string all;
    for (const char* name : kNames) {
      all += ReadBytes(folder / ("map_" + std::string(name) + ".png"));
    }
    return all;
  });
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(WriteMapPictures, LabelsAnEmptyMap) {
  const TempFolder folder;
  WriteMapPictures(SurfelMap(), {}, folder.path());
  for (const char* name : kNames) {
    const Image<Rgb8> picture = ReadPicture(folder / ("map_" + std::string(name) + ".png"));
    EXPECT_EQ(picture.width(), kWidth);
    EXPECT_GT(CountColors(picture), 2u);  // text with antialiasing
    EXPECT_GT(CountPixels(picture, {255, 255, 255}), picture.size() * 9 / 10);
  }
}

TEST(WriteMapPictures, AcceptsAnEmptyTrajectoryAndADegenerateMap) {
  const TempFolder folder;
  SurfelMap map;
  map.Append(Surfel());  // at the origin, without normal, radius and confidence
  EXPECT_NO_THROW(WriteMapPictures(map, {}, folder.path()));
}

TEST(WriteMapPictures, RejectsUnwritableFile) {
  ExpectInputError([] { WriteMapPictures(Wall(), {}, "/nonexistent/out"); },
                   ContainsRegex("/nonexistent/out/map_"));
}

using Cloud = std::vector<Eigen::Vector3f>;

constexpr Rgb8 kSourceColor = {240, 120, 0}, kTargetColor = {20, 90, 210};

// A wall of 2 m x 1.5 m that faces the camera, with a point spacing of 5 mm.
Cloud Wall(float z, float left) {
  Cloud cloud;
  for (int i = 0; i < 400; ++i) {
    for (int j = 0; j < 300; ++j) {
      cloud.emplace_back(left + 0.005f * i, 0.005f * j - 0.75f, z);
    }
  }
  return cloud;
}

TEST(WriteTwoCloudPicture, CloserCloudOccludesTheOther) {
  const TempFolder folder;
  WriteTwoCloudPicture(Wall(2, -1), Wall(2.2f, -1), folder / "p.png");
  const Image<Rgb8> picture = ReadPicture(folder / "p.png");
  EXPECT_EQ(picture.width(), 1608);
  EXPECT_EQ(picture.height(), 76 + 600 + 34);
  EXPECT_EQ(picture(400, 376), kSourceColor);
  WriteTwoCloudPicture(Wall(2.2f, -1), Wall(2, -1), folder / "p.png");
  EXPECT_EQ(ReadPicture(folder / "p.png")(400, 376), kTargetColor);
}

TEST(WriteTwoCloudPicture, IsNotMirrored) {
  const TempFolder folder;
  WriteTwoCloudPicture(Wall(2, -2), Wall(2, 0.05f), folder / "p.png");  // source left, target right
  const Image<Rgb8> picture = ReadPicture(folder / "p.png");
  EXPECT_EQ(picture(200, 376), kSourceColor);
  EXPECT_EQ(picture(600, 376), kTargetColor);
}

TEST(WriteTwoCloudPicture, CoincidingCloudsAreMixed) {
  const TempFolder folder;
  Cloud source = Wall(2, -1), target = source;
  for (std::size_t i = 0; i < source.size(); ++i) (i % 2 ? source : target)[i].z() += 1e-4f;
  WriteTwoCloudPicture(source, target, folder / "p.png");
  const Image<Rgb8> picture = ReadPicture(folder / "p.png");
  int blue = 0, orange = 0;
  for (const auto [u, v] : Pixels(350, 450, 326, 426))
    ++(picture(u, v).b > picture(u, v).r ? blue : orange);
  EXPECT_GT(blue, 1000);  // of 10,000 pixels, about half per cloud
  EXPECT_GT(orange, 1000);
}

TEST(WriteTwoCloudPicture, AcceptsEmptyClouds) {
  const TempFolder folder;
  EXPECT_NO_THROW(WriteTwoCloudPicture({}, {}, folder / "p.png"));
  EXPECT_NO_THROW(WriteTwoCloudPicture(Wall(2, -1), {}, folder / "p.png"));
}

TEST(WriteTwoCloudPicture, RejectsUnwritableFile) {
  ExpectInputError([] { WriteTwoCloudPicture({}, {}, "/nonexistent/p.png"); },
                   Names("/nonexistent/p.png"));
}

}  // namespace
}  // namespace surfit::testing
