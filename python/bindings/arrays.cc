#include "bindings/arrays.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "surfit/core/error.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::python {
namespace {

template <typename T>
using Dense = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <typename Pixel, typename T>
Image<Pixel> ImageOf(const Dense<T>& array) {
  Image<Pixel> image;
  image.Resize(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)));
  std::memcpy(static_cast<void*>(image.data()), array.data(), image.size() * sizeof(Pixel));
  return image;
}

// Converts other integer types, e.g. of 16-bit PNG in Pillow. Throws InputError for a value outside
// of 16 bits.
Image<std::uint16_t> CountsOf(const Dense<std::int64_t>& array) {
  Image<std::uint16_t> counts;
  counts.Resize(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)));
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::int64_t count = array.data()[i];
    ThrowIf(count < 0 || count > 65535, "depth has a count of ", count,
            ", must be from 0 to 65535");
    counts[i] = static_cast<std::uint16_t>(count);
  }
  return counts;
}

std::string TypeOf(const py::array& array) { return py::str(array.dtype()); }

StampedPose PoseOfRow(const double* row, const char* what, py::ssize_t index) {
  const Eigen::Quaterniond rotation(row[7], row[4], row[5], row[6]);
  const bool finite = std::all_of(row, row + 8, [](double value) { return std::isfinite(value); });
  ThrowIf(
      !finite || !(rotation.norm() > 1e-6), what, ": row ", index,
      " must be finite numbers, stamp tx ty tz qx qy qz qw, with a quaternion that is not zero");
  return {row[0], Rigid3d(rotation.normalized(), {row[1], row[2], row[3]})};
}

}  // namespace

std::string ShapeOf(const py::array& array) { return py::str(array.attr("shape")); }

RawDepth DepthOf(const py::array& depth) {
  if (depth.ndim() != 2) {
    throw InputError("depth has shape ", ShapeOf(depth), ", must be (height, width)");
  }
  if (py::isinstance<py::array_t<std::uint16_t>>(depth)) {
    return ImageOf<std::uint16_t>(Dense<std::uint16_t>(depth));
  }
  const char kind = depth.dtype().kind();
  if (kind == 'f') return ImageOf<float>(Dense<float>(depth));
  if (kind == 'i' || kind == 'u') return CountsOf(Dense<std::int64_t>(depth));
  throw InputError("depth is of type ", TypeOf(depth),
                   ", must be integer (counts) or floating-point (metres)");
}

Image<Rgb8> ColorOf(const py::object& color) {
  if (color.is_none()) return {};
  const py::array array = py::array::ensure(color);
  if (!array) throw py::error_already_set();
  if (array.ndim() != 3 || array.shape(2) != 3) {
    throw InputError("color has shape ", ShapeOf(array), ", must be (height, width, 3)");
  }
  if (!py::isinstance<py::array_t<std::uint8_t>>(array)) {
    throw InputError("color is of type ", TypeOf(array), ", must be uint8");
  }
  static_assert(sizeof(Rgb8) == 3);
  return ImageOf<Rgb8>(Dense<std::uint8_t>(array));
}

std::vector<Eigen::Vector3f> VectorsOf(const py::object& array, const char* what) {
  if (array.is_none()) return {};
  const auto rows = Dense<float>::ensure(array);
  if (!rows) throw py::error_already_set();
  if (rows.ndim() != 2 || rows.shape(1) != 3) {
    throw InputError(what, " has shape ", ShapeOf(rows), ", must be (N, 3)");
  }
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  std::vector<Eigen::Vector3f> vectors(rows.shape(0));
  std::memcpy(static_cast<void*>(vectors.data()), rows.data(),
              vectors.size() * sizeof(Eigen::Vector3f));
  return vectors;
}

Trajectory TrajectoryOf(const py::object& rows, const char* what) {
  if (!py::isinstance<py::array>(rows) && !py::isinstance<py::list>(rows)) {
    return ReadTumTrajectory(rows.cast<std::filesystem::path>().string());
  }
  const auto array = Dense<double>::ensure(rows);
  if (!array) throw py::error_already_set();
  if (array.ndim() != 2 || array.shape(1) != 8) {
    throw InputError(what, " has shape ", ShapeOf(array), ", must be (N, 8)");
  }
  Trajectory trajectory;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) {
    trajectory.push_back(PoseOfRow(array.data(i, 0), what, i));
  }
  std::stable_sort(
      trajectory.begin(), trajectory.end(),
      [](const StampedPose& a, const StampedPose& b) { return a.stamp_s < b.stamp_s; });
  return trajectory;
}

py::array_t<double> RowsOf(const Trajectory& trajectory) {
  py::array_t<double> rows({static_cast<py::ssize_t>(trajectory.size()), py::ssize_t{8}});
  double* row = rows.mutable_data();
  for (const StampedPose& pose : trajectory) {
    row[0] = pose.stamp_s;
    Eigen::Map<Eigen::Vector3d>(row + 1) = pose.world_from_camera.translation;
    Eigen::Map<Eigen::Vector4d>(row + 4) = pose.world_from_camera.rotation.coeffs();
    row += 8;
  }
  return rows;
}

}  // namespace surfit::python
