#pragma once

#include <map>
#include <optional>
#include <vector>

#include "surfit/geometry/inertial.h"
#include "surfit/registration/normal_system.h"
#include "tracking/inertial/imu_alignment.h"
#include "tracking/inertial/imu_filter.h"
#include "tracking/inertial/imu_smoother.h"

namespace surfit {

// Pose of a tracked frame.
struct TrackedPose {
  int frame = 0;
  double stamp_s = 0;         // capture time
  Rigid3d world_from_camera;  // with the motion prior
  Rigid3d registered;         // without any prior
  // Information of `registered` (1/rad^2, 1/m^2): left perturbation of the identity in the camera
  // frame. Zero: unknown.
  Matrix6d information = Matrix6d::Zero();
  // False for the first pose, a pose from a search, and the first pose of another submap.
  bool continues = false;
};

// Prediction of the camera pose by an inertial sensor, in three stages:
// 1. rotation unknown: no prediction until AlignImu() knows it
// 2. the gyroscope predicts the rotation, and the last velocity predicts the translation
// 3. both sensors predict the pose with its covariance (ImuFilter)
// If both sensors contradict the registered poses over several frames, stage 3 starts again. A
// contradiction within 5 s of the first start or of another contradiction switches the sensor off.
// Not thread-safe.
class ImuTracking {
 public:
  explicit ImuTracking(ImuRecording recording);
  ImuTracking(const ImuTracking&) = delete;
  ImuTracking& operator=(const ImuTracking&) = delete;

  struct Prediction {
    Rigid3d world_from_camera;
    // Covariance as in ImuPrediction; stage 3 only.
    std::optional<Matrix6d> covariance;
    // Covariance of the errors of registered poses that their information does not contain.
    Matrix6d pose_noise = Matrix6d::Zero();
  };
  // Prediction at a capture time. Returns std::nullopt in stage 1, without samples, if the sensor
  // is off, and more than 1.1 s after the last pose.
  std::optional<Prediction> Predict(double stamp_s) const;
  // Rotation rate of the camera in its frame, rad/s. Returns std::nullopt if Predict() does for
  // reasons other than the last pose.
  std::optional<Eigen::Vector3d> CameraRate(double stamp_s) const;
  // True if Predict() may return a pose in stage 2 or 3.
  bool IsActive() const;

  // Adds the pose of a frame, in the order of time. `predicted`: Predict() for this frame.
  void Add(const TrackedPose& pose, const std::optional<Prediction>& predicted);
  // Applies a correction of the world frame.
  void Move(const Rigid3d& new_from_old);

  ImuReport report() const;

  // Frame with its latest pose.
  struct FramePose {
    int frame = 0;
    double stamp_s = 0;  // capture time
    Rigid3d world_from_camera;
    int segment = 0;  // trajectory segment
  };
  // Smooths the poses of all frames by both sensors, see SmoothByImu(). Loop closures have moved
  // each registered pose together with the pose of its frame. The report then has the up direction
  // of all frames. Returns std::nullopt if the sensors have not predicted poses, or if they are
  // off.
  std::optional<std::vector<Rigid3d>> Smooth(const std::vector<FramePose>& frames);

 private:
  // Standard deviations per axis of the errors that registration does not know. They are estimated
  // from the differences of registered and predicted poses.
  struct PoseNoise {
    double turn_rad = 0.002, shift_m = 0.004;

    Matrix6d Covariance() const;
  };

  // Registration of a frame, relative to its pose.
  struct Registration {
    Rigid3d camera_from_registered;
    Matrix6d covariance = Matrix6d::Zero();  // as in RegisteredPose
  };

  RegisteredPose Registered(const TrackedPose& pose) const;
  void AddTurn(const TrackedPose& pose);
  void Align();
  void StartFilter();
  void StopFilter();
  // Updates the pose noise by the errors of this and the last prediction.
  void AddError(const Rigid3d& predicted_from_registered);
  void CountContradiction(bool contradicts, const char* what, const TrackedPose& pose);
  // Checks the mean size of the accelerometer. Returns the reason of a fault; empty: none.
  std::string FaultOfSize() const;
  // True if the recent poses agree much better with the negative accelerometer.
  bool NegativeAccelFits() const;
  void AddForce(const TrackedPose& pose);
  void SwitchOff(const std::string& reason);

  ImuRecording recording_;
  GyroIntegral gyro_;
  std::vector<CameraTurn> turns_;
  ImuAlignment alignment_;
  std::optional<ImuFilter> filter_;
  std::vector<TrackedPose> recent_;  // consecutive poses of the last 1.5 s, or the last eight
  double last_turn_s_ = 0;           // end of the last turn
  PoseNoise noise_;
  // Error of the last prediction (rad, m) in the predicted camera frame; std::nullopt: none.
  std::optional<Vector6d> last_error_;
  std::optional<double> trusted_since_s_;       // first start of the filter, or last contradiction
  std::optional<Eigen::Vector3d> smoothed_up_;  // up direction in the world by Smooth()
  std::map<int, Registration> registrations_;   // by frame; only frames with an information matrix
  int contradictions_ = 0;                      // consecutive frames
  // Sum of the specific forces at the poses in the world frame, m/s^2, and their number.
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  int force_count_ = 0;
  ImuReport report_;
};

}  // namespace surfit
