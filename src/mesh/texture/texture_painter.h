#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/texture/texture_charts.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Paints the charts of a layout into a texture. Not thread-safe.
class TexturePainter {
 public:
  // Keeps references to the mesh, which must have colours, and to the layout. The charts must be
  // packed into `size`.
  TexturePainter(const TriangleMesh& mesh, const TextureLayout& layout, const PackedSize& size);

  // Paints frame colours times the gain. Adds the smoothed difference of the mesh colours and these
  // colours, so that charts meet without steps. `frame`: colour image of the view of the chart.
  void Paint(const TextureChart& chart, const Image<Rgb8>& frame, const Eigen::Vector3f& gain);
  // Paints the vertex colours, for a chart of ColorViews.
  void PaintColors(const TextureChart& chart);

  // Texture coordinates (0 to 1) of a pixel of the view.
  Eigen::Vector2f CoordinatesOf(const TextureChart& chart, const Eigen::Vector2f& pixel) const;

  // Texture. Texels without a chart are black.
  Image<Rgb8>& image() { return image_; }

 private:
  using Colors = std::vector<Eigen::Vector3f>;

  Eigen::Vector2f InChart(const TextureChart& chart, const Eigen::Vector2f& pixel) const {
    return share_ * (pixel - chart.low) + Eigen::Vector2f::Constant(kChartMargin_px);
  }
  void Smooth(const TextureChart& chart, Colors* of_places) const;
  // Interpolates colours of chart vertices to texels. `is_painted` 1: the texel has a colour, also
  // in the margin.
  Colors Spread(const TextureChart& chart, const Colors& of_places,
                std::vector<std::uint8_t>* is_painted) const;

  const TriangleMesh& mesh_;
  const TextureLayout& layout_;
  const float share_;  // texels per pixel
  Image<Rgb8> image_;
};

}  // namespace surfit
