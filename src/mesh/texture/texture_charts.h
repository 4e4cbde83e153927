#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mesh/surface/mesh_edges.h"
#include "mesh/texture/texture_camera.h"

namespace surfit {

// Connected part of the mesh with the same view: a frame, or an orthographic view of the vertex
// colours.
struct TextureChart {
  int view = 0;                          // index of a frame, or frame count + ColorViews index
  std::vector<std::uint32_t> triangles;  // indices in the mesh, ascending
  std::uint32_t first_place = 0, end_place = 0;  // half-open range in TextureLayout
  Eigen::Vector2f low, high;                     // bounds in the view, px
  int left = 0, top = 0;      // position in the texture, texels; set by PackCharts()
  int width = 0, height = 0;  // with margin, texels; set by PackCharts()
};

// Six orthographic views of the vertex colours along the axes.
class ColorViews {
 public:
  // The resolution is two pixels per average triangle side.
  explicit ColorViews(const TriangleMesh& mesh);

  static constexpr int kCount = 6;
  // View with the smallest angle to the triangle normal, from 0 to 5.
  int ViewOf(const TriangleMesh& mesh, const TriangleMesh::Triangle& triangle) const;
  // Pixel of a point, without bounds.
  Eigen::Vector2f See(int view, const Eigen::Vector3f& point) const;

 private:
  float pixel_m_;
};

// Charts of a mesh with pixel coordinates in their views. A place is a vertex in a chart: vertices
// of several charts have several places.
struct TextureLayout {
  std::vector<TextureChart> charts;
  std::vector<std::uint32_t> vertices;            // mesh vertex per place
  std::vector<Eigen::Vector2f> pixels;            // position in the view per place, px
  std::vector<TriangleMesh::Triangle> triangles;  // indices of places
};

// Divides the mesh into charts. `views` has the view of each triangle, as in TextureChart::view.
// `cameras`: one per frame.
TextureLayout MakeCharts(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                         const std::vector<int>& views, const std::vector<TextureCamera>& cameras,
                         const ColorViews& color_views);

// Margin around charts, against interpolation with other charts. In texels.
inline constexpr int kChartMargin_px = 2;

// Texture size, and texels per frame pixel.
struct PackedSize {
  int width = 0, height = 0;
  double pixel_ratio = 1;
};

// Packs the charts into an image of at most max_side_px per side, on shelves by descending height.
// If necessary, reduces all charts by a common factor. Throws InputError if there are too many
// charts. The smallest factor is 0.02.
PackedSize PackCharts(int max_side_px, std::vector<TextureChart>* charts);

}  // namespace surfit
