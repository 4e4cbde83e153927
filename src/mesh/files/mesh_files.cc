#include <filesystem>
#include <ostream>

#include "io/clouds/ply.h"
#include "io/images/image_files.h"
#include "mesh/files/mesh_writers.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {
namespace {

constexpr std::size_t kBytesAtOnce = 1 << 20;

std::string EndingOf(const std::string& path) { return std::filesystem::path(path).extension(); }

void WritePlyMesh(const TriangleMesh& mesh, std::ostream& out) {
  constexpr PlyType kFloat = PlyType::kFloat32, kByte = PlyType::kUint8;
  std::vector<PlyProperty> properties = {{"x", kFloat}, {"y", kFloat}, {"z", kFloat}};
  if (!mesh.normals.empty())
    properties.insert(properties.end(), {{"nx", kFloat}, {"ny", kFloat}, {"nz", kFloat}});
  if (!mesh.colors.empty())
    properties.insert(properties.end(), {{"red", kByte}, {"green", kByte}, {"blue", kByte}});
  const auto vertices = static_cast<std::int64_t>(mesh.vertices.size());
  const auto faces = static_cast<std::int64_t>(mesh.triangles.size());
  out << FormatPlyHeader({{"vertex", vertices, properties},
                          {"face", faces, {{"vertex_indices", PlyType::kInt32, kByte}}}});
  PlyRow row;
  const auto flush = [&](std::size_t least) {
    if (row.bytes().size() < least) return;
    out.write(row.bytes().data(), static_cast<std::streamsize>(row.bytes().size()));
    row.Clear();
  };
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (const float value : mesh.vertices[i]) row.Put(value);
    if (!mesh.normals.empty())
      for (const float value : mesh.normals[i]) row.Put(value);
    if (!mesh.colors.empty()) row.Put(mesh.colors[i]);
    flush(kBytesAtOnce);
  }
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    row.Put(std::uint8_t{3});
    row.Put(triangle);
    flush(kBytesAtOnce);
  }
  flush(0);
}

}  // namespace

void RequireMeshEnding(const std::string& path) {
  const std::string ending = EndingOf(path);
  ThrowIf(ending != ".ply" && ending != ".obj" && ending != ".glb", "the mesh is ", path,
          ", must end in .ply, .obj or .glb");
}

void RequireTextureEnding(const std::string& path) {
  const std::string ending = EndingOf(path);
  ThrowIf(ending != ".obj" && ending != ".glb", "the mesh is ", path,
          ", must end in .obj or .glb for a texture");
}

std::string EncodeTexture(const MeshTexture& texture) {
  constexpr int kQuality = 92;
  return EncodeJpeg(texture.image, kQuality);
}

// glTF has no empty accessors.
static void RequireTriangles(const TriangleMesh& mesh, const std::string& path) {
  ThrowIf(mesh.vertices.empty() || mesh.triangles.empty(), path, ": the mesh has ",
          mesh.vertices.size(), " vertices and ", mesh.triangles.size(),
          " triangles, a .glb file must have one of each or more");
}

void WriteMesh(const TriangleMesh& mesh, const std::string& path) {
  RequireMeshEnding(path);
  const std::string ending = EndingOf(path);
  if (ending == ".glb") RequireTriangles(mesh, path);
  WriteFileAtomically(path, [&](std::ostream& out) {
    if (ending == ".ply") WritePlyMesh(mesh, out);
    if (ending == ".obj") WriteObjMesh(mesh, nullptr, "", out);
    if (ending == ".glb") WriteGlbMesh(mesh, nullptr, out);
  });
}

void WriteMesh(const TriangleMesh& mesh, const MeshTexture& texture, const std::string& path) {
  RequireTextureEnding(path);
  if (EndingOf(path) == ".glb") {
    RequireTriangles(mesh, path);
    WriteFileAtomically(path, [&](std::ostream& out) { WriteGlbMesh(mesh, &texture, out); });
    return;
  }
  const auto beside = [&](const char* ending) {
    return std::filesystem::path(path).replace_extension(ending);
  };
  const std::string picture = beside(".jpg").filename(), material = beside(".mtl").filename();
  const std::string jpeg = EncodeTexture(texture);
  WriteFileAtomically(beside(".jpg"), [&](std::ostream& out) { out << jpeg; });
  WriteFileAtomically(beside(".mtl"), [&](std::ostream& out) { WriteMtl(picture, out); });
  WriteFileAtomically(path,
                      [&](std::ostream& out) { WriteObjMesh(mesh, &texture, material, out); });
}

}  // namespace surfit
