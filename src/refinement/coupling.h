#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "refinement/joint_row.h"

namespace surfit {

// What ties one surfel's own unknowns to poses and calibration, for its elimination: with weighted
// rows [A b], b of its unknowns, A^T W b by blocks, b^T W b and b^T W r.
template <int kUnknowns>
struct Coupling {
  using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  explicit Coupling(std::size_t observations)
      : poses(observations, Eigen::Matrix<double, kPoseTangentSize, kUnknowns>::Zero()) {}

  // A row of the observation-th keyframe that sees the surfel.
  void Add(std::size_t observation, const JointRow& row, const SurfelRow<kUnknowns>& by_surfel,
           double weight) {
    const SurfelRow<kUnknowns> weighted = weight * by_surfel;
    poses[observation] += row.by_pose * weighted.transpose();
    calibration += row.by_calibration * weighted.transpose();
    information += weighted * by_surfel.transpose();
    gradient += weighted * row.residual;
  }

  // Divides all by the root L of b^T W b = L L^T, so that
  //   A^T W b (b^T W b)^-1 b^T W A = (A^T W b L^-T) (A^T W b L^-T)^T.
  // False if the surfel's unknowns are not determined; then nothing is changed.
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

}  // namespace surfit
