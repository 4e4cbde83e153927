#include "surfit/mapping/move_map.h"

#include <gtest/gtest.h>

#include <random>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "surfit/core/parallel.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kFrames = 50;  // maximum of first_seen of RandomSurfel()

Rigid3d Turn(double angle_rad, const Eigen::Vector3d& shift) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1, 2, 3).normalized())),
          shift};
}

// Corrections with rotations and translations that increase with the frame.
FrameCorrections GrowingCorrections() {
  std::vector<Rigid3d> corrections;
  for (int i = 0; i < kFrames; ++i) {
    corrections.push_back(Turn(0.02 * i, {0.03 * i, -0.01 * i, 0.002 * i}));
  }
  return {0, corrections};
}

SurfelMap RandomMap(int count) {
  std::mt19937_64 rng(7);
  SurfelMap map;
  for (int i = 0; i < count; ++i) map.Append(RandomSurfel(&rng));
  return map;
}

// Surfel 1 m in front of the camera of its frame. The camera is at (0.1 frame, 0, 0).
Surfel SurfelOfFrame(int frame) {
  Surfel surfel;
  surfel.position_in_world = {0.1f * frame, 0, 1};
  surfel.normal_in_world = {0, 0, -1};
  surfel.radius_m = 0.01f;
  surfel.confidence = 5;
  surfel.first_seen = frame;
  surfel.last_seen = frame + 3;
  return surfel;
}

TEST(FrameCorrections, UsesNearestCorrectionBeyondEnds) {
  const FrameCorrections corrections(10, {Turn(0, {1, 0, 0}), Turn(0, {2, 0, 0})});
  EXPECT_EQ(corrections.At(3).translation.x(), 1);
  EXPECT_EQ(corrections.At(10).translation.x(), 1);
  EXPECT_EQ(corrections.At(11).translation.x(), 2);
  EXPECT_EQ(corrections.At(99).translation.x(), 2);
}

// Drift has bent a straight wall to an arc. The correction of the poses straightens it.
TEST(MoveMap, StraightensBentWall) {
  constexpr double kBend = 0.01;  // rad per frame
  std::vector<Rigid3d> straight_from_bent;
  SurfelMap map;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Rigid3d bent_from_straight(
        Eigen::Quaterniond(Eigen::AngleAxisd(kBend * frame, Eigen::Vector3d::UnitY())), {0, 0, 0});
    straight_from_bent.push_back(bent_from_straight.Inverse());
    Surfel surfel = SurfelOfFrame(frame);
    surfel.position_in_world =
        (bent_from_straight * surfel.position_in_world.cast<double>()).cast<float>();
    surfel.normal_in_world =
        (bent_from_straight.rotation * surfel.normal_in_world.cast<double>()).cast<float>();
    map.Append(surfel);
  }
  const MoveReport report = MoveMap({0, straight_from_bent}, &map);
  EXPECT_EQ(report.moved, kFrames - 1u);  // all surfels except the surfel of frame 0
  EXPECT_GT(report.changed_cell, 0u);
  EXPECT_EQ(map.size(), static_cast<std::size_t>(kFrames));
  ExpectConsistent(map);
  for (const std::int32_t id : map.Ids()) {
    const Surfel expected = SurfelOfFrame(map[id].first_seen);
    // Single precision at a distance of 5 m, and the rounding of two stored positions.
    EXPECT_LT((map[id].position_in_world - expected.position_in_world).norm(),
              3e-6 + 2 * kPositionRounding);
    EXPECT_LT((map[id].normal_in_world - expected.normal_in_world).norm(), 2 * kNormalRounding);
    EXPECT_EQ(map[id].last_seen, expected.last_seen);
  }
}

TEST(MoveMap, MovesSurfelsToTheirCells) {
  SurfelMap map = RandomMap(3000);
  MoveMap(GrowingCorrections(), &map);
  ExpectConsistent(map);
  for (std::int32_t i = 0; i < map.cell_count(); ++i) {
    const Eigen::Vector3f centre =
        SurfelMap::kCellSize * SurfelMap::CubeOf(map.cell(i)).cast<float>();
    for (const std::int32_t b : map.cell(i).blocks) {
      for (int k = 0; k < map.block(b).count; ++k) {
        EXPECT_LE((map.block(b).Position(k) - centre).cwiseAbs().maxCoeff(),
                  SurfelMap::kCellSize / 2);
      }
    }
  }
  SurfelMap appended_anew;
  for (const std::int32_t id : map.Ids()) appended_anew.Append(map[id]);
  std::size_t cells_in_use = 0, cells_anew = appended_anew.cell_count();
  for (std::int32_t i = 0; i < map.cell_count(); ++i) cells_in_use += !map.cell(i).blocks.empty();
  EXPECT_EQ(cells_in_use, cells_anew);
}

TEST(MoveMap, KeepsOtherFieldsOfSurfels) {
  SurfelMap map = RandomMap(500);
  const SurfelMap before = map;
  MoveMap({0, {Turn(0, {0.001, 0, 0})}}, &map);
  double sum = 0, sum_before = 0;
  for (const std::int32_t id : map.Ids()) sum += map[id].confidence * map[id].color.g;
  for (const std::int32_t id : before.Ids())
    sum_before += before[id].confidence * before[id].color.g;
  EXPECT_NEAR(sum, sum_before, 1e-9 * sum_before);
}

TEST(MoveMap, KeepsMapWithIdentityCorrections) {
  SurfelMap map = RandomMap(500);
  const SurfelMap before = map;
  EXPECT_EQ(MoveMap({0, std::vector<Rigid3d>(kFrames)}, &map).moved, 0u);
  ExpectSameMap(map, before);
}

// Slanted plane in camera measurements: the other calibration tilts and shifts it.
TEST(MoveMap, AppliesNewCalibration) {
  const DepthCalibration from = {{160, 120, 131, 131, 79.5, 59.5, {}}, {{0.01, 0, 0.02, 0, 0, 0}}};
  const DepthCalibration to = {{160, 120, 135, 134, 77, 61, {}}, {{0, -0.03, 0, 0, 0, 0}}};
  const Rigid3d world_from_camera = Turn(0.4, {1, 2, 3});
  const Rigid3d correction = Turn(-0.1, {0.1, 0, 0.2});
  // Inverse depth is linear in the pixels, so both calibrations give a plane.
  const auto point_at = [](const DepthCalibration& calibration, double u, double v) {
    const Eigen::Vector3d ray = calibration.camera.Ray(u, v);
    return Eigen::Vector3d(ray /
                           (0.5 + 0.001 * u - 0.0005 * v + calibration.field.At(ray.x(), ray.y())));
  };
  const auto surfel_at = [&](const DepthCalibration& calibration, const Rigid3d& pose, int u,
                             int v) {
    const Eigen::Vector3d point = point_at(calibration, u, v);
    const Eigen::Vector3d along_u = point_at(calibration, u + 1, v) - point;
    const Eigen::Vector3d along_v = point_at(calibration, u, v + 1) - point;
    Surfel surfel = SurfelOfFrame(u);
    surfel.position_in_world = (pose * point).cast<float>();
    surfel.normal_in_world = (pose.rotation * -along_u.cross(along_v).normalized()).cast<float>();
    return surfel;
  };
  SurfelMap map;
  for (int u = 0; u < 160; u += 10) map.Append(surfel_at(from, world_from_camera, u, u / 2));
  const std::size_t size = map.size();
  MoveMap({0, {correction}}, {from, to, {world_from_camera}}, &map);
  EXPECT_EQ(map.size(), size);
  ExpectConsistent(map);
  for (const std::int32_t id : map.Ids()) {
    const int u = map[id].first_seen;
    const Surfel expected = surfel_at(to, correction * world_from_camera, u, u / 2);
    EXPECT_LT((map[id].position_in_world - expected.position_in_world).norm(),
              1e-5 + 2 * kPositionRounding);
    EXPECT_LT((map[id].normal_in_world - expected.normal_in_world).norm(), 1e-4);
  }
}

// Expects that a recalibration moves the surfel rigidly. The camera is at the world origin.
void ExpectMovesRigidly(const Surfel& surfel, const DepthCalibration& from,
                        const DepthCalibration& to) {
  const Rigid3d correction = Turn(0.5, {0.1, 0, 0.2});
  SurfelMap map;
  map.Append(surfel);
  MoveMap({0, {correction}}, {from, to, {Rigid3d()}}, &map);
  const Surfel moved = map[map.Ids().at(0)];
  EXPECT_LT((moved.position_in_world -
             (correction * surfel.position_in_world.cast<double>()).cast<float>())
                .norm(),
            1e-6 + 2 * kPositionRounding);
  EXPECT_LT((moved.normal_in_world -
             (correction.rotation * surfel.normal_in_world.cast<double>()).cast<float>())
                .norm(),
            2 * kNormalRounding);
}

// Merging has moved the surfel behind the camera of its first frame.
TEST(MoveMap, TurnsSurfelsBehindTheCameraWithTheirFrame) {
  const DepthCalibration from = {{160, 120, 131, 131, 79.5, 59.5, {}}, {}};
  DepthCalibration to = from;
  to.camera.fx = 140;
  Surfel surfel = SurfelOfFrame(0);
  surfel.position_in_world = {0.1f, 0.2f, -0.3f};
  surfel.normal_in_world = Eigen::Vector3f(1, 2, -2) / 3;
  ExpectMovesRigidly(surfel, from, to);
}

// The inverse depth of 1 / m becomes -0.5 / m.
TEST(MoveMap, TurnsSurfelsWithoutNewDepthWithTheirFrame) {
  const DepthCalibration from = {{160, 120, 131, 131, 79.5, 59.5, {}}, {}};
  DepthCalibration to = from;
  to.field.coefficients[0] = -1.5;
  ExpectMovesRigidly(SurfelOfFrame(0), from, to);
}

TEST(MoveMap, RejectsCorrectionsOfAnotherNumber) {
  ExpectInputError([] { FrameCorrections(0, {}); }, Names("corrections"));
  SurfelMap map = RandomMap(10);
  const DepthCalibration calibration = {{160, 120, 131, 131, 79.5, 59.5, {}}, {}};
  ExpectInputError(
      [&] {
        MoveMap({0, {Rigid3d()}}, {calibration, calibration, {}}, &map);
      },
      Names(1, 0));
}

TEST(MoveMapThreads, AreBitwiseIdentical) {
  SurfelMap expected = RandomMap(5000);
  {
    const ThreadLimit one(1);
    MoveMap(GrowingCorrections(), &expected);
  }
  for (const int threads : {2, 4}) {
    const ThreadLimit limit(threads);
    SurfelMap map = RandomMap(5000);
    MoveMap(GrowingCorrections(), &map);
    ExpectSameMap(map, expected);
  }
}

TEST(ReactivateSurfels, UpdatesLastSeenOfGivenFramesOnly) {
  SurfelMap map;
  for (int frame = 0; frame < kFrames; ++frame) map.Append(SurfelOfFrame(frame));
  EXPECT_EQ(ReactivateSurfels(10, 12, 90, &map), 3u);
  for (const std::int32_t id : map.Ids()) {
    const int seen = map[id].first_seen + 3;
    EXPECT_EQ(map[id].last_seen, seen >= 10 && seen <= 12 ? 90 : seen);
  }
  ExpectConsistent(map);
}

}  // namespace
}  // namespace surfit::testing
