#include "surfit/poses/pose_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using ::testing::ElementsAre;

Rigid3d PoseOf(int i) {
  const Eigen::AngleAxisd turn(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized());
  return {Eigen::Quaterniond(turn), Eigen::Vector3d(i, 0.5 * i, -0.2 * i)};
}

PoseGraphEdge Edge(std::size_t a, std::size_t b, bool loop = false) {
  PoseGraphEdge edge;
  edge.a = a;
  edge.b = b;
  edge.a_from_b = Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.9, 0.4, -0.2));
  edge.loop = loop;
  return edge;
}

// Adds a keyframe at frame index 10 k.
void AddKeyframe(int k, int parent, PoseStore* store) {
  store->AddFrame(10 * k, k, PoseOf(k), 0);
  store->MakeKeyframe(parent);
  if (parent != KeyframeLink::kNone) store->AddEdge(Edge(parent, k));
}

void AddLoop(int source, int target, PoseStore* store) {
  const auto record = std::make_unique<LoopRecord>();  // GCC 12 warns of a moved local object
  record->source_frame = 10 * source;
  record->target_frame = 10 * target;
  record->attempt.verdict.reason = GlobalRegistrationReason::kAccepted;
  record->in_graph = true;
  store->AddLoop(*record, Edge(target, source, true));
}

std::vector<std::vector<int>> PairsOf(const PoseGraph& graph) {
  std::vector<std::vector<int>> pairs;
  for (const PoseGraphEdge& edge : graph.edges) {
    pairs.push_back({static_cast<int>(edge.a), static_cast<int>(edge.b)});
  }
  return pairs;
}

TEST(PoseStore, ConnectsFramesToTheLastKeyframe) {
  PoseStore store;
  AddKeyframe(0, KeyframeLink::kNone, &store);
  store.AddFrame(5, 0.5, PoseOf(7), 0);
  AddKeyframe(1, 0, &store);
  store.AddFrame(15, 1.5, PoseOf(8), 0);
  std::vector<int> keyframes;
  for (const PosedFrame& frame : store.frames()) keyframes.push_back(frame.keyframe);
  EXPECT_THAT(keyframes, ElementsAre(0, 0, 1, 1));
  EXPECT_EQ(store.FrameOf(1).index, 10);
  EXPECT_EQ(store.ParentOf(0), KeyframeLink::kNone);
  EXPECT_EQ(store.ParentOf(1), 0);
}

TEST(PoseStore, CountsDisconnectedSubmaps) {
  PoseStore store;
  AddKeyframe(0, KeyframeLink::kNone, &store);
  AddKeyframe(1, KeyframeLink::kNone, &store);
  AddKeyframe(2, 1, &store);
  AddKeyframe(3, KeyframeLink::kNone, &store);
  EXPECT_EQ(store.submap_count(), 3);
  EXPECT_EQ(store.keyframes()[2].submap, 1);
  EXPECT_EQ(store.CountDisconnectedSubmaps(), 2u);
  AddLoop(2, 0, &store);
  EXPECT_EQ(store.CountDisconnectedSubmaps(), 1u);
  store.SetLoopsInGraph({false});
  EXPECT_EQ(store.CountDisconnectedSubmaps(), 2u);
}

TEST(PoseStore, NumbersPiecesByFirstKeyframe) {
  PoseStore store;
  AddKeyframe(0, KeyframeLink::kNone, &store);
  AddKeyframe(1, KeyframeLink::kNone, &store);
  AddKeyframe(2, KeyframeLink::kNone, &store);
  AddKeyframe(3, 1, &store);
  EXPECT_THAT(store.PieceOfKeyframe(), ElementsAre(0, 1, 2, 1));
  AddLoop(2, 0, &store);
  EXPECT_THAT(store.PieceOfKeyframe(), ElementsAre(0, 1, 0, 1));
  EXPECT_THAT(store.PieceOfSubmap(), ElementsAre(0, 1, 0));
}

// A loop of a running task is added after the relocalisation. Its optimisation has no flag for the
// relocalisation.
TEST(PoseStore, RejectedRelocalizationSeparatesPieces) {
  PoseStore store;
  AddKeyframe(0, KeyframeLink::kNone, &store);
  AddKeyframe(1, 0, &store);
  EXPECT_EQ(store.Snapshot().edges.size(), 1u);  // a task starts
  store.AddFrame(20, 2, PoseOf(2), 1);
  store.MakeKeyframe(0);
  const auto record = std::make_unique<LoopRecord>();
  record->source_frame = 20;
  record->target_frame = 0;
  record->attempt.verdict.reason = GlobalRegistrationReason::kAccepted;
  record->in_graph = record->is_relocalization = true;
  store.AddRelocalization(*record, Edge(0, 2, true));
  EXPECT_THAT(store.PieceOfKeyframe(), ElementsAre(0, 0, 0));
  AddLoop(1, 0, &store);
  store.SetLoopsInGraph({false});  // result of the task: its loop is an outlier
  EXPECT_THAT(store.loops_in_graph(), ElementsAre(true, false));
  EXPECT_THAT(PairsOf(store.Snapshot()),
              ElementsAre(ElementsAre(0, 1), ElementsAre(0, 1), ElementsAre(0, 2)));
  store.SetLoopsInGraph({true, false});
  EXPECT_THAT(store.loops_in_graph(), ElementsAre(false, true));
  EXPECT_THAT(store.PieceOfKeyframe(), ElementsAre(0, 0, 1));
}

// Keyframe 3 is added before or after the loop of the first task.
TEST(PoseStore, SnapshotOrderIsIndependentOfTaskDuration) {
  std::vector<std::vector<std::vector<int>>> orders;
  for (const bool is_slow : {false, true}) {
    PoseStore store;
    AddKeyframe(0, KeyframeLink::kNone, &store);
    AddKeyframe(1, 0, &store);
    AddKeyframe(2, 1, &store);
    EXPECT_EQ(store.Snapshot().poses.size(), 3u);
    if (is_slow) AddKeyframe(3, 2, &store);
    AddLoop(2, 0, &store);
    if (!is_slow) AddKeyframe(3, 2, &store);
    const PoseGraph graph = store.Snapshot();
    EXPECT_EQ(graph.poses[3].id, 30);
    orders.push_back(PairsOf(graph));
  }
  EXPECT_EQ(orders[0], orders[1]);
  EXPECT_THAT(orders[0], ElementsAre(ElementsAre(0, 1), ElementsAre(1, 2), ElementsAre(0, 2),
                                     ElementsAre(2, 3)));
}

TEST(PoseStore, ContinuesFromItsSavedContent) {
  PoseStore store;
  AddKeyframe(0, KeyframeLink::kNone, &store);
  AddKeyframe(1, 0, &store);
  AddLoop(1, 0, &store);
  const PoseStore continued(
      StoredPoses{store.frames(), store.keyframes(), store.edges(), store.loops_in_graph(), 2});
  EXPECT_EQ(continued.FrameOf(1).index, 10);
  ASSERT_EQ(continued.loops().size(), 1u);
  EXPECT_TRUE(continued.loops()[0].in_graph);
  EXPECT_TRUE(continued.loops()[0].is_kept);
  EXPECT_EQ(continued.loops()[0].source_frame, 10);
}

TEST(PoseStore, RecalibrationKeepsErrorsOfEdges) {
  PoseStore store;
  AddKeyframe(0, KeyframeLink::kNone, &store);
  AddKeyframe(1, 0, &store);
  const auto error_of = [&] {
    const PoseGraphEdge& edge = store.edges().front();
    return store.FrameOf(1).world_from_camera.Inverse() * store.FrameOf(0).world_from_camera *
           edge.a_from_b;
  };
  const Rigid3d error = error_of();
  const std::vector<Rigid3d> before = store.KeyframePoses();
  std::vector<Rigid3d> corrections(11, Rigid3d());
  corrections[10] = PoseOf(2);
  store.Move({0, corrections});
  store.RecalibrateEdges(before);
  EXPECT_THAT(error_of(), RigidNear(error, 1e-12, 1e-12));
}

}  // namespace
}  // namespace surfit::testing
