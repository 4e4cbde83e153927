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

// Options of the fusion of frames into a surfel map.
struct FusionOptions {
  std::string weighting = "confidence";  // "confidence" or "uniform" (weight 1 for every point)
  float merge_distance_m = 0.05f;        // between point and surfel, along the normal of the surfel
  float merge_angle_rad = 0.6f;          // between the normals of point and surfel
  // Maximum distance of merging across the surface; the radius of the point is a further limit.
  // This is the spacing of surfels on distant or coarsely sampled surfaces.
  float max_spacing_m = 0.01f;
  // Two surfels are duplicates if they are closer across the surface than this ratio of
  // max_spacing_m and of both radii. The less confident surfel is removed. 0: off.
  float duplicate_ratio = 0.7f;
  float max_slant_scale = 2;          // radius = sqrt(2) z / f * min(1 / |n_z|, max_slant_scale)
  float max_radius_ratio = 1.5f;      // of point to surfel; coarser points do not move the surfel
  float min_inactive_confidence = 1;  // less confident surfels are noise, see max_inactive_frames
  int max_inactive_frames = 20;       // fused frames without observation before noise is removed
  float max_confidence = 200;         // limit that keeps the map adaptable
  // Surfels without observation in the last active_frames fused frames are inactive: points do not
  // merge with them. After drift, a revisited surface is therefore mapped again. 0: no limit.
  int active_frames = 0;
  int max_map_points = 0;  // a full map accepts no new surfels; 0: no limit
  // Surfels are free-space violations if the measured depth is larger by more than this plus 4
  // sigma of the depth. They are removed.
  float free_space_margin_m = 0.05f;

  void Visit(OptionVisitor& visitor);
};

// Motion of the camera during the exposure of a frame.
struct FrameMotion {
  CameraMotion camera;
  double readout_s = 0;  // of depth and colour
};

// Statistics of the fusion of one frame.
struct FusionReport {
  int input_points = 0;    // pixels with depth and a normal, or the normal of a neighbour
  int merged_points = 0;   // points that merged with a surfel
  int covered_points = 0;  // points represented by the new surfel of a neighbouring pixel
  int merged = 0;          // surfels updated
  int added = 0;           // new surfels, each from one point
  int refused = 0;         // new surfels rejected because of max_map_points
  int removed = 0;         // inactive noise, free-space violations and duplicate surfels
};

// Point-based fusion of frames with poses into a surfel map (Keller et al., 3DV 2013). The surfels
// are projected into the frame, and each point merges with the nearest surfel, even if another
// surfel occludes it. With a radius of sqrt(2) pixels, the discs of every second row and column
// just cover a surface. Stores the indices of the fused frames: max_inactive_frames and
// active_frames do not count skipped or lost frames. Not thread-safe.
class Fusion {
 public:
  // Throws InputError for invalid options.
  explicit Fusion(const FusionOptions& options);
  ~Fusion();

  // Merges the measured depth of `frame` with the normals and the noise model of `surface`, the
  // filtered level of the same frame. The map averages the noise of the measured depth. Points at
  // depth edges have no normal. They take the normal of a neighbour if they are on its plane, and
  // do not move surfels. Colours are sampled at the centres of the surfels. The camera motion
  // between depth and the colour row is compensated. The result does not depend on the number of
  // threads. Aborts if the image sizes differ.
  FusionReport Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                    const Rigid3d& world_from_camera, const FrameMotion& motion, SurfelMap* map);
  FusionReport Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                    const Rigid3d& world_from_camera, SurfelMap* map) {
    return Fuse(frame, surface, world_from_camera, {}, map);
  }

  // Surfels last observed in this frame or later are active. The minimum of int: all surfels.
  int ActiveSince() const;
  // Restores the state after the fusion of these frames (ascending indices).
  void ContinueAfter(const std::vector<int>& fused_frames);

 private:
  struct Workspace;

  FusionOptions options_;
  std::unique_ptr<Workspace> workspace_;
};

// Selection of duplicate surfels.
struct DuplicateOptions {
  // Duplicates have more than this number of frames between the last observation of the older and
  // the first observation of the newer surfel. Closer observations are already fused.
  int frames_apart = 100;
  int newer_since = std::numeric_limits<int>::min();  // minimum first_seen of the newer surfel
};

// Merges surfaces that were mapped twice, after a map correction has aligned them. Each newer
// surfel merges with the nearest older surfel within the gates of fusion. Distances are measured
// along and across the normal of the newer surfel, because there is no viewing ray. The older
// surfel becomes the average weighted by confidence. Returns the number of removed newer surfels.
// Ids become invalid. The result does not depend on the number of threads. Throws InputError for
// invalid `options`.
std::size_t MergeDuplicates(const FusionOptions& options, const DuplicateOptions& doubles,
                            SurfelMap* map);

}  // namespace surfit
