#include "io/matrix_text.h"

#include "surfit/core/error.h"

namespace surfit {

Rigid3d RigidFromMatrix(const Eigen::Matrix4d& matrix, const std::string& place) {
  const Eigen::Matrix3d r = matrix.topLeftCorner<3, 3>();
  if (!((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.01 && r.determinant() > 0))
    throw InputError(place + ": the matrix is no rigid transform");
  return Rigid3d(r, matrix.topRightCorner<3, 1>());
}

Rigid3d ParseRigid(const std::vector<TextRow>& rows, std::size_t first, const std::string& path) {
  if (rows.size() < first + 4) throw InputError(path + " ends before a 4 x 4 matrix does");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 4; ++i) {
    const TextRow& row = rows[first + i];
    if (row.columns.size() != 4)
      throw InputError(Concat(row.place, " has ", row.columns.size(), " columns, must have 4"));
    for (int j = 0; j < 4; ++j) matrix(i, j) = ParseNumber(row.columns[j], row.place);
  }
  return RigidFromMatrix(matrix, rows[first].place);
}

}  // namespace surfit
