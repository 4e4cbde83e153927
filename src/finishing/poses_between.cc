#include <algorithm>
#include <optional>
#include <utility>

#include "finishing/posed_sequence.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/global_registration.h"

namespace surfit {
namespace {

struct LostSurface {
  int frame;
  double stamp_s;
  FramePyramid pyramid;
};

// Ranges from the frame before to the frame after each gap. Adjacent gaps share a frame.
std::vector<FrameRange> RangesOf(const std::vector<int>& frames,
                                 const std::vector<std::size_t>& gaps) {
  std::vector<FrameRange> ranges;
  for (const std::size_t gap : gaps) {
    if (!ranges.empty() && ranges.back().last == frames[gap]) {
      ranges.back().last = frames[gap + 1];
    } else {
      ranges.push_back({frames[gap], frames[gap + 1]});
    }
  }
  return ranges;
}

bool AgreeWithin(const FitCriteria& fit, const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d difference = a.Inverse() * b;
  return difference.translation.norm() <= fit.max_disagreement_m &&
         RotationAngle(difference.rotation) <= fit.max_disagreement_rad;
}

Rigid3d Between(const Rigid3d& a, const Rigid3d& b, double share) {
  return {a.rotation.slerp(share, b.rotation).normalized(),
          (1 - share) * a.translation + share * b.translation};
}

bool IsCertain(const IcpResult& icp, const TrackingOptions& options) {
  return icp.Succeeded() && icp.degenerate_directions.empty() &&
         icp.eigenvalues[0] >= options.min_turn_eigenvalue &&
         icp.inlier_ratio >= options.min_inlier_ratio && icp.rmse_m <= options.max_rmse_m;
}

class SearchBetween {
 public:
  explicit SearchBetween(const PosedSequence& known) : known_(known), icp_(known.slam.icp) {
    icp_.max_free_space_violation_ratio = GlobalIcpOptions().max_free_space_violation_ratio;
  }

  // Adds a frame without a pose.
  void AddLost(int frame, double stamp_s, FramePyramid pyramid) {
    lost_.push_back({frame, stamp_s, std::move(pyramid)});
  }

  // Adds the frame at a position of the trajectory. It ends the gap that the previous position has
  // begun.
  void AddPosed(std::size_t position, FramePyramid pyramid) {
    if (before_ && position == *before_ + 1) {
      for (const LostSurface& lost : lost_) Find(lost, pyramid);
    }
    lost_.clear();
    before_ = position;
    before_surface_ = std::move(pyramid);
  }

  std::vector<PoseBetween> Take() { return std::move(found_); }

 private:
  void Find(const LostSurface& lost, const FramePyramid& after_surface) {
    const StampedPose &before = known_.trajectory[*before_],
                      &after = known_.trajectory[*before_ + 1];
    const double seconds = after.stamp_s - before.stamp_s;
    if (!(seconds > 0)) return;
    const Rigid3d initial = Between(before.world_from_camera, after.world_from_camera,
                                    (lost.stamp_s - before.stamp_s) / seconds);
    const auto by_before = Registered(lost, before_surface_, before.world_from_camera, initial);
    if (!by_before) return;
    const auto by_after = Registered(lost, after_surface, after.world_from_camera, initial);
    if (!by_after || !AgreeWithin(known_.slam.loops.find.verify.fit, *by_before, *by_after)) return;
    found_.push_back({lost.frame, lost.stamp_s, Between(*by_before, *by_after, 0.5), *before_});
  }

  std::optional<Rigid3d> Registered(const LostSurface& lost, const FramePyramid& target,
                                    const Rigid3d& world_from_target,
                                    const Rigid3d& world_from_initial) const {
    const IcpResult icp =
        Register(lost.pyramid, target, world_from_target.Inverse() * world_from_initial, icp_);
    if (!IsCertain(icp, known_.slam)) return std::nullopt;
    return world_from_target * icp.target_from_source;
  }

  const PosedSequence& known_;
  IcpOptions icp_;
  std::optional<std::size_t> before_;
  FramePyramid before_surface_;
  std::vector<LostSurface> lost_;
  std::vector<PoseBetween> found_;
};

}  // namespace

std::vector<PoseBetween> FindPosesBetween(const PosedSequence& known,
                                          const std::vector<std::size_t>& gaps,
                                          const std::atomic<bool>& interrupted) {
  if (gaps.empty()) return {};
  const auto source = ReopenSequence(known.sequence, RangesOf(known.frames, gaps));
  const DepthSensor sensor = known.found.Of(source->info().sensor());
  SearchBetween search(known);
  while (std::optional<ReadResult> read = source->Next()) {
    if (interrupted) return {};
    if (!read->frame) continue;
    known.found.Correct(&*read->frame);
    FramePyramid pyramid = PreprocessDepth(read->frame->depth_m, sensor, known.slam.preprocess);
    const auto at = std::lower_bound(known.frames.begin(), known.frames.end(), read->index);
    if (at != known.frames.end() && *at == read->index) {
      search.AddPosed(static_cast<std::size_t>(at - known.frames.begin()), std::move(pyramid));
    } else {
      search.AddLost(read->index, read->frame->stamp_s, std::move(pyramid));
    }
  }
  return search.Take();
}

}  // namespace surfit
