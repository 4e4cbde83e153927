#include <fstream>
#include <memory>
#include <string>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "apps/solvers/pose_problem.h"
#include "apps/solvers/run_keyframes.h"
#include "optimization/refinement/joint_solver.h"
#include "registration/solvers/pair_solver.h"

namespace surfit {
namespace {

constexpr int kMaxIterations = 50;
// Photometric weight of the textured residual if the weight option is 0.
constexpr double kPhotometricWeight = 0.03;

// Memory value of /proc/self/status, in bytes. std::nullopt if the system has no such file.
std::optional<double> MemoryFigure(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(name + ":", 0) == 0) return 1024 * std::stod(line.substr(name.size() + 1));
  }
  return std::nullopt;
}

// Measures the increase of the peak resident memory since construction.
class PeakMemory {
 public:
  PeakMemory() {
#if defined(__GLIBC__)
    malloc_trim(0);  // reuse of freed memory would not be measured
#endif
    std::ofstream reset("/proc/self/clear_refs");
    reset << "5" << std::flush;  // resets the peak
    if (reset) before_ = MemoryFigure("VmRSS");
  }
  std::optional<double> Bytes() const {
    const std::optional<double> peak = MemoryFigure("VmHWM");
    if (!before_ || !peak) return std::nullopt;
    return std::max(0., *peak - *before_);
  }

 private:
  std::optional<double> before_;
};

RefinementOptions OptionsOf(const SolverCombination& combination, const CompareOptions& compared) {
  RefinementOptions options;
  options.solver = combination.solver;
  if (!combination.linear_solver.empty()) options.linear_solver = combination.linear_solver;
  options.max_iterations = kMaxIterations;
  options.error_model.kernel = compared.icp.error_model.kernel;
  if (combination.residual == kTexturedResidual) {
    const double given = compared.icp.error_model.photometric_weight;
    options.error_model.photometric_weight = given > 0 ? given : kPhotometricWeight;
  }
  return options;
}

void SetReport(const JointReport& report, const RefinementOptions& options, SolveOutcome* outcome) {
  outcome->succeeded = report.iterations != kNoSolution;
  const bool used_up = report.iterations == options.max_iterations;
  outcome->termination = !outcome->succeeded ? "failed" : used_up ? "max_iterations" : "converged";
  outcome->iterations = std::max(0, report.iterations);
  if (report.build_ms > 0) outcome->build_ms = report.build_ms;
  outcome->linearize_ms = report.linearize_ms;
  outcome->solve_ms = report.solve_ms;
  if (outcome->iterations > 0) outcome->iteration_ms = report.solve_ms / outcome->iterations;
  outcome->losses = report.costs;
}

SolveOutcome Solve(const RunKeyframes& run, const SolverCombination& combination,
                   const CompareOptions& compared) {
  const RefinementOptions options = OptionsOf(combination, compared);
  JointState state = {{}, {run.info.pinhole, {}}};
  for (const RefinementKeyframe& keyframe : run.keyframes) {
    state.world_from_camera.push_back(keyframe.world_from_camera);
  }
  const SharedSurfels shared = MakeSharedSurfels(run.keyframes, state.calibration, options);
  const JointKernels kernels = KernelsOf(options.error_model);
  JointPrior prior(state.calibration, options.prior.Over(run.info.camera.prior));
  prior.SetWeight(VarianceOf(FitOf(shared, state, kernels), shared, state, options));

  SolveOutcome outcome;
  outcome.points = static_cast<int>(shared.observations.size() + shared.textures.size());
  const PeakMemory memory;
  const Stopwatch total;
  const JointReport report = MinimizeJointly({shared, prior, kernels}, options, &state);
  outcome.total_ms = total.Milliseconds();
  outcome.memory_bytes = memory.Bytes();
  SetReport(report, options, &outcome);
  outcome.final_cost = (FitOf(shared, state, kernels).rho + prior.Rho(state)) / 2;
  return outcome;
}

}  // namespace

PoseProblems RefinementProblems(const CompareOptions& options) {
  return {1, [&options](int) {
            RefineRunOptions run;
            run.sequence = options.sequence;
            run.trajectory = options.run + "/trajectory.txt";
            run.max_keyframes = options.max_keyframes;
            run.preprocess = options.preprocess;
            const auto keyframes = std::make_shared<const RunKeyframes>(ReadRunKeyframes(run));
            PoseProblem problem;
            problem.solve = [&options, keyframes](const SolverCombination& combination,
                                                  const Rigid3d&) {
              return Solve(*keyframes, combination, options);
            };
            return problem;
          }};
}

}  // namespace surfit
