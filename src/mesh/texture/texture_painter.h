#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/texture/texture_charts.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Paints charts into the picture.
class TexturePainter {
 public:
  TexturePainter(const TriangleMesh& mesh, const TextureLayout& layout, const PackedSize& size);

  // What a frame shows, brightened by the gain. What then is left of the difference to the mesh's
  // own colours, smoothed over several triangles, is added: coarse shades are the mesh's, so that
  // charts meet without a step, and all that is finer is the frame's.
  void Paint(const TextureChart& chart, const Image<Rgb8>& frame, const Eigen::Vector3f& gain);
  // The colours of the mesh.
  void PaintColors(const TextureChart& chart);

  // A place of a chart, in its view's pixels, as shares of the picture's sides.
  Eigen::Vector2f PlaceOf(const TextureChart& chart, const Eigen::Vector2f& pixel) const;

  Image<Rgb8>& image() { return image_; }

 private:
  // Colours, in 8-bit steps, of the places of a chart or of its texels.
  using Colors = std::vector<Eigen::Vector3f>;

  Eigen::Vector2f InChart(const TextureChart& chart, const Eigen::Vector2f& pixel) const {
    return share_ * (pixel - chart.low) + Eigen::Vector2f::Constant(kChartMargin_px);
  }
  void Smooth(const TextureChart& chart, Colors* of_places) const;
  // Of the chart's texels; those beyond its margin have none. `is_painted` tells which have.
  Colors Spread(const TextureChart& chart, const Colors& of_places,
                std::vector<std::uint8_t>* is_painted) const;

  const TriangleMesh& mesh_;
  const TextureLayout& layout_;
  const float share_;  // texels to a pixel's side
  Image<Rgb8> image_;
};

}  // namespace surfit
