#include "surfit/mesh/texture_mesh.h"

#include <glog/logging.h>

#include <algorithm>
#include <set>

#include "mesh/surface/mesh_edges.h"
#include "mesh/texture/frame_choice.h"
#include "mesh/texture/texture_charts.h"
#include "mesh/texture/texture_painter.h"
#include "mesh/texture/texture_view.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

// All that frames tell before the picture is painted.
struct SeenFrames {
  std::vector<TextureCamera> cameras;
  std::vector<Eigen::Vector3f> gains;
  std::vector<int> views;  // of each triangle: frames first, then ColorViews
};

SeenFrames LookAtFrames(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                        const TextureFrames& frames, const TextureOptions& options,
                        const ColorViews& color_views) {
  SeenFrames seen;
  FrameChoice choice(mesh.triangles.size());
  frames([&](const TextureFrame& frame) {
    const TextureView view(mesh, frame);
    choice.Add(static_cast<int>(seen.cameras.size()), view.sharpness());
    seen.cameras.push_back(view.camera());
    seen.gains.push_back(view.gain());
  });
  seen.views = choice.Choose(mesh, neighbors, options);
  for (std::size_t i = 0; i < seen.views.size(); ++i) {
    if (seen.views[i] != FrameChoice::kNoFrame) continue;
    seen.views[i] =
        static_cast<int>(seen.cameras.size()) + color_views.ViewOf(mesh, mesh.triangles[i]);
  }
  return seen;
}

void PaintFrames(const TextureFrames& frames, const SeenFrames& seen,
                 const std::vector<TextureChart>& charts, TexturePainter* painter) {
  int index = 0;
  frames([&](const TextureFrame& frame) {
    for (const TextureChart& chart : charts)
      if (chart.view == index) painter->Paint(chart, frame.frame.color, seen.gains[index]);
    ++index;
  });
}

void Summarize(const SeenFrames& seen, const TextureLayout& layout, TextureSummary* summary) {
  const int frames = static_cast<int>(seen.cameras.size());
  std::set<int> shown;
  for (const TextureChart& chart : layout.charts)
    if (chart.view < frames) shown.insert(chart.view);
  summary->frames = frames;
  summary->frames_shown = static_cast<int>(shown.size());
  summary->charts = layout.charts.size();
  summary->triangles_unseen = static_cast<std::size_t>(
      std::count_if(seen.views.begin(), seen.views.end(), [&](int v) { return v >= frames; }));
}

}  // namespace

MeshTexture TextureMesh(const TriangleMesh& mesh, const TextureFrames& frames,
                        const TextureOptions& options, TextureSummary* summary) {
  Validate(options);
  CHECK_EQ(mesh.colors.size(), mesh.vertices.size());
  CHECK_EQ(mesh.normals.size(), mesh.vertices.size());
  CHECK_GT(options.max_texture_px, 0);
  const TriangleNeighbors neighbors(mesh.triangles);
  const ColorViews color_views(mesh);
  const SeenFrames seen = LookAtFrames(mesh, neighbors, frames, options, color_views);
  TextureLayout layout = MakeCharts(mesh, neighbors, seen.views, seen.cameras, color_views);
  *summary = {};
  Summarize(seen, layout, summary);
  const PackedSize size = PackCharts(options.max_texture_px, &layout.charts);
  summary->pixel_share = size.pixel_share;
  TexturePainter painter(mesh, layout, size);
  PaintFrames(frames, seen, layout.charts, &painter);
  MeshTexture texture;
  texture.places.resize(layout.pixels.size());
  for (const TextureChart& chart : layout.charts) {
    if (chart.view >= summary->frames) painter.PaintColors(chart);
    for (std::uint32_t i = chart.first_place; i < chart.end_place; ++i)
      texture.places[i] = painter.PlaceOf(chart, layout.pixels[i]);
  }
  texture.vertices = std::move(layout.vertices);
  texture.triangles = std::move(layout.triangles);
  texture.image = std::move(painter.image());
  return texture;
}

}  // namespace surfit
