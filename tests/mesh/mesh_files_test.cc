#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/images/image_files.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"
#include "surfit/mesh/texture_mesh.h"
#include "surfit/mesh/triangle_mesh.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

using ::testing::ElementsAre;

TriangleMesh Square() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0.5f, 0, 1}, {0.5f, 0.25f, 1}, {0, 0.25f, 1}};
  mesh.normals.assign(4, {0, 0, -1});
  mesh.colors = {{0, 0, 0}, {255, 0, 0}, {10, 128, 255}, {1, 2, 3}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  return mesh;
}

TEST(MeshFiles, PlyContainsMesh) {
  const TempFolder folder;
  const TriangleMesh mesh = Square();
  WriteMesh(mesh, folder / "mesh.ply");
  const PointCloud read = ReadPly(folder / "mesh.ply");
  EXPECT_EQ(read.points, mesh.vertices);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_EQ(read.colors, mesh.colors);
  const std::string file = ReadBytes(folder / "mesh.ply");
  EXPECT_THAT(file,
              HasSubstr("element face 2\nproperty list uchar int vertex_indices\nend_header"));
  for (int i = 0; i < 2; ++i) {
    const char* row = &file[file.size() - 13 * (2 - i)];
    std::array<std::uint32_t, 3> triangle;
    std::memcpy(&triangle, row + 1, sizeof(triangle));
    EXPECT_EQ(row[0], 3);
    EXPECT_EQ(triangle, mesh.triangles[i]);
  }
}

TEST(MeshFiles, ObjHasOneBasedIndicesAndVertexColors) {
  const TempFolder folder;
  WriteMesh(Square(), folder / "mesh.obj");
  std::istringstream file(ReadBytes(folder / "mesh.obj"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 10u);
  EXPECT_EQ(lines[2], "v 0.50000 0.25000 1.00000 0.0392 0.5020 1.0000");
  EXPECT_EQ(lines[4], "vn 0.0000 0.0000 -1.0000");
  EXPECT_EQ(lines[8], "f 1//1 3//3 2//2");
  EXPECT_EQ(lines[9], "f 1//1 4//4 3//3");
}

std::uint32_t WordAt(const std::string& file, std::size_t at) {
  std::uint32_t word;
  std::memcpy(&word, &file.at(at), sizeof(word));
  return word;
}

// Header and chunks as defined in the specification of glTF 2.0.
TEST(MeshFiles, GlbAgreesWithItsHeader) {
  const TempFolder folder;
  const TriangleMesh mesh = Square();
  WriteMesh(mesh, folder / "mesh.glb");
  const std::string file = ReadBytes(folder / "mesh.glb");
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(WordAt(file, 4), 2u);
  EXPECT_EQ(WordAt(file, 8), file.size());
  const std::uint32_t json_size = WordAt(file, 12);
  EXPECT_EQ(json_size % 4, 0u);
  EXPECT_EQ(file.substr(16, 4), "JSON");
  EXPECT_EQ(file.substr(20 + json_size + 4, 4), std::string("BIN\0", 4));
  const auto json = nlohmann::json::parse(file.substr(20, json_size));
  const std::string binary = file.substr(20 + json_size + 8);
  EXPECT_EQ(json["buffers"][0]["byteLength"], binary.size());
  const auto& primitive = json["meshes"][0]["primitives"][0];
  const auto bytes = [&](int accessor) {
    const auto& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<int>()];
    return binary.substr(view["byteOffset"].get<int>(), view["byteLength"].get<int>());
  };
  const std::string vertices = bytes(primitive["attributes"]["POSITION"]);
  ASSERT_EQ(vertices.size(), 4 * 12u);
  EXPECT_EQ(std::memcmp(vertices.data(), mesh.vertices.data(), vertices.size()), 0);
  const std::string indices = bytes(primitive["indices"]);
  ASSERT_EQ(indices.size(), 2 * 12u);
  EXPECT_EQ(std::memcmp(indices.data(), mesh.triangles.data(), indices.size()), 0);
  EXPECT_THAT(json["accessors"][0]["max"], ElementsAre(0.5, 0.25, 1));
  // sRGB 128 is 0.2158605 in linear intensity.
  const std::string colors = bytes(primitive["attributes"]["COLOR_0"]);
  ASSERT_EQ(colors.size(), 4 * 8u);
  EXPECT_EQ(WordAt(colors, 2 * 8) >> 16,
            static_cast<std::uint32_t>(std::lround(0.2158605 * 65535)));
}

TEST(MeshFiles, RejectsEmptyGlb) {
  const TempFolder folder;
  TriangleMesh mesh;
  ExpectInputError([&] { WriteMesh(mesh, folder / "mesh.glb"); }, Names("mesh.glb", "0 vertices"));
  mesh = Square();
  mesh.triangles.clear();
  ExpectInputError([&] { WriteMesh(mesh, folder / "mesh.glb"); }, Names("mesh.glb", "0 triangles"));
  EXPECT_NO_THROW(WriteMesh(TriangleMesh(), folder / "mesh.ply"));
}

TEST(KeepTriangles, RejectsMarksOfAnotherNumber) {
  TriangleMesh mesh = Square();
  ExpectInputError([&] { KeepTriangles({1}, &mesh); }, Names(1, 2));
}

// Square with a texture of two halves. Corners 0 and 2 have two texture coordinates each.
MeshTexture TwoHalves() {
  MeshTexture texture;
  texture.vertices = {0, 2, 1, 0, 3, 2};
  texture.texture_coordinates = {{0.25f, 0.125f}, {0.5f, 0.75f}, {0.5f, 0.125f},
                                 {0.5f, 0.25f},   {0.5f, 1},     {1, 1}};
  texture.triangles = {{0, 1, 2}, {3, 4, 5}};
  texture.image = Image<Rgb8>(64, 32, {255, 255, 255});
  for (int v = 0; v < 32; ++v) std::fill_n(texture.image.row(v), 32, Rgb8{200, 40, 10});
  return texture;
}

void ExpectTwoHalves(const Image<Rgb8>& image) {
  ASSERT_EQ(image.width(), 64);
  ASSERT_EQ(image.height(), 32);
  EXPECT_NEAR(image(5, 20).r, 200, 3);
  EXPECT_NEAR(image(5, 20).g, 40, 3);
  EXPECT_NEAR(image(60, 20).g, 255, 3);
}

// The OBJ file names its MTL file, and the MTL file names the texture.
TEST(MeshFiles, ObjNamesMaterialAndTexture) {
  const TempFolder folder;
  WriteMesh(Square(), TwoHalves(), folder / "a.room.obj");
  std::istringstream file(ReadBytes(folder / "a.room.obj"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 1 + 4 + 4 + 6 + 1 + 2u);
  EXPECT_EQ(lines[0], "mtllib a.room.mtl");
  EXPECT_EQ(lines[3], "v 0.50000 0.25000 1.00000");
  EXPECT_EQ(lines[9], "vt 0.250000 0.875000");  // v is up
  EXPECT_EQ(lines[15], "usemtl frames");
  EXPECT_EQ(lines[16], "f 1/1/1 3/2/3 2/3/2");
  EXPECT_EQ(lines[17], "f 1/4/1 4/5/4 3/6/3");
  const std::string material = ReadBytes(folder / "a.room.mtl");
  EXPECT_THAT(material, StartsWith("newmtl frames\n"));
  EXPECT_THAT(material, HasSubstr("\nmap_Kd a.room.jpg\n"));
  ExpectTwoHalves(ReadColorImage(folder / "a.room.jpg"));
}

TEST(MeshFiles, GlbContainsTexture) {
  const TempFolder folder;
  const MeshTexture texture = TwoHalves();
  WriteMesh(Square(), texture, folder / "mesh.glb");
  const std::string file = ReadBytes(folder / "mesh.glb");
  EXPECT_EQ(WordAt(file, 8), file.size());
  const std::uint32_t json_size = WordAt(file, 12);
  const auto json = nlohmann::json::parse(file.substr(20, json_size));
  const std::string binary = file.substr(20 + json_size + 8);
  const auto view = [&](int i) {
    const auto& range = json["bufferViews"][i];
    return binary.substr(range["byteOffset"].get<int>(), range["byteLength"].get<int>());
  };
  const auto& primitive = json["meshes"][0]["primitives"][0];
  EXPECT_FALSE(primitive["attributes"].contains("COLOR_0"));
  EXPECT_FALSE(primitive["attributes"].contains("NORMAL"));
  const auto bytes = [&](const nlohmann::json& accessor) {
    return view(json["accessors"][accessor.get<int>()]["bufferView"]);
  };
  const std::string places = bytes(primitive["attributes"]["TEXCOORD_0"]);
  ASSERT_EQ(places.size(), 6 * 4u);
  for (int i = 0; i < 6; ++i) {
    std::uint16_t place[2];
    std::memcpy(place, &places[4 * i], sizeof(place));
    EXPECT_NEAR(place[0] / 65535., texture.texture_coordinates[i].x(), 0.5 / 65535);
    EXPECT_NEAR(place[1] / 65535., texture.texture_coordinates[i].y(), 0.5 / 65535);
  }
  const std::string positions = bytes(primitive["attributes"]["POSITION"]);
  ASSERT_EQ(positions.size(), 6 * 12u);
  const Eigen::Vector3f second = Square().vertices[2];
  EXPECT_EQ(std::memcmp(&positions[12], second.data(), 12), 0);
  const std::string indices = bytes(primitive["indices"]);
  EXPECT_EQ(std::memcmp(indices.data(), texture.triangles.data(), indices.size()), 0);
  const auto& material = json["materials"][0]["pbrMetallicRoughness"];
  const int source = json["textures"][material["baseColorTexture"]["index"].get<int>()]["source"];
  EXPECT_EQ(json["images"][source]["mimeType"], "image/jpeg");
  ExpectTwoHalves(DecodeJpeg(view(json["images"][source]["bufferView"]), "picture"));
}

TEST(MeshFiles, RejectsTextureInPly) {
  const TempFolder folder;
  EXPECT_THAT([&] { WriteMesh(Square(), TwoHalves(), folder / "mesh.ply"); },
              ThrowsNaming<InputError>("mesh.ply", ".obj", ".glb"));
}

TEST(MeshFiles, RejectsUnknownExtensionAndMissingFolder) {
  const TempFolder folder;
  EXPECT_THAT([&] { WriteMesh(Square(), folder / "mesh.stl"); },
              ThrowsNaming<InputError>("mesh.stl", ".ply", ".obj", ".glb"));
  EXPECT_THAT([&] { WriteMesh(Square(), folder.path() + "/none/mesh.ply"); },
              ThrowsNaming<InputError>("none/mesh.ply"));
}

TEST(TriangleMesh, KeepTrianglesRemovesUnusedVertices) {
  TriangleMesh mesh = Square();
  KeepTriangles({0, 1}, &mesh);
  EXPECT_THAT(mesh.triangles, ElementsAre(TriangleMesh::Triangle{0, 2, 1}));
  EXPECT_THAT(mesh.vertices, ElementsAre(Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0.5f, 0.25f, 1),
                                         Eigen::Vector3f(0, 0.25f, 1)));
  EXPECT_THAT(mesh.colors, ElementsAre(Rgb8{0, 0, 0}, Rgb8{10, 128, 255}, Rgb8{1, 2, 3}));
  EXPECT_EQ(mesh.normals.size(), 3u);
}

}  // namespace
}  // namespace surfit::testing
