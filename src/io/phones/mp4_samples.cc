#include "io/phones/mp4_samples.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/sequences/frame_bytes.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Big endian numbers of a box.
class BoxBytes {
 public:
  BoxBytes(std::string bytes, const std::string& path) : bytes_(std::move(bytes)), path_(path) {}

  std::uint64_t Take(int size) {
    ThrowIf(at_ + size > bytes_.size(), path_, " is damaged: a box is too short");
    std::uint64_t number = 0;
    for (int i = 0; i < size; ++i)
      number = number << 8 | static_cast<unsigned char>(bytes_[at_ + i]);
    at_ += size;
    return number;
  }
  std::int64_t TakeSigned(int size) {
    const auto number = static_cast<std::int64_t>(Take(size));
    return size == 4 ? static_cast<std::int32_t>(number) : number;
  }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::string bytes_, path_;
  std::size_t at_ = 0;
};

struct Box {
  std::string type;
  std::uint64_t begin = 0, end = 0;  // content
};

// Boxes up to the first box of the type `last`, which is included. Bytes after it are not read.
std::vector<Box> BoxesIn(const BinaryFile& file, std::uint64_t begin, std::uint64_t end,
                         const std::string& last = "") {
  std::vector<Box> boxes;
  for (std::uint64_t at = begin; at + 8 <= end;) {
    BoxBytes head(file.Read(at, 8), file.path());
    std::uint64_t size = head.Take(4), head_size = 8;
    const std::string type = file.Read(at + 4, 4);
    if (size == 1) {
      ThrowIf(!file.Has(at, 16), file.path(), " is truncated");
      size = BoxBytes(file.Read(at + 8, 8), file.path()).Take(8);
      head_size = 16;
    }
    if (size == 0) size = end - at;  // up to the end of the file
    ThrowIf(size < head_size || size > end - at, file.path(), " is truncated or damaged: its box ",
            type, " has ", size, " bytes of ", end - at);
    boxes.push_back({type, at + head_size, at + size});
    if (type == last) break;
    at += size;
  }
  return boxes;
}

// First box at the path of types, inside of `parent`.
std::optional<Box> FindBox(const BinaryFile& file, Box parent,
                           const std::vector<std::string>& types) {
  for (const std::string& type : types) {
    const std::vector<Box> boxes = BoxesIn(file, parent.begin, parent.end, type);
    const auto box = std::find_if(boxes.begin(), boxes.end(),
                                  [&](const Box& candidate) { return candidate.type == type; });
    if (box == boxes.end()) return std::nullopt;
    parent = *box;
  }
  return parent;
}

BoxBytes ContentOf(const BinaryFile& file, const Box& box) {
  constexpr std::uint64_t kMost = 1 << 28;
  ThrowIf(box.end - box.begin > kMost, file.path(), " is damaged: its box ", box.type, " has ",
          box.end - box.begin, " bytes");
  return {file.Read(box.begin, box.end - box.begin), file.path()};
}

// Values of a box with run lengths: stts has durations, ctts has offsets of the composition.
std::vector<std::int64_t> ExpandedRuns(const BinaryFile& file, const Box& box) {
  constexpr std::size_t kMost = 1 << 26;  // 12 days at 60 Hz
  BoxBytes bytes = ContentOf(file, box);
  bytes.Take(4);  // version and flags
  const std::uint64_t count = bytes.Take(4);
  std::vector<std::int64_t> values;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t run = bytes.Take(4);
    ThrowIf(run > kMost - values.size(), file.path(), " is damaged: it has more than ", kMost,
            " frames");
    values.insert(values.end(), run, bytes.TakeSigned(4));
  }
  return values;
}

// Start of the first edit with media, in units of the track. 0 without an edit list.
std::int64_t EditStart(const BinaryFile& file, const Box& track) {
  const auto box = FindBox(file, track, {"edts", "elst"});
  if (!box) return 0;
  BoxBytes bytes = ContentOf(file, *box);
  const int size = bytes.Take(4) >> 24 == 1 ? 8 : 4;
  const std::uint64_t count = bytes.Take(4);
  for (std::uint64_t i = 0; i < count; ++i) {
    bytes.Take(size);  // duration
    const std::int64_t start = bytes.TakeSigned(size);
    bytes.Take(4);                 // rate
    if (start >= 0) return start;  // -1: a pause
  }
  return 0;
}

bool IsVideo(const BinaryFile& file, const Box& track) {
  const auto handler = FindBox(file, track, {"mdia", "hdlr"});
  return handler && handler->end - handler->begin >= 12 &&
         file.Read(handler->begin + 8, 4) == "vide";
}

}  // namespace

Mp4Samples ReadMp4Samples(const std::string& path) {
  const BinaryFile file(path);
  const Box whole = {"", 0, file.size()};
  const auto movie = FindBox(file, whole, {"moov"});
  ThrowIf(!movie, path, " is not a complete MP4 file: it has no box moov");
  for (const Box& track : BoxesIn(file, movie->begin, movie->end)) {
    if (track.type != "trak" || !IsVideo(file, track)) continue;
    const auto durations = FindBox(file, track, {"mdia", "minf", "stbl", "stts"});
    ThrowIf(!durations, path, " is damaged: its video track has no box stts");
    const auto offsets = FindBox(file, track, {"mdia", "minf", "stbl", "ctts"});
    const std::vector<std::int64_t> duration = ExpandedRuns(file, *durations);
    const std::vector<std::int64_t> offset =
        offsets ? ExpandedRuns(file, *offsets) : std::vector<std::int64_t>();
    const std::int64_t start = EditStart(file, track);
    Mp4Samples samples;
    samples.total = static_cast<int>(duration.size());
    std::int64_t decoded = 0;
    for (std::size_t i = 0; i < duration.size(); ++i) {
      samples.hidden += decoded + (i < offset.size() ? offset[i] : 0) < start;
      decoded += duration[i];
    }
    return samples;
  }
  throw InputError(path, " has no video track");
}

}  // namespace surfit
