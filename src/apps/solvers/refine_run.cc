#include "apps/solvers/refine_run.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <vector>

#include "apps/solvers/result_json.h"
#include "apps/solvers/run_keyframes.h"
#include "finishing/final_map.h"
#include "finishing/posed_sequence.h"
#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "run/posed_views.h"
#include "run/results/failures.h"
#include "run/results/result_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/optimization/keyframes.h"
#include "surfit/slam/slam.h"

namespace surfit {
namespace {

constexpr double kSameStamp = 1e-5;  // s; trajectory files have 6 decimals

Trajectory InSourceConvention(Trajectory trajectory, bool mirrored) {
  if (!mirrored) return trajectory;
  for (StampedPose& pose : trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
  return trajectory;
}

std::optional<std::size_t> PoseAt(const Trajectory& trajectory, double stamp_s) {
  const auto at =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp_s - kSameStamp,
                       [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (at == trajectory.end() || at->stamp_s > stamp_s + kSameStamp) return std::nullopt;
  return at - trajectory.begin();
}

class RefineRun {
 public:
  RefineRun(const RefineRunOptions& options,
            const std::function<void(const std::string&)>& progress)
      : options_(options), progress_(progress) {}

  RefineRunSummary Run() {
    const auto start = std::chrono::steady_clock::now();
    ReadKeyframes();
    const OutputFolder owned(options_.output,
                             {"trajectory.txt", "map.ply", "camera.yaml", "poses.json",
                              "refinement.json", "report.html"},
                             {options_.trajectory, options_.sequence.camera});
    // The depth correction field of the input camera is already applied to the frames. So the
    // initial field is empty.
    const DepthCalibration given = {run_.info.pinhole, {}, run_.info.camera.readout_s};
    summary_.refinement = Refine(options_.refinement, given, &run_.keyframes,
                                 [&](const RefinementRound& round) { Tell(round); });
    summary_.calibration =
        CalibrationOfRawDepth(run_.info, summary_.given.field, summary_.refinement.calibration);
    if (summary_.refinement.Succeeded()) failures_.Try([&] { Apply(); });
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    summary_.total_s = elapsed.count();
    summary_.failure = failures_.text();
    failures_.Try(
        [&] { WriteRefinementJson(summary_, options_, options_.output + "/refinement.json"); });
    if (failures_.any()) throw InputError(failures_.text());
    return summary_;
  }

 private:
  void ReadKeyframes() {
    run_ = ReadRunKeyframes(options_);
    options_.refinement.prior.Complete(run_.info.camera.prior);
    summary_.given.camera = run_.info.pinhole;
    summary_.given.readout_s = run_.info.camera.readout_s;
    summary_.given.field = ReadDepthField(options_.sequence, run_.info.format);
    summary_.poses = run_.trajectory.size();
    summary_.keyframes = run_.keyframes.size();
    summary_.frames_without_pose = run_.frames_without_pose;
    summary_.frames_unreadable = run_.frames_unreadable;
    progress_(Concat(summary_.keyframes, " keyframes of ", summary_.poses,
                     " poses, camera: ", NameOfCamera(options_.sequence)));
  }

  void Tell(const RefinementRound& round) {
    progress_(Concat("round: ", round.surfels, " surfels, ", round.observations, " observations, ",
                     round.texture_observations, " texture observations, rms ",
                     1000 * round.before.rms_m, " -> ", 1000 * round.after.rms_m, " mm in ",
                     round.iterations, " steps"));
  }

  void Apply() {
    const std::string doubt =
        CalibrationWarning(run_.info.sensor(), summary_.refinement.calibration);
    if (!doubt.empty()) progress_("warning: " + doubt);
    std::vector<Rigid3d> poses;
    for (const RefinementKeyframe& keyframe : run_.keyframes)
      poses.push_back(keyframe.world_from_camera);
    const Trajectory refined = CorrectTrajectory(run_.trajectory, run_.poses, poses);
    failures_.Try([&] {
      WriteTumTrajectory(InSourceConvention(refined, run_.info.mirrored),
                         options_.output + "/trajectory.txt");
    });
    failures_.Try([&] {
      WriteEstimatedCamera(run_.info, summary_.given.field, summary_.refinement.calibration,
                           options_.output + "/camera.yaml");
    });
    failures_.Try([&] { Evaluate(refined); });
    Trajectory of_frames;
    for (const std::size_t pose : run_.frame_poses) of_frames.push_back(refined[pose]);
    failures_.Try([&] { WritePoses(of_frames); });
    run_.keyframes.clear();
    FuseMap(of_frames);
  }

  void Evaluate(const Trajectory& refined) {
    const Trajectory& truth = run_.info.ground_truth;
    if (truth.empty()) return;
    summary_.before = EvaluateTrajectory(truth, run_.trajectory, run_.stamps_s, {});
    summary_.after = EvaluateTrajectory(truth, refined, run_.stamps_s, {});
  }

  void WritePoses(const Trajectory& refined) {
    const EstimatedSensor found = {summary_.refinement.calibration};
    WritePosesJson({summary_.refinement.calibration.camera,
                    found,
                    refined,
                    run_.frames,
                    refined,
                    TruthDuring(run_.stamps_s, run_.info.ground_truth),
                    summary_.after,
                    {},
                    {},
                    {},
                    {}},
                   options_.output + "/poses.json");
  }

  void FuseMap(const Trajectory& refined) {
    SlamOptions slam;
    slam.preprocess = options_.preprocess;
    const std::set<int> left_out;
    const std::map<int, Image<std::uint8_t>> moving;
    progress_("fusing the map");
    const EstimatedSensor found = {summary_.refinement.calibration};
    const PosedSequence known = {options_.sequence, slam,   refined, run_.frames,
                                 left_out,          moving, found};
    const std::optional<FinalMap> fused =
        IntegrateFinalMap(known, {}, false, [](int, std::size_t) {});
    summary_.map_points = fused->map.size();
    WriteSurfelPly(fused->map, options_.output + "/map.ply");
  }

  RefineRunOptions options_;
  const std::function<void(const std::string&)>& progress_;
  RunKeyframes run_;
  RefineRunSummary summary_;
  Failures failures_;
};

}  // namespace

RefineRunSummary RunRefinement(const RefineRunOptions& options,
                               const std::function<void(const std::string&)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  return RefineRun(options, progress).Run();
}

}  // namespace surfit
