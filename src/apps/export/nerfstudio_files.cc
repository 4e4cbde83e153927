#include "apps/export/nerfstudio_files.h"

#include <cmath>
#include <optional>

#include "apps/export/color_lens.h"
#include "mapping/rendering/blended_view.h"
#include "output/output_files.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr double kGlPixelCenter = 0.5;  // coordinates of the top-left pixel centre in nerfstudio

Json RowsOf(const Eigen::Matrix4d& matrix, int rows) {
  Json json = Json::array();
  for (int i = 0; i < rows; ++i) {
    json.push_back({matrix(i, 0), matrix(i, 1), matrix(i, 2), matrix(i, 3)});
  }
  return json;
}

}  // namespace

Image<std::uint16_t> DepthForImage(const SurfelMap& map, const PinholeCamera& lens,
                                   const Rigid3d& world_from_color) {
  DepthSensor sensor;
  sensor.camera = lens;
  sensor.camera.distortion = {};
  // The distortion moves pixels out of the undistorted image.
  const int margin = lens.HasDistortion() ? lens.width / 8 : 0;
  sensor.camera.width += 2 * margin;
  sensor.camera.height += 2 * margin;
  sensor.camera.cx += margin;
  sensor.camera.cy += margin;
  const Image<float> drawn_m = DrawBlended(map, sensor, world_from_color).depth_m;
  Image<std::uint16_t> depth(lens.width, lens.height, 0);
  constexpr double kMostUnits = 65535;
  ParallelFor(0, lens.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < lens.width; ++u) {
        const std::optional<Eigen::Vector3d> ray = RayOfLens(lens, u, v);
        if (!ray) continue;
        const Eigen::Vector2d pixel = sensor.camera.Project(*ray);
        if (!IsInside(sensor.camera, pixel, 0)) continue;
        const double units = kDepthUnits_per_m *
                             static_cast<double>(drawn_m(static_cast<int>(std::lround(pixel.x())),
                                                         static_cast<int>(std::lround(pixel.y()))));
        if (units < kMostUnits) depth(u, v) = static_cast<std::uint16_t>(std::lround(units));
      }
    }
  });
  return depth;
}

void WriteTransformsJson(const PinholeCamera& lens, const std::vector<PosedImage>& images,
                         bool has_masks, const Rigid3d& export_from_world,
                         const std::string& path) {
  const auto& [k1, k2, p1, p2, k3] = lens.distortion;
  Json json = {{"camera_model", "OPENCV"},
               {"w", lens.width},
               {"h", lens.height},
               {"fl_x", lens.fx},
               {"fl_y", lens.fy},
               {"cx", lens.cx + kGlPixelCenter},
               {"cy", lens.cy + kGlPixelCenter},
               {"k1", k1},
               {"k2", k2},
               {"k3", k3},
               {"p1", p1},
               {"p2", p2},
               {"depth_unit_scale_factor", 1 / kDepthUnits_per_m},
               {"applied_transform", RowsOf(export_from_world.Matrix(), 3)},
               {"applied_scale", 1.},
               {"ply_file_path", "points.ply"},
               {"frames", Json::array()}};
  // OpenGL cameras look along -z with y up: diag(1, -1, -1) from the axes of PinholeCamera.
  const Eigen::Matrix4d flip = Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  for (const PosedImage& image : images) {
    const Eigen::Matrix4d pose = (export_from_world * image.world_from_color).Matrix() * flip;
    json["frames"].push_back({{"file_path", "images/" + image.source.Name()},
                              {"depth_file_path", "depth/" + image.source.Name()},
                              {"timestamp", image.source.stamp_s},
                              {"transform_matrix", RowsOf(pose, 4)}});
    if (has_masks) json["frames"].back()["mask_path"] = "masks/" + image.source.Name();
  }
  WriteJson(json, path);
}

}  // namespace surfit
