#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mapping/rendering/blended_view.h"
#include "output/pictures/canvas.h"
#include "output/pictures/map_views.h"
#include "output/pictures/pictures.h"
#include "output/pictures/splat_renderer.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

struct RenderedViews {
  std::array<PictureView, 4> views;
  std::array<Image<std::int32_t>, 4> surfel_indices;
};

RenderedViews Render(const SurfelMap& map, const std::vector<std::uint8_t>& shown,
                     const std::array<PictureView, 4>& views) {
  RenderedViews rendered;
  rendered.views = views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    rendered.surfel_indices[i] = RenderSurfels(map, shown, views[i]);
  }
  return rendered;
}

Image<Rgb8> Color(const SurfelMap& map, const SurfelColoring& coloring, const PictureView& view,
                  const Image<std::int32_t>& indices) {
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const auto shaded = [&](const Rgb8& color, const Eigen::Vector3d& normal, int u, int v) {
    const Eigen::Vector3d ray = world_from_camera * view.camera.Ray(u, v).normalized();
    const double facing = std::min(std::abs(ray.dot(normal)), 1.);
    return Dimmed(color, static_cast<float>(1 - coloring.headlight * (1 - facing)));
  };
  Image<Rgb8> colors(indices.width(), indices.height());
  ParallelFor(0, indices.height(), kRowsPerBlock, [&](int begin, int end) {
    // Neighbouring pixels often show the same surfel.
    std::int32_t surfel = NearestIndexImage::kNothing;
    Rgb8 color = PictureSheet::kScene;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < indices.width(); ++u) {
        const std::int32_t next = indices(u, v);
        if (next != surfel) {
          surfel = next;
          const bool is_shown = surfel != NearestIndexImage::kNothing;
          color = is_shown ? coloring.color_of(surfel) : PictureSheet::kScene;
          if (is_shown) normal = map[surfel].normal_in_world.cast<double>();
        }
        const bool is_shaded = surfel != NearestIndexImage::kNothing && coloring.headlight > 0;
        colors(u, v) = is_shaded ? shaded(color, normal, u, v) : color;
      }
    }
  });
  return colors;
}

SurfelMap Shown(const SurfelMap& map, const std::vector<std::uint8_t>& shown) {
  std::vector<Surfel> surfels;
  for (const std::int32_t id : map.Ids()) {
    if (shown[id]) surfels.push_back(map[id]);
  }
  SurfelMap copy;
  copy.Append(surfels);
  return copy;
}

// Blended surfel colours, without sensor noise.
Image<Rgb8> Blended(const SurfelMap& map, const PictureView& view) {
  const DepthNoise none = {0};
  const BlendedView drawn = DrawBlended(map, {view.camera, none}, view.camera_from_world.Inverse());
  Image<Rgb8> picture = drawn.color;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (!(drawn.depth_m[i] > 0)) picture[i] = PictureSheet::kScene;
  }
  return picture;
}

void DrawHeader(const SurfelColoring& coloring, const std::string& count, Image<Rgb8>* image) {
  const double right = image->width() - 40;
  DrawText(image, {16, 28}, coloring.title, {30});
  DrawText(image, {16, 60}, count, {17});
  if (!coloring.scale) {
    DrawText(image, {right, 28}, coloring.legend, {17, 1});
    return;
  }
  const PixelBox bar = {right - 700, 14, right, 40};
  DrawText(image, {bar.left - 16, 27}, coloring.legend, {17, 1});
  DrawColorBar(image, *coloring.scale, bar);
}

void WriteSheet(const SurfelMap& map, const SurfelColoring& coloring, const std::string& count,
                const RenderedViews& rendered, const std::string& path) {
  PictureSheet sheet(2, 2);
  for (int i = 0; i < 4; ++i) {
    sheet.SetCell(i, Color(map, coloring, rendered.views[i], rendered.surfel_indices[i]));
    sheet.DrawCaption(i, rendered.views[i].label);
  }
  DrawHeader(coloring, count, sheet.image());
  WritePng(*sheet.image(), path);
}

void WriteColorSheet(const SurfelMap& map, const std::string& count,
                     const std::array<PictureView, 4>& views, const std::string& path) {
  PictureSheet sheet(2, 2);
  for (int i = 0; i < 4; ++i) {
    sheet.SetCell(i, Blended(map, views[i]));
    sheet.DrawCaption(i, views[i].label);
  }
  DrawHeader(ColorByColor(map), count, sheet.image());
  WritePng(*sheet.image(), path);
}

// Returns false if all surfels have the colour that Fusion gives without colour images.
bool HasColors(const SurfelMap& map, const std::vector<std::int32_t>& ids) {
  constexpr Rgb8 kNoColor = {128, 128, 128};
  return std::any_of(ids.begin(), ids.end(),
                     [&](std::int32_t id) { return map.Color(id) != kNoColor; });
}

// Grey surfels, shaded by their normals.
SurfelColoring ColorByShape() {
  SurfelColoring coloring;
  coloring.title = "Shape";
  coloring.color_of = [](std::int32_t) { return Rgb8{235, 235, 235}; };
  coloring.headlight = 0.85f;
  coloring.legend = "no colour images";
  return coloring;
}

void WriteEmptySheet(const std::string& path) {
  PictureSheet sheet(2, 2);
  Image<Rgb8>& image = *sheet.image();
  DrawText(&image, {image.width() / 2., image.height() / 2.}, "empty map", {40, 0.5});
  WritePng(image, path);
}

}  // namespace

float NoiseConfidence(const SurfelMap& map) {
  constexpr float kMost = 3, kShare = 0.1f;
  std::vector<float> confidences;
  confidences.reserve(map.size());
  for (const std::int32_t id : map.Ids()) confidences.push_back(map[id].confidence);
  return std::min(kMost, kShare * Quantile(confidences, 0.9, 0));
}

std::vector<Surfel> ReliableSurfels(const SurfelMap& map) {
  const float least = NoiseConfidence(map);
  std::vector<Surfel> surfels;
  for (const std::int32_t id : map.Ids()) {
    const Surfel surfel = map[id];
    if (surfel.confidence >= least && surfel.position_in_world.allFinite()) {
      surfels.push_back(surfel);
    }
  }
  return surfels;
}

void WriteMapPictures(const SurfelMap& map, const Trajectory& camera_path,
                      const std::string& directory, const std::optional<UprightWorld>& upright) {
  const std::string prefix = directory + "/map_";
  if (map.size() == 0) {
    for (const char* name : {"color", "normals", "last_seen", "confidence"}) {
      WriteEmptySheet(prefix + name + ".png");
    }
    return;
  }
  const float least = NoiseConfidence(map);
  const std::vector<std::int32_t> ids = map.Ids();
  std::vector<std::uint8_t> shown(map.id_end());
  for (const std::int32_t id : ids) shown[id] = map[id].confidence >= least;
  const auto views = ChooseMapViews(map, shown, camera_path, upright,
                                    PictureSheet::kCellWidth * PictureSheet::kSupersampling,
                                    PictureSheet::kCellHeight * PictureSheet::kSupersampling);
  const auto count = std::count(shown.begin(), shown.end(), 1);
  const std::string some =
      Concat(count, " of ", map.size(), " surfels, with confidence of at least ",
             std::round(100 * least) / 100, "");
  const RenderedViews trusted = Render(map, shown, views);
  if (HasColors(map, ids)) {
    WriteColorSheet(Shown(map, shown), some, views, prefix + "color.png");
  } else {
    WriteSheet(map, ColorByShape(), some, trusted, prefix + "color.png");
  }
  WriteSheet(map, ColorByNormal(map), some, trusted, prefix + "normals.png");
  WriteSheet(map, ColorByLastSeen(map), some, trusted, prefix + "last_seen.png");

  for (const std::int32_t id : ids) shown[id] = 1;
  const RenderedViews all = Render(map, shown, views);
  WriteSheet(map, ColorByConfidence(map), Concat("all ", map.size(), " surfels"), all,
             prefix + "confidence.png");
}

}  // namespace surfit
