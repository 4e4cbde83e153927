#include "surfit/mapping/move_map.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "mapping/block_lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// A correction in single precision, as it is applied to hundreds of thousands of surfels.
struct Motion {
  explicit Motion(const Rigid3d& new_from_old)
      : rotation(new_from_old.rotation.toRotationMatrix().cast<float>()),
        translation(new_from_old.translation.cast<float>()),
        is_identity(rotation == Eigen::Matrix3f::Identity() && translation.isZero(0)) {}

  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  bool is_identity;
};

void MoveSurfel(const Motion& motion, int k, SurfelBlock* block) {
  const Eigen::Vector3f position(block->x[k], block->y[k], block->z[k]);
  const Eigen::Vector3f normal(block->nx[k], block->ny[k], block->nz[k]);
  const Eigen::Vector3f p = motion.rotation * position + motion.translation;
  const Eigen::Vector3f n = (motion.rotation * normal).normalized();
  block->x[k] = p.x();
  block->y[k] = p.y();
  block->z[k] = p.z();
  block->nx[k] = n.x();
  block->ny[k] = n.y();
  block->nz[k] = n.z();
}

// Returns how many have moved.
std::size_t MoveBlock(const FrameCorrections& corrections, const std::vector<Motion>& motions,
                      SurfelBlock* block) {
  std::size_t moved = 0;
  for (int k = 0; k < block->count; ++k) {
    const Motion& motion = motions[corrections.IndexOf(block->first_seen[k])];
    if (motion.is_identity) continue;
    MoveSurfel(motion, k, block);
    ++moved;
  }
  if (moved > 0) BoundPositions(block);
  return moved;
}

std::size_t MoveCell(const FrameCorrections& corrections, const std::vector<Motion>& motions,
                     std::int32_t index, SurfelMap* map) {
  SurfelCell& cell = map->cell(index);
  std::size_t moved = 0;
  for (const std::int32_t b : cell.blocks) {
    moved += MoveBlock(corrections, motions, &map->block(b));
  }
  if (moved == 0) return 0;
  cell.bounds = {};
  for (const std::int32_t b : cell.blocks) cell.bounds.Add(map->block(b).bounds);
  return moved;
}

}  // namespace

FrameCorrections::FrameCorrections(int first_frame, std::vector<Rigid3d> new_from_old_world)
    : first_frame_(first_frame), new_from_old_world_(std::move(new_from_old_world)) {
  CHECK(!new_from_old_world_.empty());
}

std::size_t FrameCorrections::IndexOf(int frame) const {
  if (frame <= first_frame_) return 0;
  return std::min(static_cast<std::size_t>(frame - first_frame_), new_from_old_world_.size() - 1);
}

MoveReport MoveMap(const FrameCorrections& corrections, SurfelMap* map) {
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < corrections.size(); ++i) motions.emplace_back(corrections[i]);
  MoveReport report;
  report.moved = ParallelSum(0, map->cell_count(), 1, std::size_t{0}, [&](int cell, int) {
    return MoveCell(corrections, motions, cell, map);
  });
  if (report.moved > 0) report.changed_cell = map->Rehome();
  return report;
}

std::size_t WakeSurfels(int first, int last, int now, SurfelMap* map) {
  return ParallelSum(0, map->cell_count(), 1, std::size_t{0}, [&](int cell, int) {
    std::size_t woken = 0;
    for (const std::int32_t b : map->cell(cell).blocks) {
      SurfelBlock& block = map->block(b);
      for (int k = 0; k < block.count; ++k) {
        const bool wakes = block.last_seen[k] >= first && block.last_seen[k] <= last;
        if (wakes) block.last_seen[k] = now;
        woken += wakes;
      }
    }
    return woken;
  });
}

}  // namespace surfit
