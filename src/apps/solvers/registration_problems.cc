#include <algorithm>
#include <memory>

#include "apps/solvers/cloud_file.h"
#include "apps/solvers/pose_problem.h"
#include "registration/solvers/pair_solver.h"
#include "run/posed_views.h"
#include "run/results/tracking_dump.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

int SourceOf(int i, int pairs, int first, int last) {
  return pairs == 1 ? first
                    : first + static_cast<int>(std::int64_t{last - first} * i / (pairs - 1));
}

int CountValid(const FrameLevel& level) {
  const auto& z = level.vertex.z;
  return static_cast<int>(std::count_if(z.begin(), z.end(), [](float depth) { return depth > 0; }));
}

SolveOutcome Solve(const FramePyramid& source, const FramePyramid& target, IcpOptions icp,
                   const SolverCombination& combination, const Rigid3d& start) {
  SetCombination(combination, &icp);
  const Stopwatch total;
  const IcpResult result = Register(source, target, start, icp);
  return OutcomeOf(result, CountValid(source.levels.front()), total.Milliseconds());
}

}  // namespace

void SetCombination(const SolverCombination& combination, IcpOptions* icp) {
  icp->solver = combination.solver;
  if (!combination.linear_solver.empty()) icp->linear_solver = combination.linear_solver;
  icp->residual = combination.residual;
  icp->association = combination.association;
}

PoseProblem FramePairProblem(FramePyramid source, FramePyramid target,
                             const std::optional<Rigid3d>& truth, const Rigid3d& center,
                             const IcpOptions& icp) {
  PoseProblem problem;
  problem.truth = truth;
  problem.center = center;
  const auto shared_source = std::make_shared<const FramePyramid>(std::move(source));
  const auto shared_target = std::make_shared<const FramePyramid>(std::move(target));
  problem.solve = [=](const SolverCombination& combination, const Rigid3d& start) {
    return Solve(*shared_source, *shared_target, icp, combination, start);
  };
  return problem;
}

PoseProblems FramePairProblems(const CompareOptions& options) {
  if (options.pairs == 0) return {};
  const int first = options.sequence.first;
  const int frames = OpenSequence(options.sequence)->info().frame_count;
  const int last = first + frames - 1 - options.gap;
  ThrowIf(last < first, "gap is ", options.gap, ", must be below the ", frames, " frames of ",
          options.sequence.path);
  const int count = std::min(options.pairs, last - first + 1);
  return {count, [&options, count, first, last](int i) {
            const int index = SourceOf(i, count, first, last);
            PosedPair pair = ReadPosedPair(options.sequence, index, index + options.gap,
                                           options.preprocess, options.icp.error_model);
            const std::optional<Rigid3d> truth = pair.TargetFromSource();
            return FramePairProblem(std::move(pair.source.view.pyramid),
                                    std::move(pair.target.view.pyramid), truth,
                                    truth.value_or(Rigid3d()), options.icp);
          }};
}

PoseProblems ReplayProblems(const CompareOptions& options) {
  return {1, [&options](int) {
            TrackingDump dump = ReadTrackingDump(options.replay);
            return FramePairProblem(std::move(dump.source), std::move(dump.target), std::nullopt,
                                    dump.target_from_source_initial, dump.icp);
          }};
}

PoseProblems CloudProblems(const CompareOptions& options) {
  const auto read = [](const CompareOptions& given, const std::string& path) {
    CloudSensor sensor;
    if (const auto& sigma = given.sequence.inverse_depth_sigma) {
      sensor.noise.inverse_depth_sigma = *sigma;
    }
    return std::make_shared<const PreparedCloud>(PrepareCloud(ReadPointCloud(path), path, sensor,
                                                              CloudNormalOptions(),
                                                              given.icp.error_model.floor_sigma_m));
  };
  const auto source = read(options, options.source), target = read(options, options.target);
  return {1, [&options, source, target](int) {
            PoseProblem problem;
            if (!options.truth.empty()) problem.truth = ParsePose("truth", options.truth);
            problem.center = problem.truth.value_or(Rigid3d());
            problem.solve = [&options, source, target](const SolverCombination& combination,
                                                       const Rigid3d& start) {
              RegisterCloudsOptions registration;
              registration.icp = options.icp;
              SetCombination(combination, &registration.icp);
              const Stopwatch total;
              const IcpResult result =
                  RegisterClouds(source->points, target->points, start, registration);
              return OutcomeOf(result, static_cast<int>(source->points.size()),
                               total.Milliseconds());
            };
            return problem;
          }};
}

}  // namespace surfit
