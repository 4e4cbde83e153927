#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "surfit/core/image.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/registration/far_registration.h"
#include "surfit/registration/icp.h"
#include "surfit/slam/backend.h"
#include "surfit/slam/slam_state.h"

namespace surfit {

class OptionVisitor;

// The options of ICP from a frame to the next or to the map: the symmetric residual. A normal
// estimated near a crease mixes both sides; point-to-plane against it is biased, always to the same
// side as the camera moves on, and the sum of both views' normals much less. Of 480 rows a third is
// enough: what is left of the error is not the noise of single points.
inline IcpOptions TrackingIcpOptions() {
  IcpOptions icp;
  icp.residual = "symmetric_point_to_plane";
  icp.min_source_rows = 160;
  return icp;
}

// How the camera is tracked and the map is made.
struct SlamOptions {
  PreprocessOptions preprocess;
  IcpOptions icp = TrackingIcpOptions();
  FusionOptions fusion;
  RenderOptions render;
  std::string tracking = "frame_to_model";  // or "frame_to_frame"
  // Of so many frames that are tracked one is fused, and one gets a view of the map of its own,
  // which the next are registered to as well. Views of one place hardly differ at 30 Hz. 1: all.
  // Where intensities count every frame gets its own.
  int map_period = 2;
  // A frame that the camera has moved farther for since that view or that fusion, as a share of the
  // image's width at the scene's mean depth, gets its own or is fused in any case.
  double max_view_shift = 0.1;
  // After a frame whose data hold a direction of motion less than this (the smallest of
  // IcpResult::eigenvalues), every frame is fused, has its own view and is registered with all
  // rows: before a wall all of it is needed.
  double min_turn_eigenvalue = 2e-3;
  // And where shapes hold the frame itself so little, too, it is registered by intensities as well,
  // with this weight (ErrorModel::photometric_weight): before a wall or over a floor they alone
  // tell how the camera moves along it. 0: never. Where intensities count in any case, as there.
  double poorly_held_photometric_weight = 0;
  // Where tracking starts: constant_velocity, constant_pose, or so3: the last pose, turned so that
  // small images of both frames are most alike (AlignRotation).
  std::string motion_model = "constant_velocity";
  // A camera in a hand moves on as before, but for such accelerations (of each component, standard
  // deviation): what a frame's data leave open of its pose follows that. Recordings have 1 to 4.
  // Needs constant_velocity. 0: the data alone tell, however little they hold.
  double acceleration_m_per_s2 = 0;
  double turn_acceleration_rad_per_s2 = 4;
  // A registration is believed if so many of the points find a partner with such a residual.
  double min_inlier_share = 0.3;
  double max_rmse_m = 0.03;
  // One with a smaller share of inliers, or farther away than max_view_shift, is looked for from
  // afar as well, by `initialize`, and so is what follows a jump or a loss. 0: only lost frames
  // are.
  double sure_inlier_share = 0.4;
  // How a frame that tracking would lose is found from the last good one, however far it is: see
  // InitializeOptions::method; identity: not at all. It is believed only if the map agrees.
  std::string initialize = "features";
  LoopOptions loops;
  CalibrationOptions calibration;
  // Frames come at a camera's rate: none waits for what is found of loops and the camera, which
  // takes effect when it is there. So the result depends on the machine. Else a frame that it does
  // not depend on waits.
  bool real_time = false;
  // The last of so many frames is tracked, but never fused: the map can be judged by it. A frame
  // that begins a map is fused. 0: all frames are.
  int hold_out = 0;

  void Visit(OptionVisitor& visitor);
};

enum class FrameState {
  kFirst,        // the first frame with enough depth to start: it stands at the initial pose
  kTracked,      // registered, possibly found again from far
  kDegenerate,   // the same, but for directions that the data leaves free: there, as predicted
  kFrozen,       // its depth repeats the last frame's byte for byte: same pose, nothing fused
  kGiven,        // fused at a given pose, without tracking
  kLost,         // not registered: no pose, nothing fused
  kRelocalized,  // found again by a keyframe, and fused
  kNewMap,       // after long loss the first of a map apart: see LoopOptions::new_map_after
};

// "first", "tracked", "degenerate", "frozen", "given", "lost", "relocalised", "new_map".
std::string ToString(FrameState state);

// Wall time spent in each stage, milliseconds.
struct StageTimes {
  double preprocess_ms = 0;
  double predict_ms = 0;  // drawing the map, for this frame or ahead for the next
  double track_ms = 0;
  double fuse_ms = 0;
  double correct_ms = 0;  // of the map, by loops
};

// A frame that was lost when it came, and the pose that the next one has confirmed.
struct ConfirmedFrame {
  int index = 0;
  double stamp_s = 0;
  Rigid3d world_from_camera;
};

// What became of one frame.
struct FrameReport {
  int index = 0;
  double stamp_s = 0;
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;  // meaningless if lost
  bool found_again = false;   // tracked after a jump, by SlamOptions::initialize
  bool has_own_view = false;  // the map was drawn for it, unless it is not to be tracked against
  bool is_fused = false;      // into the map
  bool is_held_out = false;   // tracked, but not to be fused: SlamOptions::hold_out
  double moving_share = 0;    // of its points, those that move by themselves: neither tracked nor
                              // fused
  // The images were asked, and parts of them have moved apart: the camera may be seen against
  // something that moves. Where most of them speak against the pose, it is lost.
  bool is_apart = false;
  Image<std::uint8_t>
      moving;           // where they are: cells of the image, not 0; empty where nothing moves
  IcpResult icp;        // of a tracked or lost frame
  FusionReport fusion;  // of a fused frame
  std::optional<ConfirmedFrame> confirmed;  // the frame before
  StageTimes times;
};

// Where a frame was found to be, before anything is made of it.
struct FramePose {
  int index = 0;
  double stamp_s = 0;
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;  // meaningless if lost
};

// A frame that tracking lost, and the registration that it was lost in. What it refers to is gone
// after the call that is given it.
struct LostFrame {
  int index = 0;
  const FramePyramid& source;
  const FramePyramid& target;
  const Image<Rgb8>& source_color;  // of the finest level's pixels; empty where there is none,
  const Image<Rgb8>& target_color;  // or where nobody asks for the map's
  Rigid3d target_from_source_initial;
  const IcpResult& icp;
};

// Dense SLAM by point-based fusion: each frame is registered to what the map predicts, and one of
// SlamOptions::map_period is fused into the map at the pose found. Where SlamOptions::loops are
// enabled, the map follows the poses that closed loops correct.
class Slam {
 public:
  // The sensor's camera has fy > 0. Throws InputError for a bad sensor or bad options.
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera);
  // Takes up what another Slam has known of the same sensor, with loops enabled and tracking from
  // frame to model. The camera may be anywhere: it is looked for among the keyframes, and from the
  // last pose if the first frame follows that soon; what is found counts once the next frame
  // agrees. Frames' indices must go on from the state's. Throws InputError for options that do not
  // fit.
  Slam(const DepthSensor& sensor, const SlamOptions& options, SlamState state, StateUse use);
  ~Slam();

  // Tracks and fuses the next frame. The frame's size must be the sensor's.
  FrameReport Process(const RgbdFrame& frame);

  // Fuses the next frame at a known pose. From then on the camera stays as it was found: it is not
  // calibrated by poses that must not move.
  FrameReport ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera);

  // To be called with each frame as soon as its pose is known, or that it is lost: the frame is
  // then fused, which takes longer than tracking it. The call must not throw, nor call this object.
  void OnPose(std::function<void(const FramePose&)> call);

  // To be called with each frame that tracking loses.
  void OnLostFrame(std::function<void(const LostFrame&)> call);

  // How loops are found, instead of FindLoops(). To be called before the first frame, with loops
  // enabled.
  void UseLoopFinder(LoopFinder finder);

  // To be called with each new keyframe, with loops enabled.
  void OnKeyframe(KeyframeCall call);

  // From the next frame on, in place of SlamOptions::map_period: where frames come faster than they
  // are done, fewer of them are fused. If it is longer than that one, min_turn_eigenvalue no longer
  // makes frames be fused out of turn. Throws InputError unless that is at least 1.
  void SetMapPeriod(int frames);

  // Takes in what is still being found out about loops and the camera. To be called after the last
  // frame.
  void Finish();

  const SurfelMap& map() const;
  // Surfels that became part of others when the map was moved, in all.
  std::size_t merged_doubles() const;
  // How often surfels have changed that no frame was fused to.
  int corrections_of_map() const;
  // The sensor as the last frame was seen by: with the camera that calibration has found.
  const DepthSensor& sensor() const;
  // Null unless loops or calibration are enabled.
  const Backend* backend() const;

 private:
  class Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace surfit
