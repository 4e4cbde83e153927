#pragma once

#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "finishing/posed_sequence.h"
#include "output/pictures/pictures.h"
#include "run/results/kept_views.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/run/slam_run.h"
#include "surfit/slam/backend.h"

namespace surfit {

// Writes summary.json. Unknown values are null. Throws InputError with the path if writing fails.
void WriteSummaryJson(const SlamRunSummary& summary, const SlamRunOptions& options,
                      const std::string& path);

// Content of poses.json. Poses are in the world frame of the map. References must outlive the
// object.
struct RunPoses {
  const PinholeCamera& camera;
  const EstimatedSensor& found;
  const Trajectory& trajectory;     // estimated poses
  const std::vector<int>& frames;   // frame index of each pose
  const Trajectory& largest_piece;  // part of the trajectory; `evaluation` is for it
  const Trajectory& truth;          // ground truth in its own world frame; empty if unknown
  const std::optional<TrajectoryEvaluation>& evaluation;  // std::nullopt: no ground truth
  const std::vector<KeptView>& views;
  const std::vector<KeptView>& thumbnails;
  const std::vector<KeyframeLink>& keyframes;
  const std::optional<UprightWorld>& upright;  // std::nullopt: unknown
};

// Writes poses.json. Lengths are in metres. Poses are in the world frame of map.ply, which can
// differ from the convention of the sequence that trajectory.txt uses. Content:
//   camera          width height fx fy cx cy, px
//   calibration     estimated calibration of the prepared frames: fx fy cx cy (px),
//                   inverse_depth_field (1/m), readout_s; null: input calibration
//   color_latency_s estimated colour latency beyond the input latency
//   poses           one row per tracked frame: index stamp_s tx ty tz qx qy qz qw, camera-to-world
//   truth           ground-truth positions, aligned to the estimate as for the ATE: stamp_s tx ty
//                   tz; null without an ATE
//   errors_m        position error of each frame of the largest piece with a ground-truth pose:
//                   index, distance; null without an ATE
//   largest_piece   frame indices of the largest piece; null: all poses are of one piece
//   views           one per KeptView: index, stamp_s, why, and files: path by picture name
//   up              unit vector opposite to gravity; null: unknown
//   thumbnails      one per thumbnail, with the keys of `views`
//   keyframes       one row per KeyframeLink: frame, parent_frame (-1: no parent), submap
// Throws InputError naming the file if it cannot be written.
void WritePosesJson(const RunPoses& run, const std::string& path);

// Writes loops.csv: one row per loop candidate of this run, with result and reason. The reason
// `contradicts_others` marks outliers of the pose graph. Throws InputError with the path.
void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path);

// 64-bit FNV-1a hash (Fowler, Noll, Vo).
class Fnv1a {
 public:
  void Add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) {
      hash_ = (hash_ ^ bytes[i]) * 1099511628211u;  // NOLINT: the bytes are initialised
    }
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

// Hash of all poses and surfels as hexadecimal text. Bitwise identical results have the same
// digest.
inline std::string Digest(const Trajectory& trajectory, const SurfelMap& map) {
  Fnv1a hash;
  for (const StampedPose& pose : trajectory) {
    hash.Add(&pose.stamp_s, sizeof(double));
    hash.Add(pose.world_from_camera.translation.data(), 3 * sizeof(double));
    hash.Add(pose.world_from_camera.rotation.coeffs().data(), 4 * sizeof(double));
  }
  for (const std::int32_t id : map.Ids()) {
    const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
    const int k = id % SurfelBlock::kCapacity;
    const Eigen::Vector3f position = block.Position(k);
    const std::int16_t normal[] = {block.nx[k], block.ny[k], block.nz[k]};
    const std::uint16_t shorts[] = {block.radius[k], block.confidence[k], block.red[k],
                                    block.green[k], block.blue[k]};
    const std::int32_t frames[] = {block.FirstSeen(k), block.LastSeen(k)};
    hash.Add(position.data(), 3 * sizeof(float));
    hash.Add(normal, sizeof(normal));
    hash.Add(shorts, sizeof(shorts));
    hash.Add(frames, sizeof(frames));
  }
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash.hash();
  return text.str();
}

}  // namespace surfit
