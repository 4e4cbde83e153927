#include "tracking/motion/motion_model.h"

#include <gtest/gtest.h>

#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr double kFrame_s = 1. / 30;

Rigid3d Shifted(double x_m) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x_m, 0, 0)}; }

TrackingState After(int lost_frames) {
  TrackingState state = Next({}, TrackingEvent::kPose);
  for (int i = 0; i < lost_frames; ++i) state = Next(state, TrackingEvent::kNoPose);
  return state;
}

// Model after a motion of 1 cm.
MotionModel Moving(const TrackingOptions& options) {
  MotionModel model(options);
  MeasuredMotion motion;
  motion.last_from_frame = Shifted(0.01);
  motion.seconds = kFrame_s;
  motion.covariance = Matrix6d::Identity() * 1e-8;
  model.Update(After(0), motion);
  return model;
}

TEST(MotionModel, ContinuesLastMotion) {
  const TrackingOptions options;
  const MotionModel model = Moving(options);
  EXPECT_THAT(model.PredictPose(After(0), Shifted(1), 0), RigidNear(Shifted(1.01), 1e-12, 1e-12));
  EXPECT_NEAR(model.PredictMotion(After(0)).velocity_m_per_s.x(), 0.3, 1e-9);
  EXPECT_TRUE(model.PredictMotion(After(1)).IsZero());
}

TEST(MotionModel, FollowsTimestamps) {
  const TrackingOptions options;
  const MotionModel model = Moving(options);
  const auto predict = [&](double frames) {
    return model.PredictPose(After(0), Rigid3d(), frames * kFrame_s).translation.x();
  };
  EXPECT_NEAR(predict(2), 0.02, 1e-12);
  EXPECT_NEAR(predict(1.4), 0.014, 1e-12);
  EXPECT_NEAR(predict(0.9), 0.01, 1e-12) << "timestamps scatter";
  EXPECT_NEAR(predict(30), 0.03, 1e-12) << "motion is not known for long";
}

TEST(MotionModel, TurnsAndMovesAtConstantVelocity) {
  const TrackingOptions options;
  MotionModel model(options);
  const Rigid3d step = {QuaternionExp<double>(Eigen::Vector3d(0.1, 0.2, -0.1)),
                        Eigen::Vector3d(0.03, -0.02, 0.05)};
  MeasuredMotion motion;
  motion.last_from_frame = step;
  motion.seconds = kFrame_s;
  model.Update(After(0), motion);
  EXPECT_THAT(model.PredictPose(After(0), Rigid3d(), 2 * kFrame_s),
              RigidNear(step * step, 1e-12, 1e-12));
}

TEST(MotionModel, KnowsStepsThatNoHandMakes) {
  const TrackingOptions options;
  const MotionModel model = Moving(options);
  EXPECT_FALSE(model.IsImpossible(After(0), Shifted(0.01), kFrame_s));
  EXPECT_FALSE(model.IsImpossible(After(0), Shifted(0.06), kFrame_s));
  EXPECT_TRUE(model.IsImpossible(After(0), Shifted(0.1), kFrame_s));
  EXPECT_TRUE(model.IsImpossible(After(0), Shifted(-0.08), kFrame_s));
  EXPECT_FALSE(model.IsImpossible(After(0), Shifted(0.1), 2 * kFrame_s));
  const Rigid3d turn = {QuaternionExp<double>(Eigen::Vector3d(0, 0.4, 0)),
                        Eigen::Vector3d(0.01, 0, 0)};
  EXPECT_TRUE(model.IsImpossible(After(0), turn, kFrame_s));
  EXPECT_FALSE(model.IsImpossible(After(1), Shifted(0.2), kFrame_s)) << "the motion may be old";
  EXPECT_FALSE(MotionModel(options).IsImpossible(After(0), Shifted(0.2), kFrame_s));
}

TEST(MotionModel, ContinuesOverTwoLostFramesWithPriorOnly) {
  TrackingOptions options;
  const MotionModel without = Moving(options);
  EXPECT_THAT(without.PredictPose(After(2), Shifted(1), 0), RigidNear(Shifted(1), 1e-12, 1e-12));
  EXPECT_TRUE(without.PriorCovariance(After(0), kFrame_s));
  options.acceleration_m_per_s2 = 2;
  const MotionModel with = Moving(options);
  EXPECT_THAT(with.PredictPose(After(2), Shifted(1), 0), RigidNear(Shifted(1.03), 1e-12, 1e-12));
  EXPECT_THAT(with.PredictPose(After(3), Shifted(1), 0), RigidNear(Shifted(1), 1e-12, 1e-12));
  EXPECT_TRUE(with.PriorCovariance(After(2), kFrame_s));
  EXPECT_FALSE(with.PriorCovariance(After(3), kFrame_s));
  EXPECT_FALSE(with.PriorCovariance(After(0), 0));
}

TEST(MotionModel, ResetsMotionAfterRelocalisation) {
  TrackingOptions options;
  options.acceleration_m_per_s2 = 2;
  for (const bool is_expected : {false, true}) {
    MotionModel model = Moving(options);
    MeasuredMotion motion;
    motion.last_from_frame = Shifted(5);
    motion.seconds = kFrame_s;
    motion.is_found = true;
    motion.is_expected = is_expected;
    model.Update(After(0), motion);
    EXPECT_THAT(model.PredictPose(After(0), Rigid3d(), 0),
                RigidNear(Shifted(is_expected ? 0.01 : 0), 1e-12, 1e-12));
    EXPECT_TRUE(model.PredictMotion(After(0)).IsZero());
  }
}

TEST(MotionModel, HasNoVelocityAfterTenthOfSecondOrLoss) {
  EXPECT_FALSE(MotionModel::Velocity(After(0), Shifted(0.01), 0.09).IsZero());
  EXPECT_TRUE(MotionModel::Velocity(After(0), Shifted(0.01), 0.11).IsZero());
  EXPECT_TRUE(MotionModel::Velocity(After(1), Shifted(0.01), 0.05).IsZero());
}

}  // namespace
}  // namespace surfit::testing
