#include "surfit/mapping/move_map.h"

#include <algorithm>
#include <utility>

#include "mapping/map/block_lanes.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

class RigidMoves {
 public:
  explicit RigidMoves(const FrameCorrections& corrections) {
    for (std::size_t i = 0; i < corrections.size(); ++i) motions_.emplace_back(corrections[i]);
  }

  bool Moves(std::size_t frame) const { return !motions_[frame].is_identity; }
  void Move(std::size_t frame, Eigen::Vector3f* position, Eigen::Vector3f* normal) const {
    const Motion& motion = motions_[frame];
    *position = motion.rotation * *position + motion.translation;
    *normal = (motion.rotation * *normal).normalized();
  }

 private:
  struct Motion {
    explicit Motion(const Rigid3d& new_from_old)
        : rotation(new_from_old.rotation.toRotationMatrix().cast<float>()),
          translation(new_from_old.translation.cast<float>()),
          is_identity(rotation == Eigen::Matrix3f::Identity() && translation.isZero(0)) {}

    Eigen::Matrix3f rotation;
    Eigen::Vector3f translation;
    bool is_identity;
  };
  std::vector<Motion> motions_;
};

class RecalibratedMoves {
 public:
  RecalibratedMoves(const FrameCorrections& corrections, const Recalibration& recalibration)
      : recalibration_(recalibration) {
    ThrowIf(corrections.size() != recalibration.world_from_camera.size(), "there are ",
            corrections.size(), " corrections and ", recalibration.world_from_camera.size(),
            " poses of the recalibration, must be equal");
    for (std::size_t i = 0; i < corrections.size(); ++i) {
      const Rigid3d& world_from_old = recalibration.world_from_camera[i];
      frames_.push_back({world_from_old.Inverse(), corrections[i] * world_from_old});
    }
  }

  static bool Moves(std::size_t /*frame*/) { return true; }
  void Move(std::size_t frame, Eigen::Vector3f* position, Eigen::Vector3f* normal) const {
    constexpr double kMinDepthM = 0.01;
    const Frame& f = frames_[frame];
    const Eigen::Vector3d old_point = f.old_from_world * position->cast<double>();
    const Eigen::Vector3d old_normal = f.old_from_world.rotation * normal->cast<double>();
    // Merging can move a surfel out of the view of its first frame. Such a surfel moves rigidly
    // with the frame.
    if (old_point.z() < kMinDepthM) {
      *position = (f.world_from_new * old_point).cast<float>();
      *normal = (f.world_from_new.rotation * old_normal).cast<float>();
      return;
    }
    *position = (f.world_from_new * Moved(old_point)).cast<float>();
    *normal = (f.world_from_new.rotation * MovedNormal(old_point, old_normal)).cast<float>();
  }

 private:
  struct Frame {
    Rigid3d old_from_world, world_from_new;
  };

  Eigen::Vector3d Moved(const Eigen::Vector3d& point) const {
    return Recalibrated(point, recalibration_.from, recalibration_.to);
  }
  Eigen::Vector3d MovedNormal(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
    const double step_m = 1e-3 * point.z();
    const Eigen::Vector3d a = step_m * normal.unitOrthogonal(), b = normal.cross(a);
    const Eigen::Vector3d moved_a = Moved(point + a) - Moved(point - a);
    return moved_a.cross(Moved(point + b) - Moved(point - b)).normalized();
  }

  const Recalibration& recalibration_;
  std::vector<Frame> frames_;
};

template <typename Moves>
void MoveSurfel(const Moves& moves, std::size_t frame, int k, SurfelBlock* block) {
  Eigen::Vector3f position = block->Position(k), normal = block->Normal(k);
  moves.Move(frame, &position, &normal);
  block->SetPosition(k, position);
  block->SetNormal(k, normal);
}

template <typename Moves>
std::size_t MoveBlock(const FrameCorrections& corrections, const Moves& moves, SurfelBlock* block) {
  std::size_t moved = 0;
  for (int k = 0; k < block->count; ++k) {
    const std::size_t frame = corrections.IndexOf(block->first_seen[k]);
    if (!moves.Moves(frame)) continue;
    MoveSurfel(moves, frame, k, block);
    ++moved;
  }
  if (moved > 0) BoundPositions(block);
  return moved;
}

template <typename Moves>
std::size_t MoveCell(const FrameCorrections& corrections, const Moves& moves, std::int32_t index,
                     SurfelMap* map) {
  SurfelCell& cell = map->cell(index);
  std::size_t moved = 0;
  for (const std::int32_t b : cell.blocks) moved += MoveBlock(corrections, moves, &map->block(b));
  if (moved == 0) return 0;
  cell.bounds = {};
  for (const std::int32_t b : cell.blocks) cell.bounds.Add(map->block(b).bounds);
  return moved;
}

template <typename Moves>
MoveReport MoveAll(const FrameCorrections& corrections, const Moves& moves, SurfelMap* map) {
  MoveReport report;
  report.moved = ParallelSum(0, map->cell_count(), 1, std::size_t{0}, [&](int cell, int) {
    return MoveCell(corrections, moves, cell, map);
  });
  if (report.moved > 0) report.changed_cell = map->ReassignCells();
  return report;
}

}  // namespace

FrameCorrections::FrameCorrections(int first_frame, std::vector<Rigid3d> new_from_old_world)
    : first_frame_(first_frame), new_from_old_world_(std::move(new_from_old_world)) {
  ThrowIf(new_from_old_world_.empty(), "there are no corrections, must be at least 1");
}

std::size_t FrameCorrections::IndexOf(int frame) const {
  if (frame <= first_frame_) return 0;
  return std::min(static_cast<std::size_t>(frame - first_frame_), new_from_old_world_.size() - 1);
}

MoveReport MoveMap(const FrameCorrections& corrections, SurfelMap* map) {
  return MoveAll(corrections, RigidMoves(corrections), map);
}

MoveReport MoveMap(const FrameCorrections& corrections, const Recalibration& recalibration,
                   SurfelMap* map) {
  return MoveAll(corrections, RecalibratedMoves(corrections, recalibration), map);
}

void AppendSurfels(const SurfelMap& from, int frame_shift, SurfelMap* to) {
  for (std::int32_t c = 0; c < from.cell_count(); ++c) {
    for (const std::int32_t b : from.cell(c).blocks) {
      SurfelBlock block = from.block(b);
      for (int k = 0; k < block.count; ++k) {
        block.first_seen[k] += frame_shift;
        block.last_seen[k] += frame_shift;
        const std::int32_t added = to->Append(block[k]);
        to->block(added / SurfelBlock::kCapacity).Take(added % SurfelBlock::kCapacity, block, k);
      }
    }
  }
}

std::size_t ReactivateSurfels(int first, int last, int now, SurfelMap* map) {
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
