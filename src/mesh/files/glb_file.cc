#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mesh/files/mesh_writers.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

std::array<std::uint16_t, 256> LinearOfBytes() {
  std::array<std::uint16_t, 256> linear;
  for (int byte = 0; byte < 256; ++byte) {
    const double s = byte / 255.;
    const double value = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    linear[byte] = static_cast<std::uint16_t>(std::lround(65535 * value));
  }
  return linear;
}

// Builds a binary glTF 2.0 file: binary buffer and JSON description.
class Glb {
 public:
  // Adds binary data with its accessor description. Returns the accessor index. `target`: OpenGL
  // buffer type.
  int Add(const void* bytes, std::size_t size, Json accessor, int target) {
    accessor["bufferView"] = AddView(bytes, size);
    views_.back()["target"] = target;
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }
  void AddPicture(const std::string& jpeg) { picture_ = AddView(jpeg.data(), jpeg.size()); }

  void Write(const Json& attributes, int indices, std::ostream& out) const {
    const Json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", 0}};
    Json material = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                     {"doubleSided", true},
                     {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
    if (picture_) material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    // Rotates the mesh by 180 degrees about x, because the y axis of glTF points up.
    const Json node = {{"mesh", 0}, {"rotation", {1, 0, 0, 0}}};
    Json json = {{"asset", {{"version", "2.0"}, {"generator", "Surfit"}}},
                 {"extensionsUsed", {"KHR_materials_unlit"}},
                 {"scene", 0},
                 {"scenes", {{{"nodes", {0}}}}},
                 {"nodes", {node}},
                 {"meshes", {{{"primitives", {primitive}}}}},
                 {"materials", {material}},
                 {"accessors", accessors_},
                 {"bufferViews", views_},
                 {"buffers", {{{"byteLength", binary_.size()}}}}};
    if (picture_) {
      json["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
      json["samplers"] = Json::array({{{"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}}});
      json["images"] = Json::array({{{"bufferView", *picture_}, {"mimeType", "image/jpeg"}}});
    }
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJson = 0x4e4f534a,
                            kBinary = 0x004e4942;
    const auto size = [](const std::string& s) { return static_cast<std::uint32_t>(s.size()); };
    const auto put = [&](std::uint32_t value) {
      out.write(reinterpret_cast<const char*>(&value), sizeof(value));
    };
    for (const std::uint32_t value : {kMagic, kVersion, 28 + size(text) + size(binary_)})
      put(value);
    for (const std::uint32_t value : {size(text), kJson}) put(value);
    out << text;
    for (const std::uint32_t value : {size(binary_), kBinary}) put(value);
    out << binary_;
  }

 private:
  static constexpr int kClampToEdge = 33071;

  std::size_t AddView(const void* bytes, std::size_t size) {
    views_.push_back({{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}});
    binary_.append(static_cast<const char*>(bytes), size);
    binary_.resize((binary_.size() + 3) / 4 * 4);
    return views_.size() - 1;
  }

  std::string binary_;
  Json views_ = Json::array(), accessors_ = Json::array();
  std::optional<std::size_t> picture_;
};

constexpr int kFloatType = 5126, kUnsignedType = 5125, kShortType = 5123;
constexpr int kOfVertices = 34962, kOfIndices = 34963;

int AddVectors(const std::vector<Eigen::Vector3f>& vectors, Glb* glb) {
  Eigen::Vector3f low = vectors.front(), high = low;
  for (const Eigen::Vector3f& v : vectors) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const Json accessor = {{"componentType", kFloatType},
                         {"count", vectors.size()},
                         {"type", "VEC3"},
                         {"min", {low.x(), low.y(), low.z()}},
                         {"max", {high.x(), high.y(), high.z()}}};
  return glb->Add(vectors.data(), 12 * vectors.size(), accessor, kOfVertices);
}

int AddColors(const std::vector<Rgb8>& colors, Glb* glb) {
  const auto linear = LinearOfBytes();
  std::vector<std::array<std::uint16_t, 4>> rows;
  rows.reserve(colors.size());
  for (const Rgb8 c : colors) rows.push_back({linear[c.r], linear[c.g], linear[c.b], 65535});
  const Json accessor = {{"componentType", kShortType},
                         {"normalized", true},
                         {"count", rows.size()},
                         {"type", "VEC4"}};
  return glb->Add(rows.data(), 8 * rows.size(), accessor, kOfVertices);
}

// 16 bits resolve an eighth of a texel in the largest texture.
int AddTextureCoordinates(const std::vector<Eigen::Vector2f>& coordinates, Glb* glb) {
  std::vector<std::array<std::uint16_t, 2>> rows;
  rows.reserve(coordinates.size());
  for (const Eigen::Vector2f& place : coordinates) {
    const Eigen::Vector2f scaled = 65535 * place;
    rows.push_back({static_cast<std::uint16_t>(std::lround(scaled.x())),
                    static_cast<std::uint16_t>(std::lround(scaled.y()))});
  }
  const Json accessor = {{"componentType", kShortType},
                         {"normalized", true},
                         {"count", rows.size()},
                         {"type", "VEC2"}};
  return glb->Add(rows.data(), 4 * rows.size(), accessor, kOfVertices);
}

int AddTriangles(const std::vector<TriangleMesh::Triangle>& triangles, Glb* glb) {
  const Json accessor = {
      {"componentType", kUnsignedType}, {"count", 3 * triangles.size()}, {"type", "SCALAR"}};
  return glb->Add(triangles.data(), 12 * triangles.size(), accessor, kOfIndices);
}

std::vector<Eigen::Vector3f> PositionsOf(const TriangleMesh& mesh, const MeshTexture& texture) {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(texture.vertices.size());
  for (const std::uint32_t v : texture.vertices) positions.push_back(mesh.vertices[v]);
  return positions;
}

}  // namespace

// Without normals, which an unlit material does not use.
void WriteGlbMesh(const TriangleMesh& mesh, const MeshTexture* texture, std::ostream& out) {
  Glb glb;
  if (texture != nullptr) {
    Json attributes = {{"POSITION", AddVectors(PositionsOf(mesh, *texture), &glb)}};
    attributes["TEXCOORD_0"] = AddTextureCoordinates(texture->texture_coordinates, &glb);
    const int indices = AddTriangles(texture->triangles, &glb);
    glb.AddPicture(EncodeTexture(*texture));
    glb.Write(attributes, indices, out);
    return;
  }
  Json attributes = {{"POSITION", AddVectors(mesh.vertices, &glb)}};
  if (!mesh.colors.empty()) attributes["COLOR_0"] = AddColors(mesh.colors, &glb);
  glb.Write(attributes, AddTriangles(mesh.triangles, &glb), out);
}

}  // namespace surfit
