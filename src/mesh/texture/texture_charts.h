#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mesh/surface/mesh_edges.h"
#include "mesh/texture/texture_camera.h"

namespace surfit {

// A connected part of the mesh that one view shows: a frame, or, where none does, the mesh's own
// colours as seen along an axis.
struct TextureChart {
  int view = 0;  // frames first, then ColorViews
  std::vector<std::uint32_t> triangles;
  std::uint32_t first_place = 0, end_place = 0;
  Eigen::Vector2f low, high;  // of its places, in the view's pixels
  int left = 0, top = 0;      // where it begins in the picture, with its margin
  int width = 0, height = 0;  // there
};

// Six orthographic views that show vertices' colours, towards the axes' directions.
class ColorViews {
 public:
  explicit ColorViews(const TriangleMesh& mesh);

  static constexpr int kCount = 6;
  // Which of them shows a triangle best.
  int ViewOf(const TriangleMesh& mesh, const TriangleMesh::Triangle& triangle) const;
  Eigen::Vector2f See(int view, const Eigen::Vector3f& point) const;

 private:
  float pixel_m_;
};

// The charts of a mesh, with their places in pixels of their views.
struct TextureLayout {
  std::vector<TextureChart> charts;
  std::vector<std::uint32_t> vertices;            // of each place
  std::vector<Eigen::Vector2f> pixels;            // of the view of its chart
  std::vector<TriangleMesh::Triangle> triangles;  // of places
};

// `views` are of each triangle.
TextureLayout MakeCharts(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                         const std::vector<int>& views, const std::vector<TextureCamera>& cameras,
                         const ColorViews& color_views);

// The margin around charts in the picture, so that nothing beside them is mixed in.
inline constexpr int kChartMargin_px = 2;

// A picture and how large frames' pixels are in it.
struct PackedSize {
  int width = 0, height = 0;
  double pixel_share = 1;
};

// Puts the charts into a picture of at most this size, on shelves, the highest first; as large as
// in their views, or all smaller by the same factor. Throws InputError if there are too many.
PackedSize PackCharts(int max_side_px, std::vector<TextureChart>* charts);

}  // namespace surfit
