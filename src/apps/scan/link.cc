#include <algorithm>
#include <set>
#include <utility>

#include "apps/scan/link_file.h"
#include "apps/scan/scan_jobs.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/loop_closure/find_loops.h"

namespace surfit {
namespace {

RunPlaces PlacesNamed(const std::string& scan, const std::string& name) {
  auto places = PlacesOf(scan, {name}, PlacesPart::kAll);
  if (!places) throw InputError(scan, "/fragments/", name, ": places.bin is missing");
  return *std::move(places);
}

int RecordingOf(const ScanPlan& plan, const std::string& fragment) {
  for (const ScanFragment& each : plan.fragments) {
    if (each.name == fragment) return each.recording;
  }
  throw InputError("fragment '", fragment, "' is not in the plan");
}

class FragmentLinker {
 public:
  FragmentLinker(const FindLoopsOptions& options, RunPlaces source, RunPlaces target,
                 bool of_one_recording)
      : options_(options),
        source_(std::move(source)),
        target_(std::move(target)),
        of_one_recording_(of_one_recording) {}

  std::vector<ScanLink> Run(const std::vector<PlaceProposal>& proposals) {
    for (const PlaceProposal& proposal : proposals) {
      Try(KeyframeAt(source_, proposal.source_frame), KeyframeAt(target_, proposal.target_frame),
          {});
    }
    // An accepted link aligns both fragments, so it predicts further pairs of nearby
    // keyframes.
    const std::vector<ScanLink> by_looks = links_;
    for (const ScanLink& link : by_looks) {
      if (link.verdict.accepted()) TryNear(link);
    }
    return std::move(links_);
  }

 private:
  static const Keyframe& KeyframeAt(const RunPlaces& places, int frame) {
    const auto at = std::find_if(places.keyframes.begin(), places.keyframes.end(),
                                 [&](const Keyframe& k) { return k.frame_index == frame; });
    ThrowIf(at == places.keyframes.end(), "frame ", frame, " is not a keyframe");
    return *at;
  }

  // Verifies pairs of keyframes that are near each other according to a link.
  void TryNear(const ScanLink& link) {
    const Rigid3d target_from_source_world =
        KeyframeAt(target_, link.target_frame).world_from_camera * link.verdict.target_from_source *
        KeyframeAt(source_, link.source_frame).world_from_camera.Inverse();
    for (const Keyframe& from : source_.keyframes) {
      if (std::abs(from.frame_index - link.source_frame) > kReachFrames) continue;
      const Rigid3d pose = target_from_source_world * from.world_from_camera;
      const Keyframe* nearest = nullptr;
      double least = FindLoopsOptions::kMaxNear_m;
      for (const Keyframe& to : target_.keyframes) {
        const Rigid3d motion = to.world_from_camera.Inverse() * pose;
        const bool is_close_by =
            of_one_recording_ && from.frame_index - to.frame_index < options_.min_gap;
        if (is_close_by || RotationAngle(motion.rotation) > FindLoopsOptions::kMaxNear_rad ||
            motion.translation.norm() > least) {
          continue;
        }
        least = motion.translation.norm();
        nearest = &to;
      }
      if (nearest) Try(from, *nearest, nearest->world_from_camera.Inverse() * pose);
    }
  }

  void Try(const Keyframe& from, const Keyframe& to, const std::optional<Rigid3d>& prior) {
    if (!tried_.insert({from.frame_index, to.frame_index}).second) return;
    links_.push_back(
        {from.frame_index, to.frame_index, VerifyLoop(from.view, to.view, options_.verify, prior)});
  }

  // Maximum frame distance to the linked keyframes. Drift makes the prediction inaccurate for
  // farther keyframes.
  static constexpr int kReachFrames = 100;

  const FindLoopsOptions& options_;
  RunPlaces source_, target_;
  bool of_one_recording_;
  std::set<std::pair<int, int>> tried_;
  std::vector<ScanLink> links_;
};

}  // namespace

std::vector<ScanLink> LinkFragments(const LinkOptions& options) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  const ScanPlan plan = ReadScanPlan(options.scan);
  const FragmentCandidates pair = ReadCandidates(options.candidates);
  const std::vector<ScanLink> links = WithContext(options.candidates, [&] {
    const bool of_one_recording = RecordingOf(plan, pair.source) == RecordingOf(plan, pair.target);
    return FragmentLinker(plan.run.slam.loops.find, PlacesNamed(options.scan, pair.source),
                          PlacesNamed(options.scan, pair.target), of_one_recording)
        .Run(pair.proposals);
  });
  WriteLinks({pair.target, pair.source, links}, options.output);
  return links;
}

}  // namespace surfit
