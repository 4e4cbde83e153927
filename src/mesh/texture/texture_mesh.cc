#include "surfit/mesh/texture_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <set>

#include "mesh/surface/mesh_edges.h"
#include "mesh/texture/texture_charts.h"
#include "mesh/texture/texture_painter.h"
#include "mesh/texture/texture_view.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kTrianglesAtOnce = 8192;

double AreaOf(const TriangleMesh& mesh, std::size_t triangle) {
  const TriangleMesh::Triangle& t = mesh.triangles[triangle];
  const Eigen::Vector3f& a = mesh.vertices[t[0]];
  return 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
}

class FrameSelection {
 public:
  static constexpr int kNoFrame = -1;

  explicit FrameSelection(std::size_t triangles) : candidates_(triangles) {}

  // Adds a frame. `sharpness`: one value per triangle. Only the sharpest frames of each triangle
  // are stored.
  void Add(int frame, const std::vector<float>& sharpness) {
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

  // Returns the frame index per triangle, or kNoFrame. A greedy selection repeatedly takes the
  // frame that shows most of the remaining triangle area sharply. A second step reduces seams.
  std::vector<int> Choose(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                          const TextureOptions& options) const {
    std::vector<int> frames = CoverGreedily(mesh, static_cast<float>(options.min_sharpness));
    ReduceSeams(neighbors, static_cast<float>(options.seam_cost), &frames);
    return frames;
  }

 private:
  static constexpr int kCandidates = 12;
  struct Candidate {
    std::int32_t frame = kNoFrame;
    float sharpness = 0;
  };
  using Candidates = std::array<Candidate, kCandidates>;  // in descending order of sharpness

  std::vector<int> CoverGreedily(const TriangleMesh& mesh, float least_share) const {
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
      *best = 0;  // removes the rounding error, which could repeat the frame
    }
    return frames;
  }
  void ReduceSeams(const TriangleNeighbors& neighbors, float seam_cost,
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
          // If costs are equal, the triangle keeps its current frame.
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

  std::vector<Candidates> candidates_;
  int frame_count_ = 0;
};

struct TextureSources {
  std::vector<TextureCamera> cameras;
  std::vector<Eigen::Vector3f> gains;
  std::vector<int> views;  // per triangle: frame index, or frame count + ColorViews index
};

TextureSources LookAtFrames(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                            const TextureFrames& frames, const TextureOptions& options,
                            const ColorViews& color_views) {
  TextureSources seen;
  FrameSelection choice(mesh.triangles.size());
  frames([&](const TextureFrame& frame) {
    const TextureView view(mesh, frame);
    choice.Add(static_cast<int>(seen.cameras.size()), view.sharpness());
    seen.cameras.push_back(view.camera());
    seen.gains.push_back(view.gain());
  });
  seen.views = choice.Choose(mesh, neighbors, options);
  for (std::size_t i = 0; i < seen.views.size(); ++i) {
    if (seen.views[i] != FrameSelection::kNoFrame) continue;
    seen.views[i] =
        static_cast<int>(seen.cameras.size()) + color_views.ViewOf(mesh, mesh.triangles[i]);
  }
  return seen;
}

void PaintFrames(const TextureFrames& frames, const TextureSources& seen,
                 const std::vector<TextureChart>& charts, TexturePainter* painter) {
  int index = 0;
  frames([&](const TextureFrame& frame) {
    for (const TextureChart& chart : charts)
      if (chart.view == index) painter->Paint(chart, frame.frame.color, seen.gains[index]);
    ++index;
  });
}

void Summarize(const TextureSources& seen, const TextureLayout& layout, TextureSummary* summary) {
  const int frames = static_cast<int>(seen.cameras.size());
  std::set<int> shown;
  for (const TextureChart& chart : layout.charts)
    if (chart.view < frames) shown.insert(chart.view);
  summary->frames = frames;
  summary->frames_used = static_cast<int>(shown.size());
  summary->charts = layout.charts.size();
  summary->triangles_unseen = static_cast<std::size_t>(
      std::count_if(seen.views.begin(), seen.views.end(), [&](int v) { return v >= frames; }));
}

}  // namespace

MeshTexture TextureMesh(const TriangleMesh& mesh, const TextureFrames& frames,
                        const TextureOptions& options, TextureSummary* summary) {
  Validate(options);
  ThrowIf(options.max_texture_px == 0, "max_texture_px is 0, must be positive to make a texture");
  ThrowIf(mesh.colors.size() != mesh.vertices.size() || mesh.normals.size() != mesh.vertices.size(),
          "the mesh has ", mesh.vertices.size(), " vertices, ", mesh.colors.size(), " colours and ",
          mesh.normals.size(), " normals, must have one of each per vertex");
  const TriangleNeighbors neighbors(mesh.triangles);
  const ColorViews color_views(mesh);
  const TextureSources seen = LookAtFrames(mesh, neighbors, frames, options, color_views);
  TextureLayout layout = MakeCharts(mesh, neighbors, seen.views, seen.cameras, color_views);
  *summary = {};
  Summarize(seen, layout, summary);
  const PackedSize size = PackCharts(options.max_texture_px, &layout.charts);
  summary->pixel_ratio = size.pixel_ratio;
  TexturePainter painter(mesh, layout, size);
  PaintFrames(frames, seen, layout.charts, &painter);
  MeshTexture texture;
  texture.texture_coordinates.resize(layout.pixels.size());
  for (const TextureChart& chart : layout.charts) {
    if (chart.view >= summary->frames) painter.PaintColors(chart);
    for (std::uint32_t i = chart.first_place; i < chart.end_place; ++i)
      texture.texture_coordinates[i] = painter.CoordinatesOf(chart, layout.pixels[i]);
  }
  texture.vertices = std::move(layout.vertices);
  texture.triangles = std::move(layout.triangles);
  texture.image = std::move(painter.image());
  return texture;
}

}  // namespace surfit
