#include "apps/scan/scan_graph.h"

#include <gmock/gmock.h>

#include <random>

#include "testing/matchers.h"
#include "testing/pose_graphs.h"

namespace surfit::testing {
namespace {

constexpr int kFrames = 124, kKeyframeStep = 4;

// A circle of 10 m, 1.1 revolutions.
Rigid3d TruePose(int frame) {
  const double angle = 2.2 * M_PI * frame / kFrames;
  const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
  return PoseAlong(10 * out, {-out.y(), out.x(), 0}, Eigen::Vector3d::UnitZ());
}

// A tracked fragment with drift, in its own world frame.
RunPlaces Fragment(int first, int last, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, 6, 1> anywhere;
  for (int k = 0; k < 6; ++k) anywhere[k] = normal(*rng);
  const Rigid3d world = LeftIncrement<double>(anywhere, Rigid3d());
  RunPlaces places;
  Rigid3d drift;
  for (int i = first; i <= last; ++i) {
    Eigen::Matrix<double, 6, 1> error;
    for (int k = 0; k < 6; ++k) error[k] = 2e-4 * normal(*rng);
    drift = LeftIncrement<double>(error, drift);
    PosedFrame frame;
    frame.index = i;
    frame.stamp_s = 0.1 * i;
    frame.world_from_camera = world * TruePose(i) * drift;
    frame.keyframe = (i - first) / kKeyframeStep;
    places.frames.push_back(frame);
    if ((i - first) % kKeyframeStep > 0) continue;
    Keyframe keyframe;
    keyframe.frame_index = i;
    keyframe.world_from_camera = frame.world_from_camera;
    if (!places.keyframes.empty()) {
      PoseGraphEdge edge;
      edge.a = places.keyframes.size() - 1;
      edge.b = edge.a + 1;
      edge.a_from_b = places.keyframes.back().world_from_camera.Inverse() * frame.world_from_camera;
      edge.information = 1e6 * Matrix6d::Identity();
      places.edges.push_back(edge);
    }
    places.keyframes.push_back(keyframe);
  }
  return places;
}

class ScanGraphTest : public ::testing::Test {
 protected:
  ScanGraphTest() {
    for (int first = 0; first < kFrames; first += 28) {
      fragments_.emplace_back(Fragment(first, std::min(kFrames, first + 36) - 1, &rng_));
      recordings_.push_back(0);
    }
  }

  // Adds a link between two keyframes with a measurement error.
  void Link(std::size_t source, int source_keyframe, std::size_t target, int target_keyframe,
            const Rigid3d& error = {}) {
    GraphLink link;
    link.source = source;
    link.target = target;
    link.source_keyframe = source_keyframe;
    link.target_keyframe = target_keyframe;
    link.target_from_source =
        True(target, target_keyframe).Inverse() * True(source, source_keyframe) * error;
    link.information = 1e8 * Matrix6d::Identity();
    link.overlap_ratio = 0.5;
    links_.push_back(link);
  }
  Rigid3d True(std::size_t fragment, int keyframe) const {
    return TruePose(fragments_[fragment]->keyframes[keyframe].frame_index);
  }

  // Largest position error after alignment of the first frame.
  static double Error(const std::vector<PosedFrame>& frames) {
    const Rigid3d true_from_world =
        TruePose(frames[0].index) * frames[0].world_from_camera.Inverse();
    double most = 0;
    for (const PosedFrame& frame : frames) {
      most = std::max(most, ((true_from_world * frame.world_from_camera).translation -
                             TruePose(frame.index).translation)
                                .norm());
    }
    return most;
  }

  std::mt19937_64 rng_{3};
  std::vector<std::optional<RunPlaces>> fragments_;
  std::vector<int> recordings_;
  std::vector<GraphLink> links_;
};

TEST_F(ScanGraphTest, JoinsConsecutiveFragmentsByCommonFrames) {
  ScanGraph graph(fragments_, recordings_, {}, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  const std::vector<PosedFrame> frames = graph.Frames(0);
  ASSERT_EQ(frames.size(), kFrames);
  for (int i = 0; i < kFrames; ++i) EXPECT_EQ(frames[i].index, i);
  EXPECT_LT(Error(frames), 0.5);
  // Motions of consecutive frames have no jumps between fragments.
  for (int i = 1; i < kFrames; ++i) {
    const Rigid3d motion = frames[i - 1].world_from_camera.Inverse() * frames[i].world_from_camera;
    const Rigid3d truth = TruePose(i - 1).Inverse() * TruePose(i);
    EXPECT_LT((motion.translation - truth.translation).norm(), 0.02) << i;
  }
}

TEST_F(ScanGraphTest, LinksCorrectDriftAndOutliersAreRejected) {
  ScanGraph without(fragments_, recordings_, {}, LoopOptions());
  ASSERT_TRUE(without.Solve());
  const std::size_t last = fragments_.size() - 1;
  Link(last, 0, 0, 0);
  Link(last, 1, 0, 1);
  Link(last, 2, 0, 2);
  Link(2, 3, 0, 4, Rigid3d(Eigen::Quaterniond::Identity(), {1.5, 0, 0}));
  ScanGraph graph(fragments_, recordings_, links_, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(graph.links()[i].is_rejected) << i;
    EXPECT_LT(graph.Residual(graph.links()[i])->translation.norm(), 0.02);
  }
  EXPECT_TRUE(graph.links()[3].is_rejected);
  EXPECT_GT(graph.Residual(graph.links()[3])->translation.norm(), 1);
  EXPECT_LT(Error(graph.Frames(0)), Error(without.Frames(0)));
}

// The tracking of fragment 2 slides by 0.8 m between two keyframes. Links of both halves are right.
TEST_F(ScanGraphTest, CutsFragmentWhereItsOdometryContradictsLinks) {
  constexpr std::size_t kSlides = 2, kEdge = 4;
  const Rigid3d slide(Eigen::Quaterniond::Identity(), {0.5, 0.6, 0});
  RunPlaces& places = *fragments_[kSlides];
  const Rigid3d world_from_slid = places.keyframes[kEdge + 1].world_from_camera * slide *
                                  places.keyframes[kEdge + 1].world_from_camera.Inverse();
  for (PosedFrame& frame : places.frames) {
    if (frame.keyframe > static_cast<int>(kEdge)) {
      frame.world_from_camera = world_from_slid * frame.world_from_camera;
    }
  }
  for (std::size_t k = kEdge + 1; k < places.keyframes.size(); ++k) {
    places.keyframes[k].world_from_camera = world_from_slid * places.keyframes[k].world_from_camera;
  }
  places.edges[kEdge].a_from_b = places.keyframes[kEdge].world_from_camera.Inverse() *
                                 places.keyframes[kEdge + 1].world_from_camera;
  places.edges[kEdge].information *= 0.1;
  for (const int keyframe : {0, 2}) Link(kSlides, keyframe, 0, keyframe + 1);
  for (const int keyframe : {6, 7, 8}) Link(kSlides, keyframe, 0, keyframe - 3);
  ScanGraph graph(fragments_, recordings_, links_, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  ASSERT_EQ(graph.cuts().size(), 1u);
  EXPECT_EQ(graph.cuts()[0].fragment, kSlides);
  EXPECT_EQ(graph.cuts()[0].edge, kEdge);
  EXPECT_EQ(graph.cuts()[0].after - graph.cuts()[0].before, kKeyframeStep);
  for (const GraphLink& link : graph.links()) EXPECT_FALSE(link.is_rejected);
  EXPECT_LT(Error(graph.Frames(0)), 0.2);
}

TEST_F(ScanGraphTest, DoesNotCutFragmentForOneWrongLink) {
  const std::size_t last = fragments_.size() - 1;
  Link(last, 0, 0, 0);
  Link(last, 1, 0, 1);
  Link(2, 3, 0, 4, Rigid3d(Eigen::Quaterniond::Identity(), {1.5, 0, 0}));
  ScanGraph graph(fragments_, recordings_, links_, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  EXPECT_TRUE(graph.cuts().empty());
  EXPECT_TRUE(graph.links()[2].is_rejected);
}

TEST_F(ScanGraphTest, KeepsConsistentLoopsWithinFragments) {
  const auto add_loop = [&](std::size_t a, std::size_t b, const Rigid3d& error) {
    PoseGraphEdge edge;
    edge.a = a, edge.b = b;
    edge.a_from_b = True(0, static_cast<int>(a)).Inverse() * True(0, static_cast<int>(b)) * error;
    edge.information = 1e8 * Matrix6d::Identity();
    edge.loop = true;
    fragments_[0]->edges.push_back(edge);
  };
  add_loop(0, 5, {});
  add_loop(1, 7, Rigid3d(Eigen::Quaterniond::Identity(), {1.5, 0, 0}));
  ScanGraph graph(fragments_, recordings_, {}, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  const std::vector<PoseGraphEdge>& kept = graph.fragments()[0]->kept_loops;
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].b, 5u);
  EXPECT_TRUE(graph.fragments()[1]->kept_loops.empty());
}

TEST_F(ScanGraphTest, BridgesAMissingFragmentByALink) {
  fragments_[1].reset();
  {
    ScanGraph graph(fragments_, recordings_, {}, LoopOptions());
    ASSERT_TRUE(graph.Solve());
    EXPECT_TRUE(graph.IsDisconnected(0));
    EXPECT_FALSE(graph.IsDisconnected(1));  // fragment 1 is missing
    EXPECT_FALSE(graph.IsDisconnected(2));
  }
  Link(fragments_.size() - 1, 1, 0, 0);
  ScanGraph graph(fragments_, recordings_, links_, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  EXPECT_FALSE(graph.IsDisconnected(0));
  EXPECT_EQ(graph.Frames(0).front().index, 0);
}

// Both recordings have equal frame numbers, which contain no information about poses.
TEST_F(ScanGraphTest, JoinsRecordingsOnlyByLinks) {
  for (int first = 0; first < 64; first += 28) {
    fragments_.emplace_back(Fragment(first, std::min(64, first + 36) - 1, &rng_));
    recordings_.push_back(1);
  }
  const std::size_t second = 5;
  {
    ScanGraph graph(fragments_, recordings_, {}, LoopOptions());
    ASSERT_TRUE(graph.Solve());
    EXPECT_EQ(graph.Frames(0).size(), kFrames);
    EXPECT_TRUE(graph.Frames(1).empty());
    EXPECT_TRUE(graph.IsDisconnected(second));
  }
  for (const int k : {1, 4, 7}) Link(second + 1, k, 1, k);
  ScanGraph graph(fragments_, recordings_, links_, LoopOptions());
  ASSERT_TRUE(graph.Solve());
  const std::vector<PosedFrame> first_frames = graph.Frames(0), frames = graph.Frames(1);
  EXPECT_EQ(first_frames.size(), kFrames);
  ASSERT_EQ(frames.size(), 64u);
  // Both recordings are in one world frame.
  const Rigid3d true_from_world = TruePose(0) * first_frames[0].world_from_camera.Inverse();
  for (const PosedFrame& frame : frames) {
    EXPECT_LT(((true_from_world * frame.world_from_camera).translation -
               TruePose(frame.index).translation)
                  .norm(),
              0.2)
        << frame.index;
  }
}

TEST_F(ScanGraphTest, HasNoFramesWithoutTrackedFrames) {
  ScanGraph graph({std::nullopt, std::nullopt}, {0, 0}, {}, LoopOptions());
  EXPECT_TRUE(graph.Solve());
  EXPECT_TRUE(graph.Frames(0).empty());
}

}  // namespace
}  // namespace surfit::testing
