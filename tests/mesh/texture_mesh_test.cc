#include "surfit/mesh/texture_mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kGrey = {128, 128, 128};
using Texture = std::function<Rgb8(float x, float y)>;

// Waves of 12 and 15 mm, which are finer than the triangles.
Rgb8 Waves(float x, float y) {
  const double a = std::sin(2 * M_PI * x / 0.012), b = std::sin(2 * M_PI * y / 0.015);
  const auto byte = [](double value) { return static_cast<std::uint8_t>(128 + 90 * value + 0.5); };
  return {byte(a * b), byte(a), byte(b)};
}

// Adds a square of triangles that faces z = 0.
void AddSquare(Eigen::Vector3f center, float side, Rgb8 color, TriangleMesh* mesh) {
  constexpr int kCells = 20;
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (int v = 0; v <= kCells; ++v) {
    for (int u = 0; u <= kCells; ++u) {
      const Eigen::Vector3f offset(u / 20.f - 0.5f, v / 20.f - 0.5f, 0);
      mesh->vertices.push_back(center + side * offset);
      mesh->normals.push_back(-Eigen::Vector3f::UnitZ());
      mesh->colors.push_back(color);
    }
  }
  for (std::uint32_t v = 0; v < kCells; ++v) {
    for (std::uint32_t u = 0; u < kCells; ++u) {
      const std::uint32_t a = first + v * (kCells + 1) + u, c = a + kCells + 1;
      mesh->triangles.push_back({a, c + 1, a + 1});
      mesh->triangles.push_back({a, c, c + 1});
    }
  }
}

TriangleMesh Wall() {
  TriangleMesh mesh;
  AddSquare({0, 0, 1}, 0.4f, kGrey, &mesh);
  return mesh;
}

// Frame of a camera at `place` that looks along z at a wall at z = 1.
TextureFrame FrameAt(const Eigen::Vector3d& place, const Texture& texture) {
  TextureFrame frame;
  frame.camera = {320, 240, 300, 300, 159.5, 119.5, {}};
  frame.world_from_camera.translation = place;
  frame.frame.color = Image<Rgb8>(320, 240);
  frame.frame.depth_m = Image<float>(320, 240);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const Eigen::Vector3d point = place + (1 - place.z()) * frame.camera.Ray(u, v);
      frame.frame.color(u, v) =
          texture(static_cast<float>(point.x()), static_cast<float>(point.y()));
    }
  }
  return frame;
}

TextureFrames Of(const std::vector<TextureFrame>& frames) {
  return [frames](const auto& visit) {
    for (const TextureFrame& frame : frames) visit(frame);
  };
}

// Four near views of a wall of 0.4 m, and one far view.
std::vector<TextureFrame> FourNearAndOneFar() {
  std::vector<TextureFrame> frames = {FrameAt({0, 0, 0}, Waves)};
  for (const double x : {-0.1, 0.1})
    for (const double y : {-0.1, 0.1}) frames.push_back(FrameAt({x, y, 0.6}, Waves));
  return frames;
}

Rgb8 PixelAt(const Image<Rgb8>& image, const Eigen::Vector2f& place) {
  const float u = place.x() * static_cast<float>(image.width()) - 0.5f;
  const float v = place.y() * static_cast<float>(image.height()) - 0.5f;
  const int left = std::clamp(static_cast<int>(u), 0, image.width() - 2);
  const int top = std::clamp(static_cast<int>(v), 0, image.height() - 2);
  const float s = u - static_cast<float>(left), t = v - static_cast<float>(top);
  const auto mix = [&](std::uint8_t Rgb8::*part) {
    const float upper = (1 - s) * image(left, top).*part + s * image(left + 1, top).*part;
    const float lower = (1 - s) * image(left, top + 1).*part + s * image(left + 1, top + 1).*part;
    return static_cast<std::uint8_t>((1 - t) * upper + t * lower + 0.5f);
  };
  return {mix(&Rgb8::r), mix(&Rgb8::g), mix(&Rgb8::b)};
}

Eigen::Vector3f MiddleOf(const TriangleMesh& mesh, std::size_t i) {
  const TriangleMesh::Triangle& t = mesh.triangles[i];
  return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
}
Rgb8 ShownAt(const MeshTexture& texture, std::size_t i) {
  const TriangleMesh::Triangle& t = texture.triangles[i];
  return PixelAt(texture.image,
                 (texture.texture_coordinates[t[0]] + texture.texture_coordinates[t[1]] +
                  texture.texture_coordinates[t[2]]) /
                     3);
}

MeshTexture TextureOf(const TriangleMesh& mesh, const std::vector<TextureFrame>& frames,
                      TextureSummary* summary, const TextureOptions& options = {}) {
  return TextureMesh(mesh, Of(frames), options, summary);
}

double PsnrOfWaves(const TriangleMesh& mesh, const MeshTexture& texture) {
  double squares = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3f middle = MiddleOf(mesh, i);
    const Rgb8 seen = ShownAt(texture, i), true_color = Waves(middle.x(), middle.y());
    squares += std::pow(seen.r - true_color.r, 2) + std::pow(seen.g - true_color.g, 2) +
               std::pow(seen.b - true_color.b, 2);
  }
  return 10 * std::log10(255 * 255 * 3 * static_cast<double>(mesh.triangles.size()) / squares);
}

// The PSNR of grey is 13 dB. Pixels have the width h = 1.3 mm. The error of linear interpolation is
// at most h^2 / 8 (2 pi / 12 mm)^2 = 6 % of 90 grey values, and half of it in the RMS. It occurs in
// two directions, and twice because texels are between pixels: 5 grey values, 34 dB. The far frame
// alone (h = 3.3 mm) has 20 dB.
TEST(TextureMesh, ShowsDetailsFinerThanTriangles) {
  const TriangleMesh mesh = Wall();
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, FourNearAndOneFar(), &summary);
  const double psnr = PsnrOfWaves(mesh, texture);
  std::printf("PSNR %.2f dB, %zu charts\n", psnr, summary.charts);
  EXPECT_GT(psnr, 30);
  EXPECT_EQ(summary.frames, 5);
  EXPECT_EQ(summary.triangles_unseen, 0u);
  EXPECT_EQ(summary.pixel_ratio, 1);
}

TEST(TextureMesh, UsesSharpestFrames) {
  const auto plain = [](Rgb8 color) { return [=](float, float) { return color; }; };
  // The mean colour equals the colour of the mesh, so no offset is added.
  const TriangleMesh mesh = Wall();
  const TextureFrame far = FrameAt({0, 0, 0}, plain({128, 128, 128}));
  TextureFrame near = FrameAt({0, 0, 0.3}, Waves);
  TextureSummary summary;
  TextureOf(mesh, {far, near}, &summary);
  EXPECT_EQ(summary.frames_used, 1);
  EXPECT_EQ(summary.charts, 1u);
  EXPECT_GT(PsnrOfWaves(mesh, TextureOf(mesh, {far, near}, &summary)), 20);
  // 300 / 0.7 px per metre: 2 m/s is 860 px/s, 4 px in 5 ms.
  near.motion.velocity_m_per_s.x() = 2;
  EXPECT_LT(PsnrOfWaves(mesh, TextureOf(mesh, {far, near}, &summary)), 14);
}

// The colour image is captured after the camera has moved by 2 cm.
TEST(TextureMesh, UsesPoseAtCaptureTimeOfColor) {
  const TriangleMesh mesh = Wall();
  const Eigen::Vector3d velocity(0.2, 0, 0);
  TextureFrame frame = FrameAt({0.02, 0, 0.5}, Waves);
  frame.world_from_camera.translation.x() = 0;
  TextureSummary summary;
  EXPECT_LT(PsnrOfWaves(mesh, TextureOf(mesh, {frame}, &summary)), 14);
  frame.motion.velocity_m_per_s = velocity;
  frame.frame.color_stamp_s = 0.1;
  EXPECT_GT(PsnrOfWaves(mesh, TextureOf(mesh, {frame}, &summary)), 20);
}

TEST(TextureMesh, TextureCoordinatesAreInsideImage) {
  const TriangleMesh mesh = Wall();
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, FourNearAndOneFar(), &summary);
  ASSERT_EQ(texture.triangles.size(), mesh.triangles.size());
  ASSERT_EQ(texture.vertices.size(), texture.texture_coordinates.size());
  EXPECT_GT(texture.texture_coordinates.size(),
            mesh.vertices.size());  // vertices at seams have several texture coordinates
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t place = texture.triangles[i][k];
      ASSERT_EQ(texture.vertices[place], mesh.triangles[i][k]);
      for (const float share : texture.texture_coordinates[place]) {
        ASSERT_GT(share, 0);
        ASSERT_LT(share, 1);
      }
    }
  }
}

// A small red square in front occludes a part of the wall in the first frame. The second frame
// views the wall from the side.
TEST(TextureMesh, RespectsOcclusion) {
  TriangleMesh mesh = Wall();
  const std::size_t wall = mesh.triangles.size();
  AddSquare({0, 0, 0.7f}, 0.1f, {255, 0, 0}, &mesh);
  std::vector<TextureFrame> frames;
  for (const double x : {0., 0.3}) {
    frames.push_back(FrameAt({x, 0, 0.2}, [](float, float) { return kGrey; }));
    TextureFrame& frame = frames.back();
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u) {
        const Eigen::Vector3d at = frame.world_from_camera * (0.5 * frame.camera.Ray(u, v));
        if (std::abs(at.x()) < 0.05 && std::abs(at.y()) < 0.05)
          frame.frame.color(u, v) = {255, 0, 0};
      }
    }
  }
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, frames, &summary);
  EXPECT_LT(summary.triangles_unseen, 30u);  // triangles at the borders of both occluded regions
  for (std::size_t i = 0; i < wall; ++i) {
    ASSERT_LT(ShownAt(texture, i).r, 140) << MiddleOf(mesh, i).transpose();
    ASSERT_GT(ShownAt(texture, i).g, 110);
  }
  for (std::size_t i = wall; i < mesh.triangles.size(); ++i) ASSERT_GT(ShownAt(texture, i).r, 200);
}

// Colours of occluders in front of the mesh, for example people, are not used.
TEST(TextureMesh, IgnoresColorsOfOccluders) {
  const TriangleMesh mesh = Wall();
  TextureFrame frame = FrameAt({0, 0, 0.5}, Waves);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 160; ++u) frame.frame.depth_m(u, v) = 0.3f;
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, {frame}, &summary);
  EXPECT_GT(summary.triangles_unseen, mesh.triangles.size() * 2 / 5);
  EXPECT_LT(summary.triangles_unseen, mesh.triangles.size() * 3 / 5);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (MiddleOf(mesh, i).x() >= -0.02f) continue;
    ASSERT_TRUE(ShownAt(texture, i) == kGrey);
  }
}

TEST(TextureMesh, UsesMeshColorsOfUnseenTriangles) {
  TriangleMesh mesh = Wall();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.colors[i] = {static_cast<std::uint8_t>(200 * (0.5f + mesh.vertices[i].x())), 50, 100};
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, {}, &summary);
  EXPECT_EQ(summary.triangles_unseen, mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Rgb8 shown = ShownAt(texture, i);
    // Half a texel is a quarter of a cell: 1 grey value, plus two roundings.
    ASSERT_NEAR(shown.r, 200 * (0.5f + MiddleOf(mesh, i).x()), 4);
    ASSERT_EQ(shown.g, 50);
  }
}

// One frame has half the brightness. Its half of the wall gets the brightness of the other frame.
TEST(TextureMesh, EqualisesBrightnessOfFrames) {
  const TriangleMesh mesh = Wall();
  std::vector<TextureFrame> frames;
  for (const double x : {-0.13, 0.13}) {
    const auto color = static_cast<std::uint8_t>(x < 0 ? 64 : 128);
    frames.push_back(FrameAt({x, 0, 0.6}, [=](float, float) { return Rgb8{color, color, color}; }));
  }
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, frames, &summary);
  EXPECT_EQ(summary.frames_used, 2);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    ASSERT_NEAR(ShownAt(texture, i).r, 128, 2);
}

TEST(TextureMesh, ScalesDownToMaxTextureSize) {
  const TriangleMesh mesh = Wall();
  TextureOptions options;
  options.max_texture_px = 100;
  TextureSummary summary;
  const MeshTexture texture = TextureOf(mesh, FourNearAndOneFar(), &summary, options);
  EXPECT_LE(texture.image.width(), 100);
  EXPECT_LE(texture.image.height(), 100);
  EXPECT_LT(summary.pixel_ratio, 0.5);
  options.max_texture_px = 4;
  EXPECT_THAT([&] { TextureOf(mesh, FourNearAndOneFar(), &summary, options); },
              ThrowsNaming<InputError>("max_texture_px", 4));
  options.max_texture_px = 0;
  EXPECT_THAT([&] { TextureOf(mesh, FourNearAndOneFar(), &summary, options); },
              ThrowsNaming<InputError>("max_texture_px", 0));
  options.min_sharpness = 2;
  EXPECT_THAT([&] { TextureOf(mesh, {}, &summary, options); },
              ThrowsNaming<InputError>("min_sharpness", 2));
}

TEST(TextureMesh, IsTheSameAtAnyNumberOfThreads) {
  const TriangleMesh mesh = Wall();
  const std::vector<TextureFrame> frames = FourNearAndOneFar();
  TextureSummary summary;
  const auto textures = AtThreads({1, 2, 4}, [&] { return TextureOf(mesh, frames, &summary); });
  for (const MeshTexture& texture : textures) {
    EXPECT_EQ(texture.triangles, textures[0].triangles);
    EXPECT_EQ(texture.texture_coordinates, textures[0].texture_coordinates);
    EXPECT_TRUE(texture.image == textures[0].image);
  }
}

}  // namespace
}  // namespace surfit::testing
