#include "run/run_results.h"

#include <map>
#include <string>

#include "core/trace.h"
#include "run/posed_views.h"
#include "run/results/result_files.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

struct PathsInOneFrame {
  Trajectory estimate, truth;
};

Trajectory Moved(Trajectory trajectory, const Rigid3d& new_from_old_world) {
  for (StampedPose& pose : trajectory) {
    pose.world_from_camera = new_from_old_world * pose.world_from_camera;
  }
  return trajectory;
}

// Paths of the largest piece and of the ground truth in the upright world. The relative pose of
// other pieces is unknown. If the upright world is unknown, the paths are in the world of the
// ground truth, or in that of the run without ground truth.
PathsInOneFrame InOneFrame(const RunOutcome& run, const Trajectory& truth) {
  Rigid3d truth_from_run;
  if (run.evaluation && run.evaluation->ate)
    truth_from_run = run.evaluation->ate->alignment.target_from_source;
  const Rigid3d shown_from_run = run.upright ? run.upright->upright_from_world : truth_from_run;
  return {Moved(run.largest_piece, shown_from_run),
          Moved(truth, shown_from_run * truth_from_run.Inverse())};
}

void WriteViews(const RunOutcome& run, const DepthSensor& sensor, std::vector<KeptView>* views) {
  *views = run.views.Finish(run.map, sensor);
  KeptViews::Write(*views, run.options.output);
}

void WriteThumbnails(const RunOutcome& run, const DepthSensor& sensor,
                     std::vector<KeptView>* thumbnails) {
  std::map<int, Rigid3d> poses;
  const Trajectory& trajectory = run.trajectory.poses();
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    poses[run.trajectory.frames()[i]] = trajectory[i].world_from_camera;
  }
  *thumbnails = run.thumbnails.Finish(run.map, sensor, poses);
  Thumbnails::Write(*thumbnails, run.options.output);
}

// Keyframes of this run. Parents in earlier runs of the session become KeyframeLink::kNone.
std::vector<KeyframeLink> OwnKeyframes(const RunOutcome& run) {
  std::vector<KeyframeLink> keyframes;
  if (!run.backend || run.trajectory.frames().empty()) return keyframes;
  const int first = run.trajectory.frames().front();
  for (KeyframeLink link : run.backend->poses().keyframes()) {
    if (link.frame < first) continue;
    if (link.parent_frame < first) link.parent_frame = KeyframeLink::kNone;
    keyframes.push_back(link);
  }
  return keyframes;
}

void WritePictures(const RunOutcome& run, const Trajectory& truth, Failures* failures) {
  const TraceSlice slice("write_pictures");
  const std::string& folder = run.options.output;
  failures->Try([&] { WriteMapPictures(run.map, run.trajectory.poses(), folder, run.upright); });
  failures->Try([&] {
    const PathsInOneFrame paths = InOneFrame(run, truth);
    WriteTrajectoryPicture(paths.estimate, paths.truth, folder + "/trajectory.png");
  });
}

}  // namespace

void WriteRunResults(const RunOutcome& run, Failures* failures) {
  const std::string& folder = run.options.output;
  failures->Try([&] {
    const TraceSlice slice("write_map");
    WriteSurfelPly(run.map, folder + "/map.ply");
  });
  const DepthSensor sensor = run.found.Of(run.info.sensor());
  std::vector<KeptView> views;
  failures->Try([&] { WriteViews(run, sensor, &views); });
  std::vector<KeptView> thumbnails;
  failures->Try([&] { WriteThumbnails(run, sensor, &thumbnails); });
  const std::vector<KeyframeLink> keyframes = OwnKeyframes(run);
  Trajectory truth;
  failures->Try([&] { truth = TruthDuring(run.stamps_s, run.info.ground_truth); });
  failures->Try([&] {
    WritePosesJson(
        {sensor.camera, run.found, run.trajectory.poses(), run.trajectory.frames(),
         run.largest_piece, truth, run.evaluation, views, thumbnails, keyframes, run.upright},
        folder + "/poses.json");
  });
  if (run.options.pictures) WritePictures(run, truth, failures);
}

}  // namespace surfit
