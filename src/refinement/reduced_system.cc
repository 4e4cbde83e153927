#include "refinement/reduced_system.h"

#include <algorithm>

#include "cost_functions/robust_kernel.h"
#include "refinement/plane_row.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Poses as the rows use them.
struct Placed {
  explicit Placed(const JointState& joint) : state(joint) {
    for (const Rigid3d& pose : joint.world_from_camera) {
      rotations.push_back(pose.rotation.toRotationMatrix());
    }
  }

  PlaneSight SightOf(const PlaneObservation& o, const SharedSurfel& surfel) const {
    return PlaneSight(o, surfel, rotations[o.keyframe],
                      state.world_from_camera[o.keyframe].translation, state.calibration);
  }

  const JointState& state;
  std::vector<Eigen::Matrix3d> rotations;
};

std::vector<PlaneSight> SightsOf(const SharedSurfels& shared, const SharedSurfel& surfel,
                                 const Placed& placed) {
  std::vector<PlaneSight> sights;
  sights.reserve(surfel.end - surfel.begin);
  for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
    sights.push_back(placed.SightOf(shared.observations[i], surfel));
  }
  return sights;
}

// Gauss-Newton on one number, reweighted in each step.
double BestDisplacement(const std::vector<PlaneSight>& sights, const RobustKernel& kernel) {
  constexpr int kSteps = 4;
  double displacement = 0;
  for (int step = 0; step < kSteps; ++step) {
    double information = 0, gradient = 0;
    for (const PlaneSight& sight : sights) {
      const double r = sight.Residual(displacement);
      const double b = sight.ByDisplacement(displacement);
      const double weight = EvaluateKernel(kernel, r * r).slope;
      information += weight * b * b;
      gradient += weight * b * r;
    }
    if (!(information > 0)) break;
    displacement -= gradient / information;
  }
  return displacement;
}

// A^T W b of one surfel: a block for each keyframe that sees it, and one of the calibration.
struct Coupling {
  std::vector<PoseRow> poses;
  CalibrationRow calibration = CalibrationRow::Zero();
  double information = 0;  // b^T W b
  double gradient = 0;     // b^T W r
};

class Reducer {
 public:
  Reducer(const SharedSurfels& shared, const BlockPattern& pattern, const Placed& placed,
          const RobustKernel& kernel)
      : shared_(shared), placed_(placed), kernel_(kernel), system_(pattern) {}

  void Add(const SharedSurfel& surfel) {
    const std::vector<PlaneSight> sights = SightsOf(shared_, surfel, placed_);
    const double displacement = BestDisplacement(sights, kernel_);
    Coupling coupling;
    for (std::size_t i = 0; i < sights.size(); ++i) {
      const int keyframe = shared_.observations[surfel.begin + i].keyframe;
      AddRow(sights[i].Row(displacement, surfel.normal_in_world, placed_.rotations[keyframe],
                           placed_.state.calibration),
             keyframe, &coupling);
    }
    if (coupling.information > 0) Eliminate(surfel, coupling);
  }

  const ReducedSystem& system() const { return system_; }

 private:
  void AddRow(const PlaneRow& row, int keyframe, Coupling* coupling) {
    const double squared = row.residual * row.residual;
    const KernelValue<double> kernel = EvaluateKernel(kernel_, squared);
    const PoseRow weighted = kernel.slope * row.by_pose;
    const CalibrationRow calibration = kernel.slope * row.by_calibration;
    system_.rho += kernel.rho;
    system_.PoseBlock(keyframe, keyframe).noalias() += weighted * row.by_pose.transpose();
    system_.mixed[keyframe].noalias() += calibration * row.by_pose.transpose();
    system_.calibration.noalias() += calibration * row.by_calibration.transpose();
    system_.gradient.segment<kPoseTangentSize>(kPoseTangentSize * keyframe) +=
        row.residual * weighted;
    system_.gradient.tail<kCalibrationSize>() += row.residual * calibration;
    coupling->poses.push_back(row.by_displacement * weighted);
    coupling->calibration += row.by_displacement * calibration;
    coupling->information += kernel.slope * row.by_displacement * row.by_displacement;
    coupling->gradient += kernel.slope * row.by_displacement * row.residual;
  }

  void Eliminate(const SharedSurfel& surfel, const Coupling& coupling) {
    const double share = coupling.gradient / coupling.information;
    const PlaneObservation* const seen = &shared_.observations[surfel.begin];
    for (std::size_t i = 0; i < coupling.poses.size(); ++i) {
      const int row = seen[i].keyframe;
      const PoseRow scaled = coupling.poses[i] / coupling.information;
      for (std::size_t j = 0; j <= i; ++j) {
        system_.PoseBlock(row, seen[j].keyframe).noalias() -=
            scaled * coupling.poses[j].transpose();
      }
      system_.mixed[row].noalias() -= coupling.calibration * scaled.transpose();
      system_.gradient.segment<kPoseTangentSize>(kPoseTangentSize * row) -=
          share * coupling.poses[i];
    }
    const CalibrationRow scaled = coupling.calibration / coupling.information;
    system_.calibration.noalias() -= scaled * coupling.calibration.transpose();
    system_.gradient.tail<kCalibrationSize>() -= share * coupling.calibration;
  }

  const SharedSurfels& shared_;
  const Placed& placed_;
  const RobustKernel& kernel_;
  ReducedSystem system_;
};

}  // namespace

ReducedSystem::ReducedSystem(const BlockPattern& block_pattern)
    : pattern(&block_pattern),
      poses(block_pattern.block_count(), PoseMatrix::Zero()),
      mixed(block_pattern.pose_count(), MixedMatrix::Zero()),
      gradient(Eigen::VectorXd::Zero(kPoseTangentSize * block_pattern.pose_count() +
                                     kCalibrationSize)) {}

ReducedSystem& ReducedSystem::operator+=(const ReducedSystem& other) {
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] += other.poses[i];
  for (std::size_t k = 0; k < mixed.size(); ++k) mixed[k] += other.mixed[k];
  calibration += other.calibration;
  gradient += other.gradient;
  rho += other.rho;
  return *this;
}

JointFit& JointFit::operator+=(const JointFit& other) {
  rho += other.rho;
  weight += other.weight;
  squared_sigmas += other.squared_sigmas;
  squared_metres += other.squared_metres;
  return *this;
}

double BestDisplacement(const SharedSurfels& shared, const SharedSurfel& surfel,
                        const JointState& state, const RobustKernel& kernel) {
  return BestDisplacement(SightsOf(shared, surfel, Placed(state)), kernel);
}

JointFit FitOf(const SharedSurfels& shared, const JointState& state, const RobustKernel& kernel) {
  constexpr int kGrain = 512;
  const Placed placed(state);
  const auto fit_block = [&](int begin, int end) {
    JointFit fit;
    for (int s = begin; s < end; ++s) {
      const std::vector<PlaneSight> sights = SightsOf(shared, shared.surfels[s], placed);
      const double displacement = BestDisplacement(sights, kernel);
      for (const PlaneSight& sight : sights) {
        const double r = sight.Residual(displacement), distance = sight.Distance(displacement);
        const KernelValue<double> value = EvaluateKernel(kernel, r * r);
        fit += {value.rho, value.slope, value.slope * r * r, value.slope * distance * distance};
      }
    }
    return fit;
  };
  return ParallelSum(0, static_cast<int>(shared.surfels.size()), kGrain, JointFit(), fit_block);
}

ReducedSystem Reduce(const SharedSurfels& shared, const BlockPattern& pattern,
                     const JointState& state, const RobustKernel& kernel) {
  constexpr int kBlocks = 4;  // each has a system of its own
  const Placed placed(state);
  const int count = static_cast<int>(shared.surfels.size());
  return ParallelSum(0, count, std::max(1, (count + kBlocks - 1) / kBlocks), ReducedSystem(pattern),
                     [&](int begin, int end) {
                       Reducer reducer(shared, pattern, placed, kernel);
                       for (int s = begin; s < end; ++s) reducer.Add(shared.surfels[s]);
                       return reducer.system();
                     });
}

}  // namespace surfit
