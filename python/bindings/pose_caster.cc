#include "bindings/pose_caster.h"

#include "bindings/arrays.h"
#include "surfit/core/error.h"

namespace py = pybind11;

namespace surfit::python {

Rigid3d PoseOf(const py::array_t<double>& matrix) {
  if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4) {
    throw InputError("pose has shape ", ShapeOf(matrix), ", must be (4, 4)");
  }
  Eigen::Matrix4d m;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) m(row, column) = matrix.at(row, column);
  }
  // A rotation matrix in single precision has errors of about 1e-6.
  constexpr double kTolerance = 1e-5;
  const Eigen::Matrix3d rotation = m.topLeftCorner<3, 3>();
  const bool is_rigid =
      m.allFinite() && m.row(3) == Eigen::RowVector4d(0, 0, 0, 1) &&
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < kTolerance &&
      rotation.determinant() > 0;
  ThrowIf(!is_rigid,
          "pose is not a rigid motion: must be a rotation and a translation, with (0, 0, 0, 1) as "
          "last row");
  return Rigid3d(rotation, Eigen::Vector3d(m.topRightCorner<3, 1>()));
}

void WriteMatrix(const Rigid3d& pose, double* numbers) {
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(numbers);
  matrix = pose.Matrix();
}

py::array_t<double> MatrixOf(const Rigid3d& pose) {
  py::array_t<double> matrix({4, 4});
  WriteMatrix(pose, matrix.mutable_data());
  return matrix;
}

}  // namespace surfit::python
