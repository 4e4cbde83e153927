#include "apps/export/colmap_files.h"

#include <cstdint>
#include <cstring>
#include <ostream>
#include <utility>

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

constexpr double kPixelCenter = 0.5;  // coordinates of the top-left pixel centre in COLMAP
constexpr double kUnknownError = -1;
constexpr int kCameraId = 1;

struct CameraModel {
  int id;
  const char* name;
  std::vector<double> parameters;
};

CameraModel ModelOf(const PinholeCamera& lens) {
  std::vector<double> parameters = {lens.fx, lens.fy, lens.cx + kPixelCenter,
                                    lens.cy + kPixelCenter};
  if (!lens.HasDistortion()) return {1, "PINHOLE", parameters};
  const auto& [k1, k2, p1, p2, k3] = lens.distortion;
  parameters.insert(parameters.end(), {k1, k2, p1, p2});
  if (k3 == 0) return {4, "OPENCV", parameters};
  parameters.insert(parameters.end(), {k3, 0, 0, 0});
  return {6, "FULL_OPENCV", parameters};
}

// Binary and text writers with the same interface.
class BinaryWriter {
 public:
  explicit BinaryWriter(std::ostream& out) : out_(out) {}
  template <typename T>
  void Put(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    out_.write(bytes, sizeof(T));
  }
  void PutText(const std::string& text) { out_.write(text.c_str(), text.size() + 1); }

 private:
  std::ostream& out_;
};

// Image and position in its list of points.
using Track = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

std::vector<Track> TracksOf(const SparsePoints& points) {
  std::vector<Track> tracks(points.points.size());
  for (std::size_t i = 0; i < points.views.size(); ++i) {
    for (std::size_t k = 0; k < points.views[i].size(); ++k) {
      tracks[points.views[i][k].point].emplace_back(static_cast<std::uint32_t>(i + 1),
                                                    static_cast<std::uint32_t>(k));
    }
  }
  return tracks;
}

Rigid3d ImageFromWorld(const ColmapModel& model, const PosedImage& image) {
  return (model.export_from_world * image.world_from_color).Inverse();
}

void WriteCameras(const ColmapModel& model, const std::string& binary, const std::string& text) {
  const CameraModel camera = ModelOf(model.lens);
  WriteFileAtomically(binary, [&](std::ostream& out) {
    BinaryWriter file(out);
    file.Put<std::uint64_t>(1);
    file.Put<std::uint32_t>(kCameraId);
    file.Put<std::int32_t>(camera.id);
    file.Put<std::uint64_t>(model.lens.width);
    file.Put<std::uint64_t>(model.lens.height);
    for (const double parameter : camera.parameters) file.Put(parameter);
  });
  WriteFileAtomically(text, [&](std::ostream& out) {
    out.precision(17);
    out << "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        << kCameraId << ' ' << camera.name << ' ' << model.lens.width << ' ' << model.lens.height;
    for (const double parameter : camera.parameters) out << ' ' << parameter;
    out << '\n';
  });
}

void WriteImages(const ColmapModel& model, const std::string& binary, const std::string& text) {
  WriteFileAtomically(binary, [&](std::ostream& out) {
    BinaryWriter file(out);
    file.Put<std::uint64_t>(model.images.size());
    for (std::size_t i = 0; i < model.images.size(); ++i) {
      const Rigid3d pose = ImageFromWorld(model, model.images[i]);
      file.Put<std::uint32_t>(static_cast<std::uint32_t>(i + 1));
      file.Put(pose.rotation.w());
      for (const double number : pose.rotation.vec()) file.Put(number);
      for (const double number : pose.translation) file.Put(number);
      file.Put<std::uint32_t>(kCameraId);
      file.PutText(model.images[i].source.Name());
      file.Put<std::uint64_t>(model.points.views[i].size());
      for (const PointView& view : model.points.views[i]) {
        file.Put(view.pixel.x() + kPixelCenter);
        file.Put(view.pixel.y() + kPixelCenter);
        file.Put<std::uint64_t>(view.point + 1);
      }
    }
  });
  WriteFileAtomically(text, [&](std::ostream& out) {
    out << "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
        << "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
    for (std::size_t i = 0; i < model.images.size(); ++i) {
      const Rigid3d pose = ImageFromWorld(model, model.images[i]);
      out.precision(17);
      out << i + 1 << ' ' << pose.rotation.w();
      for (const double number : pose.rotation.vec()) out << ' ' << number;
      for (const double number : pose.translation) out << ' ' << number;
      out << ' ' << kCameraId << ' ' << model.images[i].source.Name() << '\n';
      out.precision(9);
      const char* separator = "";
      for (const PointView& view : model.points.views[i]) {
        out << separator << view.pixel.x() + kPixelCenter << ' ' << view.pixel.y() + kPixelCenter
            << ' ' << view.point + 1;
        separator = " ";
      }
      out << '\n';
    }
  });
}

void WritePoints(const ColmapModel& model, const std::string& binary, const std::string& text) {
  const std::vector<Track> tracks = TracksOf(model.points);
  const auto position_of = [&](const Surfel& point) -> Eigen::Vector3d {
    return model.export_from_world * point.position_in_world.cast<double>();
  };
  WriteFileAtomically(binary, [&](std::ostream& out) {
    BinaryWriter file(out);
    file.Put<std::uint64_t>(tracks.size());
    for (std::size_t k = 0; k < tracks.size(); ++k) {
      const Surfel& point = model.points.points[k];
      file.Put<std::uint64_t>(k + 1);
      for (const double number : position_of(point)) file.Put(number);
      for (const std::uint8_t channel : {point.color.r, point.color.g, point.color.b}) {
        file.Put(channel);
      }
      file.Put(kUnknownError);
      file.Put<std::uint64_t>(tracks[k].size());
      for (const auto& [image, place] : tracks[k]) {
        file.Put(image);
        file.Put(place);
      }
    }
  });
  WriteFileAtomically(text, [&](std::ostream& out) {
    out << "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
    out.precision(17);
    for (std::size_t k = 0; k < tracks.size(); ++k) {
      const Surfel& point = model.points.points[k];
      out << k + 1;
      for (const double number : position_of(point)) out << ' ' << number;
      out << ' ' << int{point.color.r} << ' ' << int{point.color.g} << ' ' << int{point.color.b}
          << ' ' << kUnknownError;
      for (const auto& [image, place] : tracks[k]) out << ' ' << image << ' ' << place;
      out << '\n';
    }
  });
}

}  // namespace

void WriteColmapModel(const ColmapModel& model, const std::string& binary_folder,
                      const std::string& text_folder) {
  const auto write = [&](const char* name, auto function) {
    function(model, binary_folder + "/" + name + ".bin", text_folder + "/" + name + ".txt");
  };
  write("cameras", WriteCameras);
  write("images", WriteImages);
  write("points3D", WritePoints);
}

}  // namespace surfit
