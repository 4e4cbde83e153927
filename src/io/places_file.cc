#include "surfit/io/places_file.h"

#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#include "core/read_file.h"
#include "io/deflate.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr char kMagic[] = "surfit places 1\n";
constexpr std::size_t kMagicBytes = sizeof(kMagic) - 1;
// Of the file and of an image in it: what a damaged number may ask for.
constexpr std::size_t kMostBytes = std::size_t{4} << 30;
constexpr std::uint64_t kMostImageBytes = std::uint64_t{64} << 20;
constexpr int kLevel = 1;

class Writer {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void Put(const Rigid3d& pose) {
    for (const double number : pose.rotation.coeffs()) Put(number);
    for (const double number : pose.translation) Put(number);
  }
  void PutCount(std::size_t count) { Put(static_cast<std::uint32_t>(count)); }
  template <typename T>
  void PutImage(const Image<T>& image) {
    Put(image.width());
    Put(image.height());
    PutCompressed(image.data(), image.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void PutCompressed(const void* data, std::size_t size) {
    const std::string compressed = Deflate(data, size, kLevel);
    PutCount(compressed.size());
    bytes_ += compressed;
  }

  std::string bytes_;
};

class Reader {
 public:
  Reader(std::string bytes, const std::string& path) : bytes_(std::move(bytes)), path_(path) {
    if (bytes_.compare(0, kMagicBytes, kMagic) != 0) Fail("does not begin as a file of places");
    at_ = kMagicBytes;
  }

  template <typename T>
  T Take() {
    T value{};
    std::memcpy(&value, Skip(sizeof(T)), sizeof(T));
    return value;
  }
  Rigid3d TakePose() {
    Rigid3d pose;
    for (double& number : pose.rotation.coeffs()) number = Take<double>();
    for (double& number : pose.translation) number = Take<double>();
    if (!pose.translation.allFinite() || !(std::abs(pose.rotation.norm() - 1) < 1e-6)) {
      Fail("has a pose that is none");
    }
    return pose;
  }
  // Of things that take so many bytes each at least.
  std::size_t TakeCount(std::size_t bytes_each) {
    const std::size_t count = Take<std::uint32_t>();
    if (count > (bytes_.size() - at_) / bytes_each) Fail("ends too early");
    return count;
  }
  int TakeBelow(std::size_t count, const char* what) {
    const int number = Take<int>();
    if (number < 0 || static_cast<std::size_t>(number) >= count) {
      Fail(Concat("names ", what, " ", number, " of ", count));
    }
    return number;
  }
  template <typename T>
  Image<T> TakeImage(PlacesPart part) {
    const int width = Take<int>(), height = Take<int>();
    const std::size_t count = TakeCount(1);
    const char* compressed = Skip(count);
    if (part == PlacesPart::kFeatures) return {};
    const auto bytes = static_cast<std::uint64_t>(width) * height * sizeof(T);
    // zlib makes at most about 1000 bytes of one.
    if (width < 0 || height < 0 || width > 16384 || height > 16384 || bytes > kMostImageBytes ||
        bytes > 1100 * (count + 1)) {
      Fail(Concat("has an image of ", width, " x ", height));
    }
    Image<T> image(width, height);
    if (bytes > 0 && !Inflate(compressed, count, image.data(), bytes)) Fail("has a damaged image");
    return image;
  }
  void End() const {
    if (at_ != bytes_.size()) Fail("goes on after its end");
  }
  [[noreturn]] void Fail(const std::string& why) const { throw InputError(path_ + ": " + why); }

 private:
  const char* Skip(std::size_t count) {
    if (count > bytes_.size() - at_) Fail("ends too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }

  std::string bytes_;
  const std::string& path_;
  std::size_t at_ = 0;
};

void PutView(const PlaceView& view, Writer* writer) {
  const PinholeCamera& camera = view.camera;
  writer->Put(camera.width);
  writer->Put(camera.height);
  for (const double number : {camera.fx, camera.fy, camera.cx, camera.cy}) writer->Put(number);
  writer->Put(view.noise.inverse_depth_sigma);
  writer->PutImage(view.depth);
  writer->PutImage(view.intensity);
  writer->PutCount(view.features.size());
  for (const PlaceFeature& feature : view.features) {
    for (const float number : feature.point) writer->Put(number);
    for (const std::uint64_t bits : feature.descriptor) writer->Put(bits);
  }
}

PlaceView TakeView(PlacesPart part, Reader* reader) {
  PlaceView view;
  PinholeCamera& camera = view.camera;
  camera.width = reader->Take<int>();
  camera.height = reader->Take<int>();
  for (double* number : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
    *number = reader->Take<double>();
  }
  view.noise.inverse_depth_sigma = reader->Take<double>();
  view.depth = reader->TakeImage<std::uint16_t>(part);
  view.intensity = reader->TakeImage<std::uint8_t>(part);
  view.features.resize(reader->TakeCount(3 * sizeof(float) + sizeof(BinaryDescriptor)));
  for (PlaceFeature& feature : view.features) {
    for (float& number : feature.point) number = reader->Take<float>();
    for (std::uint64_t& bits : feature.descriptor) bits = reader->Take<std::uint64_t>();
  }
  if (view.depth.empty()) return view;
  const bool fits = view.depth.width() == camera.width && view.depth.height() == camera.height &&
                    (view.intensity.empty() || view.intensity.size() == view.depth.size());
  if (!fits || !(camera.fx > 0) || !(camera.fy > 0) || !(view.noise.inverse_depth_sigma > 0)) {
    reader->Fail("has a view whose camera is none");
  }
  return view;
}

void PutEdge(const PoseGraphEdge& edge, Writer* writer) {
  writer->PutCount(edge.a);
  writer->PutCount(edge.b);
  writer->Put(edge.a_from_b);
  for (const double number : edge.information.reshaped()) writer->Put(number);
  writer->Put(edge.loop);
}

PoseGraphEdge TakeEdge(std::size_t keyframes, Reader* reader) {
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(reader->TakeBelow(keyframes, "keyframe"));
  edge.b = static_cast<std::size_t>(reader->TakeBelow(keyframes, "keyframe"));
  edge.a_from_b = reader->TakePose();
  for (double& number : edge.information.reshaped()) number = reader->Take<double>();
  edge.loop = reader->Take<std::uint8_t>() != 0;
  if (edge.a == edge.b || !IsInformation(edge.information))
    reader->Fail("has an edge that is none");
  return edge;
}

}  // namespace

void WritePlaces(const RunPlaces& places, const std::string& path) {
  Writer writer;
  writer.PutCount(places.frames.size());
  for (const PosedFrame& frame : places.frames) {
    writer.Put(frame.index);
    writer.Put(frame.stamp_s);
    writer.Put(frame.world_from_camera);
    writer.Put(frame.keyframe);
    writer.Put(frame.stretch);
  }
  writer.PutCount(places.keyframes.size());
  for (const Keyframe& keyframe : places.keyframes) {
    writer.Put(keyframe.frame_index);
    writer.Put(keyframe.stamp_s);
    writer.Put(keyframe.world_from_camera);
    PutView(keyframe.view, &writer);
  }
  writer.PutCount(places.edges.size());
  for (const PoseGraphEdge& edge : places.edges) PutEdge(edge, &writer);
  WriteFileAtomically(path, [&](std::ostream& file) { file << kMagic << writer.bytes(); });
}

RunPlaces ReadPlaces(const std::string& path, PlacesPart part) {
  constexpr std::size_t kPoseBytes = 7 * sizeof(double);
  Reader reader(ReadFile(path, kMostBytes), path);
  RunPlaces places;
  places.frames.resize(reader.TakeCount(kPoseBytes));
  for (std::size_t i = 0; i < places.frames.size(); ++i) {
    PosedFrame& frame = places.frames[i];
    frame.index = reader.Take<int>();
    frame.stamp_s = reader.Take<double>();
    frame.world_from_camera = reader.TakePose();
    frame.keyframe = reader.Take<int>();
    frame.stretch = reader.Take<int>();
    if (i > 0 && frame.index <= places.frames[i - 1].index) reader.Fail("has frames in disorder");
  }
  places.keyframes.resize(reader.TakeCount(kPoseBytes));
  for (Keyframe& keyframe : places.keyframes) {
    keyframe.frame_index = reader.Take<int>();
    keyframe.stamp_s = reader.Take<double>();
    keyframe.world_from_camera = reader.TakePose();
    keyframe.view = TakeView(part, &reader);
  }
  for (const PosedFrame& frame : places.frames) {
    if (frame.keyframe < 0 || frame.keyframe >= static_cast<int>(places.keyframes.size())) {
      reader.Fail(Concat("names keyframe ", frame.keyframe, " of ", places.keyframes.size()));
    }
  }
  places.edges.resize(reader.TakeCount(kPoseBytes));
  for (PoseGraphEdge& edge : places.edges) edge = TakeEdge(places.keyframes.size(), &reader);
  reader.End();
  return places;
}

}  // namespace surfit
