#include <filesystem>
#include <optional>
#include <utility>

#include "apps/solvers/cloud_file.h"
#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/point_cloud.h"
#include "surfit/registration/register_clouds.h"

namespace surfit::python {
namespace {

PointCloud CloudOf(const py::object& points, const py::object& normals, const std::string& what) {
  PointCloud cloud;
  cloud.points = VectorsOf(points, what.c_str());
  cloud.normals = VectorsOf(normals, (what + "_normals").c_str());
  ThrowIf(!cloud.normals.empty() && cloud.normals.size() != cloud.points.size(), what,
          "_normals has ", cloud.normals.size(), " rows, must have ", cloud.points.size(), " as ",
          what);
  return cloud;
}

// Returns std::nullopt without rows.
template <typename Scalar, typename Row>
std::optional<py::array_t<Scalar>> RowsOrNone(const py::object& cloud,
                                              std::vector<Row> PointCloud::*field) {
  const auto& rows = cloud.cast<const PointCloud&>().*field;
  if (rows.empty()) return std::nullopt;
  return RowsView<Scalar>(rows, cloud);
}

void BindPointCloud(py::module_& module) {
  py::class_<PointCloud> cloud(module, "PointCloud",
                               "Point cloud of a file. Arrays are views without copy.");
  BindRows<float>(&cloud, FIELD(PointCloud, points), "N x 3, float32, metres");
  cloud.def_property_readonly(
      "normals",
      [](const py::object& self) { return RowsOrNone<float>(self, &PointCloud::normals); },
      "N x 3, float32; None without normals");
  cloud.def_property_readonly(
      "colors",
      [](const py::object& self) { return RowsOrNone<std::uint8_t>(self, &PointCloud::colors); },
      "N x 3, uint8, red first; None without colours");
  module.def(
      "read_point_cloud",
      [](const std::filesystem::path& path) {
        const py::gil_scoped_release release;
        return ReadPointCloud(path.string());
      },
      py::arg("path"), "Reads a PLY or PCD file. NaN coordinates are kept.");
}

IcpResult RegisterPoints(PointCloud source, PointCloud target, const Rigid3d& start,
                         const RegisterCloudsOptions& options, const CloudSensor& sensor,
                         const CloudNormalOptions& normals) {
  Validate(options);
  Validate(sensor);
  Validate(normals);
  const double floor_sigma_m = options.icp.error_model.floor_sigma_m;
  const auto prepare = [&](PointCloud cloud, const char* what) {
    return PrepareCloud(std::move(cloud), what, sensor, normals, floor_sigma_m).points;
  };
  return RegisterClouds(prepare(std::move(source), "source"), prepare(std::move(target), "target"),
                        start, options);
}

}  // namespace

void BindClouds(py::module_& module) {
  BindPointCloud(module);
  module.def(
      "register",
      [](const py::object& source, const py::object& target, const py::object& source_normals,
         const py::object& target_normals, std::optional<Rigid3d> target_from_source,
         RegisterCloudsOptions options, CloudSensor sensor, CloudNormalOptions normals) {
        PointCloud source_cloud = CloudOf(source, source_normals, "source");
        PointCloud target_cloud = CloudOf(target, target_normals, "target");
        const py::gil_scoped_release release;
        return RegisterPoints(std::move(source_cloud), std::move(target_cloud),
                              target_from_source.value_or(Rigid3d()), options, sensor, normals);
      },
      py::arg("source"), py::arg("target"), py::arg("source_normals") = py::none(),
      py::arg("target_normals") = py::none(), py::arg("target_from_source") = py::none(),
      py::arg("options") = RegisterCloudsOptions(), py::arg("sensor") = CloudSensor(),
      py::arg("normals") = CloudNormalOptions(),
      "Registers two clouds, N x 3 arrays in metres, by ICP with nearest neighbours, coarse to "
      "fine. target_from_source: initial pose, 4 x 4; the identity if None. Points that are not "
      "finite are removed. Normals are estimated if they are None.");
}

}  // namespace surfit::python
