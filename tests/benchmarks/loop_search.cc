#include "benchmarks/loop_search.h"

#include <algorithm>
#include <ctime>
#include <memory>
#include <utility>

#include "run/posed_views.h"
#include "surfit/loop_closure/place_index.h"

namespace surfit::testing {
namespace {

// Adds the CPU time of all threads during its lifetime to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double* sum_ms) : sum_ms_(*sum_ms), begin_(std::clock()) {}
  ~CpuTimer() { sum_ms_ += 1e3 * static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_ms_;
  std::clock_t begin_;
};

struct EvaluatedFrame {
  int index;
  int keyframe;  // index of the keyframe
  std::optional<Rigid3d> truth;
};

class LoopRun {
 public:
  LoopRun(const LoopSearchOptions& options, const SequenceInfo& info)
      : options_(options),
        info_(info),
        estimate_(ReadEstimate(options.trajectory, info)),
        index_(options.index) {}

  void Process(const ReadResult& read) {
    const std::optional<Rigid3d> pose = InterpolatePose(estimate_, read.stamp_s);
    if (!read.frame || !pose) {
      ++result_.left_out;
      return;
    }
    const FramePyramid pyramid =
        PreprocessDepth(read.frame->depth_m, info_.sensor(), options_.preprocess);
    std::vector<Keyframe>& keyframes = result_.keyframes;
    if (keyframes.empty() || IsKeyframe(keyframes.back(), read.index, pyramid.levels.back(), *pose,
                                        options_.keyframes)) {
      AddKeyframe(*read.frame, pyramid, *pose);
    }
    ++result_.frames;
    frames_.push_back({read.index, static_cast<int>(keyframes.size()) - 1,
                       InterpolatePose(info_.ground_truth, read.stamp_s)});
    if (keyframes.size() > truth_of_keyframes_.size()) {
      truth_of_keyframes_.push_back(frames_.back().truth);
    }
  }

  LoopSearchResult Finish() {
    const double count = std::max<double>(1, static_cast<double>(result_.keyframes.size()));
    result_.view_ms /= count;
    result_.query_ms /= count;
    result_.verify_ms /= std::max<double>(1, static_cast<double>(result_.loops.size()));
    for (const Keyframe& keyframe : result_.keyframes) {
      result_.view_bytes += keyframe.view.Bytes();
    }
    if (!info_.ground_truth.empty()) Evaluate();
    return std::move(result_);
  }

 private:
  void AddKeyframe(const RgbdFrame& frame, const FramePyramid& pyramid, const Rigid3d& pose) {
    Keyframe keyframe = {frame.index, frame.stamp_s, pose, {}};
    {
      const CpuTimer timer(&result_.view_ms);
      keyframe.view = MakePlaceView(pyramid, frame.color, options_.view);
    }
    std::vector<Keyframe>& keyframes = result_.keyframes;
    keyframes.push_back(std::move(keyframe));
    const int position = static_cast<int>(keyframes.size()) - 1;
    TryLoops(position);
    index_.Add(position, keyframes.back().view);
    result_.given_up +=
        static_cast<int>(LimitKeyframes(options_.max_view_bytes, &keyframes, &index_).size());
  }

  void TryLoops(int source) {
    std::vector<LoopCandidate> proposals;
    {
      const CpuTimer timer(&result_.query_ms);
      proposals = ProposeLoopCandidates(source, result_.keyframes, index_, options_.loops);
    }
    const CpuTimer timer(&result_.verify_ms);
    for (const LoopCandidate& proposal : proposals) {
      const Keyframe& from = result_.keyframes[source];
      const Keyframe& to = result_.keyframes[proposal.target];
      const GlobalRegistrationResult verdict =
          VerifyLoop(from.view, to.view, options_.loops.verify, proposal.target_from_source_prior);
      result_.loops.push_back(
          {from.frame_index, to.frame_index, {proposal, verdict}, {}, {}, false, false});
    }
  }

  void Evaluate() {
    result_.evaluation.emplace();
    for (FoundLoop& loop : result_.loops) EvaluateLoop(&loop);
    for (const EvaluatedFrame& frame : frames_) {
      if (!Returns(frame)) continue;
      ++result_.evaluation->revisiting;
      result_.evaluation->linked += IsLinked(frame);
    }
  }

  void EvaluateLoop(FoundLoop* loop) {
    const LoopCandidate& proposal = loop->attempt.proposal;
    const auto& source = truth_of_keyframes_[proposal.source];
    const auto& target = truth_of_keyframes_[proposal.target];
    if (!source || !target) return;
    const GlobalRegistrationResult& verdict = loop->attempt.verdict;
    const Rigid3d truth = target->Inverse() * *source;
    const Rigid3d off = truth * verdict.target_from_source.Inverse();
    loop->error_rad = RotationAngle(off.rotation);
    loop->error_m = (verdict.target_from_source.translation - truth.translation).norm();
    if (!verdict.accepted()) return;
    loop->wrong = *loop->error_m > options_.wrong_m || *loop->error_rad > options_.wrong_rad;
    loop->disputed = loop->wrong && SurfacesSpeakFor(*loop, truth);
    LoopEvaluation& evaluation = *result_.evaluation;
    evaluation.wrong += loop->wrong;
    evaluation.disputed += loop->disputed;
    evaluation.worst_m = std::max(evaluation.worst_m, *loop->error_m);
    evaluation.worst_rad = std::max(evaluation.worst_rad, *loop->error_rad);
  }

  bool SurfacesSpeakFor(const FoundLoop& loop, const Rigid3d& truth) const {
    PlaceView source = result_.keyframes[loop.attempt.proposal.source].view;
    const PlaceView& target = result_.keyframes[loop.attempt.proposal.target].view;
    source.features.clear();
    const VerifyLoopOptions& verify = options_.loops.verify;
    const GlobalRegistrationResult from_truth = VerifyLoop(source, target, verify, truth);
    const Rigid3d& pose = loop.attempt.verdict.target_from_source;
    const Rigid3d off = pose.Inverse() * from_truth.target_from_source;
    if (from_truth.accepted() && (off.translation.norm() > verify.fit.max_disagreement_m ||
                                  RotationAngle(off.rotation) > verify.fit.max_disagreement_rad)) {
      return false;
    }
    const FrameLevel from = PyramidOf(source, verify.preprocess).levels.front();
    const FrameLevel to = PyramidOf(target, verify.preprocess).levels.front();
    const auto at_loop = MedianSurfaceDistance(from, to, pose);
    const auto at_truth = MedianSurfaceDistance(from, to, truth);
    return at_loop && (!at_truth || *at_loop < *at_truth);
  }

  bool Returns(const EvaluatedFrame& frame) const {
    return frame.truth &&
           std::any_of(frames_.begin(), frames_.end(), [&](const EvaluatedFrame& other) {
             if (!other.truth || frame.index - other.index <= options_.revisit_gap) return false;
             const Rigid3d motion = other.truth->Inverse() * *frame.truth;
             return motion.translation.norm() < options_.revisit_m &&
                    RotationAngle(motion.rotation) < options_.revisit_rad;
           });
  }

  bool IsLinked(const EvaluatedFrame& frame) const {
    return std::any_of(result_.loops.begin(), result_.loops.end(), [&](const FoundLoop& loop) {
      return loop.attempt.verdict.accepted() && loop.attempt.proposal.source == frame.keyframe &&
             frame.index - loop.target_frame > options_.revisit_gap;
    });
  }

  const LoopSearchOptions& options_;
  const SequenceInfo& info_;
  Trajectory estimate_;
  PlaceIndex index_;
  std::vector<EvaluatedFrame> frames_;
  std::vector<std::optional<Rigid3d>> truth_of_keyframes_;
  LoopSearchResult result_;
};

}  // namespace

LoopSearchResult SearchLoops(const LoopSearchOptions& options) {
  const std::unique_ptr<FrameSource> source = OpenSequence(options.sequence);
  LoopRun run(options, source->info());
  while (const std::optional<ReadResult> read = source->Next()) run.Process(*read);
  return run.Finish();
}

}  // namespace surfit::testing
