#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/registration/normal_system.h"
#include "surfit/tracking/tracking.h"
#include "tracking/motion/prior_noise.h"

namespace surfit {

// Motion of the camera between two frames by registration alone.
struct RegisteredMotion {
  double from_s = 0, to_s = 0;
  Rigid3d from_camera_to_camera;            // camera frame at `to_s` to that at `from_s`, m
  Matrix6d information = Matrix6d::Zero();  // of the later registration
  double model_age_s = 0;  // mean age of the surfels that the later frame is registered to
};

// Motion of the camera between two frames by the prior poses.
struct PriorMotion {
  Rigid3d last_from_frame;
  Matrix6d covariance;  // rad, m; of the left increment, in the frame of the later camera
};

// Trajectory of another source (a phone, a robot, another SLAM), compared with registration.
//
// The body of the prior has a constant offset from the camera, and the scale is 1. SourceNoise is
// the model of the errors. Variances are from lower quartiles, so up to three quarters of the prior
// may be wrong.
//
// Stretches of the prior whose motion over 1, 2, 4, ... frames differs by more than eight standard
// deviations from the registered motion are rejected. Not thread-safe.
class PriorPoses {
 public:
  explicit PriorPoses(Trajectory world_from_body);

  // Adds the motion to a frame. Without prior poses at both times, or if the motion does not begin
  // at the last frame, the comparison starts again.
  void Add(const RegisteredMotion& motion);

  // Motion of the camera between two times. std::nullopt without prior poses at both times, or if
  // the prior is not trusted. A trusted prior has agreed with at least 32 registered motions, and
  // with all of the last motions.
  std::optional<PriorMotion> Trusted(double from_s, double to_s) const;
  // Motion between two frames that were added, for the pose graph. std::nullopt without a prior
  // motion for each frame between them, or in a rejected stretch.
  std::optional<PriorMotion> Accepted(double from_s, double to_s) const;

  // Pose of the camera in the world of the prior. std::nullopt without a prior pose at this time.
  std::optional<Rigid3d> CameraAt(double stamp_s) const;
  // Factors of the standard deviations of a registration, at least 1.
  const Vector6d& registration_scale() const { return registration_scale_; }
  // Covariance of the drift between two registered poses.
  Matrix6d RegisteredDrift(double seconds) const;
  // Covariance of the error of one registered pose relative to the map.
  Matrix6d RegistrationNoise() const;

  // Counts a frame whose registration begins at the prior motion.
  void CountUse() { ++used_; }
  PriorPoseSummary Summary() const;

  const Rigid3d& body_from_camera() const { return body_from_camera_; }

 private:
  struct Sample {
    double from_s, to_s;
    int run;                         // motions without interruption have the same number
    Rigid3d camera, body;            // pose after the motion, since the beginning of the run
    std::array<double, 2> variance;  // of the registration, rad^2 and m^2
    double model_age_s;
  };
  struct Interval {
    int begin, end;  // samples
  };
  std::optional<Rigid3d> BodyMotion(double from_s, double to_s) const;
  Matrix6d PriorCovariance(double seconds) const;
  bool IsOneRun(int begin, int end) const;
  Rigid3d CameraOver(int begin, int end) const;
  Rigid3d BodyOver(int begin, int end) const;
  Vector6d Difference(int begin, int end, const Rigid3d& body_from_camera) const;
  Rigid3d PriorOver(int begin, int end) const;
  bool IsPriorRougher(int begin, int end, int channel) const;
  bool Contradicts(int begin, int end) const;
  double Spread(const SourceNoise& noise, int scale) const;
  void Fit();
  void FitMount();
  void MeasureNoise();
  void ScaleRegistration();
  void AddThirdDifferences(int channel, NoiseStatistics* statistics) const;
  std::vector<int> WindowsOf(int length, int step) const;
  double MountCost(const Rigid3d& mount, const std::vector<int>& windows, int length) const;
  Rigid3d RefinedMount(Rigid3d mount, const std::vector<int>& windows, int length) const;
  std::vector<Rigid3d> MountCandidates(const std::vector<int>& windows, int length) const;
  void UpdateTrust();
  const std::vector<Interval>& Rejected() const;

  Trajectory world_from_body_;
  std::vector<Sample> samples_;
  Rigid3d body_from_camera_;
  std::array<SourceNoise, 2> noise_;  // rotation, translation
  double frame_s_ = 0;                // median time of a motion
  Vector6d registration_scale_ = Vector6d::Ones();
  int next_fit_ = 0;
  bool is_trusted_ = false;
  int checked_from_ = 0;  // first sample of the present check
  int needed_ = 0;        // samples that must agree
  int used_ = 0, without_ = 0;
  mutable std::vector<Interval> rejected_;
  mutable std::size_t rejected_at_ = 0;  // number of samples of `rejected_`
};

}  // namespace surfit
