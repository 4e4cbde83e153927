#include "run/poses_json.h"

#include <map>
#include <nlohmann/json.hpp>

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

Json CameraJson(const PinholeCamera& c) {
  return {{"width", c.width}, {"height", c.height}, {"fx", c.fx},
          {"fy", c.fy},       {"cx", c.cx},         {"cy", c.cy}};
}

Json PosesOf(const RunPoses& run) {
  Json poses = Json::array();
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    const StampedPose& pose = run.trajectory[i];
    const Eigen::Vector3d& t = pose.world_from_camera.translation;
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    poses.push_back({run.frames[i], pose.stamp_s, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  }
  return poses;
}

Json TruthOf(const RunPoses& run, const Rigid3d& estimated_from_true) {
  Json truth = Json::array();
  for (const StampedPose& pose : run.truth) {
    const Eigen::Vector3d t = estimated_from_true * pose.world_from_camera.translation;
    truth.push_back({pose.stamp_s, t.x(), t.y(), t.z()});
  }
  return truth;
}

Json ErrorsOf(const RunPoses& run, const Rigid3d& estimated_from_true) {
  std::map<double, int> frame_at;
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    frame_at[run.trajectory[i].stamp_s] = run.frames[i];
  }
  Json errors = Json::array();
  for (const MatchedPose& pose : MatchPoses(run.truth, run.trajectory, MatchOptions())) {
    const Eigen::Vector3d truth = estimated_from_true * pose.ground_truth.translation;
    errors.push_back({frame_at.at(pose.stamp_s), (truth - pose.estimate.translation).norm()});
  }
  return errors;
}

Json ViewsOf(const RunPoses& run) {
  Json views = Json::array();
  for (std::size_t i = 0; i < run.views.size(); ++i) {
    const KeptView& view = run.views[i];
    Json files = Json::object();
    for (const KeptView::Picture& picture : view.pictures) {
      files[picture.name] = KeptViews::FileName(static_cast<int>(i), picture.name);
    }
    views.push_back(
        {{"index", view.index}, {"stamp_s", view.stamp_s}, {"why", view.why}, {"files", files}});
  }
  return views;
}

}  // namespace

void WritePosesJson(const RunPoses& run, const std::string& path) {
  Json j;
  j["camera"] = CameraJson(run.camera);
  j["poses"] = PosesOf(run);
  j["truth"] = nullptr;
  j["errors_m"] = nullptr;
  if (run.evaluation && run.evaluation->ate) {
    const Rigid3d estimated_from_true = run.evaluation->ate->alignment.target_from_source.Inverse();
    j["truth"] = TruthOf(run, estimated_from_true);
    j["errors_m"] = ErrorsOf(run, estimated_from_true);
  }
  j["views"] = ViewsOf(run);
  WriteFileAtomically(path, [&](std::ostream& file) { file << j.dump() << '\n'; });
}

}  // namespace surfit
