#pragma once

#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "finishing/known_sequence.h"
#include "run/results/kept_views.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/run/slam_run.h"
#include "surfit/slam/backend.h"

namespace surfit {

// Writes summary.json: what is known of the run, null where it is not. Throws InputError naming
// the file if it cannot be written.
void WriteSummaryJson(const SlamRunSummary& summary, const SlamRunOptions& options,
                      const std::string& path);

// Where a run's cameras were, in the frame of its map.
struct RunPoses {
  const PinholeCamera& camera;
  const FoundSensor& found;        // of the frames as they are read
  const Trajectory& trajectory;    // as estimated
  const std::vector<int>& frames;  // of the trajectory's poses: the frames' indices
  const Trajectory& truth;         // in its own world; empty if unknown
  const std::optional<TrajectoryEvaluation>& evaluation;
  const std::vector<KeptView>& views;
  const std::vector<KeptView>& thumbnails;
  const std::vector<KeyframeLink>& keyframes;
};

// Writes, in metres and in the frame of map.ply (trajectory.txt is in the sequence's own):
//   camera          width height fx fy cx cy, pixels
//   calibration     what the run found of the frames as they are read: fx fy cx cy, pixels,
//                   inverse_depth_field, 1/m, readout_s; null where the camera is as given
//   color_latency_s by how much colour was found to be earlier than the frames have it
//   poses           of each tracked frame: index stamp_s tx ty tz qx qy qz qw, camera-to-world
//   truth           positions of the ground truth, moved onto the estimate as for ATE: stamp_s tx
//                   ty tz; null where unknown, or where nothing says how to move it
//   errors_m        of each frame with a true pose: index, distance from that position; or null
//   views           of each KeptView: index, stamp_s, and files: picture's name to path
//   thumbnails      the same of Thumbnails
//   keyframes       of each KeyframeLink: frame, parent_frame (-1: none), submap
// Throws InputError naming the file if it cannot be written.
void WritePosesJson(const RunPoses& run, const std::string& path);

// Writes all loops that were tried, one per line, with the figures and the reason of the verdict.
// The pose graph may have overruled a verdict. Loops of earlier runs of a session are left out.
// Throws InputError naming the file.
void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path);

// The 64-bit FNV-1a hash (Fowler, Noll, Vo).
class Fnv1a {
 public:
  void Add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) {
      hash_ = (hash_ ^ bytes[i]) * 1099511628211u;  // NOLINT: the bytes are set
    }
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

// The hash of a trajectory's and a map's bytes, in hexadecimal.
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
    const float numbers[] = {block.x[k], block.y[k], block.z[k], block.confidence[k]};
    const std::int16_t normal[] = {block.nx[k], block.ny[k], block.nz[k]};
    const std::uint16_t shorts[] = {block.radius[k], block.red[k], block.green[k], block.blue[k]};
    const std::int32_t frames[] = {block.first_seen[k], block.last_seen[k]};
    hash.Add(numbers, sizeof(numbers));
    hash.Add(normal, sizeof(normal));
    hash.Add(shorts, sizeof(shorts));
    hash.Add(frames, sizeof(frames));
  }
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash.hash();
  return text.str();
}

}  // namespace surfit
