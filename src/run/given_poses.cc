#include "run/given_poses.h"

#include <sstream>

#include "surfit/core/error.h"
#include "surfit/geometry/mirror.h"
#include "surfit/io/tum_trajectory.h"

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
    throw InputError(Concat("initial_pose is 'groundtruth', but the sequence has no true pose at ",
                            std::to_string(first_stamp_s), " s"));
  }
  const Rigid3d pose = ParsePose("initial_pose", initial_pose);
  return info.mirrored ? Mirrored(pose) : pose;
}

Trajectory ReadEstimate(const std::string& path, const SequenceInfo& info) {
  Trajectory trajectory = ReadTumTrajectory(path);
  if (info.mirrored) {
    for (StampedPose& pose : trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
  }
  return trajectory;
}

}  // namespace surfit
