#include "bindings/slam_session.h"

#include <utility>

#include "bindings/arrays.h"
#include "run/results/result_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::python {
namespace {

bool AreSame(const DepthSensor& sensor, const DepthSensor& other) {
  const PinholeCamera &a = sensor.camera, &b = other.camera;
  return sensor.noise.inverse_depth_sigma == other.noise.inverse_depth_sigma &&
         a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy;
}

std::string Describe(const DepthSensor& sensor) {
  const PinholeCamera& camera = sensor.camera;
  return Concat(camera.width, " x ", camera.height, " px, fx ", camera.fx, ", fy ", camera.fy,
                ", cx ", camera.cx, ", cy ", camera.cy, ", noise ",
                sensor.noise.inverse_depth_sigma, " 1/m");
}

}  // namespace

SlamSession::SlamSession(const SlamOptions& options, const std::optional<RgbdCamera>& camera,
                         const RectifyOptions& rectify, const Rigid3d& world_from_first_camera)
    : options_(options), world_from_first_camera_(world_from_first_camera) {
  Validate(options_);
  Validate(rectify);
  if (!camera) return;
  maker_.emplace(*camera, rectify);
  Start(maker_->sensor(), maker_->mirrored());
}

void SlamSession::Start(const DepthSensor& sensor, bool mirrored) {
  sensor_ = sensor;
  mirrored_ = mirrored;
  slam_ = std::make_unique<Slam>(sensor, options_, world_from_first_camera_);
  slam_->OnPose([this](const FrameReport& pose) {
    try {
      if (on_pose_) on_pose_(pose);
    } catch (...) {
      thrown_ = std::current_exception();
    }
  });
}

template <typename Work>
auto SlamSession::Locked(const Work& work) {
  ThrowIf(worker_ == std::this_thread::get_id(),
          "the callback of on_pose() must not call its Slam");
  const py::gil_scoped_release release;
  const std::lock_guard<std::mutex> lock(mutex_);
  struct Worker {
    std::atomic<std::thread::id>& id;
    explicit Worker(std::atomic<std::thread::id>& of) : id(of) { id = std::this_thread::get_id(); }
    ~Worker() { id = std::thread::id(); }
  } const worker(worker_);
  return work();
}

void SlamSession::OnPose(std::function<void(const FrameReport&)> call) {
  Locked([&] { on_pose_.swap(call); });
}

FrameReport SlamSession::Process(const Frame& frame,
                                 const std::optional<Rigid3d>& world_from_camera) {
  return Locked([&] {
    if (!slam_) Start(frame.sensor, frame.mirrored);
    if (!AreSame(frame.sensor, sensor_)) {
      throw InputError("the frame's camera is ", Describe(frame.sensor), ", must be ",
                       Describe(sensor_), " as before");
    }
    const FrameReport report = world_from_camera
                                   ? slam_->ProcessAt(frame.images, *world_from_camera)
                                   : slam_->Process(frame.images);
    next_index_ = frame.images.index + 1;
    if (report.HasPose()) {
      trajectory_.push_back({report.stamp_s, report.world_from_camera});
    }
    if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
    return report;
  });
}

FrameReport SlamSession::Process(const py::object& color, const py::array& depth, double stamp_s,
                                 std::optional<int> index,
                                 const std::optional<Rigid3d>& world_from_camera) {
  if (!maker_) throw InputError("camera is not set, must be set for frames that are arrays");
  const int frame_index = index ? *index : Locked([&] { return next_index_; });
  return Process(maker_->Make(color, depth, stamp_s, frame_index), world_from_camera);
}

void SlamSession::Finish() {
  Locked([&] {
    if (slam_) slam_->Finish();
  });
}

std::optional<DepthCalibration> SlamSession::FoundCalibration() {
  return Locked([&]() -> std::optional<DepthCalibration> {
    const Backend* backend = slam_ ? slam_->backend() : nullptr;
    if (!backend || !backend->is_recalibrated()) return std::nullopt;
    return *backend->calibration();
  });
}

Trajectory SlamSession::CurrentTrajectory() const {
  return slam_ && slam_->backend() ? slam_->backend()->poses().trajectory() : trajectory_;
}

py::array_t<double> SlamSession::TrajectoryRows() {
  return RowsOf(Locked([&] { return CurrentTrajectory(); }));
}

py::array_t<double> SlamSession::Poses() {
  const Trajectory trajectory = Locked([&] { return CurrentTrajectory(); });
  py::array_t<double> poses(
      {static_cast<py::ssize_t>(trajectory.size()), py::ssize_t{4}, py::ssize_t{4}});
  double* data = poses.mutable_data();
  for (const StampedPose& pose : trajectory) {
    WriteMatrix(pose.world_from_camera, data);
    data += 16;
  }
  return poses;
}

SurfelColumns SlamSession::Surfels() {
  return Locked([&] { return slam_ ? ColumnsOf(slam_->map()) : SurfelColumns(); });
}

std::size_t SlamSession::SurfelCount() {
  return Locked([&] { return slam_ ? slam_->map().size() : 0; });
}

std::string SlamSession::DigestOfResult() {
  return Locked([&] { return Digest(CurrentTrajectory(), slam_ ? slam_->map() : SurfelMap()); });
}

void SlamSession::WriteTrajectory(const std::string& path) {
  Locked([&] {
    Trajectory trajectory = CurrentTrajectory();
    for (StampedPose& pose : trajectory) {
      if (mirrored_) pose.world_from_camera = Mirrored(pose.world_from_camera);
    }
    WriteTumTrajectory(trajectory, path);
  });
}

void SlamSession::WriteMap(const std::string& path) {
  Locked([&] { WriteSurfelPly(slam_ ? slam_->map() : SurfelMap(), path); });
}

}  // namespace surfit::python
