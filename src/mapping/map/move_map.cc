#include "surfit/mapping/move_map.h"

#include <algorithm>
#include <array>
#include <utility>

#include "mapping/map/block_lanes.h"
#include "mapping/map/eight_records.h"
#include "surfit/core/error.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Rigid transformation in single precision, as a record for EightRecords: the rows of [R t].
struct MotionRecord {
  explicit MotionRecord(const Rigid3d& motion) {
    const Eigen::Matrix3f rotation = motion.rotation.toRotationMatrix().cast<float>();
    const Eigen::Vector3f translation = motion.translation.cast<float>();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) rows[4 * row + column] = rotation(row, column);
      rows[4 * row + 3] = translation[row];
    }
  }

  float rows[16] = {};  // the last four are 0
};

// Transformations of eight surfels.
template <typename Instructions>
struct EightMotions {
  using V = Lanes<float, Instructions>;

  EightMotions(const std::vector<MotionRecord>& records, const std::size_t (&frames)[8]) {
    for (int part = 0; part < 2; ++part) {
      const float* eight[8];
      for (int j = 0; j < 8; ++j) eight[j] = &records[frames[j]].rows[8 * part];
      EightRecords<Instructions>::Load(eight, parts[part]);
    }
  }

  const V& At(int row, int column) const { return parts[row / 2][4 * (row % 2) + column]; }
  void Rotate(V (&direction)[3]) const {
    const V x = direction[0], y = direction[1], z = direction[2];
    for (int i = 0; i < 3; ++i) direction[i] = At(i, 0) * x + At(i, 1) * y + At(i, 2) * z;
  }
  void Move(V (&point)[3]) const {
    Rotate(point);
    for (int i = 0; i < 3; ++i) point[i] += At(i, 3);
  }

  V parts[2][8];
};

class RigidMoves {
 public:
  explicit RigidMoves(const FrameCorrections& corrections) {
    const MotionRecord none{Rigid3d()};
    for (std::size_t i = 0; i < corrections.size(); ++i) {
      motions_.emplace_back(corrections[i]);
      is_identity_.push_back(std::equal(none.rows, none.rows + 16, motions_.back().rows));
    }
  }

  bool Moves(std::size_t frame) const { return !is_identity_[frame]; }

  // Moves eight surfels. `frames`: index of the correction of each.
  template <typename Instructions>
  void Move(const std::size_t (&frames)[8], Lanes<float, Instructions> (&position)[3],
            Lanes<float, Instructions> (&normal)[3]) const {
    const EightMotions<Instructions> motions(motions_, frames);
    motions.Move(position);
    motions.Rotate(normal);
  }

 private:
  std::vector<MotionRecord> motions_;
  std::vector<bool> is_identity_;
};

// With a = x / z, b = y / z, w = 1 / z, a calibration without distortion maps a surface w(a, b) to
//   a' = ka a + sa,  b' = kb b + sb,  w' = w + change(a, b).
class RecalibratedMoves {
 public:
  RecalibratedMoves(const FrameCorrections& corrections, const Recalibration& recalibration) {
    ThrowIf(corrections.size() != recalibration.world_from_camera.size(), "there are ",
            corrections.size(), " corrections and ", recalibration.world_from_camera.size(),
            " poses of the recalibration, must be equal");
    for (std::size_t i = 0; i < corrections.size(); ++i) {
      const Rigid3d& world_from_old = recalibration.world_from_camera[i];
      old_from_world_.emplace_back(world_from_old.Inverse());
      world_from_new_.emplace_back(corrections[i] * world_from_old);
    }
    const PinholeCamera &from = recalibration.from.camera, &to = recalibration.to.camera;
    const double ka = from.fx / to.fx, kb = from.fy / to.fy;
    const double sa = (from.cx - to.cx) / to.fx, sb = (from.cy - to.cy) / to.fy;
    scale_[0] = static_cast<float>(ka);
    scale_[1] = static_cast<float>(kb);
    shift_[0] = static_cast<float>(sa);
    shift_[1] = static_cast<float>(sb);
    const InverseDepthField field = recalibration.to.field.Substituted(ka, sa, kb, sb);
    for (std::size_t i = 0; i < InverseDepthField::kSize; ++i) {
      change_[i] =
          static_cast<float>(field.coefficients[i] - recalibration.from.field.coefficients[i]);
    }
  }

  static bool Moves(std::size_t /*frame*/) { return true; }

  template <typename Instructions>
  void Move(const std::size_t (&frames)[8], Lanes<float, Instructions> (&position)[3],
            Lanes<float, Instructions> (&normal)[3]) const {
    const EightMotions<Instructions> old_from_world(old_from_world_, frames);
    old_from_world.Move(position);
    old_from_world.Rotate(normal);
    Recalibrate<Instructions>(position, normal);
    const EightMotions<Instructions> world_from_new(world_from_new_, frames);
    world_from_new.Move(position);
    world_from_new.Rotate(normal);
  }

 private:
  // The normal n is proportional to (dw/da, dw/db, w - a dw/da - b dw/db), with the factor n . p.
  template <typename Instructions>
  void Recalibrate(Lanes<float, Instructions> (&position)[3],
                   Lanes<float, Instructions> (&normal)[3]) const {
    using V = Lanes<float, Instructions>;
    constexpr float kMinDepth_m = 0.01f;
    constexpr auto kMinInverse = static_cast<float>(InverseDepthField::kMinInverse);
    const auto& [c0, c1, c2, c3, c4, c5] = change_;
    const auto& [x, y, z] = position;
    const auto& [nx, ny, nz] = normal;
    const V w = V(1.f) / Max(z, V(kMinDepth_m)), a = x * w, b = y * w;
    const V new_w = w + V(c0) + a * (V(c1) + V(c3) * a + V(c4) * b) + b * (V(c2) + V(c5) * b);
    const V new_a = V(scale_[0]) * a + V(shift_[0]), new_b = V(scale_[1]) * b + V(shift_[1]);
    const V factor = nx * x + ny * y + nz * z;
    const V by_a = (nx + factor * (V(c1) + V(2 * c3) * a + V(c4) * b)) / V(scale_[0]);
    const V by_b = (ny + factor * (V(c2) + V(c4) * a + V(2 * c5) * b)) / V(scale_[1]);
    const V rest = factor * new_w - new_a * by_a - new_b * by_b;
    const V length = sqrt(by_a * by_a + by_b * by_b + rest * rest);
    const V new_z = V(1.f) / Max(new_w, V(kMinInverse));
    const V new_position[3] = {new_a * new_z, new_b * new_z, new_z};
    const V new_normal[3] = {by_a / length, by_b / length, rest / length};
    // Merging can move a surfel out of the view of its first frame.
    const auto is_regular = (z >= V(kMinDepth_m)) & (new_w > V(kMinInverse));
    for (int i = 0; i < 3; ++i) {
      position[i] = Select(is_regular, new_position[i], position[i]);
      normal[i] = Select(is_regular, new_normal[i], normal[i]);
    }
  }

  std::vector<MotionRecord> old_from_world_, world_from_new_;
  float scale_[2], shift_[2];
  std::array<float, InverseDepthField::kSize> change_;
};

// Moves the surfels of a block, and collects the surfels that leave the cell.
template <typename Moves>
class BlockMover {
 public:
  BlockMover(const FrameCorrections& corrections, const Moves& moves)
      : corrections_(corrections), moves_(moves) {}

  // Returns how many surfels have moved. Appends the surfels outside of the cell to `strays`: their
  // positions in the block can be clamped.
  int Move(std::int32_t first_id, SurfelBlock* block, std::vector<SurfelMove>* strays) {
    int moved = 0;
    const std::uint64_t outside = WithInstructions([&](auto instructions) {
      for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
        x_[k] = block->X(k);
        y_[k] = block->Y(k);
        z_[k] = block->Z(k);
      }
      for (int k = 0; k < block->count; k += 8) {
        moved += MoveEight<decltype(instructions)>(k, block);
      }
      return Store(block);
    });
    ForEachBit(outside & MaskOfAll(*block) & ~block->to_remove, [&](int k) {
      strays->push_back({first_id + k, {x_[k], y_[k], z_[k]}});
    });
    if (moved > 0) BoundPositions(block);
    return moved;
  }

 private:
  // Moves surfels k to k + 7 of the block, up to its count. Sets the normals.
  template <typename Instructions>
  int MoveEight(int k, SurfelBlock* block) {
    using V = Lanes<float, Instructions>;
    const int count = std::min(8, block->count - k);
    std::size_t frames[8];
    float components[3][8];
    for (int j = 0; j < 8; ++j) {
      const int of = k + std::min(j, count - 1);
      frames[j] = corrections_.IndexOf(block->FirstSeen(of));
      const Eigen::Vector3f normal = block->Normal(of);
      for (int i = 0; i < 3; ++i) components[i][j] = normal[i];
    }
    V position[3] = {V::Load(&x_[k]), V::Load(&y_[k]), V::Load(&z_[k])};
    V normal[3] = {V::Load(components[0]), V::Load(components[1]), V::Load(components[2])};
    moves_.template Move<Instructions>(frames, position, normal);
    int moved = 0;
    for (int j = 0; j < count; ++j) {
      if (!moves_.Moves(frames[j])) continue;
      x_[k + j] = position[0][j];
      y_[k + j] = position[1][j];
      z_[k + j] = position[2][j];
      block->SetNormal(k + j, {normal[0][j], normal[1][j], normal[2][j]});
      ++moved;
    }
    return moved;
  }

  // Sets the positions of the block. Returns the mask of positions outside of its cell.
  std::uint64_t Store(SurfelBlock* block) const {
    constexpr float kLow = 0.5f * SurfelMap::kCellSize, kHigh = 1.5f * SurfelMap::kCellSize;
    PerSurfel<std::uint8_t> is_outside;
    for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
      const float x = x_[k] - block->origin[0], y = y_[k] - block->origin[1],
                  z = z_[k] - block->origin[2];
      block->x[k] = SmallCoordinate::From(x);
      block->y[k] = SmallCoordinate::From(y);
      block->z[k] = SmallCoordinate::From(z);
      is_outside[k] =
          (x < kLow) | (x >= kHigh) | (y < kLow) | (y >= kHigh) | (z < kLow) | (z >= kHigh);
    }
    return MaskOf(is_outside);
  }

  const FrameCorrections& corrections_;
  const Moves& moves_;
  alignas(32) PerSurfel<float> x_, y_, z_;  // positions in the world, m
};

template <typename Moves>
std::size_t MoveCell(const FrameCorrections& corrections, const Moves& moves, std::int32_t index,
                     SurfelMap* map, std::vector<SurfelMove>* strays) {
  BlockMover<Moves> mover(corrections, moves);
  SurfelCell& cell = map->cell(index);
  std::size_t moved = 0;
  for (const std::int32_t b : cell.blocks) {
    moved += mover.Move(b * SurfelBlock::kCapacity, &map->block(b), strays);
  }
  if (moved == 0) return 0;
  cell.bounds = {};
  for (const std::int32_t b : cell.blocks) cell.bounds.Add(map->block(b).bounds);
  return moved;
}

template <typename Moves>
MoveReport MoveAll(const FrameCorrections& corrections, const Moves& moves, SurfelMap* map) {
  std::vector<std::vector<SurfelMove>> of_cell(map->cell_count());
  MoveReport report;
  report.moved = ParallelSum(0, map->cell_count(), 1, std::size_t{0}, [&](int cell, int) {
    return MoveCell(corrections, moves, cell, map, &of_cell[cell]);
  });
  if (report.moved == 0) return report;
  std::vector<SurfelMove> strays;
  for (const auto& some : of_cell) strays.insert(strays.end(), some.begin(), some.end());
  report.changed_cell = map->Relocate(strays);
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
        const std::int64_t last = std::int64_t{block.LastSeen(k)} + frame_shift;
        ThrowIf(last > SurfelBlock::kMaxFrame, "the frame index ", last, " must be at most ",
                SurfelBlock::kMaxFrame);
        block.SetFirstSeen(k, block.FirstSeen(k) + frame_shift);
        block.SetLastSeen(k, block.LastSeen(k) + frame_shift);
        const std::int32_t added = to->Append(block[k]);
        to->block(added / SurfelBlock::kCapacity)
            .Take(added % SurfelBlock::kCapacity, block, k, block.Position(k));
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
        const std::int32_t seen = block.LastSeen(k);
        const bool wakes = seen >= first && seen <= last;
        if (wakes) block.SetLastSeen(k, now);
        woken += wakes;
      }
    }
    return woken;
  });
}

}  // namespace surfit
