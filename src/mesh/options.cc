// The options of this module.
#include "surfit/core/options.h"

#include <cmath>

#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

void MeshOptions::Visit(OptionVisitor& v) {
  v.Group("mesh");
  v.Add(cell_m, "cell_m", "size of the cells that the surface is found in: about a triangle's side",
        Positive(), AsFlag(), Everyday());
  v.Add(max_triangles, "max_triangles", "triangles at most: flat parts get larger ones",
        ZeroIs("no limit"), AsFlag(), Everyday());
  v.Add(watertight, "watertight",
        "fill all holes, with triangles that are made up; a sheet gets a back", AsFlag(),
        Everyday());
  v.Add(min_piece_m, "min_piece_m", "loose pieces that are smaller across are left out",
        ZeroIs("none"), AsFlag(), Everyday());
  v.Add(normal_noise_rad, "normal_noise_rad",
        "surfels are smoothed until noise tilts their normals by about this", ZeroIs("as they are"),
        Below(M_PI / 2), AsFlag());
  v.Add(support_radii, "support_radii",
        "the surface goes on beside surfels by so many of their radii; maps without radii are "
        "trimmed by distance alone",
        Positive(), AsFlag());
  v.Add(trim_distance_m, "trim_distance_m",
        "nothing farther than this from all points of the map is kept", Positive(), AsFlag());
}

void TextureOptions::Visit(OptionVisitor& v) {
  v.Group("texture");
  v.Add(max_texture_px, "max_texture_px",
        "sides of the picture at most; phones take 4096, and some viewers no more than 8192",
        ZeroIs("none: colours of vertices"), Between(0, 16384), AsFlag(), Everyday());
  v.Add(max_texture_frames, "max_texture_frames",
        "frames that are looked at: of equal parts of the run the ones that moved least",
        ZeroIs("all"), AsFlag());
  v.Add(least_sharpness, "least_sharpness",
        "of the frame that a triangle has, as a share of that of its sharpest", Share(), AsFlag());
  v.Add(seam_cost, "seam_cost",
        "share of its sharpness that a triangle gives up to have a neighbour's frame", AtLeast(0),
        AsFlag());
}

}  // namespace surfit
