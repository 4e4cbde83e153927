#include <charconv>
#include <iterator>

#include "mesh/files/mesh_writers.h"

namespace surfit {
namespace {

constexpr std::size_t kTextAtOnce = 1 << 20;  // bytes

class TextLines {
 public:
  explicit TextLines(std::ostream& out) : out_(out) {}
  ~TextLines() { out_ << text_; }
  TextLines& operator=(TextLines&&) = delete;

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
    if (text_.size() < kTextAtOnce) return;
    out_ << text_;
    text_.clear();
  }

 private:
  std::ostream& out_;
  std::string text_;
};

constexpr int kDigits = 5;  // decimal places of coordinates in m
constexpr int kDigitsOfOne = 4;
constexpr int kDigitsOfPlace = 6;

void WriteVertices(const TriangleMesh& mesh, bool has_colors, TextLines* to) {
  TextLines& lines = *to;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    lines.Word("v");
    for (const float value : mesh.vertices[i]) lines.Number(value, kDigits);
    if (has_colors) {
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
}

void WriteTriangles(const TriangleMesh& mesh, const MeshTexture* texture, TextLines* to) {
  TextLines& lines = *to;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    lines.Word("f");
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[i][k];
      lines.Word(" ");
      lines.Index(v);
      if (texture != nullptr || !mesh.normals.empty()) lines.Word("/");
      if (texture != nullptr) lines.Index(texture->triangles[i][k]);
      if (mesh.normals.empty()) continue;
      lines.Word("/");
      lines.Index(v);
    }
    lines.End();
  }
}

}  // namespace

// Writes no vertex colours if there is a texture, because some viewers multiply both.
void WriteObjMesh(const TriangleMesh& mesh, const MeshTexture* texture, const std::string& material,
                  std::ostream& out) {
  TextLines lines(out);
  if (texture != nullptr) {
    lines.Word(("mtllib " + material).c_str());
    lines.End();
  }
  WriteVertices(mesh, texture == nullptr && !mesh.colors.empty(), &lines);
  if (texture != nullptr) {
    for (const Eigen::Vector2f& place : texture->texture_coordinates) {
      lines.Word("vt");
      lines.Number(place.x(), kDigitsOfPlace);
      lines.Number(1 - place.y(), kDigitsOfPlace);
      lines.End();
    }
    lines.Word("usemtl frames");
    lines.End();
  }
  WriteTriangles(mesh, texture, &lines);
}

void WriteMtl(const std::string& picture, std::ostream& out) {
  out << "newmtl frames\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd " << picture << "\n";
}

}  // namespace surfit
