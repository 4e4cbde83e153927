#include "output/pictures/splat_renderer.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kGrain = 4096;

struct Canvas {
  Canvas(const PictureView& view, NearestIndexImage* nearest)
      : rotation(view.camera_from_world.rotation.toRotationMatrix().cast<float>()),
        translation(view.camera_from_world.translation.cast<float>()),
        focal_px(view.camera.fx),
        cx(view.camera.cx),
        cy(view.camera.cy),
        image(*nearest) {}

  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  float focal_px, cx, cy;
  NearestIndexImage& image;
};

struct PixelRange {
  int begin, end;
};

PixelRange Clip(float first, float last, int size) {
  return {static_cast<int>(std::clamp(std::ceil(first), 0.f, static_cast<float>(size))),
          static_cast<int>(std::clamp(std::floor(last) + 1, 0.f, static_cast<float>(size)))};
}

// Draws the pixels whose rays intersect the disc (c, n, radius) in the camera frame. With c = z r
// and r = (x, y, 1), the ray r + e with e = (ex, ey, 0) intersects the plane of the disc at depth z
// + k:
//   n . ((z + k) (r + e) - z r) = 0,   k = -z n.e / n.(r + e),
// at the offset (z + k) e + k r from c. Single precision is sufficient, because there is no
// cancellation.
void DrawDisc(const Canvas& canvas, const Eigen::Vector3f& c, const Eigen::Vector3f& n,
              float radius, std::int32_t index) {
  const float x = c.x() / c.z(), y = c.y() / c.z(), z = c.z();
  const float u = canvas.focal_px * x + canvas.cx, v = canvas.focal_px * y + canvas.cy;
  // The point c + d of the disc is f a.d / (z + dz) px from u, with a = (1, 0, -x). The maximum of
  // a.d is the radius times the length of the projection of a onto the plane of the disc.
  const float nearest_z = z - radius * std::sqrt(std::max(0.f, 1 - n.z() * n.z()));
  const auto reach = [&](float slope, float along_normal) {
    const float in_plane = std::max(0.f, 1 + slope * slope - along_normal * along_normal);
    return canvas.focal_px * radius * std::sqrt(in_plane) / nearest_z;
  };
  const float reach_u = reach(x, n.x() - x * n.z()), reach_v = reach(y, n.y() - y * n.z());
  const PixelRange columns = Clip(u - reach_u, u + reach_u, canvas.image.width());
  const PixelRange rows = Clip(v - reach_v, v + reach_v, canvas.image.height());
  const float n_r = n.x() * x + n.y() * y + n.z();
  const float per_pixel = 1 / canvas.focal_px;
  for (int row = rows.begin; row < rows.end; ++row) {
    const float ey = (row - v) * per_pixel;
    for (int column = columns.begin; column < columns.end; ++column) {
      if (canvas.image.IsHidden(column, row, nearest_z)) continue;
      const float ex = (column - u) * per_pixel;
      const float n_e = n.x() * ex + n.y() * ey;
      if (n_r + n_e >= 0) continue;
      const float k = -z * n_e / (n_r + n_e);
      const Eigen::Vector3f offset((z + k) * ex + k * x, (z + k) * ey + k * y, k);
      if (offset.squaredNorm() > radius * radius) continue;
      // IsHidden() requires depths of at least nearest_z. Rounding must not make the result depend
      // on the order of surfels.
      canvas.image.Offer(column, row, std::max(z + k, nearest_z), index);
    }
  }
}

void DrawSquare(const Canvas& canvas, const Eigen::Vector3f& c, int size, std::int32_t index) {
  const float u = canvas.focal_px * c.x() / c.z() + canvas.cx - 0.5f * size;
  const float v = canvas.focal_px * c.y() / c.z() + canvas.cy - 0.5f * size;
  const PixelRange columns = Clip(u, std::ceil(u) + size - 1, canvas.image.width());
  const PixelRange rows = Clip(v, std::ceil(v) + size - 1, canvas.image.height());
  for (int row = rows.begin; row < rows.end; ++row) {
    for (int column = columns.begin; column < columns.end; ++column) {
      canvas.image.Offer(column, row, c.z(), index);
    }
  }
}

}  // namespace

Image<std::int32_t> RenderSurfels(const SurfelMap& map, const std::vector<std::uint8_t>& shown,
                                  const PictureView& view) {
  NearestIndexImage nearest(view.camera.width, view.camera.height);
  const Canvas canvas(view, &nearest);
  ParallelFor(0, map.id_end(), kGrain, [&](int begin, int end) {
    for (int id = begin; id < end; ++id) {
      if (!shown[id]) continue;
      const Surfel surfel = map[id];
      const Eigen::Vector3f center =
          canvas.rotation * surfel.position_in_world + canvas.translation;
      const Eigen::Vector3f normal = canvas.rotation * surfel.normal_in_world;
      if (!(center.z() > 2 * surfel.radius_m) || normal.dot(center) >= 0) continue;
      DrawDisc(canvas, center, normal, surfel.radius_m, id);
      DrawSquare(canvas, center, 1, id);
    }
  });
  return nearest.Indices();
}

Image<std::int32_t> RenderPoints(const std::vector<Eigen::Vector3f>& points_in_world, int size_px,
                                 const PictureView& view) {
  NearestIndexImage nearest(view.camera.width, view.camera.height);
  const Canvas canvas(view, &nearest);
  ParallelFor(0, static_cast<int>(points_in_world.size()), kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector3f p = canvas.rotation * points_in_world[i] + canvas.translation;
      if (p.z() > 0) DrawSquare(canvas, p, size_px, i);
    }
  });
  return nearest.Indices();
}

}  // namespace surfit
