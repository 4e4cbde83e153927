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

// A Slam with what Python wants beside it: arrays made frames, and the trajectory so far. Safe for
// several threads, one at a time; none of its methods holds the GIL while it works or waits.
class SlamSession {
 public:
  // Without a camera, the first frame's is taken. Throws InputError for bad options.
  SlamSession(const SlamOptions& options, const std::optional<RgbdCamera>& camera,
              const PrepareOptions& prepare, const Rigid3d& world_from_first_camera);

  // Throws InputError unless the frame has the session's sensor.
  FrameReport Process(const Frame& frame, const std::optional<Rigid3d>& world_from_camera);

  // Without an index, that after the last frame's. Throws InputError without a camera.
  FrameReport Process(const py::object& color, const py::array& depth, double stamp_s,
                      std::optional<int> index, const std::optional<Rigid3d>& world_from_camera);

  // See Slam::OnPose(). What it throws is thrown by Process() in the end.
  void OnPose(std::function<void(const FrameReport&)> call);

  // See Slam::Finish().
  void Finish();
  // By which the last frame was seen, where that is not as given.
  std::optional<DepthCalibration> FoundCalibration();

  py::array_t<double> TrajectoryRows();
  py::array_t<double> Poses();
  SurfelColumns Surfels();
  std::size_t SurfelCount();
  std::string DigestOfResult();
  bool mirrored() const { return mirrored_; }

  // Throw InputError naming the file if it cannot be written.
  void WriteTrajectory(const std::string& path);
  void WriteMap(const std::string& path);

 private:
  // What `work` returns of the state, which nobody else has meanwhile. Throws InputError where it
  // is called by what Process() calls, which would wait for itself.
  template <typename Work>
  auto Locked(const Work& work);
  void Start(const DepthSensor& sensor, bool mirrored);
  Trajectory CurrentTrajectory() const;  // to be called while locked

  SlamOptions options_;
  Rigid3d world_from_first_camera_;
  std::optional<FrameMaker> maker_;

  std::mutex mutex_;                       // of all below
  std::atomic<std::thread::id> worker_{};  // who has locked it
  std::function<void(const FrameReport&)> on_pose_;
  std::exception_ptr thrown_;  // by that
  std::unique_ptr<Slam> slam_;
  DepthSensor sensor_;
  bool mirrored_ = false;
  int next_index_ = 0;
  Trajectory trajectory_;  // as it was at the time
};

}  // namespace surfit::python
