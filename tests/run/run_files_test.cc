#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "io/images/image_files.h"
#include "output/output_files.h"
#include "output/recorded_run.h"
#include "run/posed_views.h"
#include "run/results/kept_views.h"
#include "run/results/result_files.h"
#include "surfit/core/error.h"
#include "surfit/geometry/sensor.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

SurfelMap OneSurfel() {
  SurfelMap map;
  Surfel surfel;
  surfel.position_in_world = {1, 2, 3};
  surfel.confidence = 4;
  map.Append(surfel);
  return map;
}

TEST(WriteCsv, LeavesCellsOfNanEmpty) {
  const TempFolder folder;
  const double inf = std::numeric_limits<double>::infinity();
  WriteCsv(Json::array({{{"a", std::nan("")}, {"b", 1.5}, {"c", nullptr}},
                        {{"a", inf}, {"b", -inf}, {"c", "x,y"}}}),
           folder / "table.csv");
  EXPECT_EQ(ReadBytes(folder / "table.csv"), "a,b,c\n,1.5,\ninf,-inf,\"x,y\"\n");
}

TEST(ReadRecordedRun, RejectsQuaternionsThatAreNoRotation) {
  const TempFolder folder;
  folder.Write("summary.json", "{}");
  const auto write = [&](const char* quaternion) {
    folder.Write("poses.json", Concat("{\"poses\": [[7, 0.5, 1, 2, 3, ", quaternion,
                                      "]], \"calibration\": null}"));
  };
  write("0, 0, 0, 1");
  EXPECT_EQ(ReadRecordedRun(folder.path()).trajectory.size(), 1u);
  write("0, 0, 0, 0");
  ExpectInputError([&] { ReadRecordedRun(folder.path()); }, Names("poses.json", 7, 0));
}

TEST(Digest, OfNoDataIsTheOffsetBasisOfFnv1a) {
  EXPECT_EQ(Digest({}, SurfelMap()), "cbf29ce484222325");
}

TEST(Digest, DependsOnTheLastBitOfEveryPart) {
  const Trajectory trajectory = {{1.0, Rigid3d()}};
  const std::string digest = Digest(trajectory, OneSurfel());
  EXPECT_EQ(Digest(trajectory, OneSurfel()), digest);

  Trajectory moved = trajectory;
  moved[0].world_from_camera.translation.z() = 5e-324;
  EXPECT_NE(Digest(moved, OneSurfel()), digest);
  Trajectory later = trajectory;
  later[0].stamp_s = std::nextafter(1.0, 2.0);
  EXPECT_NE(Digest(later, OneSurfel()), digest);

  using Block = SurfelBlock;
  const auto expect_in_digest = [&](auto... arrays) {
    for (const auto array : {arrays...}) {
      SurfelMap map = OneSurfel();
      ++(map.block(0).*array)[0];
      EXPECT_NE(Digest(trajectory, map), digest);
    }
  };
  expect_in_digest(&Block::nx, &Block::ny, &Block::nz);
  expect_in_digest(&Block::x, &Block::y, &Block::z);
  expect_in_digest(&Block::radius, &Block::confidence, &Block::red, &Block::green, &Block::blue);
  expect_in_digest(&Block::first_seen_low, &Block::last_seen_low);
  expect_in_digest(&Block::first_seen_high, &Block::last_seen_high);
}

const Rigid3d kPose(Eigen::Quaterniond(0.8, 0.6, 0, 0), {1, 2, 3});

TEST(ParsePose, ReadsTranslationAndNormalisedQuaternion) {
  EXPECT_THAT(ParsePose("x", "1,2,3,1.2,0,0,1.6"), RigidNear(kPose, 1e-15, 1e-15));
}

TEST(ParsePose, RejectsOtherTextByName) {
  for (const char* text : {"", "1,2,3", "1,2,3,0,0,0,0", "1,2,3,0,0,0,1,5", "1;2;3;0;0;0;1",
                           "a,2,3,0,0,0,1", "1,2,3,0,0,0,1x"}) {
    EXPECT_THAT([&] { ParsePose("initial_pose", text); },
                ThrowsNaming<InputError>("initial_pose", Concat("'", text, "'")));
  }
}

TEST(InitialPose, IsIdentityGroundTruthOrNumbers) {
  SequenceInfo info;
  info.ground_truth = {{10.0, kPose}};
  EXPECT_THAT(InitialPose("identity", info, 10), RigidNear(Rigid3d(), 0, 0));
  EXPECT_THAT(InitialPose("groundtruth", info, 10.01), RigidNear(kPose, 0, 0));
  EXPECT_THROW(InitialPose("groundtruth", info, 10.1), InputError);
  EXPECT_THAT(InitialPose("1,2,3,.6,0,0,.8", info, 10), RigidNear(kPose, 1e-15, 1e-15));
}

TEST(InitialPose, ReadsNumbersInTheConventionOfTheSource) {
  SequenceInfo info;
  info.mirrored = true;
  info.ground_truth = {{10.0, kPose}};  // in the convention of Surfit
  EXPECT_THAT(InitialPose("1,2,3,.6,0,0,.8", info, 10), RigidNear(Mirrored(kPose), 1e-15, 1e-15));
  EXPECT_THAT(InitialPose("groundtruth", info, 10), RigidNear(kPose, 0, 0));
}

constexpr int kWidth = 32, kHeight = 24;

PinholeCamera Camera() { return {kWidth, kHeight, 30, 30, 15.5, 11.5, {}}; }

RgbdFrame Frame(int index, bool with_color) {
  RgbdFrame frame;
  frame.index = index;
  frame.depth_m = Image<float>(kWidth, kHeight, 1.f);
  if (with_color) frame.color = Image<Rgb8>(kWidth, kHeight, {200, 100, 50});
  return frame;
}

// A map of one surfel, 1 m in front of the camera. It covers the image centre.
SurfelMap Map() {
  SurfelMap map;
  Surfel surfel;
  surfel.position_in_world = {0, 0, 1};
  surfel.normal_in_world = {0, 0, -1};
  surfel.color = {20, 40, 200};
  surfel.radius_m = 0.05f;
  surfel.confidence = 20;
  map.Append(surfel);
  return map;
}

FrameReport Report(FrameState state, double rmse_m = 0) {
  FrameReport report;
  report.state = state;
  report.icp.rmse_m = rmse_m;
  return report;
}

std::vector<int> KeptOf(int frames) {
  KeptViews views;
  const SurfelMap map = Map();
  for (int i = 0; i < frames; ++i) {
    views.Offer(Frame(i, false), Report(FrameState::kGiven), map, {Camera(), {}});
  }
  std::vector<int> kept;
  for (const KeptView& view : views.Finish(map, {Camera(), {}})) kept.push_back(view.index);
  return kept;
}

TEST(KeptViews, AreEvenlySpacedForAnyLength) {
  EXPECT_THAT(KeptOf(0), ElementsAre());
  EXPECT_THAT(KeptOf(3), ElementsAre(0, 1, 2));
  EXPECT_THAT(KeptOf(10), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(KeptOf(11), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(KeptOf(100), ElementsAre(0, 16, 32, 48, 64, 80, 96, 99));  // with the last frame
}

TEST(KeptViews, ShowTheInputAndTheMapFromItsPose) {
  KeptViews views;
  views.Offer(Frame(7, true), Report(FrameState::kFirst), Map(), {Camera(), {}});
  const std::vector<KeptView> kept = views.Finish(Map(), {Camera(), {}});
  ASSERT_EQ(kept.size(), 1u);
  const KeptView& view = kept[0];
  EXPECT_EQ(view.index, 7);
  ASSERT_EQ(view.pictures.size(), 4u);
  const auto middle = [&](int picture) {
    const Image<Rgb8> image = DecodeJpeg(view.pictures[picture].jpeg, "view");
    EXPECT_EQ(image.width(), kWidth);
    return image(kWidth / 2, kHeight / 2);
  };
  // The frame is orange and the surfel is blue. The difference is much larger than JPEG errors.
  EXPECT_GT(middle(0).r, middle(0).b + 100);
  EXPECT_GT(middle(1).b, middle(1).r + 100);
  EXPECT_NEAR(middle(2).g, middle(3).g, 30);  // equal depth has equal colours
  // Pixels without surfel are grey in the model view, but not in the input.
  EXPECT_NE(DecodeJpeg(view.pictures[2].jpeg, "view")(0, 0),
            DecodeJpeg(view.pictures[3].jpeg, "view")(0, 0));
}

TEST(KeptViews, IncludeTheFirstDegenerateAndLostFrames) {
  KeptViews views;
  const SurfelMap map = Map();
  const auto offer = [&](int index, FrameState state, double rmse_m) {
    views.Offer(Frame(index, false), Report(state, rmse_m), map, {Camera(), {}});
  };
  for (int i = 0; i < 200; ++i) {
    const FrameState state = i == 0               ? FrameState::kFirst
                             : i == 3 || i == 90  ? FrameState::kDegenerate
                             : i == 51 || i == 53 ? FrameState::kLost
                                                  : FrameState::kTracked;
    offer(i, state, i == 71 ? 0.02 : 0.01);
  }
  std::vector<int> kept;
  for (const KeptView& view : views.Finish(map, {Camera(), {}})) {
    if (view.why != "evenly spread") kept.push_back(view.index);
  }
  // The first degenerate frame, the first lost frame, the largest RMSE, and the last frame.
  EXPECT_THAT(kept, ElementsAre(3, 51, 71, 199));
}

TEST(Thumbnails, AreEvenlySpaced) {
  Thumbnails thumbnails;
  for (int i = 0; i < 250; ++i) thumbnails.Offer(Frame(i, false));
  const std::vector<KeptView> kept = thumbnails.Finish(Map(), {Camera(), {}}, {});
  ASSERT_EQ(kept.size(), 63u);  // every fourth of 250 frames
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i].index, 4 * static_cast<int>(i));
}

TEST(Thumbnails, ShowTheFinalMapForFramesWithAPose) {
  Thumbnails thumbnails;
  thumbnails.Offer(Frame(3, true));
  thumbnails.Offer(Frame(4, true));
  const auto kept = thumbnails.Finish(Map(), {Camera(), {}}, {{4, Rigid3d()}});
  ASSERT_EQ(kept.size(), 2u);
  ASSERT_EQ(kept[0].pictures.size(), 1u);
  EXPECT_EQ(kept[0].pictures[0].name, "input_color");
  ASSERT_EQ(kept[1].pictures.size(), 2u);
  const Image<Rgb8> model = DecodeJpeg(kept[1].pictures[1].jpeg, "model");
  // The surfel is blue. The difference is much larger than JPEG errors.
  EXPECT_GT(model(kWidth / 2, kHeight / 2).b, model(kWidth / 2, kHeight / 2).r + 100);
}

TEST(Thumbnails, AreSmall) {
  Thumbnails thumbnails;
  RgbdFrame frame;
  frame.depth_m = Image<float>(641, 480, 1.f);
  frame.color = Image<Rgb8>(641, 480, {200, 100, 50});
  thumbnails.Offer(frame);
  const PinholeCamera camera = {641, 480, 500, 500, 320, 239.5, {}};
  const auto kept = thumbnails.Finish(Map(), {camera, {}}, {{0, Rigid3d()}});
  ASSERT_EQ(kept.size(), 1u);
  for (const auto& picture : kept[0].pictures) {
    const Image<Rgb8> image = DecodeJpeg(picture.jpeg, picture.name);
    EXPECT_EQ(image.width(), 321) << picture.name;
    EXPECT_EQ(image.height(), 240) << picture.name;
  }
}

TEST(Thumbnails, WriteOnlyRemovableFiles) {
  const TempFolder folder;
  Thumbnails thumbnails;
  std::map<int, Rigid3d> poses;
  for (int i = 0; i < Thumbnails::kMost; ++i) {
    thumbnails.Offer(Frame(i, i % 2 == 0));
    poses[i] = Rigid3d();
  }
  Thumbnails::Write(thumbnails.Finish(Map(), {Camera(), {}}, poses), folder.path());
  int removed = 0;
  for (const std::string& name : Thumbnails::FileNames()) {
    removed += std::filesystem::remove(folder.path() + "/" + name);
  }
  EXPECT_EQ(removed, 2 * Thumbnails::kMost);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() + "/thumbnails"));
}

// The maximum number of views: a separate frame for each reason.
TEST(KeptViews, WriteOnlyRemovableFiles) {
  const TempFolder folder;
  KeptViews views;
  const SurfelMap map = Map();
  const auto offer = [&](int index, const FrameReport& report) {
    views.Offer(Frame(index, true), report, map, {Camera(), {}});
  };
  for (int i = 0; i < 19; ++i) {  // even frames are kept as well
    const FrameState state = i == 3 ? FrameState::kDegenerate : FrameState::kTracked;
    offer(i, Report(state, i == 1 ? 0.02 : 0.01));
  }
  offer(19, Report(FrameState::kLost));
  offer(20, Report(FrameState::kGiven));
  const std::vector<KeptView> kept = views.Finish(map, {Camera(), {}});
  EXPECT_EQ(kept.size(), KeptViews::kMost);
  KeptViews::Write(kept, folder.path());
  for (const std::string& name : KeptViews::FileNames()) {
    EXPECT_TRUE(std::filesystem::remove(folder.path() + "/" + name)) << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() + "/views"));
}

}  // namespace
}  // namespace surfit::testing
