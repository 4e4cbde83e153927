#include "mesh/surface/cell_patches.h"

namespace surfit {
namespace {

constexpr int kFaces = 6;

int EdgeBetween(int corner, int other) {
  const int axis = (corner ^ other) == 1 ? 0 : (corner ^ other) == 2 ? 1 : 2;
  const int k = (corner >> (axis + 1) % 3 & 1) | (corner >> (axis + 2) % 3 & 1) << 1;
  return 4 * axis + k;
}

class Tracer {
 public:
  explicit Tracer(int pattern) : pattern_(pattern) {
    for (auto& next : next_) next = {-1, -1};
    for (int face = 0; face < kFaces; ++face) LinkFace(face);
  }

  CellPatches Trace() const {
    CellPatches patches;
    patches.of_edge.fill(CellPatches::kNone);
    for (int start = 0; start < CellPatches::kEdges; ++start) {
      if (next_[start][0] < 0 || patches.of_edge[start] != CellPatches::kNone) continue;
      int edge = start;
      while (edge >= 0) {  // visits all edges of one cycle
        patches.of_edge[edge] = patches.count;
        int following = -1;
        for (const int next : next_[edge]) {
          if (patches.of_edge[next] == CellPatches::kNone) following = next;
        }
        edge = following;
      }
      ++patches.count;
    }
    return patches;
  }

 private:
  bool IsBehind(int corner) const { return pattern_ >> corner & 1; }

  void Link(int edge, int other) {
    next_[edge][next_[edge][0] < 0 ? 0 : 1] = other;
    next_[other][next_[other][0] < 0 ? 0 : 1] = edge;
  }

  void LinkFace(int face) {
    const int axis = face % 3, base = face < 3 ? 0 : 1 << axis;
    const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
    const std::array<int, 4> around = {base, base + u, base + u + v, base + v};
    std::array<int, 4> cut = {};
    int count = 0;
    for (int i = 0; i < 4; ++i) {
      const int corner = around[i], other = around[(i + 1) % 4];
      if (IsBehind(corner) != IsBehind(other)) cut[count++] = EdgeBetween(corner, other);
    }
    if (count == 2) Link(cut[0], cut[1]);
    if (count != 4) return;
    // Edges i - 1 and i of the face share corner i.
    const int first = IsBehind(around[0]) ? 0 : 1;
    Link(cut[(first + 3) % 4], cut[first]);
    Link(cut[first + 1], cut[first + 2]);
  }

  int pattern_;
  // Neighbours of each cut edge on its two faces; -1: the edge is not cut.
  std::array<std::array<int, 2>, CellPatches::kEdges> next_;
};

}  // namespace

const std::array<CellPatches, 256>& AllCellPatches() {
  static const auto all = [] {
    std::array<CellPatches, 256> patches;
    for (int pattern = 0; pattern < 256; ++pattern) patches[pattern] = Tracer(pattern).Trace();
    return patches;
  }();
  return all;
}

}  // namespace surfit
