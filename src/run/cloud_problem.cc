// Two point clouds from files.
#include <memory>

#include "registration/pair_solver.h"
#include "run/cloud_file.h"
#include "run/given_poses.h"
#include "run/pose_problem.h"

namespace surfit {

PoseProblems CloudProblems(const CompareOptions& options) {
  const auto read = [](const CompareOptions& given, const std::string& path) {
    return std::make_shared<const PreparedCloud>(
        ReadCloudFile(path, CloudNormalOptions(), given.icp.error_model.floor_sigma_m));
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
