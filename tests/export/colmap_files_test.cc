#include "apps/export/colmap_files.h"

#include <gmock/gmock.h>

#include <cstring>
#include <sstream>

#include "testing/matchers.h"
#include "testing/random_pose.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

template <typename T>
T Take(const std::string& bytes, std::size_t* at) {
  T value;
  std::memcpy(&value, bytes.data() + *at, sizeof(T));
  *at += sizeof(T);
  return value;
}

// One point in two images. The camera of COLMAP has its pixel centres at 0.5.
TEST(ColmapFiles, PosesAndPointsProjectToTheStoredPixels) {
  const TempFolder folder;
  const PinholeCamera lens = {640, 480, 500, 510, 320, 240, {0.1, -0.2, 0.001, 0.002, 0.3}};
  std::vector<PosedImage> images(2);
  images[0].source.index = 3;
  images[1].source.index = 12;
  images[1].world_from_color = Rigid3d(QuaternionExp<double>({0.1, 0.2, -0.1}), {0.3, 0.1, 0});
  const Rigid3d export_from_world(QuaternionExp<double>({1, 2, 0.5}), {1, -2, 3});
  SparsePoints points;
  points.points.resize(1);
  points.points[0].position_in_world = {0.25f, -0.5f, 2};
  points.points[0].color = {1, 2, 3};
  points.views = {{{0, {10, 20}}}, {{0, {30, 40}}}};
  WriteColmapModel({lens, images, points, export_from_world}, folder.path(), folder.path());

  const std::string cameras = ReadBytes(folder / "cameras.bin");
  std::size_t at = 0;
  EXPECT_EQ(Take<std::uint64_t>(cameras, &at), 1u);
  EXPECT_EQ(Take<std::uint32_t>(cameras, &at), 1u);
  EXPECT_EQ(Take<std::int32_t>(cameras, &at), 6);  // FULL_OPENCV
  EXPECT_EQ(Take<std::uint64_t>(cameras, &at), 640u);
  EXPECT_EQ(Take<std::uint64_t>(cameras, &at), 480u);
  for (const double value : {500., 510., 320.5, 240.5, 0.1, -0.2, 0.001, 0.002, 0.3, 0., 0., 0.}) {
    EXPECT_EQ(Take<double>(cameras, &at), value);
  }
  EXPECT_EQ(at, cameras.size());
  EXPECT_THAT(ReadBytes(folder / "cameras.txt"), HasSubstr("1 FULL_OPENCV 640 480 500 510 320.5"));

  const std::string bytes = ReadBytes(folder / "images.bin");
  at = 0;
  EXPECT_EQ(Take<std::uint64_t>(bytes, &at), 2u);
  for (std::uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(Take<std::uint32_t>(bytes, &at), i + 1);
    double q[4], t[3];
    for (double& number : q) number = Take<double>(bytes, &at);
    for (double& number : t) number = Take<double>(bytes, &at);
    const Rigid3d image_from_export(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]});
    EXPECT_THAT(image_from_export * export_from_world,
                RigidNear(images[i].world_from_color.Inverse(), 1e-12, 1e-12));
    EXPECT_EQ(Take<std::uint32_t>(bytes, &at), 1u);
    EXPECT_EQ(std::string(bytes.c_str() + at), i == 0 ? "000003.png" : "000012.png");
    at += 11;
    EXPECT_EQ(Take<std::uint64_t>(bytes, &at), 1u);
    EXPECT_EQ(Take<double>(bytes, &at), (i == 0 ? 10.5 : 30.5));
    EXPECT_EQ(Take<double>(bytes, &at), (i == 0 ? 20.5 : 40.5));
    EXPECT_EQ(Take<std::uint64_t>(bytes, &at), 1u);
  }
  EXPECT_EQ(at, bytes.size());

  std::istringstream text(ReadBytes(folder / "points3D.txt"));
  std::string header;
  std::getline(text, header);
  std::int64_t id;
  Eigen::Vector3d position;
  int r, g, b, error, image, place, other_image, other_place;
  text >> id >> position.x() >> position.y() >> position.z() >> r >> g >> b >> error >> image >>
      place >> other_image >> other_place;
  EXPECT_TRUE(text);
  EXPECT_EQ(id, 1);
  EXPECT_THAT(position, VectorNear(export_from_world * Eigen::Vector3d(0.25, -0.5, 2), 1e-12));
  EXPECT_THAT((std::vector<int>{r, g, b, error, image, place, other_image, other_place}),
              ElementsAre(1, 2, 3, -1, 1, 0, 2, 0));
}

TEST(ColmapFiles, CameraModelFollowsFromTheDistortion) {
  const TempFolder folder;
  const auto model_of = [&](const std::array<double, 5>& distortion) {
    const PinholeCamera lens = {64, 48, 50, 51, 32, 24, distortion};
    WriteColmapModel({lens, {}, {}, {}}, folder.path(), folder.path());
    return ReadBytes(folder / "cameras.txt");
  };
  EXPECT_THAT(model_of({}), HasSubstr(" PINHOLE "));
  EXPECT_THAT(model_of({0.1, 0, 0, 0, 0}), HasSubstr(" OPENCV "));
  EXPECT_THAT(model_of({0, 0, 0, 0, 0.1}), HasSubstr(" FULL_OPENCV "));
}

}  // namespace
}  // namespace surfit::testing
