#include "tracking/pose_search.h"

#include "core/trace.h"
#include "tracking/pose_validation.h"

namespace surfit {
namespace {

// Interval of relocalised frames. A relocalisation takes as long as many registrations.
constexpr int kRelocalizeStride = 3;

// Criteria without colours, because motion blur changes them. The map confirms the surfaces.
FitCriteria ShapesAlone() {
  FitCriteria fit = InitializeOptions::FrameCriteria();
  fit.min_value_correlation = fit.min_detail_correlation = -1;
  return fit;
}

}  // namespace

std::optional<Tracked> PoseSearch::FromLastFrame(const PreparedFrame& frame,
                                                 const TrackingState& state,
                                                 const ReferenceView& last) const {
  if (options_.initialize == "identity" || !state.is_localised) return std::nullopt;
  const bool verifies = options_.VerifiesBySearch();
  const bool is_soon = verifies && state.lost_frames < kSearchStride;
  if (!is_soon && state.lost_frames % kSearchStride != 0) return std::nullopt;
  if (!HasEnoughDepth(frame, options_.icp)) return std::nullopt;
  const TraceSlice slice("find_again", frame.images.index);
  InitializeOptions initialization;
  initialization.method = options_.initialize;
  // A plane fits itself everywhere: colours are necessary.
  const bool is_plain = state.last.is_weakly_constrained && options_.acceleration_m_per_s2 > 0;
  if (verifies && !is_plain) initialization.fit = ShapesAlone();
  IcpOptions icp_options = FarIcpOptions();
  icp_options.min_source_rows = options_.icp.min_source_rows;
  const FarVerdict found = RegisterFar(frame.view, last.view, initialization, icp_options);
  if (!found.accepted()) return std::nullopt;
  return Confirm(frame, last, last.world_from_view * found.target_from_source);
}

std::optional<Tracked> PoseSearch::ByKeyframes(const PreparedFrame& frame,
                                               const TrackingState& state,
                                               const ReferenceView& last) const {
  if (!relocalizer_ || state.lost_frames % kRelocalizeStride != 0) return std::nullopt;
  if (!HasEnoughDepth(frame, options_.icp)) return std::nullopt;
  const std::optional<KeyframePose> found = relocalizer_->Find(frame.view);
  if (!found) return std::nullopt;
  views_->ActivateAround(found->frame_index, frame.images.index);
  std::optional<Tracked> tracked = Confirm(frame, last, found->world_from_camera);
  if (!tracked) return std::nullopt;
  tracked->state = FrameState::kRelocalized;
  tracked->keyframe = found->keyframe;
  return tracked;
}

std::optional<Tracked> PoseSearch::Confirm(const PreparedFrame& frame, const ReferenceView& last,
                                           const Rigid3d& world_from_found) const {
  const auto register_to = [&](const ReferenceView& reference) {
    return registration_.Register(frame, reference, world_from_found, options_.icp);
  };
  Tracked tracked = options_.IsFrameToFrame()
                        ? register_to(last)
                        : register_to(views_->ViewAt(world_from_found, frame.HasIntensities()));
  if (!tracked.is_held()) return std::nullopt;
  if (tracked.verdict == Verdict::kUncertain) {
    if (!AreOnePlace(tracked.world_from_camera, world_from_found)) return std::nullopt;
    tracked.verdict = Verdict::kAccepted;
  }
  tracked.found_again = tracked.has_second = true;
  return tracked;
}

}  // namespace surfit
