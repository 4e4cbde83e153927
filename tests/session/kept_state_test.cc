// Continuation of SLAM from a stored state.
#include <gmock/gmock.h>

#include "mapping/same_map.h"
#include "session/some_session.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

constexpr int kFirst = 60, kAll = 120;

class KeptState : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    room_ = new SimulatedSequence(SimulateRoom(1, kAll, Sensor::kKinect));
    KeepSession(*room_, kFirst, folder_->path());
  }
  static void TearDownTestSuite() {
    delete folder_;
    delete room_;
  }

  static Slam GoOn(StateUse use, const SlamOptions& options = SessionSlamOptions()) {
    return {{room_->camera, {}}, options, ReadSession(folder_->path()).state, use};
  }
  // Processes frames `begin` to `end` - 1 of the room as the next frames of the session.
  static std::vector<FrameReport> Process(Slam* slam, int begin, int end, double later_s = 0) {
    std::vector<FrameReport> reports;
    for (int i = begin; i < end; ++i) {
      RgbdFrame frame = room_->frames[i];
      frame.index = kFirst + i - begin;
      frame.stamp_s += later_s;
      reports.push_back(slam->Process(frame));
    }
    return reports;
  }
  // Expects correct poses up to two pixels at 2 m, the accuracy of the map.
  static void ExpectRight(const std::vector<PosedFrame>& frames, int begin) {
    for (const PosedFrame& frame : frames) {
      if (frame.index < kFirst) continue;
      const Rigid3d& truth = room_->world_from_camera[begin + frame.index - kFirst];
      EXPECT_LT((frame.world_from_camera.translation - truth.translation).norm(), 0.03)
          << frame.index;
    }
  }

  static TempFolder* folder_;
  static SimulatedSequence* room_;
};

TempFolder* KeptState::folder_ = nullptr;
SimulatedSequence* KeptState::room_ = nullptr;

TEST_F(KeptState, ContinuesAtTheLastFrame) {
  Slam slam = GoOn(StateUse::kContinue);
  const auto reports = Process(&slam, kFirst, kAll);
  slam.Finish();
  EXPECT_EQ(reports[0].state, FrameState::kLost);  // before confirmation by the next frame
  ASSERT_TRUE(reports[1].confirmed);
  const Backend& backend = *slam.backend();
  EXPECT_EQ(backend.poses().frames().size(), static_cast<std::size_t>(kAll));
  ExpectRight(backend.poses().frames(), kFirst);
  EXPECT_EQ(backend.counts().submaps, 1u);
}

TEST_F(KeptState, RelocalisesADistantCamera) {
  Slam slam = GoOn(StateUse::kContinue);
  const auto reports = Process(&slam, 20, 50, 1000);
  slam.Finish();
  EXPECT_EQ(slam.backend()->counts().relocalisations, 1u);
  EXPECT_GE(slam.backend()->poses().frames().size(), kFirst + 25u);
  ExpectRight(slam.backend()->poses().frames(), 20);
}

TEST_F(KeptState, IsDeterministic) {
  const auto run = [&] {
    Slam slam = GoOn(StateUse::kContinue);
    Process(&slam, kFirst, kFirst + 20);
    slam.Finish();
    return std::make_pair(slam.map(), slam.backend()->poses().frames());
  };
  const auto a = run(), b = run();
  ExpectSameMap(a.first, b.first);
  ExpectSamePoses(a.second, b.second);
}

TEST_F(KeptState, IsNotChangedByLocalisation) {
  Slam slam = GoOn(StateUse::kLocalize);
  const Slam before = GoOn(StateUse::kLocalize);
  const auto reports = Process(&slam, 10, 60, 1000);
  slam.Finish();
  ExpectSameMap(slam.map(), before.map());
  EXPECT_EQ(slam.backend()->poses().frames().size(), static_cast<std::size_t>(kFirst));
  int held = 0;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    if (reports[i].state == FrameState::kLost) continue;
    ++held;
    const Rigid3d& truth = room_->world_from_camera[10 + i];
    EXPECT_LT((reports[i].world_from_camera.translation - truth.translation).norm(), 0.03) << i;
    EXPECT_FALSE(reports[i].is_fused);
  }
  EXPECT_GE(held, 45);
}

TEST_F(KeptState, RejectsOptionsWithoutLoopsOrMap) {
  SlamOptions options = SessionSlamOptions();
  options.loops.enabled = options.loops.relocalization = false;
  ExpectInputError([&] { GoOn(StateUse::kContinue, options); }, Names("loops.enabled"));
  options = SessionSlamOptions();
  options.tracking = "frame_to_frame";
  ExpectInputError([&] { GoOn(StateUse::kContinue, options); }, Names("frame_to_model"));
}

}  // namespace
}  // namespace surfit::testing
