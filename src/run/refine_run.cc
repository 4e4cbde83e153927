#include "surfit/run/refine_run.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "run/output_files.h"
#include "run/result_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/frame/rolling_shutter.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/frame_source.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/refinement/keyframes.h"
#include "surfit/slam/slam.h"

namespace surfit {
namespace {

constexpr int kReadAhead = 4;
constexpr double kSameStamp = 1e-5;  // s; trajectories have 6 decimals

Trajectory InSourceConvention(Trajectory trajectory, bool mirrored) {
  if (!mirrored) return trajectory;
  for (StampedPose& pose : trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
  return trajectory;
}

// The pose at a frame's stamp.
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
    PrepareOutputFolder(options_.output,
                        {"trajectory.txt", "map.ply", "camera.yaml", "refinement.json"});
    // Frames come with the given field applied.
    summary_.refinement = Refine(options_.refinement, {info_.pinhole, {}}, &keyframes_,
                                 [&](const RefinementRound& round) { Tell(round); });
    summary_.calibration =
        OfMeasuredDepth(info_, summary_.given.field, summary_.refinement.calibration);
    if (summary_.refinement.Succeeded()) Apply();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    summary_.total_s = elapsed.count();
    WriteRefinementJson(summary_, options_, options_.output + "/refinement.json");
    return summary_;
  }

 private:
  void ReadKeyframes() {
    const auto source = ReadAhead(OpenSequence(options_.sequence), kReadAhead);
    info_ = source->info();
    options_.refinement.prior.Complete(info_.camera.prior);
    summary_.given.camera = info_.pinhole;
    summary_.given.field = ReadDepthField(options_.sequence, info_.format);
    given_ = InSourceConvention(ReadTumTrajectory(options_.trajectory), info_.mirrored);
    summary_.poses = given_.size();
    const std::vector<std::size_t> chosen =
        ChooseKeyframes(given_, options_.keyframe_translation_m, options_.keyframe_rotation_rad,
                        options_.max_keyframes);
    while (const std::optional<ReadResult> read = source->Next()) {
      stamps_s_.push_back(read->stamp_s);
      const std::optional<std::size_t> pose = PoseAt(given_, read->stamp_s);
      if (!pose) ++summary_.frames_without_pose;
      if (!read->frame) ++summary_.frames_unreadable;
      if (!pose || !read->frame || !std::binary_search(chosen.begin(), chosen.end(), *pose)) {
        continue;
      }
      keyframe_poses_.push_back(*pose);
      keyframes_.push_back({given_[*pose].world_from_camera,
                            MakeKeyframeImages(Unrolled(*read->frame, given_), info_.sensor(),
                                               options_.preprocess)});
    }
    summary_.keyframes = keyframes_.size();
    if (keyframes_.empty()) {
      throw InputError(Concat(options_.trajectory, " has no pose at a stamp of a frame of ",
                              options_.sequence.path));
    }
    progress_(Concat(keyframes_.size(), " keyframes of ", given_.size(), " poses"));
  }

  // As of the middle of its readout.
  RgbdFrame Unrolled(const RgbdFrame& frame, const Trajectory& trajectory) const {
    return AtMiddleOfReadout(frame, info_.sensor(), MotionAt(trajectory, frame.stamp_s));
  }

  void Tell(const RefinementRound& round) {
    progress_(Concat("round: ", round.surfels, " surfels, ", round.observations, " observations, ",
                     round.texture_observations, " of texture, rms ", 1000 * round.before.rms_m,
                     " -> ", 1000 * round.after.rms_m, " mm in ", round.iterations, " steps"));
  }

  void Apply() {
    std::vector<Rigid3d> poses;
    for (const RefinementKeyframe& keyframe : keyframes_)
      poses.push_back(keyframe.world_from_camera);
    const Trajectory refined = CorrectTrajectory(given_, keyframe_poses_, poses);
    TumTrajectoryWriter writer(options_.output + "/trajectory.txt");
    for (const StampedPose& pose : InSourceConvention(refined, info_.mirrored)) writer.Append(pose);
    WriteFoundCamera(info_, summary_.given.field, summary_.refinement.calibration,
                     options_.output + "/camera.yaml");
    if (!info_.ground_truth.empty()) {
      summary_.before = EvaluateTrajectory(info_.ground_truth, given_, stamps_s_, {});
      summary_.after = EvaluateTrajectory(info_.ground_truth, refined, stamps_s_, {});
    }
    keyframes_.clear();
    FuseMap(refined);
  }

  void FuseMap(const Trajectory& refined) {
    progress_("fusing the map");
    const DepthCalibration& calibration = summary_.refinement.calibration;
    SlamOptions options;
    options.preprocess = options_.preprocess;
    Slam slam({calibration.camera, info_.camera.noise, 0}, options, {});
    const auto source = ReadAhead(OpenSequence(options_.sequence), kReadAhead);
    while (std::optional<ReadResult> read = source->Next()) {
      const std::optional<std::size_t> pose = PoseAt(refined, read->stamp_s);
      if (!pose || !read->frame) continue;
      RgbdFrame frame = Unrolled(*read->frame, refined);
      CorrectDepth(calibration.camera, calibration.field, &frame.depth_m);
      slam.ProcessAt(frame, refined[*pose].world_from_camera);
    }
    summary_.map_points = slam.map().size();
    WriteSurfelPly(slam.map(), options_.output + "/map.ply");
  }

  RefineRunOptions options_;
  const std::function<void(const std::string&)>& progress_;
  SequenceInfo info_;
  Trajectory given_;
  std::vector<double> stamps_s_;             // of all frames
  std::vector<std::size_t> keyframe_poses_;  // indices of given_
  std::vector<RefinementKeyframe> keyframes_;
  RefineRunSummary summary_;
};

}  // namespace

RefineRunSummary RunRefinement(const RefineRunOptions& options,
                               const std::function<void(const std::string&)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  return RefineRun(options, progress).Run();
}

}  // namespace surfit
