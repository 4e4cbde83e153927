#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <array>
#include <deque>

#include "core/named_values.h"
#include "cost_functions/kernel_loss.h"
#include "cost_functions/pose_manifold.h"
#include "optimization/pose_graph/pose_graph_names.h"
#include "optimization/refinement/joint_solver.h"
#include "registration/solvers/pair_solver.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr NamedValue<ceres::LinearSolverType> kLinearSolvers[] = {
    {"sparse_schur", ceres::SPARSE_SCHUR}, {"iterative_schur", ceres::ITERATIVE_SCHUR}};

// Relative precision of conjugate gradients. The default of Ceres, 0.1, needs many more steps.
constexpr double kStepPrecision = 1e-3;

// All parameters of a surfel are one block, [d] or [d a_1 a_2]: blocks that are eliminated first
// must not share a residual.
using PlaneCost =
    ceres::AutoDiffCostFunction<PlaneInverseDepth, 1, kPoseSize, kCalibrationSize, kPlaneUnknowns>;
using TexturedPlaneCost = ceres::AutoDiffCostFunction<PlaneInverseDepth, 1, kPoseSize,
                                                      kCalibrationSize, kTexturedUnknowns>;
using TextureCost =
    ceres::AutoDiffCostFunction<SurfelTexture, 2, kPoseSize, kCalibrationSize, kTexturedUnknowns>;

ceres::Problem::Options RowsOwnedByUs() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

class AllRows {
 public:
  AllRows(const JointProblem& joint, const RefinementOptions& options, const JointState& state)
      : joint_(joint),
        image_rows_(state.calibration.camera.height),
        poses_(state.world_from_camera.size()),
        numbers_(joint.shared.surfels.size()),
        plane_loss_(joint.kernels.plane),
        texture_loss_(joint.kernels.texture),
        problem_(RowsOwnedByUs()) {
    AddPoses(state);
    AddCalibration(state, FixedCalibration(options));
    PlaceSurfels(state);
    for (std::size_t s = 0; s < numbers_.size(); ++s) AddSurfel(s);
    std::vector<double*> blocks;
    for (auto& pose : poses_) blocks.push_back(pose.data());
    joint.prior.AddTo(blocks, calibration_.data(), &prior_losses_, &problem_);
  }

  ceres::Solver::Summary Minimize(ceres::Solver::Options options) {
    const SingleThreadedLibraries single_threaded;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& numbers : numbers_) {
      options.linear_solver_ordering->AddElementToGroup(numbers.data(), kFirst);
    }
    for (auto& pose : poses_) {
      options.linear_solver_ordering->AddElementToGroup(pose.data(), kLast);
    }
    options.linear_solver_ordering->AddElementToGroup(calibration_.data(), kLast);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary;
  }

  void TakeState(JointState* state) const {
    for (std::size_t k = 1; k < poses_.size(); ++k) {  // the first pose is fixed
      state->world_from_camera[k] = PoseFromBlock(poses_[k].data());
    }
    CalibrationFromBlock(calibration_.data(), &state->calibration);
  }

 private:
  enum EliminationGroup { kFirst, kLast };

  void AddPoses(const JointState& state) {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      PoseToBlock(state.world_from_camera[k], poses_[k].data());
      problem_.AddParameterBlock(poses_[k].data(), kPoseSize, &manifold_);
    }
    problem_.SetParameterBlockConstant(poses_.front().data());
  }

  void AddCalibration(const JointState& state, const std::vector<bool>& held) {
    CalibrationToBlock(state.calibration, calibration_.data());
    problem_.AddParameterBlock(calibration_.data(), kCalibrationSize);
    std::vector<int> constant;
    for (int i = 0; i < kCalibrationSize; ++i) {
      if (held[i]) constant.push_back(i);
    }
    if (constant.size() == kCalibrationSize) {
      problem_.SetParameterBlockConstant(calibration_.data());
    } else if (!constant.empty()) {
      free_calibration_ = std::make_unique<ceres::SubsetManifold>(kCalibrationSize, constant);
      problem_.SetManifold(calibration_.data(), free_calibration_.get());
    }
  }

  // Initialises the surfel parameters to their optimum for the initial poses and calibration.
  void PlaceSurfels(const JointState& state) {
    constexpr int kGrain = 512;
    const PlacedPoses placed(state);
    ParallelFor(0, static_cast<int>(numbers_.size()), kGrain, [&](int begin, int end) {
      for (int s = begin; s < end; ++s) {
        const SharedSurfel& surfel = joint_.shared.surfels[s];
        const SurfelParameters best =
            SurfelResiduals(joint_.shared, surfel, placed).Best(joint_.kernels);
        numbers_[s][0] = best.displacement;
        if (surfel.textures_begin == surfel.textures_end) continue;
        // SurfelParameters::texture is in standard deviations, the block in intensity.
        const double sigma = 1. / joint_.shared.textures[surfel.textures_begin].inverse_sigma;
        numbers_[s][1] = sigma * best.texture[0];
        numbers_[s][2] = sigma * best.texture[1];
      }
    });
  }

  void AddSurfel(std::size_t s) {
    const SharedSurfel& surfel = joint_.shared.surfels[s];
    const bool textured = surfel.textures_end > surfel.textures_begin;
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      const PlaneObservation& o = joint_.shared.observations[i];
      planes_.emplace_back(o.u, o.v, o.inverse_depth, 1. / o.inverse_sigma, surfel.point_in_world,
                           surfel.normal_in_world,
                           MotionOf(o, joint_.shared.readouts[o.keyframe], image_rows_));
      if (textured) {
        Add(&planes_.back(), o.keyframe, s, &plane_loss_, &textured_plane_costs_);
      } else {
        Add(&planes_.back(), o.keyframe, s, &plane_loss_, &plane_costs_);
      }
    }
    for (std::size_t i = surfel.textures_begin; i < surfel.textures_end; ++i) {
      const TextureObservation& o = joint_.shared.textures[i];
      textures_.emplace_back(o.taps, 1. / o.inverse_sigma, TexturePoints(surfel),
                             surfel.normal_in_world);
      Add(&textures_.back(), o.keyframe, s, &texture_loss_, &texture_costs_);
    }
  }

  template <typename Functor, typename Cost>
  void Add(Functor* functor, int keyframe, std::size_t surfel, ceres::LossFunction* loss,
           std::deque<Cost>* costs) {
    costs->emplace_back(functor, ceres::DO_NOT_TAKE_OWNERSHIP);
    problem_.AddResidualBlock(&costs->back(), loss, poses_[keyframe].data(), calibration_.data(),
                              numbers_[surfel].data());
  }

  const JointProblem& joint_;
  int image_rows_;
  std::vector<std::array<double, kPoseSize>> poses_;
  std::array<double, kCalibrationSize> calibration_;
  std::vector<std::array<double, kTexturedUnknowns>> numbers_;
  std::deque<PlaneInverseDepth> planes_;
  std::deque<SurfelTexture> textures_;
  std::deque<PlaneCost> plane_costs_;
  std::deque<TexturedPlaneCost> textured_plane_costs_;
  std::deque<TextureCost> texture_costs_;
  KernelLoss plane_loss_, texture_loss_;
  std::vector<std::unique_ptr<ceres::LossFunction>> prior_losses_;
  ProductPoseManifold manifold_;
  std::unique_ptr<ceres::SubsetManifold> free_calibration_;
  ceres::Problem problem_;  // last member: points to other members
};

ceres::Solver::Options SolverOptions(const RefinementOptions& options) {
  ceres::Solver::Options o;
  o.linear_solver_type = ValueOf("linear_solver", options.linear_solver, kLinearSolvers);
  o.sparse_linear_algebra_library_type =
      ValueOf("sparse_backend", SparseBackendNames().front(), kSparseBackends);
  o.preconditioner_type = ceres::SCHUR_JACOBI;
  o.eta = kStepPrecision;
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = options.min_relative_step_change;
  o.gradient_tolerance = 0;  // depends on units: only the cost is tested
  o.parameter_tolerance = 0;
  o.num_threads = 1;
  o.logging_type = ceres::SILENT;
  return o;
}

}  // namespace

std::vector<std::string> RefinementLinearSolverNames() { return NamesOf(kLinearSolvers); }

JointReport MinimizeWithCeres(const JointProblem& problem, const RefinementOptions& options,
                              JointState* state) {
  const Stopwatch building;
  AllRows rows(problem, options, *state);
  JointReport report;
  report.build_ms = building.Milliseconds();
  const Stopwatch solving;
  const ceres::Solver::Summary summary = rows.Minimize(SolverOptions(options));
  report.solve_ms = solving.Milliseconds();
  if (!summary.IsSolutionUsable()) {
    report.iterations = kNoSolution;
    return report;
  }
  rows.TakeState(state);
  report.iterations = summary.num_linear_solves;
  report.linearize_ms = 1000 * summary.jacobian_evaluation_time_in_seconds /
                        std::max(1, summary.num_jacobian_evaluations);
  for (const ceres::IterationSummary& iteration : summary.iterations) {
    if (iteration.iteration == 0 || iteration.step_is_successful) {
      report.costs.push_back(iteration.cost);
    }
  }
  return report;
}

}  // namespace surfit
