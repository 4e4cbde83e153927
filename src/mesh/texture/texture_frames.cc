#include "mesh/texture/texture_frames.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "output/recorded_run.h"

namespace surfit {
namespace {

constexpr int kFramesAhead = 4;

// Image speed of the point on the optical axis at a depth of 1.5 m, in focal lengths per second.
double SpeedOf(const CameraMotion& motion) {
  constexpr double kUsualDepth_m = 1.5;
  const Eigen::Vector3d way = motion.angular_velocity_rad_per_s.cross(Eigen::Vector3d::UnitZ()) +
                              motion.velocity_m_per_s / kUsualDepth_m;
  return way.head<2>().norm();
}

// Divides the run into at most `max_frames` parts. Returns the index of the slowest frame per part.
std::set<int> ChooseFrames(const RecordedRun& run, int max_frames) {
  std::vector<std::pair<int, double>> frames;  // index and speed
  std::size_t i = 0;
  for (const auto& [index, pose] : run.world_from_camera) {
    const double stamp_s = run.trajectory[i++].stamp_s;
    if (run.held_out.count(index) == 0)
      frames.emplace_back(index, SpeedOf(MotionAt(run.trajectory, stamp_s)));
  }
  const std::size_t parts =
      max_frames == 0 ? frames.size() : std::min<std::size_t>(max_frames, frames.size());
  std::set<int> chosen;
  for (std::size_t part = 0; part < parts; ++part) {
    const auto begin = frames.begin() + static_cast<std::ptrdiff_t>(part * frames.size() / parts);
    const auto end =
        frames.begin() + static_cast<std::ptrdiff_t>((part + 1) * frames.size() / parts);
    chosen.insert(std::min_element(begin, end, [](const auto& a, const auto& b) {
                    return a.second < b.second;
                  })->first);
  }
  return chosen;
}

}  // namespace

TextureFrames TextureFramesOf(const std::string& run_folder, const SequenceOptions& sequence,
                              int max_frames) {
  const auto run = std::make_shared<const RecordedRun>(ReadRecordedRun(run_folder));
  const std::set<int> chosen = ChooseFrames(*run, max_frames);
  return [=](const std::function<void(const TextureFrame&)>& visit) {
    const auto source = ReadAhead(OpenSequence(sequence), kFramesAhead);
    RequireCameraOfFrames(*run, run_folder, source->info().pinhole);
    const DepthSensor sensor = run->found.Of(source->info().sensor());
    while (std::optional<ReadResult> read = source->Next()) {
      if (!read->frame || read->frame->color.empty() || chosen.count(read->index) == 0) continue;
      TextureFrame frame = {std::move(*read->frame), sensor.camera,
                            run->world_from_camera.at(read->index),
                            MotionAt(run->trajectory, read->stamp_s), sensor.readout_s};
      run->found.Correct(&frame.frame);
      visit(frame);
    }
  };
}

}  // namespace surfit
