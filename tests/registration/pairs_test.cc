// Registers pairs of frames from the identity, with the options of the align program.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "apps/solvers/register_run.h"
#include "surfit/io/sequence.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

struct PairCounts {
  int pairs = 0;
  int accurate = 0;  // final error below 3 mm and 0.1 deg
  int clean = 0;     // accurate, and every level improved loss and inliers
  int wrong = 0;     // converged with an error above 2 cm or 1 deg
};

bool EveryLevelImproves(const std::vector<IcpIteration>& iterations, int max_iterations) {
  for (auto first = iterations.begin(); first != iterations.end();) {
    const auto next_level =
        std::find_if(first, iterations.end(), [&](auto& i) { return i.level != first->level; });
    const IcpIteration& last = *(next_level - 1);
    if (!(last.average_loss < first->average_loss) || last.inlier_count <= first->inlier_count ||
        next_level - first > max_iterations + 1) {
      return false;
    }
    first = next_level;
  }
  return true;
}

void Count(const IcpResult& result, const Rigid3d& truth, const IcpOptions& options,
           PairCounts* outcome) {
  const Rigid3d error = truth.Inverse() * result.target_from_source;
  const double off_m = error.translation.norm();
  const double off_deg = RotationAngle(error.rotation) * 180 / M_PI;
  const bool accurate = result.Succeeded() && off_m < 0.003 && off_deg < 0.1;
  ++outcome->pairs;
  outcome->accurate += accurate;
  outcome->clean += accurate && EveryLevelImproves(result.iterations, options.max_iterations);
  outcome->wrong += result.termination == Termination::kConverged && (off_m > 0.02 || off_deg > 1);
}

// Pairs of every `step`-th frame and frames at the ascending distances `gaps`.
PairCounts RegisterPairs(const std::string& sequence, const std::vector<int>& gaps, int step) {
  SequenceOptions sequence_options;
  sequence_options.path = SharedData(sequence);
  const std::unique_ptr<FrameSource> source = OpenSequence(sequence_options);
  const SequenceInfo& info = source->info();
  const AlignRunOptions options;
  struct View {
    FramePyramid pyramid;
    Rigid3d world_from_camera;
  };
  std::deque<View> last_views;  // newest first
  PairCounts outcome;
  for (int index = 0; auto read = source->Next(); ++index) {
    View view;
    const bool is_source = index % step == 0;
    const bool is_target = std::any_of(gaps.begin(), gaps.end(), [&](int gap) {
      return index >= gap && (index - gap) % step == 0;
    });
    if (is_source || is_target) {
      view.pyramid = PreprocessDepth(read->frame->depth_m, info.sensor(), options.preprocess);
    }
    view.world_from_camera = InterpolatePose(info.ground_truth, read->stamp_s).value();
    last_views.push_front(std::move(view));
    for (const int gap : gaps) {
      if (index < gap || (index - gap) % step != 0) continue;
      const View &from = last_views[gap], &to = last_views[0];
      Count(Register(from.pyramid, to.pyramid, Rigid3d(), options.icp),
            to.world_from_camera.Inverse() * from.world_from_camera, options.icp, &outcome);
    }
    if (static_cast<int>(last_views.size()) > gaps.back()) last_views.pop_back();
  }
  return outcome;
}

void Print(const std::string& sequence, const PairCounts& outcome) {
  std::printf("%s: of %d pairs %d accurate, %d of these better on each level, %d wrong\n",
              sequence.c_str(), outcome.pairs, outcome.accurate, outcome.clean, outcome.wrong);
}

void ExpectGood(const std::string& sequence, int step) {
  const PairCounts outcome = RegisterPairs(sequence, {5, 10, 20}, step);
  Print(sequence, outcome);
  EXPECT_LE(outcome.wrong, 0.01 * outcome.pairs);
  EXPECT_GE(outcome.clean, 0.97 * outcome.pairs);
}

class SomePairs : public ::testing::TestWithParam<std::string> {};
class AllPairs : public ::testing::TestWithParam<std::string> {};

TEST_P(SomePairs, AreRegisteredFromIdentity) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  ExpectGood(GetParam(), 13);
}

TEST_P(AllPairs, AreRegisteredFromIdentity) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  ExpectGood(GetParam(), 1);
}

// Outside the basin of convergence of ICP: a wrong pose must not be reported as converged.
TEST_P(SomePairs, ReportFailureOfFarPairs) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  const PairCounts outcome = RegisterPairs(GetParam(), {30, 40, 60, 90}, 10);
  Print(GetParam(), outcome);
  EXPECT_GE(outcome.pairs, 50);
  EXPECT_LE(outcome.wrong, 0.01 * outcome.pairs);
}

INSTANTIATE_TEST_SUITE_P(Sequences, SomePairs, ::testing::Values("icl_office", "icl_office_kinect"),
                         [](const auto& instance) { return instance.param; });
INSTANTIATE_TEST_SUITE_P(Sequences, AllPairs, ::testing::Values("icl_office", "icl_office_kinect"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace surfit::testing
