#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "io/images/image_files.h"
#include "io/sequences/recording.h"
#include "surfit/core/error.h"

namespace surfit {

// Binary file, read in parts. The file size is checked before memory is allocated. The file must
// not become shorter. Not thread-safe.
class BinaryFile {
 public:
  // Throws InputError naming the file if it cannot be opened.
  explicit BinaryFile(const std::string& path);

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  // True if the file has `count` bytes at the offset `at`.
  bool Has(std::uint64_t at, std::uint64_t count) const {
    return at <= size_ && count <= size_ - at;
  }
  // Reads `count` bytes at the offset `at`. Throws InputError naming the file if it is too short or
  // cannot be read.
  std::string Read(std::uint64_t at, std::uint64_t count) const;

 private:
  std::string path_;
  mutable std::ifstream file_;
  std::uint64_t size_ = 0;
};

// Position of an image in a .klg or .sens file, in bytes. Raw depth has 16-bit little endian
// counts, other depth is compressed by zlib. Raw colour is RGB, other colour is a JPEG or PNG file.
// `count` 0: no image.
struct ImageBytes {
  std::uint64_t at = 0, count = 0;
  ImageSize size;
  bool is_raw = false;
};

// Reads the images of a frame, without colour if `color` has no bytes. Throws InputError naming
// file and frame if the bytes are not an image of this size. The size is checked before memory is
// allocated. `frame`: frame index, for messages.
FrameImages ReadImages(const BinaryFile& file, int frame, const ImageBytes& depth,
                       const ImageBytes& color);

// Adds a warning if the file has fewer frames than its header declares. `claimed`: number in the
// header, `found`: number of complete frames, at most `claimed`.
template <typename Count>
void WarnIfShort(const std::string& path, Count claimed, int found, OpenedRecording* opened) {
  if (claimed == static_cast<Count>(found)) return;
  opened->warnings.push_back(
      Concat(path, " declares ", claimed, " frames, but is damaged or truncated after ", found));
}

}  // namespace surfit
