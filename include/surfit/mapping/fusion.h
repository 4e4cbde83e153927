#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

class OptionVisitor;

// How frames become surfels.
struct FusionOptions {
  std::string weighting = "confidence";  // or "uniform": a = 1 for every point
  float merge_distance_m = 0.05f;        // along the surfel's normal, between point and surfel
  float merge_angle_rad = 0.6f;          // between their normals
  // A point merges with a surfel if its ray passes the surfel's centre within the point's radius,
  // but never farther than this across the surface: so much stays between the surfels of a far or
  // coarsely sampled surface.
  float max_spacing_m = 0.01f;
  // Of two surfels that are closer across the surface than this share of their radii, and of the
  // spacing, the one of less confidence is removed. 0 = none.
  float duplicate_share = 0.7f;
  float max_slant_scale = 2;      // radius = sqrt(2) z / f times at most this for 1 / |n_z|
  float max_radius_ratio = 1.5f;  // points that are coarser than this do not move a surfel
  float lasting_confidence = 1;   // a surfel with less, seen about once, is noise ...
  int max_dormant_frames = 20;    // ... and removed after so many fused frames without it
  float max_confidence = 200;     // so that the map can still change
  // Surfels not seen in so many fused frames do not meet points: where the camera has drifted, what
  // it sees again is not fused with what it saw long ago, but mapped once more. 0 = no limit.
  int active_frames = 0;
  int max_map_points = 0;  // a map of so many surfels takes no further ones; 0 = no limit
  // Measured farther than this behind a surfel, plus 4 sigma of the depth: it is not there.
  float free_space_margin_m = 0.05f;

  void Visit(OptionVisitor& visitor);
};

// How a frame's camera moved while it took the images.
struct FrameMotion {
  CameraMotion camera;
  double readout_s = 0;  // of both images' rows
};

// What the fusion of one frame did.
struct FusionReport {
  int input_points = 0;    // pixels with depth and a normal, their own or a neighbour's
  int merged_points = 0;   // of those, the ones that met a surfel
  int covered_points = 0;  // points without one that a new surfel of a pixel beside stands for
  int merged = 0;          // surfels updated
  int added = 0;           // surfels, each from one of the other points
  int refused = 0;         // surfels that max_map_points left no place for
  int removed = 0;         // surfels: dormant noise, free-space violations and doubles
};

// Fuses posed frames into a map: point-based fusion (Keller et al., 3DV 2013). The map is projected
// into the frame at its tracked pose, so that each point meets the surfel nearest to itself rather
// than the one that happens to hide the others. A surfel stands for all points within their radius:
// with sqrt(2) pixels, discs of every second pixel of rows and columns just cover a surface. Keeps
// its buffers between frames, and remembers which frames it has fused: surfels go dormant by these,
// not by those that were skipped or lost.
class Fusion {
 public:
  explicit Fusion(const FusionOptions& options);
  ~Fusion();

  // Merges the measured depth of the frame, whose noise averages out in the map, with the normals
  // of `surface`, its filtered vertex and normal map, which tells the noise. Points at depth edges
  // have none: they take that of a neighbour whose plane they lie in. They complete the map, but
  // move no surfel. Surfels take the frame's colours where they lie, at the moment when their row
  // of the colour image was read. The result does not depend on the number of threads.
  FusionReport Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                    const Rigid3d& world_from_camera, const FrameMotion& motion, SurfelMap* map);
  FusionReport Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                    const Rigid3d& world_from_camera, SurfelMap* map) {
    return Fuse(frame, surface, world_from_camera, {}, map);
  }

  // The surfels that were last seen in this frame or later are active after the last one.
  int ActiveSince() const;
  // As if these frames, by ascending index, had been fused.
  void GoOnAfter(const std::vector<int>& fused_frames);

 private:
  struct Workspace;

  FusionOptions options_;
  std::unique_ptr<Workspace> workspace_;
};

// Which surfels may be doubles.
struct DoublesOptions {
  // The older one was last seen more than so many frames before the newer one was first seen: those
  // were never fused together.
  int frames_apart = 100;
  int newer_since = std::numeric_limits<int>::min();  // the newer one was first seen then or later
};

// Merges surfaces that were mapped twice, once the map has been moved so that they coincide. A
// surfel is merged with the nearest older one that is the same by the gates of fusion, measured
// along and across its own normal, as nobody looks at both: a surfel stands for what is within
// their radius. The older one stays, as the average of both by their
// confidences; the newer one is removed. Returns how many were. The result does not depend on the
// number of threads. Ids change.
std::size_t MergeDoubles(const FusionOptions& options, const DoublesOptions& doubles,
                         SurfelMap* map);

}  // namespace surfit
