// Custom frame source: a simulated camera in a simulated room.
#include <cstdio>

#include "surfit/frame/frame_source.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "surfit/slam/slam.h"

class SimulatedCamera : public surfit::FrameSource {
 public:
  explicit SimulatedCamera(int frames)
      : scene_(surfit::MakeScene("room")), path_(surfit::MakePath(scene_, frames, /*seed=*/1)) {
    info_.format = "simulated";
    info_.pinhole = {160, 120, 131, 131, 79.5, 59.5};  // width height fx fy cx cy, px
    info_.frame_count = frames;
    info_.ground_truth = path_;
  }
  const surfit::SequenceInfo& info() const override { return info_; }
  std::optional<surfit::ReadResult> Next() override {
    if (next_ == info_.frame_count) return std::nullopt;
    const auto& [stamp_s, pose] = path_[next_];
    surfit::ReadResult result;
    result.index = next_++;
    result.stamp_s = stamp_s;
    result.frame = surfit::RenderFrame(scene_, info_.pinhole, pose, result.index, stamp_s);
    return result;
  }

 private:
  surfit::Scene scene_;
  surfit::Trajectory path_;
  surfit::SequenceInfo info_;
  int next_ = 0;
};

// Tracks the camera and prints the error of the last pose. Returns 0 if it is below 15 mm.
int main() {
  SimulatedCamera camera(30);
  const surfit::Trajectory& truth = camera.info().ground_truth;
  surfit::Slam slam(camera.info().sensor(), surfit::SlamOptions(), truth.front().world_from_camera);
  surfit::FrameReport report;
  while (const auto result = camera.Next()) report = slam.Process(*result->frame);
  const Eigen::Vector3d error =
      report.world_from_camera.translation - truth.back().world_from_camera.translation;
  std::printf("%s, %zu surfels, %.1f mm off\n", surfit::ToString(report.state).c_str(),
              slam.map().size(), 1000 * error.norm());
  // 15 mm is the distance of two pixels on a wall at 2 m.
  return report.state == surfit::FrameState::kTracked && error.norm() < 0.015 ? 0 : 1;
}
