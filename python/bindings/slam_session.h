#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "bindings/bind.h"
#include "bindings/frame.h"
#include "bindings/surfels.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/slam/slam.h"

namespace surfit::python {

// Slam for Python: converts arrays to frames, and stores the trajectory. Thread-safe: calls run one
// after another. All functions release the GIL while they run or wait.
class SlamSession {
 public:
  // Without a camera, the camera of the first frame is used. Throws InputError for invalid options.
  SlamSession(const SlamOptions& options, const std::optional<RgbdCamera>& camera,
              const RectifyOptions& rectify, const Rigid3d& world_from_first_camera);

  // Throws InputError if the sensor of the frame differs from the sensor of the session.
  FrameReport Process(const Frame& frame, const std::optional<Rigid3d>& world_from_camera);

  // Without an index, uses the index after the last frame. Throws InputError without a camera.
  FrameReport Process(const py::object& color, const py::array& depth, double stamp_s,
                      std::optional<int> index, const std::optional<Rigid3d>& world_from_camera);

  // See Slam::OnPose(). Exceptions of the callback are thrown at the end of Process().
  void OnPose(std::function<void(const FrameReport&)> call);

  // See Slam::Finish().
  void Finish();
  // Estimated calibration; std::nullopt: the input calibration is kept.
  std::optional<DepthCalibration> FoundCalibration();

  py::array_t<double> TrajectoryRows();
  py::array_t<double> Poses();
  SurfelColumns Surfels();
  std::size_t SurfelCount();
  std::string DigestOfResult();
  bool mirrored() const { return mirrored_; }

  // Throw InputError with the name of the file if it cannot be written.
  void WriteTrajectory(const std::string& path);
  void WriteMap(const std::string& path);

 private:
  // Returns the result of `work`, which has exclusive access to the state. Throws InputError if it
  // is called from the callback of Process(): this would be a deadlock.
  template <typename Work>
  auto Locked(const Work& work);
  void Start(const DepthSensor& sensor, bool mirrored);
  Trajectory CurrentTrajectory() const;  // call while locked

  SlamOptions options_;
  Rigid3d world_from_first_camera_;
  std::optional<FrameMaker> maker_;

  std::mutex mutex_;                       // guards the members below
  std::atomic<std::thread::id> worker_{};  // thread that holds the lock
  std::function<void(const FrameReport&)> on_pose_;
  std::exception_ptr thrown_;  // exception of on_pose_
  std::unique_ptr<Slam> slam_;
  DepthSensor sensor_;
  bool mirrored_ = false;
  int next_index_ = 0;
  Trajectory trajectory_;  // without later corrections
};

}  // namespace surfit::python
