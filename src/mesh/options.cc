#include "surfit/core/options.h"

#include <cmath>

#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

void MeshOptions::Visit(OptionVisitor& v) {
  v.Group("mesh");
  v.Add(cell_m, "cell_m", "cell size of surface extraction, about the side of a triangle",
        Positive(), AsFlag(), Everyday());
  v.Add(max_triangles, "max_triangles",
        "maximum number of triangles; flat regions get larger triangles", ZeroIs("no limit"),
        AsFlag(), Everyday());
  v.Add(watertight, "watertight",
        "fill all holes with artificial triangles; open sheets get a back side", AsFlag(),
        Everyday());
  v.Add(min_component_m, "min_component_m",
        "minimum diameter of disconnected pieces; smaller pieces are removed", ZeroIs("keep all"));
  v.Add(normal_noise_rad, "normal_noise_rad",
        "smooth surfels until the noise of their normals is about this", ZeroIs("no smoothing"),
        Below(M_PI / 2));
  v.Add(
      support_radii, "support_radii",
      "maximum extent of the surface beside surfels, in surfel radii; for maps without radii only "
      "trim_distance_m applies",
      Positive());
  v.Add(trim_distance_m, "trim_distance_m",
        "maximum distance between the surface and the points of the map", Positive());
}

void TextureOptions::Visit(OptionVisitor& v) {
  v.Group("texture");
  v.Add(max_texture_px, "max_texture_px",
        "maximum side of the texture image; phones support 4096, some viewers at most 8192",
        ZeroIs("vertex colours, no texture"), Between(0, 16384), AsFlag(), Everyday());
  v.Add(max_texture_frames, "max_texture_frames",
        "maximum number of texture frames: the slowest frame in each of this many parts of the run",
        ZeroIs("all"));
  v.Add(min_sharpness, "min_sharpness",
        "minimum sharpness of the frame of a triangle, relative to its sharpest frame", Share());
  v.Add(
      seam_cost, "seam_cost",
      "relative loss of sharpness that is accepted for using the frame of a neighbouring triangle",
      AtLeast(0));
}

}  // namespace surfit
