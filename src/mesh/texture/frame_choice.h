#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh/surface/mesh_edges.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Which frame each triangle has its colours from.
class FrameChoice {
 public:
  static constexpr int kNoFrame = -1;

  explicit FrameChoice(std::size_t triangles) : candidates_(triangles) {}

  // A frame, how sharply it shows each triangle, and which one it is. Of many frames that show a
  // triangle the sharpest ones are kept.
  void Add(int frame, const std::vector<float>& sharpness);

  // Frames are taken one after the other, each time that which shows most of what is left, by area
  // and sharpness, where it is sharp enough; then triangles take their neighbours' frames where
  // that saves seams that cost more than the sharpness that is lost.
  std::vector<int> Choose(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                          const TextureOptions& options) const;

 private:
  static constexpr int kCandidates = 12;
  struct Candidate {
    std::int32_t frame = kNoFrame;
    float sharpness = 0;
  };
  using Candidates = std::array<Candidate, kCandidates>;  // the sharpest first

  std::vector<int> CoverGreedily(const TriangleMesh& mesh, float least_share) const;
  void SaveSeams(const TriangleNeighbors& neighbors, float seam_cost,
                 std::vector<int>* frames) const;

  std::vector<Candidates> candidates_;
  int frame_count_ = 0;
};

}  // namespace surfit
