#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mesh/mesh_steps.h"
#include "mesh/surface/cell_patches.h"
#include "surfit/core/parallel.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {
namespace {

constexpr int kMeshBlocksPerTask = 8;
constexpr int kBlockSide = DistanceField::kSide, kWideSide = DistanceField::kWide;
constexpr std::uint16_t kNoVertex = 0xffff;

struct SurfaceVertex {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f normal;    // before refinement: approximate direction to the observed side
  Rgb8 color;
  bool is_supported = false;  // a surfel with the same orientation is near
};

struct Around {
  float weight = 0, height = 0;  // sum of weights; weighted sum of signed plane distances, m
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float color_weight = 0;
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  bool is_supported = false;

  float Distance() const { return weight > 0 ? height / weight : 0; }
};

// Refines vertices by nearby surfels. Not thread-safe: use one object per thread.
class VertexRefiner {
 public:
  VertexRefiner(const DistanceField& field, const SurfelCubes& surfels)
      : field_(field), surfels_(surfels) {}

  void Refine(std::vector<SurfaceVertex>* vertices) {
    if (vertices->empty()) return;
    Eigen::Vector3f low = vertices->front().position, high = low;
    for (const SurfaceVertex& vertex : *vertices) {
      low = low.cwiseMin(vertex.position);
      high = high.cwiseMax(vertex.position);
    }
    const Eigen::Vector3f margin =
        Eigen::Vector3f::Constant(field_.support_m() + field_.cell_m() / 2);
    surfels_.FindWithin(low - margin, high + margin, &ranges_);
    for (SurfaceVertex& vertex : *vertices) Refine(&vertex);
  }

 private:
  Around LookAround(const Eigen::Vector3f& place) const {
    Around around;
    for (const SurfelCubes::Range& range : ranges_) {
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const MeshSurfel& surfel = surfels_.surfels()[i];
        const Eigen::Vector3f offset = place - surfel.position;
        const float square = offset.squaredNorm();
        const SurfelKernel kernel(surfel, field_.SupportOf(surfel));
        const float weight = kernel.Weight(square);
        if (!(weight > 0)) continue;
        const float height = surfel.normal.dot(offset);
        around.weight += weight;
        around.height += weight * height;
        around.normal += weight * surfel.normal;
        // Colours vary faster than heights, so their weights are concentrated on near surfels.
        const float share = 1 - square * kernel.per_square;
        const float color_weight = weight * share * share * share * share;
        around.color_weight += color_weight;
        around.color +=
            color_weight * Eigen::Vector3f(surfel.color.r, surfel.color.g, surfel.color.b);
        if (std::abs(height) <= field_.cell_m() &&
            square - height * height <= surfel.reach_m * surfel.reach_m)
          around.is_supported = true;
      }
    }
    return around;
  }

  void Refine(SurfaceVertex* vertex) const {
    const float most_m = field_.cell_m() / 2;
    const Eigen::Vector3f first = vertex->position, seen_side = vertex->normal;
    Around around = LookAround(first);
    for (int i = 0; i < 2; ++i) {
      vertex->normal = around.normal.normalized();
      const Eigen::Vector3f moved = vertex->position - around.Distance() * vertex->normal;
      const Eigen::Vector3f offset = moved - first;
      vertex->position = first + offset * std::min(1.f, most_m / std::max(offset.norm(), most_m));
      around = LookAround(vertex->position);
    }
    vertex->normal = around.normal.normalized();
    const Eigen::Vector3f color =
        around.color / std::max(around.color_weight, std::numeric_limits<float>::min());
    vertex->color = ToRgb8(color);
    vertex->is_supported = around.is_supported && vertex->normal.dot(seen_side) > 0;
  }

  const DistanceField& field_;
  const SurfelCubes& surfels_;
  std::vector<SurfelCubes::Range> ranges_;
};

struct BlockMesh {
  std::array<std::uint16_t, DistanceField::kPoints> first;
  std::vector<SurfaceVertex> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
  std::uint32_t begin = 0;
};

int WideIndex(const Cube& point) {
  return ((point.z() + 1) * kWideSide + point.y() + 1) * kWideSide + point.x() + 1;
}
int CellIndex(const Cube& cell) {
  return (cell.z() * kBlockSide + cell.y()) * kBlockSide + cell.x();
}
Cube Corner(int c) { return {c & 1, c >> 1 & 1, c >> 2}; }

struct Cell {
  std::array<float, CellPatches::kCorners> values;
  int pattern = 0;  // bit c: the value of corner c is negative
  bool is_known = true;

  Cell(const DistanceField::WideBlock& field, const Cube& at) {
    for (int c = 0; c < CellPatches::kCorners; ++c) {
      values[c] = field[WideIndex(at + Corner(c))];
      is_known = is_known && !std::isnan(values[c]);
      pattern |= (values[c] < 0 ? 1 : 0) << c;
    }
  }
  bool IsCut() const { return is_known && pattern != 0 && pattern != 255; }

  // Mean of the zero crossings of a patch, relative to corner 0, in cell sides.
  Eigen::Vector3f MiddleOf(const CellPatches& patches, int patch) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
    for (int e = 0; e < CellPatches::kEdges; ++e) {
      if (patches.of_edge[e] != patch) continue;
      const int axis = e / 4, from = EdgeCorner(axis, e % 4), to = from | 1 << axis;
      Eigen::Vector3f place = Corner(from).cast<float>();
      place[axis] += values[from] / (values[from] - values[to]);
      sum += place;
      ++count;
    }
    return sum / static_cast<float>(count);
  }

  Eigen::Vector3f Gradient() const {
    Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
    for (int c = 0; c < CellPatches::kCorners; ++c)
      gradient += values[c] * (2 * Corner(c) - Cube::Ones()).cast<float>();
    return gradient;
  }
};

void FindVertices(const DistanceField& field, int block, const DistanceField::WideBlock& values,
                  BlockMesh* mesh) {
  const auto& patches_of = AllCellPatches();
  const Cube origin = kBlockSide * field.BlockAt(block);
  mesh->first.fill(kNoVertex);
  for (int z = 0; z < kBlockSide; ++z) {
    for (int y = 0; y < kBlockSide; ++y) {
      for (int x = 0; x < kBlockSide; ++x) {
        const Cube at(x, y, z);
        const Cell cell(values, at);
        if (!cell.IsCut()) continue;
        mesh->first[CellIndex(at)] = static_cast<std::uint16_t>(mesh->vertices.size());
        const CellPatches& patches = patches_of[cell.pattern];
        for (int p = 0; p < patches.count; ++p) {
          SurfaceVertex vertex;
          vertex.position = field.PointAt(origin + at) + field.cell_m() * cell.MiddleOf(patches, p);
          vertex.normal = cell.Gradient();
          mesh->vertices.push_back(vertex);
        }
      }
    }
  }
}

class QuadBuilder {
 public:
  QuadBuilder(const DistanceField& field, std::vector<BlockMesh>* blocks)
      : field_(field), blocks_(*blocks) {}

  void Join(int block, const DistanceField::WideBlock& values) {
    const Cube own = field_.BlockAt(block);
    for (int k = 0; k < 8; ++k)
      around_[k] = k == 7 ? block : field_.FindBlock(own - Cube::Ones() + Corner(k));
    for (int z = 0; z < kBlockSide; ++z)
      for (int y = 0; y < kBlockSide; ++y)
        for (int x = 0; x < kBlockSide; ++x)
          for (int axis = 0; axis < 3; ++axis) JoinAround({x, y, z}, axis, values, &blocks_[block]);
  }

 private:
  struct Place {
    std::uint32_t index = 0;
    const SurfaceVertex* vertex = nullptr;
  };

  // Adds the quad around a grid edge if the edge is cut.
  void JoinAround(const Cube& point, int axis, const DistanceField::WideBlock& values,
                  BlockMesh* mesh) const {
    const float from = values[WideIndex(point)];
    const float to = values[WideIndex(point + Cube::Unit(axis))];
    if (std::isnan(from) || std::isnan(to) || (from < 0) == (to < 0)) return;
    const Cube u = Cube::Unit((axis + 1) % 3), v = Cube::Unit((axis + 2) % 3);
    const std::array<Cube, 4> cells = {point - u - v, point - v, point, point - u};
    constexpr std::array<int, 4> kEdgeOf = {3, 2, 0, 1};
    std::array<Place, 4> corners;
    for (int i = 0; i < 4; ++i) {
      corners[i] = Find(cells[i], 4 * axis + kEdgeOf[i], values);
      if (corners[i].vertex == nullptr) return;
    }
    // The quad must face the grid point with the non-negative value.
    if (!(from < 0)) std::swap(corners[1], corners[3]);
    AddQuad(corners, mesh);
  }

  Place Find(const Cube& at, int edge, const DistanceField::WideBlock& values) const {
    const Cube inside(at.x() & (kBlockSide - 1), at.y() & (kBlockSide - 1),
                      at.z() & (kBlockSide - 1));
    const int k = (at.x() < 0 ? 0 : 1) | (at.y() < 0 ? 0 : 2) | (at.z() < 0 ? 0 : 4);
    if (around_[k] < 0) return {};
    const BlockMesh& block = blocks_[around_[k]];
    const std::uint16_t first = block.first[CellIndex(inside)];
    if (first == kNoVertex) return {};
    const std::uint32_t index = first + AllCellPatches()[Cell(values, at).pattern].of_edge[edge];
    const SurfaceVertex& vertex = block.vertices[index];
    return vertex.is_supported ? Place{block.begin + index, &vertex} : Place{};
  }

  static void AddQuad(const std::array<Place, 4>& q, BlockMesh* mesh) {
    const auto squared = [&](int i, int j) {
      return (q[i].vertex->position - q[j].vertex->position).squaredNorm();
    };
    const int s = squared(0, 2) <= squared(1, 3) ? 0 : 1;
    const auto at = [&](int i) { return q[(s + i) % 4].index; };
    mesh->triangles.push_back({at(0), at(1), at(2)});
    mesh->triangles.push_back({at(0), at(2), at(3)});
  }

  const DistanceField& field_;
  std::vector<BlockMesh>& blocks_;
  std::array<int, 8> around_ = {};
};

TriangleMesh Gather(const std::vector<BlockMesh>& blocks) {
  TriangleMesh mesh;
  for (const BlockMesh& block : blocks) {
    for (const SurfaceVertex& vertex : block.vertices) {
      mesh.vertices.push_back(vertex.position);
      mesh.normals.push_back(vertex.normal);
      mesh.colors.push_back(vertex.color);
    }
    mesh.triangles.insert(mesh.triangles.end(), block.triangles.begin(), block.triangles.end());
  }
  return mesh;
}

}  // namespace

TriangleMesh ExtractSurface(const DistanceField& field, const SurfelCubes& surfels,
                            const std::function<void(double)>& done) {
  const int count = field.block_count();
  std::vector<BlockMesh> blocks(count);
  ParallelFor(0, count, kMeshBlocksPerTask, [&](int begin, int end) {
    VertexRefiner refiner(field, surfels);
    DistanceField::WideBlock values;
    for (int i = begin; i < end; ++i) {
      field.Load(i, &values);
      FindVertices(field, i, values, &blocks[i]);
      refiner.Refine(&blocks[i].vertices);
    }
    done(0.8 * (end - begin) / count);
  });
  std::uint32_t vertices = 0;
  for (BlockMesh& block : blocks) {
    block.begin = vertices;
    vertices += static_cast<std::uint32_t>(block.vertices.size());
  }
  ParallelFor(0, count, kMeshBlocksPerTask, [&](int begin, int end) {
    QuadBuilder joiner(field, &blocks);
    DistanceField::WideBlock values;
    for (int i = begin; i < end; ++i) {
      field.Load(i, &values);
      joiner.Join(i, values);
    }
    done(0.2 * (end - begin) / count);
  });
  TriangleMesh mesh = Gather(blocks);
  KeepTriangles(std::vector<std::uint8_t>(mesh.triangles.size(), 1), &mesh);
  return mesh;
}

}  // namespace surfit
