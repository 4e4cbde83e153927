#include "io/files/places_file.h"

#include <gmock/gmock.h>

#include "surfit/core/error.h"
#include "testing/largest_allocation.h"
#include "testing/matchers.h"
#include "testing/mutations.h"
#include "testing/random_pose.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

RunPlaces SomePlaces() {
  std::mt19937_64 rng(5);
  RunPlaces places;
  for (int i = 0; i < 6; ++i) {
    PosedFrame frame;
    frame.index = 10 + 2 * i;
    frame.stamp_s = 0.1 * i;
    frame.world_from_camera = RandomPose(1, 1, &rng);
    frame.keyframe = i / 3;
    frame.segment = i / 5;
    places.frames.push_back(frame);
    if (i % 3 > 0) continue;
    Keyframe keyframe;
    keyframe.frame_index = frame.index;
    keyframe.stamp_s = frame.stamp_s;
    keyframe.world_from_camera = frame.world_from_camera;
    PlaceView& view = keyframe.view;
    view.camera.width = 8;
    view.camera.height = 6;
    view.camera.fx = view.camera.fy = 7;
    view.noise.inverse_depth_sigma = 0.003;
    view.field = {{0.1, 0.2, 0.3, 0.4, 0.5, 0.6}};
    view.depth = Image<std::uint16_t>(8, 6);
    view.intensity = Image<std::uint8_t>(8, 6);
    for (int k = 0; k < 48; ++k) {
      view.depth.data()[k] = static_cast<std::uint16_t>(1000 + k);
      view.intensity.data()[k] = static_cast<std::uint8_t>(k);
    }
    view.features = {{{1.f, 2.f, 3.f}, {7, 8}}};
    places.keyframes.push_back(keyframe);
  }
  PoseGraphEdge edge;
  edge.a = 0;
  edge.b = 1;
  edge.a_from_b = RandomPose(1, 1, &rng);
  edge.information = 2 * Matrix6d::Identity();
  edge.loop = true;
  places.edges = {edge};
  return places;
}

void ExpectSame(const Rigid3d& a, const Rigid3d& b) {
  EXPECT_EQ(a.translation, b.translation);
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
}

TEST(PlacesFile, RoundTripsBitwise) {
  const TempFolder folder;
  const RunPlaces written = SomePlaces();
  WritePlaces(written, folder / "places.bin");
  const RunPlaces read = ReadPlaces(folder / "places.bin");
  ASSERT_EQ(read.frames.size(), written.frames.size());
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    EXPECT_EQ(read.frames[i].index, written.frames[i].index);
    EXPECT_EQ(read.frames[i].stamp_s, written.frames[i].stamp_s);
    EXPECT_EQ(read.frames[i].keyframe, written.frames[i].keyframe);
    EXPECT_EQ(read.frames[i].segment, written.frames[i].segment);
    ExpectSame(read.frames[i].world_from_camera, written.frames[i].world_from_camera);
  }
  ASSERT_EQ(read.keyframes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const PlaceView &view = read.keyframes[i].view, &other = written.keyframes[i].view;
    EXPECT_EQ(read.keyframes[i].frame_index, written.keyframes[i].frame_index);
    ExpectSame(read.keyframes[i].world_from_camera, written.keyframes[i].world_from_camera);
    EXPECT_EQ(view.camera.fx, other.camera.fx);
    EXPECT_EQ(view.field.coefficients, other.field.coefficients);
    EXPECT_EQ(view.noise.inverse_depth_sigma, other.noise.inverse_depth_sigma);
    EXPECT_TRUE(std::equal(view.depth.data(), view.depth.data() + 48, other.depth.data()));
    EXPECT_TRUE(
        std::equal(view.intensity.data(), view.intensity.data() + 48, other.intensity.data()));
    ASSERT_EQ(view.features.size(), 1u);
    EXPECT_EQ(view.features[0].point, other.features[0].point);
    EXPECT_EQ(view.features[0].descriptor, other.features[0].descriptor);
  }
  ASSERT_EQ(read.edges.size(), 1u);
  EXPECT_EQ(read.edges[0].b, 1u);
  EXPECT_TRUE(read.edges[0].loop);
  EXPECT_EQ(read.edges[0].information, written.edges[0].information);
  ExpectSame(read.edges[0].a_from_b, written.edges[0].a_from_b);
}

TEST(PlacesFile, ReadsFeaturesWithoutImages) {
  const TempFolder folder;
  WritePlaces(SomePlaces(), folder / "places.bin");
  const RunPlaces read = ReadPlaces(folder / "places.bin", PlacesPart::kFeatures);
  EXPECT_TRUE(read.keyframes[0].view.depth.empty());
  EXPECT_EQ(read.keyframes[0].view.features.size(), 1u);
}

// Files of version 0.1 end after the edges.
TEST(PlacesFile, ReadsFilesWithoutDepthCorrections) {
  const TempFolder folder;
  const RunPlaces written = SomePlaces();
  WritePlaces(written, folder / "places.bin");
  const std::string bytes = ReadBytes(folder / "places.bin");
  const std::size_t fields = written.keyframes.size() * sizeof(InverseDepthField);
  folder.Write("old.bin", bytes.substr(0, bytes.size() - fields));
  const RunPlaces read = ReadPlaces(folder / "old.bin");
  ASSERT_EQ(read.keyframes.size(), written.keyframes.size());
  EXPECT_TRUE(read.keyframes[0].view.field.IsZero());
  EXPECT_EQ(read.edges.size(), written.edges.size());
}

TEST(PlacesFile, RejectsDamagedFiles) {
  const TempFolder folder;
  WritePlaces(SomePlaces(), folder / "places.bin");
  const std::string bytes = ReadBytes(folder / "places.bin");
  for (const std::string& damaged :
       {std::string(), bytes.substr(0, bytes.size() - 1), bytes + "x"}) {
    folder.Write("damaged.bin", damaged);
    EXPECT_THAT([&] { ReadPlaces(folder / "damaged.bin"); },
                ThrowsNaming<InputError>("damaged.bin"));
  }
  EXPECT_THROW(ReadPlaces(folder / "none.bin"), InputError);
}

TEST(PlacesFile, ReadsOrRejectsAnyBytesInBoundedMemory) {
  const TempFolder folder;
  WritePlaces(SomePlaces(), folder / "places.bin");
  const std::string bytes = ReadBytes(folder / "places.bin");
  Random random(7);
  int taken = 0;
  constexpr int kMutations = 2000;
  for (int i = 0; i < kMutations; ++i) {
    const std::string mutated = Mutated(bytes, &random);
    folder.Write("mutated.bin", mutated);
    ResetLargestAllocation();
    try {
      ReadPlaces(folder / "mutated.bin");
      ++taken;
    } catch (const InputError&) {
    }
    ASSERT_LE(LargestAllocation(), 1100 * mutated.size() + (1 << 20)) << i;
  }
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, kMutations);
}

}  // namespace
}  // namespace surfit::testing
