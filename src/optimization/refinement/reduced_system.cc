#include "optimization/refinement/reduced_system.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "cost_functions/robust_kernel.h"
#include "surfit/core/parallel.h"

namespace surfit {

namespace {

// Terms for the elimination of one surfel: A^T W b by blocks, b^T W b and b^T W r. See
// ReducedSystem.
template <int kUnknowns>
struct Coupling {
  using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  explicit Coupling(std::size_t observations)
      : poses(observations, Eigen::Matrix<double, kPoseTangentSize, kUnknowns>::Zero()) {}

  // Adds a row. `observation`: index of the keyframe in the observations of the surfel.
  void Add(std::size_t observation, const JointRow& row, const SurfelRow<kUnknowns>& by_surfel,
           double weight) {
    const SurfelRow<kUnknowns> weighted = weight * by_surfel;
    poses[observation] += row.by_pose * weighted.transpose();
    calibration += row.by_calibration * weighted.transpose();
    information += weighted * by_surfel.transpose();
    gradient += weighted * row.residual;
  }

  // Multiplies all by the inverse root of b^T W b = L L^T, so that
  //   A^T W b (b^T W b)^-1 b^T W A = (A^T W b L^-T) (A^T W b L^-T)^T.
  // Returns false, without changes, if the surfel parameters are not observable.
  bool Whiten() {
    const Eigen::LLT<Square> llt(information);
    if (!(llt.info() == Eigen::Success && information.diagonal().minCoeff() > 0)) return false;
    const auto upper = llt.matrixU();
    for (auto& pose : poses) upper.template solveInPlace<Eigen::OnTheRight>(pose);
    upper.template solveInPlace<Eigen::OnTheRight>(calibration);
    llt.matrixL().solveInPlace(gradient);
    return true;
  }

  std::vector<Eigen::Matrix<double, kPoseTangentSize, kUnknowns>> poses;
  Eigen::Matrix<double, kCalibrationSize, kUnknowns> calibration =
      Eigen::Matrix<double, kCalibrationSize, kUnknowns>::Zero();
  Square information = Square::Zero();
  SurfelRow<kUnknowns> gradient = SurfelRow<kUnknowns>::Zero();
};

class Reducer {
 public:
  Reducer(const SharedSurfels& shared, const BlockPattern& pattern, const PlacedPoses& placed,
          const JointKernels& kernels)
      : shared_(shared), placed_(placed), kernels_(kernels), system_(pattern) {}

  void Add(const SharedSurfel& surfel) {
    const SurfelResiduals sight(shared_, surfel, placed_);
    if (sight.textures().empty()) {
      Add<kPlaneUnknowns>(surfel, sight);
    } else {
      Add<kTexturedUnknowns>(surfel, sight);
    }
  }

  const ReducedSystem& system() const { return system_; }

 private:
  template <int kUnknowns>
  void Add(const SharedSurfel& surfel, const SurfelResiduals& sight) {
    const SurfelParameters numbers = sight.Best(kernels_);
    Coupling<kUnknowns> coupling(sight.planes().size());
    for (std::size_t i = 0; i < sight.planes().size(); ++i) {
      const int keyframe = shared_.observations[surfel.begin + i].keyframe;
      const JointRow row =
          sight.planes()[i].Row(numbers.displacement, surfel.normal_in_world,
                                placed_.rotations[keyframe], placed_.state.calibration);
      const KernelValue<double> kernel =
          EvaluateKernel(kernels_.plane, row.residual * row.residual);
      system_.rho += kernel.rho;
      AddRow(row, keyframe, kernel.slope);
      SurfelRow<kUnknowns> by_surfel = SurfelRow<kUnknowns>::Zero();
      by_surfel[0] = row.by_displacement;
      coupling.Add(i, row, by_surfel, kernel.slope);
    }
    if constexpr (kUnknowns == kTexturedUnknowns) AddTextures(surfel, sight, numbers, &coupling);
    if (coupling.Whiten()) Eliminate(surfel, coupling);
  }

  void AddTextures(const SharedSurfel& surfel, const SurfelResiduals& sight,
                   const SurfelParameters& numbers, Coupling<kTexturedUnknowns>* coupling) {
    for (std::size_t i = 0; i < sight.textures().size(); ++i) {
      const TextureObservation& seen = shared_.textures[surfel.textures_begin + i];
      const std::array<JointRow, 2> rows = sight.textures()[i].Rows(
          numbers, surfel.normal_in_world, placed_.rotations[seen.keyframe]);
      const double squared =
          rows[0].residual * rows[0].residual + rows[1].residual * rows[1].residual;
      const KernelValue<double> kernel = EvaluateKernel(kernels_.texture, squared);
      system_.rho += kernel.rho;
      for (int j = 0; j < 2; ++j) {
        AddRow(rows[j], seen.keyframe, kernel.slope);
        Eigen::Vector3d by_surfel(rows[j].by_displacement, 0, 0);
        by_surfel[1 + j] = -1;
        coupling->Add(seen.index, rows[j], by_surfel, kernel.slope);
      }
    }
  }

  void AddRow(const JointRow& row, int keyframe, double weight) {
    const PoseRow weighted = weight * row.by_pose;
    const CalibrationRow calibration = weight * row.by_calibration;
    system_.PoseBlock(keyframe, keyframe).noalias() += weighted * row.by_pose.transpose();
    system_.mixed[keyframe].noalias() += calibration * row.by_pose.transpose();
    system_.calibration.noalias() += calibration * row.by_calibration.transpose();
    system_.gradient.segment<kPoseTangentSize>(kPoseTangentSize * keyframe) +=
        row.residual * weighted;
    system_.gradient.tail<kCalibrationSize>() += row.residual * calibration;
  }

  template <int kUnknowns>
  void Eliminate(const SharedSurfel& surfel, const Coupling<kUnknowns>& coupling) {
    const PlaneObservation* const seen = &shared_.observations[surfel.begin];
    for (std::size_t i = 0; i < coupling.poses.size(); ++i) {
      const int row = seen[i].keyframe;
      for (std::size_t j = 0; j <= i; ++j) {
        system_.PoseBlock(row, seen[j].keyframe).noalias() -=
            coupling.poses[i] * coupling.poses[j].transpose();
      }
      system_.mixed[row].noalias() -= coupling.calibration * coupling.poses[i].transpose();
      system_.gradient.template segment<kPoseTangentSize>(kPoseTangentSize * row) -=
          coupling.poses[i] * coupling.gradient;
    }
    system_.calibration.noalias() -= coupling.calibration * coupling.calibration.transpose();
    system_.gradient.template tail<kCalibrationSize>() -= coupling.calibration * coupling.gradient;
  }

  const SharedSurfels& shared_;
  const PlacedPoses& placed_;
  const JointKernels& kernels_;
  ReducedSystem system_;
};

}  // namespace

BlockPattern::BlockPattern(const SharedSurfels& shared, std::size_t pose_count)
    : pose_count_(static_cast<int>(pose_count)),
      indices_(pose_count * (pose_count + 1) / 2, kNoBlock) {
  constexpr std::int32_t kTied = 0;
  for (int k = 0; k < pose_count_; ++k) {
    indices_[PairOf(k, k)] = kTied;
    if (k > 0) indices_[PairOf(k, k - 1)] = kTied;
  }
  for (const SharedSurfel& surfel : shared.surfels) {
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      for (std::size_t j = surfel.begin; j < i; ++j) {
        indices_[PairOf(shared.observations[i].keyframe, shared.observations[j].keyframe)] = kTied;
      }
    }
  }
  for (std::int32_t& index : indices_) {
    if (index == kTied) index = static_cast<std::int32_t>(block_count_++);
  }
}

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

JointFit FitOf(const SharedSurfels& shared, const JointState& state, const JointKernels& kernels) {
  constexpr int kGrain = 512;
  const PlacedPoses placed(state);
  const auto fit_block = [&](int begin, int end) {
    JointFit fit;
    for (int s = begin; s < end; ++s) {
      fit += SurfelResiduals(shared, shared.surfels[s], placed).FitOf(kernels);
    }
    return fit;
  };
  return ParallelSum(0, static_cast<int>(shared.surfels.size()), kGrain, JointFit(), fit_block);
}

ReducedSystem Reduce(const SharedSurfels& shared, const BlockPattern& pattern,
                     const JointState& state, const JointKernels& kernels) {
  constexpr int kBlocks = 4;  // number of partial sums
  const PlacedPoses placed(state);
  const int count = static_cast<int>(shared.surfels.size());
  return ParallelSum(0, count, std::max(1, (count + kBlocks - 1) / kBlocks), ReducedSystem(pattern),
                     [&](int begin, int end) {
                       Reducer reducer(shared, pattern, placed, kernels);
                       for (int s = begin; s < end; ++s) reducer.Add(shared.surfels[s]);
                       return reducer.system();
                     });
}

}  // namespace surfit
