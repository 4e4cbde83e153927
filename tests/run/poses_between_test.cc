#include <gmock/gmock.h>

#include "finishing/posed_sequence.h"
#include "run/results/evaluate_run.h"
#include "run/results/run_files.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

constexpr int kFrames = 9;
const PinholeCamera kCamera = {160, 120, 131.25, 131.25, 79.5, 59.5, {}};

// Depth images of a room. The frames 3 and 4 are lost. The trajectory has all other frames.
class PosesBetween : public ::testing::Test {
 protected:
  void SetUp() override {
    const Scene room = MakeScene("room", 1);
    path_ = MakePath(room, kFrames, 1);
    std::string list = "# depth\n";
    for (int i = 0; i < kFrames; ++i) {
      const RgbdFrame frame = RenderFrame(room, kCamera, path_[i].world_from_camera, i);
      Image<std::uint16_t> raw(kCamera.width, kCamera.height);
      for (std::size_t p = 0; p < raw.size(); ++p) {
        raw[p] = static_cast<std::uint16_t>(5000 * frame.depth_m[p] + 0.5);
      }
      const std::string name = Format("depth/%03d.png", i);
      WriteDepth(folder_ / name, raw);
      list += std::to_string(path_[i].stamp_s) + " " + name + "\n";
      if (i == 3 || i == 4) continue;
      trajectory_.push_back(path_[i]);
      frames_.push_back(i);
    }
    folder_.Write("depth.txt", list);
    folder_.Write("camera.yaml",
                  "%YAML:1.0\n---\ndepth_camera: { width: 160, height: 120, fx: 131.25, "
                  "fy: 131.25, cx: 79.5, cy: 59.5 }\ndepth_units_per_metre: 5000.\n");
  }

  std::vector<PoseBetween> Found() {
    const SequenceOptions sequence = Options(folder_);
    return FindPosesBetween({sequence, slam_, trajectory_, frames_, left_out_, moving_, {}}, {2},
                            false);
  }

  TempFolder folder_;
  SlamOptions slam_;
  Trajectory path_, trajectory_;
  std::vector<int> frames_;
  std::set<int> left_out_;
  std::map<int, Image<std::uint8_t>> moving_;
};

TEST_F(PosesBetween, AreThoseOfLostFrames) {
  const std::vector<PoseBetween> found = Found();
  ASSERT_EQ(found.size(), 2u);
  for (const PoseBetween& pose : found) {
    EXPECT_THAT(pose.world_from_camera,
                RigidNear(path_[pose.frame].world_from_camera, 0.004, 0.002));
    EXPECT_EQ(pose.before, 2u);
  }
  EXPECT_EQ(found[0].frame, 3);
  EXPECT_EQ(found[1].frame, 4);
}

TEST_F(PosesBetween, AreNotFoundIfBothSidesDisagree) {
  for (std::size_t p = 3; p < trajectory_.size(); ++p) {
    trajectory_[p].world_from_camera.translation.x() += 0.04;
  }
  EXPECT_TRUE(Found().empty());
}

TEST_F(PosesBetween, AreNotFoundWithoutDepth) {
  WriteDepth(folder_ / "depth/003.png", Image<std::uint16_t>(kCamera.width, kCamera.height, 0));
  const std::vector<PoseBetween> found = Found();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].frame, 4);
}

TEST(FrameTable, MarksLostFramesWhosePoseWasFound) {
  const TempFolder folder;
  FrameTable table(folder.path());
  for (int i = 0; i < 4; ++i) {
    FrameReport report;
    report.index = i;
    report.state = i == 0 ? FrameState::kTracked : FrameState::kLost;
    table.Add(report, 0, 0);
  }
  table.MarkFound({2});
  const std::string rows = ReadBytes(folder / "frames.csv");
  EXPECT_THAT(rows, ::testing::HasSubstr("\n0,0.000000,tracked,"));
  EXPECT_THAT(rows, ::testing::HasSubstr("\n1,0.000000,lost,"));
  EXPECT_THAT(rows, ::testing::HasSubstr("\n2,0.000000,between,"));
  EXPECT_THAT(rows, ::testing::HasSubstr("\n3,0.000000,lost,"));
}

// The inertial sensor places the lost frames that registration has not found.
TEST(AddBridgedFrames, AddsFramesWithoutRegistration) {
  const TempFolder folder;
  RunTrajectory trajectory(folder.path(), false);
  for (const int index : {0, 3}) {
    FrameReport report;
    report.index = index;
    report.state = FrameState::kTracked;
    report.world_from_camera.translation = {1. * index, 0, 0};
    trajectory.Add(report);
  }
  const Rigid3d step(Eigen::Quaterniond::Identity(), {0.5, 0, 0});
  std::vector<PoseBetween> found = {{2, 0.2, Rigid3d(), 0}};
  AddBridgedFrames({{1, 0.1, 0, step}, {2, 0.2, 0, step}, {4, 0.4, 3, step}, {6, 0.6, 5, step}},
                   trajectory, &found);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].frame, 1);
  EXPECT_EQ(found[0].world_from_camera.translation.x(), 0.5);
  EXPECT_EQ(found[1].world_from_camera.translation.x(), 0) << "the registered pose stays";
  EXPECT_EQ(found[2].frame, 4);
  EXPECT_EQ(found[2].world_from_camera.translation.x(), 3.5);
}

}  // namespace
}  // namespace surfit::testing
