#include "run/posed_views.h"

#include <cmath>
#include <memory>
#include <sstream>
#include <utility>

#include "surfit/core/error.h"
#include "surfit/evaluation/error_statistics.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/registration/association.h"

namespace surfit {

Rigid3d ParsePose(const std::string& option, const std::string& text) {
  std::istringstream stream(text);
  double value[7];
  for (int i = 0; i < 7; ++i) {
    if (i > 0 && stream.get() != ',') stream.setstate(std::ios::failbit);
    stream >> value[i];
  }
  const bool complete = stream && stream.peek() == std::char_traits<char>::eof();
  const Eigen::Quaterniond rotation(value[6], value[3], value[4], value[5]);
  if (!complete || !(rotation.norm() > 1e-6)) {
    throw InputError(Concat(option, " is '", text, "', must be tx,ty,tz,qx,qy,qz,qw"));
  }
  return Rigid3d(rotation.normalized(), {value[0], value[1], value[2]});
}

Rigid3d InitialPose(const std::string& initial_pose, const SequenceInfo& info,
                    double first_stamp_s) {
  if (initial_pose == "identity") return Rigid3d();
  if (initial_pose == "groundtruth") {
    const std::optional<Rigid3d> pose = InterpolatePose(info.ground_truth, first_stamp_s);
    if (pose) return *pose;
    throw InputError(
        Concat("initial_pose is 'groundtruth', but the sequence has no ground-truth pose at ",
               std::to_string(first_stamp_s), " s"));
  }
  const Rigid3d pose = ParsePose("initial_pose", initial_pose);
  return info.mirrored ? Mirrored(pose) : pose;
}

Trajectory ReadEstimate(const std::string& path, const SequenceInfo& info) {
  return InConvention(ReadTumTrajectory(path), info);
}

Trajectory InConvention(Trajectory trajectory, const SequenceInfo& info) {
  if (info.mirrored) {
    for (StampedPose& pose : trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
  }
  return trajectory;
}

PosedView ReadPosedView(const SequenceOptions& options, int index,
                        const PreprocessOptions& preprocess) {
  SequenceOptions sequence = options;
  sequence.first = sequence.last = index;
  sequence.stride = 1;
  const std::unique_ptr<FrameSource> source = OpenSequence(sequence);
  std::optional<ReadResult> result = source->Next();
  if (!result) throw InputError(Concat(sequence.path, ": there is no frame ", index));
  if (!result->frame) throw InputError(result->error);
  PosedView posed;
  posed.view.pyramid = PreprocessDepth(result->frame->depth_m, source->info().sensor(), preprocess);
  posed.view.color = std::move(result->frame->color);
  posed.world_from_camera = InterpolatePose(source->info().ground_truth, result->stamp_s);
  return posed;
}

std::optional<Rigid3d> PosedPair::TargetFromSource() const {
  if (!source.world_from_camera || !target.world_from_camera) return std::nullopt;
  return target.world_from_camera->Inverse() * *source.world_from_camera;
}

PosedPair ReadPosedPair(const SequenceOptions& options, int source, int target,
                        const PreprocessOptions& preprocess, const ErrorModel& error_model) {
  PosedPair pair = {ReadPosedView(options, source, preprocess),
                    ReadPosedView(options, target, preprocess)};
  if (error_model.UsesIntensities()) {
    for (PosedView* posed : {&pair.source, &pair.target}) {
      AddIntensity(posed->view.color, &posed->view.pyramid);
    }
  }
  return pair;
}

std::optional<double> MedianSurfaceDistance(const FrameLevel& source, const FrameLevel& target,
                                            const Rigid3d& target_from_source) {
  const ProjectiveAssociation association(source, target, AssociationGates(), ErrorModel());
  const PairBuffer pairs = association.Collect(target_from_source);
  std::vector<double> distances;
  for (int i = 0; i < pairs.size; ++i) {
    distances.push_back(std::abs(pairs.n(i).dot(pairs.p(i) - pairs.q(i))));
  }
  if (distances.empty()) return std::nullopt;
  return Summarize(std::move(distances)).median;
}

Trajectory TruthDuring(const std::vector<double>& stamps_s, const Trajectory& ground_truth) {
  const double kMarginSeconds = MatchOptions().max_gap_s;
  Trajectory truth;
  for (const StampedPose& pose : ground_truth) {
    if (pose.stamp_s >= stamps_s.front() - kMarginSeconds &&
        pose.stamp_s <= stamps_s.back() + kMarginSeconds) {
      truth.push_back(pose);
    }
  }
  return truth;
}

}  // namespace surfit
