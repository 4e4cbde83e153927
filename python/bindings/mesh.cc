#include <filesystem>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/without_gil.h"
#include "surfit/mesh/mesh_surfels.h"

namespace surfit::python {
namespace {

struct MeshWithSummary : TriangleMesh {
  MeshSummary summary;
};

void BindMeshSummary(py::module_& module) {
  BindReport<MeshSummary>(module, "MeshSummary", "Statistics of a mesh.")
      .def_readonly(FIELD(MeshSummary, pieces), "connected pieces of the mesh")
      .def_readonly(FIELD(MeshSummary, components_dropped),
                    "removed pieces smaller than min_component_m")
      .def_readonly(FIELD(MeshSummary, triangles_dropped), "triangles of removed pieces")
      .def_readonly(FIELD(MeshSummary, triangles_found), "before decimation")
      .def_readonly(FIELD(MeshSummary, decimation_m), "motion of the surface by decimation, m")
      .def_readonly(FIELD(MeshSummary, median_distance_m),
                    "median distance from the points to the mesh before decimation")
      .def_readonly(FIELD(MeshSummary, p90_distance_m), "90 % quantile of these distances")
      .def_readonly(FIELD(MeshSummary, covered), "ratio of points with a surface within 3 cells");
}

}  // namespace

void BindMesh(py::module_& module) {
  BindMeshSummary(module);
  py::class_<MeshWithSummary> mesh(module, "TriangleMesh",
                                   "Triangle mesh. Arrays are views without copy.");
  BindRows<float>(&mesh, FIELD(TriangleMesh, vertices), "N x 3, float32, metres");
  BindRows<float>(&mesh, FIELD(TriangleMesh, normals), "N x 3, float32, towards the observer");
  BindRows<std::uint8_t>(&mesh, FIELD(TriangleMesh, colors),
                         "N x 3, uint8, red first; empty without colours");
  BindRows<std::uint32_t>(
      &mesh, FIELD(TriangleMesh, triangles),
      "M x 3, uint32: vertex indices, counterclockwise as seen by the observer");
  mesh.def_readonly(FIELD(MeshWithSummary, summary), "statistics")
      .def(
          "write",
          [](const MeshWithSummary& made, const std::filesystem::path& path) {
            const py::gil_scoped_release release;
            WriteMesh(made, path.string());
          },
          py::arg("path"), "Writes a .ply, .obj or .glb file.")
      .def("__repr__", [](const MeshWithSummary& made) {
        return "<surfit.TriangleMesh of " + std::to_string(made.vertices.size()) +
               " vertices and " + std::to_string(made.triangles.size()) + " triangles>";
      });
  module.def(
      "make_mesh",
      [](const PointCloud& cloud, const MeshOptions& options, const py::object& progress) {
        return WithoutGil(progress, [&](const auto& call) {
          PointCloud finite = cloud;
          RemoveNonFinite(&finite);
          MeshWithSummary made;
          static_cast<TriangleMesh&>(made) =
              MeshSurfels(finite, options, &made.summary,
                          [&](const std::string& stage, double share) { call(stage, share); });
          return made;
        });
      },
      py::arg("cloud"), py::arg("options") = MeshOptions(), py::arg("progress") = py::none(),
      "Creates a mesh of a map (read_point_cloud('map.ply')) or of another cloud with normals. "
      "Calls progress(stage, completed ratio).");
}

}  // namespace surfit::python
