// The options of this room.
#include "surfit/core/options.h"

#include <cmath>

#include "surfit/mesh/mesh_surfels.h"

namespace surfit {

void MeshOptions::Visit(OptionVisitor& v) {
  v.Group("mesh");
  v.Add(cell_m, "cell_m", "size of the cells that the surface is found in: about a triangle's side",
        Positive(), AsFlag(), Everyday());
  v.Add(max_triangles, "max_triangles", "triangles at most: flat parts get larger ones",
        ZeroIs("no limit"), AsFlag(), Everyday());
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

}  // namespace surfit
