#include "io/files/places_file.h"

#include <cstdint>

#include "core/files.h"
#include "io/files/packed.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr char kPlacesMagic[] = "surfit places 1\n";
constexpr std::size_t kMaxBytes = std::size_t{4} << 30;  // maximum file size

void PutEdge(const PoseGraphEdge& edge, Packer* writer) {
  writer->PutCount(edge.a);
  writer->PutCount(edge.b);
  writer->Put(edge.a_from_b);
  for (const double number : edge.information.reshaped()) writer->Put(number);
  writer->Put(edge.loop);
}

PoseGraphEdge TakeEdge(std::size_t keyframes, Unpacker* reader) {
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(reader->TakeBelow(keyframes, "keyframe"));
  edge.b = static_cast<std::size_t>(reader->TakeBelow(keyframes, "keyframe"));
  edge.a_from_b = reader->TakePose();
  for (double& number : edge.information.reshaped()) number = reader->Take<double>();
  edge.loop = reader->Take<std::uint8_t>() != 0;
  if (edge.a == edge.b || !IsInformation(edge.information)) reader->Fail("has an invalid edge");
  return edge;
}

}  // namespace

void WritePlaces(const RunPlaces& places, const std::string& path) {
  Packer writer;
  writer.PutCount(places.frames.size());
  for (const PosedFrame& frame : places.frames) {
    writer.Put(frame.index);
    writer.Put(frame.stamp_s);
    writer.Put(frame.world_from_camera);
    writer.Put(frame.keyframe);
    writer.Put(frame.segment);
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
  for (const Keyframe& keyframe : places.keyframes) PutField(keyframe.view.field, &writer);
  WriteFileAtomically(path, [&](std::ostream& file) { file << kPlacesMagic << writer.bytes(); });
}

RunPlaces ReadPlaces(const std::string& path, PlacesPart part) {
  constexpr std::size_t kPoseBytes = 7 * sizeof(double);
  Unpacker reader(ReadFile(path, kMaxBytes), path);
  reader.TakeMagic(kPlacesMagic, "places");
  RunPlaces places;
  places.frames.resize(reader.TakeCount(kPoseBytes));
  for (std::size_t i = 0; i < places.frames.size(); ++i) {
    PosedFrame& frame = places.frames[i];
    frame.index = reader.Take<int>();
    frame.stamp_s = reader.Take<double>();
    frame.world_from_camera = reader.TakePose();
    frame.keyframe = reader.Take<int>();
    frame.segment = reader.Take<int>();
    if (i > 0 && frame.index <= places.frames[i - 1].index)
      reader.Fail("has frames in wrong order");
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
      reader.Fail(Concat("has the index of keyframe ", frame.keyframe, ", must be below ",
                         places.keyframes.size()));
    }
  }
  places.edges.resize(reader.TakeCount(kPoseBytes));
  for (PoseGraphEdge& edge : places.edges) edge = TakeEdge(places.keyframes.size(), &reader);
  if (!reader.IsAtEnd()) {
    for (Keyframe& keyframe : places.keyframes) keyframe.view.field = TakeField(&reader);
  }
  reader.End();
  return places;
}

}  // namespace surfit
