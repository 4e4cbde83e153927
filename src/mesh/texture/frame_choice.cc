#include "mesh/texture/frame_choice.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kTrianglesAtOnce = 8192;

double AreaOf(const TriangleMesh& mesh, std::size_t triangle) {
  const TriangleMesh::Triangle& t = mesh.triangles[triangle];
  const Eigen::Vector3f& a = mesh.vertices[t[0]];
  return 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
}

}  // namespace

void FrameChoice::Add(int frame, const std::vector<float>& sharpness) {
  frame_count_ = std::max(frame_count_, frame + 1);
  const int count = static_cast<int>(candidates_.size());
  ParallelFor(0, count, kTrianglesAtOnce, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Candidates& kept = candidates_[i];
      if (!(sharpness[i] > kept.back().sharpness)) continue;
      int k = kCandidates - 1;
      for (; k > 0 && sharpness[i] > kept[k - 1].sharpness; --k) kept[k] = kept[k - 1];
      kept[k] = {frame, sharpness[i]};
    }
  });
}

std::vector<int> FrameChoice::CoverGreedily(const TriangleMesh& mesh, float least_share) const {
  // What a triangle adds to the worth of its candidates while it has no frame.
  const auto worth = [&](std::size_t i, const Candidate& candidate) {
    const float share = candidate.sharpness / candidates_[i][0].sharpness;
    return share >= least_share ? share * AreaOf(mesh, i) : 0.;
  };
  std::vector<double> worths(frame_count_);
  std::vector<std::vector<std::uint32_t>> shown(frame_count_);
  for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
    for (const Candidate& candidate : candidates_[i]) {
      if (candidate.frame == kNoFrame || !(worth(i, candidate) > 0)) continue;
      worths[candidate.frame] += worth(i, candidate);
      shown[candidate.frame].push_back(i);
    }
  }
  std::vector<int> frames(candidates_.size(), kNoFrame);
  while (frame_count_ > 0) {
    const auto best = std::max_element(worths.begin(), worths.end());
    if (!(*best > 0)) break;
    const int frame = static_cast<int>(best - worths.begin());
    for (const std::uint32_t i : shown[frame]) {
      if (frames[i] != kNoFrame) continue;
      frames[i] = frame;
      for (const Candidate& candidate : candidates_[i])
        if (candidate.frame != kNoFrame) worths[candidate.frame] -= worth(i, candidate);
    }
    *best = 0;  // but for what is lost by rounding
  }
  return frames;
}

void FrameChoice::SaveSeams(const TriangleNeighbors& neighbors, float seam_cost,
                            std::vector<int>* frames) const {
  constexpr int kSweeps = 5;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      const Candidates& candidates = candidates_[i];
      float least_cost = 0;
      int best = kNoFrame;
      for (const Candidate& candidate : candidates) {
        if (candidate.frame == kNoFrame) break;
        float cost = 1 - candidate.sharpness / candidates[0].sharpness;
        for (const std::uint32_t other : neighbors.Of(i)) {
          if (other != TriangleNeighbors::kNone && (*frames)[other] != candidate.frame)
            cost += seam_cost;
        }
        // Of equal ones that which it has.
        const bool is_less = cost < least_cost;
        if (best != kNoFrame && !is_less &&
            !(cost == least_cost && candidate.frame == (*frames)[i]))
          continue;
        best = candidate.frame;
        least_cost = cost;
      }
      (*frames)[i] = best;
    }
  }
}

std::vector<int> FrameChoice::Choose(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                                     const TextureOptions& options) const {
  std::vector<int> frames = CoverGreedily(mesh, static_cast<float>(options.least_sharpness));
  SaveSeams(neighbors, static_cast<float>(options.seam_cost), &frames);
  return frames;
}

}  // namespace surfit
