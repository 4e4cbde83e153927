#include <algorithm>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>

#include "io/ply.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// Rows are put together in memory, and written when there are so many bytes.
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

// Lines of words and numbers.
class TextLines {
 public:
  explicit TextLines(std::ostream& out) : out_(out) {}
  ~TextLines() { out_ << text_; }
  TextLines(const TextLines&) = delete;
  TextLines& operator=(const TextLines&) = delete;

  void Word(const char* word) { text_ += word; }
  void Number(float value, int digits) {
    text_ += ' ';
    char buffer[64];
    const auto end =
        std::to_chars(buffer, std::end(buffer), value, std::chars_format::fixed, digits).ptr;
    text_.append(buffer, end);
  }
  void Index(std::uint32_t zero_based) { text_ += std::to_string(zero_based + 1); }
  void End() {
    text_ += '\n';
    if (text_.size() < kBytesAtOnce) return;
    out_ << text_;
    text_.clear();
  }

 private:
  std::ostream& out_;
  std::string text_;
};

void WriteObjMesh(const TriangleMesh& mesh, std::ostream& out) {
  constexpr int kDigits = 5;  // of a metre: a hundredth of a millimetre
  constexpr int kDigitsOfOne = 4;
  TextLines lines(out);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    lines.Word("v");
    for (const float value : mesh.vertices[i]) lines.Number(value, kDigits);
    if (!mesh.colors.empty()) {
      const Rgb8 c = mesh.colors[i];
      for (const std::uint8_t byte : {c.r, c.g, c.b})
        lines.Number(static_cast<float>(byte) / 255.f, kDigitsOfOne);
    }
    lines.End();
  }
  for (const Eigen::Vector3f& normal : mesh.normals) {
    lines.Word("vn");
    for (const float value : normal) lines.Number(value, kDigitsOfOne);
    lines.End();
  }
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    lines.Word("f");
    for (const std::uint32_t v : triangle) {
      lines.Word(" ");
      lines.Index(v);
      if (mesh.normals.empty()) continue;
      lines.Word("//");
      lines.Index(v);
    }
    lines.End();
  }
}

// From sRGB to the linear scale that glTF has, as a share of 65535.
std::array<std::uint16_t, 256> LinearOfBytes() {
  std::array<std::uint16_t, 256> linear;
  for (int byte = 0; byte < 256; ++byte) {
    const double s = byte / 255.;
    const double value = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    linear[byte] = static_cast<std::uint16_t>(std::lround(65535 * value));
  }
  return linear;
}

// The parts of a binary glTF (Khronos, glTF 2.0): buffer views behind each other, and what they
// hold.
class Glb {
 public:
  // A table of rows of numbers of a type of OpenGL's; returns the accessor's number.
  int Add(const void* bytes, std::size_t size, Json accessor, int target) {
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}, {"target", target}});
    accessor["bufferView"] = views_.size() - 1;
    accessors_.push_back(std::move(accessor));
    binary_.append(static_cast<const char*>(bytes), size);
    binary_.resize((binary_.size() + 3) / 4 * 4);
    return static_cast<int>(accessors_.size()) - 1;
  }

  void Write(const Json& attributes, int indices, std::ostream& out) const {
    const Json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", 0}};
    const Json material = {
        {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
        {"doubleSided", true},
        {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
    // Half a turn about x: from y down and z forward to y up.
    const Json node = {{"mesh", 0}, {"rotation", {1, 0, 0, 0}}};
    const Json json = {{"asset", {{"version", "2.0"}, {"generator", "Surfit"}}},
                       {"extensionsUsed", {"KHR_materials_unlit"}},
                       {"scene", 0},
                       {"scenes", {{{"nodes", {0}}}}},
                       {"nodes", {node}},
                       {"meshes", {{{"primitives", {primitive}}}}},
                       {"materials", {material}},
                       {"accessors", accessors_},
                       {"bufferViews", views_},
                       {"buffers", {{{"byteLength", binary_.size()}}}}};
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
  std::string binary_;
  Json views_ = Json::array(), accessors_ = Json::array();
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

void WriteGlbMesh(const TriangleMesh& mesh, std::ostream& out) {
  Glb glb;
  Json attributes = {{"POSITION", AddVectors(mesh.vertices, &glb)}};
  if (!mesh.normals.empty()) attributes["NORMAL"] = AddVectors(mesh.normals, &glb);
  if (!mesh.colors.empty()) attributes["COLOR_0"] = AddColors(mesh.colors, &glb);
  const Json accessor = {
      {"componentType", kUnsignedType}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}};
  const int indices =
      glb.Add(mesh.triangles.data(), 12 * mesh.triangles.size(), accessor, kOfIndices);
  glb.Write(attributes, indices, out);
}

}  // namespace

void RequireMeshEnding(const std::string& path) {
  const std::string ending = EndingOf(path);
  if (ending != ".ply" && ending != ".obj" && ending != ".glb")
    throw InputError(Concat("the mesh is ", path, ", must end in .ply, .obj or .glb"));
}

void WriteMesh(const TriangleMesh& mesh, const std::string& path) {
  RequireMeshEnding(path);
  const std::string ending = EndingOf(path);
  WriteFileAtomically(path, [&](std::ostream& out) {
    if (ending == ".ply") WritePlyMesh(mesh, out);
    if (ending == ".obj") WriteObjMesh(mesh, out);
    if (ending == ".glb") WriteGlbMesh(mesh, out);
  });
}

}  // namespace surfit
