#pragma once

#include <cstddef>
#include <limits>
#include <memory>

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

class OptionVisitor;

// Options of Fusion, MergeDuplicates() and the active window.
struct FusionOptions {
  static constexpr float kMaxRadiusRatio = 1.5f;  // coarser points do not change a surfel's shape
  static constexpr float kMaxConfidence = 200;    // upper limit, which keeps the map adaptable

  float merge_distance_m = 0.05f;  // maximum distance of point and surfel along the surfel normal
  float merge_angle_rad = 0.6f;    // maximum angle of the normals of point and surfel
  // Maximum distance of point and surfel across the surface. The radius of the point is a second
  // limit. This is also the surfel spacing on distant surfaces.
  float max_spacing_m = 0.01f;
  // Removes the less confident of two surfels that are closer across the surface than this ratio of
  // the minimum of max_spacing_m and both radii. 0: off.
  float duplicate_ratio = 0.7f;
  float max_slant_scale = 2;          // radius = sqrt(2) z / f * min(1 / |n_z|, max_slant_scale)
  float min_inactive_confidence = 1;  // less confident surfels are noise
  int max_inactive_frames = 20;       // fused frames until unobserved noise is removed
  // Surfels that were not observed in the last active_frames fused frames are inactive: points do
  // not merge with them. After drift, a revisited surface is mapped again. 0: no limit.
  int active_frames = 0;
  int max_map_points = 0;  // maximum number of surfels; a full map gets no new surfels; 0: no limit
  // Minimum depth difference of a free-space violation, plus 4 sigma of the depth. Active surfels
  // in front of the measured surface by more than this are removed, if all 3 x 3 pixels have depth.
  float free_space_margin_m = 0.05f;

  void Visit(OptionVisitor& visitor);
};

// Camera motion and readout time of a frame, to sample its colours. Default: no motion.
struct FrameMotion {
  CameraMotion camera;
  double readout_s = 0;  // of depth and colour
};

// Statistics of one fused frame. input_points = merged_points + covered_points + added + refused.
struct FusionReport {
  int input_points = 0;    // pixels with depth and a normal, also of a neighbour
  int merged_points = 0;   // points that merged with a surfel
  int covered_points = 0;  // points represented by the new surfel of a neighbouring pixel
  int merged = 0;          // updated surfels
  int added = 0;           // new surfels
  int refused = 0;         // surfels not added because of max_map_points
  int removed = 0;         // removed surfels: inactive noise, free-space violations, duplicates
};

// Point-based fusion of frames into a surfel map (Keller et al., 3DV 2013). Surfels are projected
// into the frame. Each point merges with the nearest matching surfel of 3 x 3 pixels, which may be
// occluded by another surfel. Surfels that were not observed for max_inactive_frames fused frames
// are noise if their confidence is low. Not thread-safe.
class Fusion {
 public:
  // Throws InputError for invalid options.
  explicit Fusion(const FusionOptions& options);
  ~Fusion();

  // Fuses a frame. Frame indices must increase, which is not checked. `surface` is the filtered
  // finest level of `frame`. The measured depth of `frame` is merged, because the map averages its
  // noise. `surface` gives normals and the noise model. Points at depth edges use the normal of a
  // neighbour on the same plane, and do not move surfels. Colours are sampled at the surfel
  // centres, with the camera motion between depth and colour. New surfels without a colour are
  // black (no brightness) with color_weight 0, or grey without a colour image. Ids become invalid.
  // The result is the same for any number of threads. Throws if depth and `surface` differ in size,
  // or if the frame index is negative or above SurfelBlock::kMaxFrame.
  FusionReport Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                    const Rigid3d& world_from_camera, const FrameMotion& motion, SurfelMap* map);
  FusionReport Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                    const Rigid3d& world_from_camera, SurfelMap* map) {
    return Fuse(frame, surface, world_from_camera, {}, map);
  }

  // First frame of the active window: surfels last observed in this frame or later are active.
  // Minimum of int: all surfels, until more than active_frames frames are fused, or without a
  // limit.
  int ActiveSince() const;
  // Restores the state after the fusion of these frames (ascending indices, not checked). Call
  // before the first Fuse().
  void ContinueAfter(const std::vector<int>& fused_frames);

 private:
  struct Workspace;

  FusionOptions options_;
  std::unique_ptr<Workspace> workspace_;
};

// Options of MergeDuplicates().
struct DuplicateOptions {
  // Duplicates have more than this number of frames between the last observation of the older and
  // the first observation of the newer surfel.
  int frames_apart = 100;
  int newer_since = std::numeric_limits<int>::min();  // minimum first_seen of the newer surfel
};

// Merges surfaces that were mapped twice, after a map correction has aligned them. Each newer
// surfel merges with the nearest older surfel within the gates of fusion. Distances are along and
// across the normal of the newer surfel. The older surfel becomes the average weighted by
// confidence, with the later last_seen. Returns the number of removed surfels. Ids become invalid.
// The result does not depend on the number of threads. Throws InputError for invalid `options`.
std::size_t MergeDuplicates(const FusionOptions& options, const DuplicateOptions& doubles,
                            SurfelMap* map);

}  // namespace surfit
