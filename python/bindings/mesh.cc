// Triangle meshes of maps.
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/without_gil.h"
#include "surfit/mesh/mesh_surfels.h"

namespace py = pybind11;

namespace surfit::python {
namespace {

// A mesh and how it was made.
struct MadeMesh {
  TriangleMesh mesh;
  MeshSummary summary;
};

// N x 3.
template <typename T, typename Row>
py::array_t<T> RowsOfMesh(const py::object& self, const std::vector<Row> TriangleMesh::*rows) {
  static_assert(sizeof(Row) == 3 * sizeof(T));
  const auto& all = self.cast<const MadeMesh&>().mesh.*rows;
  return ViewOf(reinterpret_cast<const T*>(all.data()), {static_cast<py::ssize_t>(all.size()), 3},
                self);
}

void BindMeshSummary(py::module_& module) {
  BindReport<MeshSummary>(module, "MeshSummary", "What was made of a cloud.")
      .def_readonly("pieces", &MeshSummary::pieces, "that are left")
      .def_readonly("pieces_dropped", &MeshSummary::pieces_dropped, "below min_piece_m")
      .def_readonly("triangles_dropped", &MeshSummary::triangles_dropped, "of these")
      .def_readonly("triangles_found", &MeshSummary::triangles_found, "before decimation")
      .def_readonly("decimation_m", &MeshSummary::decimation_m, "that it moved the surface by")
      .def_readonly("median_distance_m", &MeshSummary::median_distance_m,
                    "from the points to the mesh before decimation")
      .def_readonly("p90_distance_m", &MeshSummary::p90_distance_m, "nine tenths are no farther")
      .def_readonly("covered", &MeshSummary::covered, "share of points with mesh within 3 cells");
}

}  // namespace

void BindMesh(py::module_& module) {
  BindMeshSummary(module);
  py::class_<MadeMesh>(module, "TriangleMesh", "A surface. The arrays are views of its memory.")
      .def_property_readonly(
          "vertices",
          [](const py::object& self) { return RowsOfMesh<float>(self, &TriangleMesh::vertices); },
          "N x 3, float32, metres")
      .def_property_readonly(
          "normals",
          [](const py::object& self) { return RowsOfMesh<float>(self, &TriangleMesh::normals); },
          "N x 3, float32, to the side that was seen")
      .def_property_readonly(
          "colors",
          [](const py::object& self) {
            return RowsOfMesh<std::uint8_t>(self, &TriangleMesh::colors);
          },
          "N x 3, uint8, red first; empty without")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            return RowsOfMesh<std::uint32_t>(self, &TriangleMesh::triangles);
          },
          "M x 3, uint32: vertices, counterclockwise from the side that was seen")
      .def_readonly("summary", &MadeMesh::summary, "how it was made")
      .def(
          "write",
          [](const MadeMesh& made, const std::filesystem::path& path) {
            const py::gil_scoped_release release;
            WriteMesh(made.mesh, path.string());
          },
          py::arg("path"), "Writes a .ply, .obj or .glb file.")
      .def("__repr__", [](const MadeMesh& made) {
        return "<surfit.TriangleMesh of " + std::to_string(made.mesh.vertices.size()) +
               " vertices and " + std::to_string(made.mesh.triangles.size()) + " triangles>";
      });
  module.def(
      "make_mesh",
      [](const PointCloud& cloud, const MeshOptions& options, const py::object& progress) {
        return WithoutGil(progress, [&](const auto& call) {
          PointCloud finite = cloud;
          RemoveNonFinite(&finite);
          MadeMesh made;
          made.mesh =
              MeshSurfels(finite, options, &made.summary,
                          [&](const std::string& stage, double share) { call(stage, share); });
          return made;
        });
      },
      py::arg("cloud"), py::arg("options") = MeshOptions(), py::arg("progress") = py::none(),
      "The surface of a map (read_point_cloud('map.ply')) or of another cloud with normals. "
      "progress is called with what is being done and the share of all that is done.");
}

}  // namespace surfit::python
