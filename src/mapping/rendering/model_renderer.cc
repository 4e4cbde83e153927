#include "surfit/mapping/model_renderer.h"

#include <algorithm>

#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

ModelView BlankView(const DepthSensor& sensor, const Rigid3d& world_from_view) {
  const PinholeCamera& camera = sensor.camera;
  ModelView view;
  view.world_from_view = world_from_view;
  view.surface.camera = camera;
  view.surface.noise = sensor.noise;
  view.surface.vertex.Resize(camera.width, camera.height);
  view.surface.normal.Resize(camera.width, camera.height);
  view.surfel_index.Resize(camera.width, camera.height);
  return view;
}

}  // namespace

ModelRenderer::ModelRenderer(const RenderOptions& options) : options_(options) {
  Validate(options);
}

ModelRenderer::~ModelRenderer() = default;

ModelView ModelRenderer::Render(const SurfelMap& map, const DepthSensor& sensor,
                                const Rigid3d& world_from_view, int active_since) {
  const PinholeCamera& camera = sensor.camera;
  constexpr int kMostPixels = std::numeric_limits<std::int16_t>::max();
  ThrowIf(std::max(camera.width, camera.height) > kMostPixels, "the view has ", camera.width, " x ",
          camera.height, " pixels, must have at most ", kMostPixels, " per row and column");
  const PosedCamera posed(camera, world_from_view);
  const ViewFrustum frustum(posed, static_cast<float>(options_.max_half_window_px));
  const std::vector<std::int32_t> cells = VisibleCells(map, frustum);
  lists_.resize(cells.size());
  ParallelFor(0, static_cast<int>(cells.size()), 1, [&](int i, int) {
    lists_[i].Assign(map, map.cell(cells[i]), posed, frustum, options_, active_since);
  });

  ModelView view = BlankView(sensor, world_from_view);
  ParallelFor(0, BandCount(camera.height), 1, [&](int band, int) {
    BandCanvas canvas(band, posed, sensor.noise, options_);
    canvas.Draw(lists_, kStable);
    canvas.Draw(lists_, kUnstable);
    canvas.WriteTo(&view);
  });
  return view;
}

Image<Rgb8> ColorsOf(const ModelView& view, const SurfelMap& map) {
  Image<Rgb8> colors(view.surfel_index.width(), view.surfel_index.height());
  const int width = colors.width();
  ParallelFor(0, colors.height(), kRowsPerBlock, [&](int begin, int end) {
    std::transform(
        view.surfel_index.row(begin), view.surfel_index.row(begin) + (end - begin) * width,
        colors.row(begin),
        [&](std::int32_t id) { return id == ModelView::kNoSurfel ? Rgb8() : map.Color(id); });
  });
  return colors;
}

}  // namespace surfit
