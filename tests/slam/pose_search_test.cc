#include "tracking/pose_search.h"

#include <gtest/gtest.h>

#include "surfit/frame/preprocess.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "tracking/tracked.h"

namespace surfit::testing {
namespace {

// Registers views by features to a given pose.
class GivenFeatures : public Relocalizer {
 public:
  std::optional<Rigid3d> last_from_frame;  // std::nullopt: not accepted
  int calls = 0;

  std::optional<KeyframePose> Find(const ColoredView& /*view*/, int /*rank*/) override {
    return std::nullopt;
  }
  std::optional<Rigid3d> RegisterTo(const ColoredView& /*earlier*/,
                                    const ColoredView& /*view*/) override {
    ++calls;
    return last_from_frame;
  }
  std::optional<int> BeginSubmap(int /*lost_frames*/) override { return std::nullopt; }
};

// Views of a simulated room instead of a map.
class RoomViews : public ModelViews {
 public:
  RoomViews(const Scene& scene, const DepthSensor& sensor) : scene_(scene), sensor_(sensor) {}

  const ReferenceView& View() const override { return view_; }
  bool Update(const Rigid3d& world_from_predicted, bool /*must*/, bool with_intensities) override {
    view_ = ViewAt(world_from_predicted, with_intensities);
    return true;
  }
  ReferenceView ViewAt(const Rigid3d& world_from_view, bool /*with_intensities*/) override {
    ReferenceView reference;
    const Image<float> depth_m = Render(scene_, sensor_.camera, world_from_view).depth_m;
    reference.view.pyramid = PreprocessDepth(depth_m, sensor_, {});
    reference.world_from_view = world_from_view;
    return reference;
  }
  ReferenceView NewestViewAt(const Rigid3d& world_from_view, bool with_intensities) override {
    return ViewAt(world_from_view, with_intensities);
  }
  void ActivateAround(int /*frame_index*/, int /*now*/) override {}
  void UseSubmap(int /*submap*/) override {}

 private:
  const Scene& scene_;
  const DepthSensor& sensor_;
  ReferenceView view_;
};

// Searches the pose of the second of two frames of a room.
class PoseSearchTest : public ::testing::Test {
 protected:
  PoseSearchTest() {
    images_.depth_m = Render(scene_, sensor_.camera, pose_).depth_m;
    images_.index = 1;
    images_.stamp_s = kInterval_s;
    state_.phase = TrackingPhase::kTracking;
    tracked_.state = FrameState::kTracked;
    tracked_.verdict = Verdict::kUncertain;
    tracked_.world_from_camera = pose_;
    features_.last_from_frame = last_.world_from_view.Inverse() * pose_;
  }

  Tracked Search() {
    const MovingRegions regions;
    const FrameRegistration registration(options_, regions);
    MovingRegions found_regions;
    PoseSearch search(options_, registration, &found_regions, &views_);
    search.UseRelocalizer(&features_);
    const PreprocessedFrame frame = {
        images_, images_, {PreprocessDepth(images_.depth_m, sensor_, {}), {}}, {}};
    return search.Search(frame, {state_, last_, kInterval_s, 0, state_.lost_frames, std::nullopt},
                         tracked_);
  }

  static constexpr double kInterval_s = 0.03;
  const DepthSensor sensor_ = {{160, 120, 131, 131, 79.5, 59.5, {}}, {}};
  const Scene scene_ = MakeScene("room", 1);
  const Trajectory path_ = MakePath(scene_, 100, 1);
  const Rigid3d pose_ = path_[1].world_from_camera;
  RoomViews views_{scene_, sensor_};
  const ReferenceView last_ = views_.ViewAt(path_[0].world_from_camera, false);
  TrackingOptions options_;
  TrackingState state_;
  RgbdFrame images_;
  Tracked tracked_;
  GivenFeatures features_;
};

TEST_F(PoseSearchTest, FeaturesThatAgreeConfirmAnUncertainPose) {
  const Tracked found = Search();
  EXPECT_EQ(found.state, FrameState::kTracked);
  EXPECT_EQ(found.verdict, Verdict::kAccepted);
  EXPECT_TRUE(found.has_second);
  EXPECT_FALSE(found.found_by_search);  // the pose of tracking itself
  EXPECT_EQ(features_.calls, 1);
}

TEST_F(PoseSearchTest, RegistersGloballyIfFeaturesDisagree) {
  const Rigid3d beside(Eigen::Quaterniond::Identity(), {0.3, 0, 0});
  tracked_.world_from_camera = pose_ * beside;
  features_.last_from_frame.reset();
  const Tracked found = Search();
  EXPECT_EQ(found.state, FrameState::kTracked);
  EXPECT_TRUE(found.found_by_search);
  EXPECT_LT((found.world_from_camera.translation - pose_.translation).norm(), 0.005);
}

// Without verification, as in real time, global registration would take as long as ten frames.
TEST_F(PoseSearchTest, FeaturesAloneFindTheFrameWithoutVerification) {
  options_.confident_inlier_ratio = 0;
  tracked_.state = FrameState::kLost;
  const Tracked found = Search();
  EXPECT_EQ(found.state, FrameState::kTracked);
  EXPECT_TRUE(found.found_by_search);
  EXPECT_LT((found.world_from_camera.translation - pose_.translation).norm(), 0.005);
  features_.last_from_frame.reset();
  EXPECT_EQ(Search().state, FrameState::kLost);
}

}  // namespace
}  // namespace surfit::testing
