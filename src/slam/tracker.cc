#include "slam/tracker.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/trace.h"
#include "frame/rolling_shutter.h"
#include "surfit/registration/far_registration.h"

namespace surfit {
namespace {

// Of lost frames the first five are looked for, and then every fifth: that takes as long as
// tracking ten frames.
constexpr int kSearchStride = 5;

// Over more time a hand does not move steadily.
constexpr double kMaxMotion_s = 0.1;
// Over so many lost frames it does, if accelerations are given.
constexpr int kSteadyFrames = 3;

// A registration that shapes hold poorly, farther from where the camera is expected, is led astray:
// by intensities that repeat, as of planks. Of accelerations of 2 m/s^2, a hand's, these are 1 g.
constexpr double kMostSigmas = 5;

// A camera that was tracked until then is near enough to be tracked on.
constexpr double kFollows_s = 1;

// A level that is coarse enough to be summed up in next to no time.
constexpr std::size_t kReadoutLevel = 3;

// A frame that passes the side of a doorway sees through nothing (less than 0.2 % of the cells).
// From a wrong pose about as much is behind the map as before it, and more than 12 % in all.
constexpr double kMostBehindNewest = 0.02;

// What two views must show to be looked at in the map: its surfaces are to agree in any case, and
// motion blurs colours.
FitCriteria ShapesAlone() {
  FitCriteria fit = InitializeOptions::FrameCriteria();
  fit.min_value_correlation = fit.min_detail_correlation = -1;
  return fit;
}

bool AreWithin(double way_m, double turn_rad, const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d between = a.Inverse() * b;
  return between.translation.norm() <= way_m && RotationAngle(between.rotation) <= turn_rad;
}

// As a pose found forwards and one found backwards must.
bool Agree(const Tracked& a, const Tracked& b) {
  const FitCriteria criteria;
  return AreWithin(criteria.max_disagreement_m, criteria.max_disagreement_rad, a.world_from_camera,
                   b.world_from_camera);
}

// What the map says and what another view says, which is as exact as one frame is: a wrong pose is
// off by more.
bool AreOnePlace(const Rigid3d& a, const Rigid3d& b) { return AreWithin(0.05, 0.05, a, b); }

}  // namespace

Tracker::Tracker(const SlamOptions& options, const Rigid3d& world_from_first_camera)
    : options_(options),
      belief_(options),
      features_(options.icp.error_model),
      last_{{}, world_from_first_camera, {}},
      motion_prior_(options.acceleration_m_per_s2, options.turn_acceleration_rad_per_s2) {}

bool Tracker::Repeats(const RgbdFrame& frame) {
  const bool repeats = has_started_ && frame.depth_m == last_depth_m_;
  last_depth_m_ = frame.depth_m;
  return repeats;
}

bool Tracker::HasEnoughDepth(const PreparedFrame& frame) const {
  const Image<float>& normal_z = frame.surface().normal.z;
  const auto points =
      std::count_if(normal_z.begin(), normal_z.end(), [](float z) { return z < 0; });
  return points >= options_.icp.min_inliers;
}

bool Tracker::MayFollow(const PreparedFrame& frame) const {
  const double seconds = frame.images.stamp_s - last_stamp_s_;
  return is_last_known_ || (seconds > 0 && seconds < kFollows_s);
}

std::optional<Rigid3d> Tracker::PredictNext() const {
  if (proposal_) return proposal_->view.world_from_view;
  if (!is_last_known_) return last_.world_from_view;
  if (options_.motion_model == "so3") return std::nullopt;
  if (options_.motion_model == "constant_pose") return last_.world_from_view;
  // After a loss the motion is unknown, unless accelerations are given: start where the camera was
  // last seen.
  if (lost_count_ > 0 && !MovesOn()) return last_.world_from_view;
  Rigid3d expected = last_.world_from_view;
  for (int i = 0; i <= lost_count_; ++i) expected = expected * last_from_next_;
  return expected;
}

bool Tracker::MovesOn() const {
  return options_.acceleration_m_per_s2 > 0 && has_started_ && is_last_known_ && !proposal_ &&
         lost_count_ < kSteadyFrames;
}

Rigid3d Tracker::Predict(const PreparedFrame& frame) const {
  if (const std::optional<Rigid3d> predicted = PredictNext()) return *predicted;
  const ViewPair views = {frame.view.pyramid, frame.view.color, last_.view.pyramid,
                          last_.view.color};
  return last_.world_from_view * AlignRotation(views, Rigid3d());
}

CameraMotion Tracker::MotionTo(double stamp_s, const Tracked& tracked) const {
  const double seconds = stamp_s - last_stamp_s_;
  const bool follows = has_started_ && is_last_known_ && lost_count_ == 0 && seconds < kMaxMotion_s;
  if (!follows || tracked.found_again) return {};
  return MotionOver(last_.world_from_view.Inverse() * tracked.world_from_camera, seconds);
}

Tracked Tracker::Start(const PreparedFrame& frame) const {
  Tracked tracked;
  tracked.state = HasEnoughDepth(frame) ? FrameState::kFirst : FrameState::kLost;
  tracked.world_from_camera = last_.world_from_view;
  return tracked;
}

Tracked Tracker::Repeat() const {
  Tracked tracked;
  tracked.state = lost_count_ > 0 ? FrameState::kLost : FrameState::kFrozen;
  tracked.world_from_camera = last_.world_from_view;
  return tracked;
}

Tracked Tracker::Track(const PreparedFrame& frame, const ReferenceView& reference,
                       const Rigid3d& world_from_predicted) const {
  IcpOptions icp_options = options_.icp;
  if (is_poorly_held_) icp_options.min_source_rows = 0;
  return RegisterTo(reference, frame, world_from_predicted, icp_options, ExpectedCovariance(frame));
}

std::optional<Matrix6d> Tracker::ExpectedCovariance(const PreparedFrame& frame) const {
  const double seconds = frame.images.stamp_s - last_stamp_s_;
  if (!MovesOn() || !(seconds > 0)) return std::nullopt;
  return motion_prior_.Covariance(seconds);
}

Rigid3d Tracker::PoseByItsMotion(const PreparedFrame& frame, double readout_s,
                                 const Tracked& tracked) const {
  const double stamp_s = frame.images.stamp_s;
  const CameraMotion motion = MotionTo(stamp_s, tracked);
  const bool is_free = !tracked.icp.free_directions.empty();
  if (readout_s == 0 || motion.IsZero() || is_free) return tracked.world_from_camera;
  const std::vector<FrameLevel>& levels = frame.view.pyramid.levels;
  return tracked.world_from_camera *
         ReadoutCorrection(levels[std::min(kReadoutLevel, levels.size() - 1)], readout_s,
                           frame.motion, motion, stamp_s - last_stamp_s_);
}

Tracked Tracker::RegisterTo(const ReferenceView& reference, const PreparedFrame& frame,
                            const Rigid3d& world_from_start, const IcpOptions& icp_options,
                            const std::optional<Matrix6d>& covariance) const {
  const Rigid3d start = reference.world_from_view.Inverse() * world_from_start;
  Registering registering = {reference, icp_options, std::nullopt};
  if (covariance) registering.expected = In(start, {Rigid3d(), *covariance});
  Tracked tracked = Judge(frame, registering, Hold(frame.view.pyramid, registering, start));
  if (tracked.is_held()) return tracked;
  // Something may have come before most of the view, and led the registration astray.
  HeldPose none;
  none.icp.target_from_source = start;
  const Tracked hidden = Judge(frame, registering, none);
  if (!hidden.is_held()) return tracked;
  const Tracked again =
      Judge(frame, registering, {hidden.icp, hidden.is_poorly_held, std::nullopt});
  return again.is_held() ? again : tracked;
}

HeldPose Tracker::Hold(const FramePyramid& frame, const Registering& registering,
                       const Rigid3d& reference_from_start) const {
  HeldPose held = HoldByData(frame, registering, reference_from_start);
  if (!registering.expected || !held.icp.Succeeded()) return held;
  const ExpectedPose likely =
      MostLikely(*registering.expected, held.icp.target_from_source, held.icp.trusted_information,
                 held.is_poorly_held ? kMostSigmas : std::numeric_limits<double>::infinity());
  held.icp.target_from_source = likely.target_from_source;
  held.covariance = likely.covariance;
  return held;
}

HeldPose Tracker::HoldByData(const FramePyramid& frame, const Registering& registering,
                             const Rigid3d& reference_from_start) const {
  const FramePyramid& model = registering.reference.view.pyramid;
  const IcpOptions& icp_options = registering.icp;
  HeldPose held;
  held.icp = Register(frame, model, reference_from_start, icp_options);
  held.is_poorly_held =
      !held.icp.iterations.empty() && held.icp.eigenvalues[0] < options_.min_turn_eigenvalue;
  const bool can_help =
      options_.poorly_held_photometric_weight > 0 && !icp_options.error_model.UsesIntensities() &&
      !frame.levels.front().intensity.empty() && !model.levels.front().intensity.empty();
  if (!held.is_poorly_held || !can_help) return held;
  IcpOptions with_intensities = icp_options;
  with_intensities.error_model.photometric_weight = options_.poorly_held_photometric_weight;
  held.icp = Register(frame, model, reference_from_start, with_intensities);
  return held;
}

// Compares the views at a pose. Where something moves, the frame is registered once more without
// it.
Tracked Tracker::Judge(const PreparedFrame& frame, const Registering& registering,
                       const HeldPose& held) const {
  const ReferenceView& reference = registering.reference;
  const FramePyramid& model = reference.view.pyramid;
  const auto compare_at = [&](const Rigid3d& model_from_frame) {
    return CompareViews(frame.surface(), frame.images.color, model.levels.front(), reference.grey,
                        registering.icp.error_model, model_from_frame);
  };
  Tracked tracked;
  HeldPose best = held;
  const Rigid3d& model_from_frame = held.icp.target_from_source;
  ViewComparison views = compare_at(model_from_frame);
  tracked.moving = regions_.Find(
      frame.surface(), views, reference.world_from_view * model_from_frame, frame.images.stamp_s);
  if (!tracked.moving.empty()) {
    best = Hold(Without(frame.view.pyramid, tracked.moving), registering, model_from_frame);
    views = compare_at(best.icp.target_from_source);
  }
  if (best.covariance) {
    tracked.motion_covariance =
        In(best.icp.target_from_source.Inverse(), {Rigid3d(), *best.covariance}).covariance;
  }
  tracked.icp = std::move(best.icp);
  tracked.is_poorly_held = best.is_poorly_held;
  tracked.world_from_camera = reference.world_from_view * tracked.icp.target_from_source;
  const int moving = views.CountInFront(tracked.moving);
  tracked.moving_share = views.points > 0 ? static_cast<double>(moving) / views.points : 0;
  tracked.behind_share =
      views.compared > 0 ? static_cast<double>(views.behind) / views.compared : 0;
  tracked.verdict = belief_.Judge(tracked.icp, views, moving);
  if (tracked.verdict == Verdict::kRefuted) return tracked;
  tracked.state =
      tracked.icp.free_directions.empty() ? FrameState::kTracked : FrameState::kDegenerate;
  return tracked;
}

bool Tracker::MayShowNewest(const Tracked& tracked) const {
  return tracked.verdict != Verdict::kBelieved && lost_count_ == 0 && is_last_known_ &&
         options_.tracking != "frame_to_frame" && tracked.behind_share <= kMostBehindNewest;
}

Tracked Tracker::Backed(Tracked tracked, Tracked by_newest) const {
  const bool is_believed = by_newest.is_held() && by_newest.verdict == Verdict::kBelieved;
  if (!is_believed || !AreOnePlace(tracked.world_from_camera, by_newest.world_from_camera))
    return tracked;
  by_newest.has_second = by_newest.is_by_newest = true;
  return by_newest;
}

bool Tracker::IsDoubtful(const Tracked& tracked) const {
  return !tracked.is_held() || tracked.verdict == Verdict::kDoubtful || lost_count_ > 0 ||
         !is_last_known_ ||
         (doubts() && (needs_search_ || tracked.icp.inlier_share < options_.sure_inlier_share));
}

bool Tracker::IsUnexpected(const Tracked& found) const {
  return MovesOn() && !AreOnePlace(*PredictNext(), found.world_from_camera);
}

Tracked Tracker::Better(Tracked tracked, std::optional<Tracked> found) const {
  if (found && !(tracked.is_held() && IsUnexpected(*found))) {
    if (!tracked.is_held() || !Agree(tracked, *found)) return *std::move(found);
    tracked.verdict = Verdict::kBelieved;
    tracked.has_second = true;
    return tracked;
  }
  if (tracked.verdict == Verdict::kDoubtful) tracked.state = FrameState::kLost;
  return tracked;
}

std::optional<Rigid3d> Tracker::FindFromLast(const PreparedFrame& frame) const {
  if (options_.initialize == "identity" || !is_last_known_) return std::nullopt;
  const bool is_soon = doubts() && lost_count_ < kSearchStride;
  if (!is_soon && lost_count_ % kSearchStride != 0) return std::nullopt;
  if (!HasEnoughDepth(frame)) return std::nullopt;
  const TraceSlice slice("find_again", frame.images.index);
  InitializeOptions initialization;
  initialization.method = options_.initialize;
  // A plain surface agrees with itself all along: there colours have a say.
  const bool is_plain = is_poorly_held_ && options_.acceleration_m_per_s2 > 0;
  if (doubts() && !is_plain) initialization.fit = ShapesAlone();
  IcpOptions icp_options = FarIcpOptions();
  icp_options.min_source_rows = options_.icp.min_source_rows;
  const FarVerdict found = RegisterFar(frame.view, last_.view, initialization, icp_options);
  if (!found.accepted()) return std::nullopt;
  return last_.world_from_view * found.target_from_source;
}

std::optional<Tracked> Tracker::Confirm(const PreparedFrame& frame, const ReferenceView& reference,
                                        const Rigid3d& world_from_found) const {
  Tracked tracked = RegisterTo(reference, frame, world_from_found, options_.icp);
  if (!tracked.is_held()) return std::nullopt;
  if (tracked.verdict == Verdict::kDoubtful) {
    if (!AreOnePlace(tracked.world_from_camera, world_from_found)) return std::nullopt;
    tracked.verdict = Verdict::kBelieved;
  }
  tracked.found_again = tracked.has_second = true;
  return tracked;
}

void Tracker::Propose(const PreparedFrame& frame, const Tracked& tracked) {
  ColoredView rest = {Without(frame.view.pyramid, tracked.moving), frame.view.color};
  proposal_ = {{std::move(rest), tracked.world_from_camera, {}}, tracked};
}

bool Tracker::NeedsConfirmation(const PreparedFrame& frame, const Tracked& tracked) const {
  if (!is_last_known_) return true;
  if (lost_count_ == 0 && !tracked.found_again) return false;
  if (!tracked.has_second) return true;  // tracking started at no known place
  const Rigid3d motion = last_.world_from_view.Inverse() * tracked.world_from_camera;
  return lost_count_ >= kSearchStride ||
         !Belief::IsPossible(motion, frame.images.stamp_s - last_stamp_s_);
}

std::optional<Tracked> Tracker::ConfirmProposal(const PreparedFrame& frame,
                                                const Tracked& tracked) {
  Proposal proposal = *std::move(proposal_);
  proposal_.reset();
  if (!tracked.is_held() || tracked.verdict != Verdict::kBelieved) return std::nullopt;
  const PreparedFrame rest = {
      frame.images, {Without(frame.view.pyramid, tracked.moving), frame.view.color}, frame.motion};
  const Tracked from_there =
      RegisterTo(proposal.view, rest, tracked.world_from_camera, options_.icp);
  if (!from_there.is_held() ||
      !AreOnePlace(from_there.world_from_camera, tracked.world_from_camera)) {
    return std::nullopt;
  }
  Tracked confirmed = tracked;
  confirmed.found_again = true;
  confirmed.keyframe = proposal.tracked.keyframe;
  if (confirmed.keyframe >= 0) confirmed.state = FrameState::kRelocalized;
  confirmed_ = std::move(proposal);
  return confirmed;
}

Tracked Tracker::Checked(const PreparedFrame& frame, Tracked tracked) {
  const double stamp_s = frame.images.stamp_s;
  if (!doubts()) return tracked;
  features_.Follow(frame.view,
                   tracked.is_held() ? std::optional(tracked.world_from_camera) : std::nullopt,
                   stamp_s);
  if (!tracked.is_held()) return tracked;
  if (!features_.IsDue(stamp_s) && !tracked.found_again) return tracked;
  const Rigid3d& pose = tracked.world_from_camera;
  CameraMotion since_last;
  if (is_last_known_) {
    since_last = MotionOver(last_.world_from_view.Inverse() * pose, stamp_s - last_stamp_s_);
  }
  const FeatureMotion motion =
      features_.Check(frame.view, tracked.moving, {pose, since_last}, stamp_s);
  tracked.is_apart = motion.IsApart();
  if (motion.IsRefuted()) tracked.state = FrameState::kLost;
  return tracked;
}

// The way over lost frames is not one frame's motion, nor is a jump. Where a camera is found again
// about where it was expected, it has moved as before.
void Tracker::KeepMotion(const PreparedFrame& frame, const Tracked& tracked) {
  const double seconds = frame.images.stamp_s - last_stamp_s_;
  const bool is_next = has_started_ && is_last_known_ && lost_count_ == 0 && !tracked.found_again;
  const std::optional<Matrix6d> expected = ExpectedCovariance(frame);
  const bool moved_on = !is_next && expected && !IsUnexpected(tracked);
  motion_ = MotionTo(frame.images.stamp_s, tracked);
  motion_prior_.Forget();
  if (moved_on) {
    motion_prior_.Keep(*expected, seconds);
    return;
  }
  last_from_next_ =
      is_next ? last_.world_from_view.Inverse() * tracked.world_from_camera : Rigid3d();
  if (is_next && tracked.motion_covariance) motion_prior_.Keep(*tracked.motion_covariance, seconds);
}

void Tracker::Keep(PreparedFrame frame, const Tracked& tracked) {
  KeepMotion(frame, tracked);
  proposal_.reset();
  confirmed_.reset();
  last_stamp_s_ = frame.images.stamp_s;
  needs_search_ = tracked.found_again;
  is_poorly_held_ = tracked.is_poorly_held;
  is_by_newest_ = tracked.is_by_newest;
  if (options_.tracking == "frame_to_frame" || options_.initialize != "identity" ||
      options_.motion_model == "so3") {
    last_.view = std::move(frame.view);
  }
  last_.world_from_view = tracked.world_from_camera;
  has_started_ = is_last_known_ = true;
  lost_count_ = 0;
}

void Tracker::Move(const Rigid3d& new_from_old_world) {
  last_.world_from_view = new_from_old_world * last_.world_from_view;
  regions_.Move(new_from_old_world);
  features_.Move(new_from_old_world);
  if (proposal_) {
    proposal_->view.world_from_view = new_from_old_world * proposal_->view.world_from_view;
  }
}

}  // namespace surfit
