#include "run/results/run_files.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <optional>
#include <sstream>
#include <utility>

#include "core/files.h"
#include "output/recorded_run.h"
#include "run/results/kept_views.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

std::vector<std::string> RunFileNames() {
  std::vector<std::string> names = {"trajectory.txt",    "trajectory_online.txt",
                                    "loops.csv",         "frames.csv",
                                    "localization.csv",  "map.ply",
                                    "summary.json",      "poses.json",
                                    "trajectory.png",    "map_color.png",
                                    "map_normals.png",   "map_confidence.png",
                                    "map_last_seen.png", "camera.yaml",
                                    "places.bin",        "report.html"};
  for (const std::string& name : KeptViews::FileNames()) names.push_back(name);
  for (const std::string& name : Thumbnails::FileNames()) names.push_back(name);
  for (const std::string& name : ViewFileNames()) names.push_back(name);
  return names;
}

RunTrajectory::RunTrajectory(const std::string& folder, bool mirrored)
    : mirrored_(mirrored),
      path_(folder + "/trajectory.txt"),
      file_(path_),
      online_(folder + "/trajectory_online.txt") {}

void RunTrajectory::Add(const FrameReport& report) {
  if (report.confirmed) {
    Append(report.confirmed->index,
           {report.confirmed->stamp_s, report.confirmed->world_from_camera});
  }
  if (!report.HasPose()) return;
  const StampedPose pose = {report.stamp_s, report.world_from_camera};
  Append(report.index, pose);
  online_.Append(InSourceConvention(pose));
}

void RunTrajectory::Append(int index, const StampedPose& pose) {
  poses_.push_back(pose);
  frames_.push_back(index);
  file_.Append(InSourceConvention(pose));
}

void RunTrajectory::Replace(Trajectory corrected) {
  poses_ = std::move(corrected);
  const std::size_t count = std::min(poses_.size(), frames_.size());
  poses_.resize(count);
  frames_.resize(count);
  is_replaced_ = true;
}

void RunTrajectory::Insert(const std::vector<PoseBetween>& found) {
  for (const PoseBetween& pose : found) {
    const auto at = std::lower_bound(frames_.begin(), frames_.end(), pose.frame);
    poses_.insert(poses_.begin() + (at - frames_.begin()), {pose.stamp_s, pose.world_from_camera});
    frames_.insert(at, pose.frame);
  }
  is_replaced_ = is_replaced_ || !found.empty();
}

void RunTrajectory::Finish() const {
  if (!is_replaced_) return;
  Trajectory written = poses_;
  for (StampedPose& pose : written) pose = InSourceConvention(pose);
  WriteTumTrajectory(written, path_);
}

StampedPose RunTrajectory::InSourceConvention(StampedPose pose) const {
  if (mirrored_) pose.world_from_camera = Mirrored(pose.world_from_camera);
  return pose;
}

namespace {

// Names of the upper triangle of FrameReport::covariance, row by row. Each begins with a comma.
std::string CovarianceNames() {
  std::string names;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) names += Concat(",cov_", i, j);
  }
  return names;
}

void AppendCovariance(const std::optional<Matrix6d>& covariance, std::ostringstream* row) {
  *row << std::scientific << std::setprecision(6);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      *row << ',';
      if (covariance) *row << (*covariance)(i, j);
    }
  }
}

}  // namespace

FrameTable::FrameTable(const std::string& folder) : path_(folder + "/frames.csv"), file_(path_) {
  file_.Append(
      "index,stamp_s,state,fused,termination,iterations,inliers,inlier_ratio,rmse_m,"
      "smallest_eigenvalue,moving_ratio,two_motions,points,merged_points,merged,added,removed,"
      "read_ms,preprocess_ms,predict_ms,track_ms,fuse_ms,correct_ms,frame_ms,keyframe" +
      CovarianceNames() + '\n');
}

void FrameTable::Add(const FrameReport& report, double read_ms, double frame_ms) {
  const bool registered = !report.icp.iterations.empty();
  std::ostringstream row;
  row << report.index << ',' << std::fixed << std::setprecision(6) << report.stamp_s << ','
      << ToString(report.state) << ',' << report.is_fused << ','
      << (registered ? ToString(report.icp.termination) : "") << ',' << report.icp.step_count << ','
      << report.icp.inlier_count << ',' << report.icp.inlier_ratio << ',' << report.icp.rmse_m
      << ',' << std::scientific << report.icp.eigenvalues[0] << ',' << std::fixed
      << report.moving_ratio << ',' << report.has_two_motions << ',' << report.fusion.input_points
      << ',' << report.fusion.merged_points << ',' << report.fusion.merged << ','
      << report.fusion.added << ',' << report.fusion.removed << ',' << std::setprecision(3)
      << read_ms << ',' << report.times.preprocess_ms << ',' << report.times.predict_ms << ','
      << report.times.track_ms << ',' << report.times.fuse_ms << ',' << report.times.correct_ms
      << ',' << frame_ms << ',';
  if (report.keyframe >= 0) row << report.keyframe;
  AppendCovariance(report.covariance, &row);
  row << '\n';
  file_.Append(row.str());
}

void FrameTable::AddSkipped(const ReadResult& result, double frame_ms) {
  std::ostringstream row;
  row << result.index << ',' << std::fixed << std::setprecision(6) << result.stamp_s
      << ",skipped,0,,0,0,0,0,0,0,0,0,0,0,0,0," << std::setprecision(3) << result.read_ms
      << ",0,0,0,0,0," << frame_ms << ',';
  AppendCovariance(std::nullopt, &row);
  row << '\n';
  file_.Append(row.str());
}

void FrameTable::MarkFound(const std::vector<int>& frames) {
  if (frames.empty() || !std::filesystem::is_regular_file(path_)) return;
  std::istringstream rows(ReadFile(path_));
  std::ostringstream marked;
  std::string row;
  while (std::getline(rows, row)) {
    const std::size_t index_end = row.find(','), state = row.find(",lost,");
    const bool is_found = state != std::string::npos &&
                          std::binary_search(frames.begin(), frames.end(),
                                             std::atoi(row.substr(0, index_end).c_str()));
    marked << (is_found ? row.replace(state, 6, ",between,") : row) << '\n';
  }
  WriteFileAtomically(path_, [&](std::ostream& out) { out << marked.str(); });
}

}  // namespace surfit
