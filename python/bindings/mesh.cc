// Triangle meshes of maps.
#include <filesystem>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/without_gil.h"
#include "surfit/mesh/mesh_surfels.h"

namespace surfit::python {
namespace {

// A mesh and how it was made.
struct MadeMesh : TriangleMesh {
  MeshSummary summary;
};

void BindMeshSummary(py::module_& module) {
  BindReport<MeshSummary>(module, "MeshSummary", "What was made of a cloud.")
      .def_readonly(FIELD(MeshSummary, pieces), "that are left")
      .def_readonly(FIELD(MeshSummary, pieces_dropped), "below min_piece_m")
      .def_readonly(FIELD(MeshSummary, triangles_dropped), "of these")
      .def_readonly(FIELD(MeshSummary, triangles_found), "before decimation")
      .def_readonly(FIELD(MeshSummary, decimation_m), "that it moved the surface by")
      .def_readonly(FIELD(MeshSummary, median_distance_m),
                    "from the points to the mesh before decimation")
      .def_readonly(FIELD(MeshSummary, p90_distance_m), "nine tenths are no farther")
      .def_readonly(FIELD(MeshSummary, covered), "share of points with mesh within 3 cells");
}

}  // namespace

void BindMesh(py::module_& module) {
  BindMeshSummary(module);
  py::class_<MadeMesh> mesh(module, "TriangleMesh",
                            "A surface. The arrays are views of its memory.");
  BindRows<float>(&mesh, FIELD(TriangleMesh, vertices), "N x 3, float32, metres");
  BindRows<float>(&mesh, FIELD(TriangleMesh, normals), "N x 3, float32, to the side that was seen");
  BindRows<std::uint8_t>(&mesh, FIELD(TriangleMesh, colors),
                         "N x 3, uint8, red first; empty without");
  BindRows<std::uint32_t>(&mesh, FIELD(TriangleMesh, triangles),
                          "M x 3, uint32: vertices, counterclockwise from the side that was seen");
  mesh.def_readonly(FIELD(MadeMesh, summary), "how it was made")
      .def(
          "write",
          [](const MadeMesh& made, const std::filesystem::path& path) {
            const py::gil_scoped_release release;
            WriteMesh(made, path.string());
          },
          py::arg("path"), "Writes a .ply, .obj or .glb file.")
      .def("__repr__", [](const MadeMesh& made) {
        return "<surfit.TriangleMesh of " + std::to_string(made.vertices.size()) +
               " vertices and " + std::to_string(made.triangles.size()) + " triangles>";
      });
  module.def(
      "make_mesh",
      [](const PointCloud& cloud, const MeshOptions& options, const py::object& progress) {
        return WithoutGil(progress, [&](const auto& call) {
          PointCloud finite = cloud;
          RemoveNonFinite(&finite);
          MadeMesh made;
          static_cast<TriangleMesh&>(made) =
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
