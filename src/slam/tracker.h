#pragma once

#include <optional>

#include "slam/belief.h"
#include "slam/feature_watch.h"
#include "slam/motion_prior.h"
#include "slam/moving_regions.h"
#include "slam/prepared_frame.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/registration/far_registration.h"
#include "surfit/slam/slam.h"

namespace surfit {

// What a frame is registered to, and the pose that it is seen from.
struct ReferenceView {
  ColoredView view;  // its colours are the map's only where intensities count
  Rigid3d world_from_view;
  Image<float> grey;  // brightness of the model's cells (ViewGrid), 0 where unknown; may be empty

  bool has_intensities() const { return !view.pyramid.levels.front().intensity.empty(); }
};

// What came of tracking a frame.
struct Tracked {
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;             // meaningless if lost
  IcpResult icp;                         // of a frame that was registered, or failed to be
  bool found_again = false;              // after a jump
  bool has_second = false;               // found from afar as well
  int keyframe = -1;                     // that it was relocalised by
  bool has_own_view = false;             // the map was drawn for it
  Verdict verdict = Verdict::kBelieved;  // of a frame that was registered
  CellMask moving;                       // not registered, and not to be fused
  double moving_share = 0;               // of the points
  bool is_apart = false;                 // FrameReport::is_apart
  bool is_poorly_held = false;           // by shapes alone: SlamOptions::min_turn_eigenvalue
  double behind_share = 0;               // of the cells compared, those well behind the model
  bool is_by_newest = false;             // believed by surfels that are not stable yet
  // Of the motion to it, in the camera's frame, where that was expected.
  std::optional<Matrix6d> motion_covariance;

  bool is_held() const { return state != FrameState::kLost; }
};

// A registration, and whether shapes alone hold it poorly.
struct HeldPose {
  IcpResult icp;  // its pose is the most likely one
  bool is_poorly_held = false;
  std::optional<Matrix6d> covariance;  // of the left increment, where a pose was expected
};

// What a frame is registered to from a pose, and how.
struct Registering {
  const ReferenceView& reference;
  const IcpOptions& icp;
  std::optional<ExpectedPose> expected;  // in the reference's frame, if the motion tells it
};

// Where a lost frame may have been.
struct Proposal {
  ReferenceView view;  // without what moves
  Tracked tracked;
};

// Follows the camera: predicts its pose, registers frames, and keeps what the next one needs to
// know of those before.
class Tracker {
 public:
  // Keeps a reference to the options.
  Tracker(const SlamOptions& options, const Rigid3d& world_from_first_camera);

  // Another run has ended at the given pose: the map is known, but not where the camera is.
  void GoOnAfter(double stamp_s) {
    has_started_ = true;
    is_last_known_ = false;
    last_stamp_s_ = stamp_s;
  }
  // Whether the frame follows so soon that it may be tracked from the last pose.
  bool MayFollow(const PreparedFrame& frame) const;

  bool has_started() const { return has_started_; }
  // Frames since the last one that was held.
  int lost_count() const { return lost_count_; }
  // The last frame was lost, held poorly or by the newest surfels: the next one takes all that the
  // map can tell, and gives it all that it sees.
  bool needs_all() const { return lost_count_ > 0 || is_poorly_held_ || is_by_newest_; }
  // The next frame may be registered by its intensities as well.
  bool needs_intensities() const {
    return options_.icp.error_model.UsesIntensities() ||
           (options_.poorly_held_photometric_weight > 0 && needs_all());
  }
  // The last frame that was held, as far as the options need it; its pose always.
  const ReferenceView& last() const { return last_; }

  // Whether its depth is that of the frame before, byte for byte; it is compared with the next.
  bool Repeats(const RgbdFrame& frame);
  bool HasEnoughDepth(const PreparedFrame& frame) const;
  // Where the camera is expected with the next frame; nothing where the frame itself must tell.
  std::optional<Rigid3d> PredictNext() const;
  Rigid3d Predict(const PreparedFrame& frame) const;
  // How it moves, as far as the last frames tell.
  CameraMotion expected_motion() const { return lost_count_ > 0 ? CameraMotion() : motion_; }
  // How it has moved from the last frame, if that was the one before.
  CameraMotion MotionTo(double stamp_s, const Tracked& tracked) const;

  // Each of these is the outcome of a frame: the first one with enough depth, one that repeats the
  // last, and one that is registered to a reference from where it is expected.
  Tracked Start(const PreparedFrame& frame) const;
  Tracked Repeat() const;
  Tracked Track(const PreparedFrame& frame, const ReferenceView& reference,
                const Rigid3d& world_from_predicted) const;
  // Its pose once the motion during its readout is the one that it tells, not the expected one.
  Rigid3d PoseByItsMotion(const PreparedFrame& frame, double readout_s,
                          const Tracked& tracked) const;

  // Whether a frame that is not believed may show what those before have just begun to map: they
  // were all held, and it does not see through what the map shows, as it would from a wrong pose.
  bool MayShowNewest(const Tracked& tracked) const;
  // A frame that is not believed by what the map shows, and the same by all that was ever fused:
  // the second, if it is believed and at the same pose.
  Tracked Backed(Tracked tracked, Tracked by_newest) const;

  // Whether frames are looked for from afar that are not lost.
  bool doubts() const {
    return options_.sure_inlier_share > 0 && options_.initialize != "identity";
  }
  // Lost, after a loss or a jump, or held by so few inliers that it may be at a wrong pose.
  bool IsDoubtful(const Tracked& tracked) const;
  // Where a doubtful frame is, by tracking and from afar: from afar, where they do not agree. A
  // wrong pose near the last one may have as many inliers. After a loss tracking starts at no known
  // place, and is not believed alone.
  Tracked Better(Tracked tracked, std::optional<Tracked> found) const;

  // Where a doubtful frame may be, as far as it and the last one tell; nothing unless it is this
  // frame's turn to be looked for.
  std::optional<Rigid3d> FindFromLast(const PreparedFrame& frame) const;
  // A frame that was found there, if the reference agrees.
  std::optional<Tracked> Confirm(const PreparedFrame& frame, const ReferenceView& reference,
                                 const Rigid3d& world_from_found) const;

  // After a long loss, and where no hand moves a camera so far, one frame is not enough: the next
  // must be found from there, and from this one likewise. Whether this outcome is such a one.
  bool NeedsConfirmation(const PreparedFrame& frame, const Tracked& tracked) const;
  void Propose(const PreparedFrame& frame, const Tracked& tracked);
  bool has_proposal() const { return proposal_.has_value(); }
  // What was proposed, at the pose of a frame that was tracked from there and agrees; nothing if it
  // does not. There is no proposal afterwards.
  std::optional<Tracked> ConfirmProposal(const PreparedFrame& frame, const Tracked& tracked);
  // The one that the frame at work has confirmed, if so; null once that is kept or lost.
  const Proposal* confirmed() const { return confirmed_ ? &*confirmed_ : nullptr; }

  // Asks the images whether a frame that is held is where it is said to be: else it is lost.
  Tracked Checked(const PreparedFrame& frame, Tracked tracked);

  // Each frame that is held, with what moves in it.
  void Remember(const PreparedFrame& frame, const Tracked& tracked) {
    regions_.Remember(frame.surface(), tracked.moving, tracked.world_from_camera,
                      frame.images.stamp_s);
  }
  // One of both is to be called with each outcome but of a frame that repeats the last.
  void Keep(PreparedFrame frame, const Tracked& tracked);
  void Lose() {
    ++lost_count_;
    if (!MovesOn()) motion_prior_.Forget();
    confirmed_.reset();
    needs_search_ = true;
  }

  // The world has been corrected.
  void Move(const Rigid3d& new_from_old_world);

 private:
  // Accelerations are given, and so few frames have been lost that the camera moves as before.
  bool MovesOn() const;
  // Found far from where it was expected: by a place that looks alike.
  bool IsUnexpected(const Tracked& found) const;
  void KeepMotion(const PreparedFrame& frame, const Tracked& tracked);
  // How surely a frame is where it is expected; nothing where the motion does not tell.
  std::optional<Matrix6d> ExpectedCovariance(const PreparedFrame& frame) const;
  Tracked RegisterTo(const ReferenceView& reference, const PreparedFrame& frame,
                     const Rigid3d& world_from_start, const IcpOptions& icp_options,
                     const std::optional<Matrix6d>& covariance = std::nullopt) const;
  // By shapes, and where these hold it poorly by intensities as well. What both leave open follows
  // the motion.
  HeldPose Hold(const FramePyramid& frame, const Registering& registering,
                const Rigid3d& reference_from_start) const;
  HeldPose HoldByData(const FramePyramid& frame, const Registering& registering,
                      const Rigid3d& reference_from_start) const;
  Tracked Judge(const PreparedFrame& frame, const Registering& registering,
                const HeldPose& held) const;

  const SlamOptions& options_;
  Belief belief_;
  MovingRegions regions_;
  FeatureWatch features_;
  std::optional<Proposal> proposal_;  // of the last frame
  std::optional<Proposal> confirmed_;
  bool has_started_ = false;
  bool is_last_known_ = true;  // false until a frame is held where another run has ended
  int lost_count_ = 0;
  bool needs_search_ = false;    // the last frame was lost, or came with a jump
  bool is_poorly_held_ = false;  // the last frame,
  bool is_by_newest_ = false;    // likewise
  ReferenceView last_;
  double last_stamp_s_ = 0;
  CameraMotion motion_;        // to the last frame
  MotionPrior motion_prior_;   // likewise, how surely
  Rigid3d last_from_next_;     // motion that the motion model expects
  Image<float> last_depth_m_;  // of the last frame, held or not
};

}  // namespace surfit
