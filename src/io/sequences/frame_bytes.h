#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "io/images/image_files.h"
#include "io/sequences/recording.h"
#include "surfit/core/error.h"

namespace surfit {

// A file of binary little endian values that is too large to be read at once. Whether bytes are
// there is checked before memory is taken for them.
class BinaryFile {
 public:
  // Throws InputError naming the file if it cannot be opened.
  explicit BinaryFile(const std::string& path);

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  bool Has(std::uint64_t at, std::uint64_t count) const {
    return at <= size_ && count <= size_ - at;
  }
  // Throws InputError naming the file if it ends before, or cannot be read.
  std::string Read(std::uint64_t at, std::uint64_t count) const;

 private:
  std::string path_;
  mutable std::ifstream file_;
  std::uint64_t size_ = 0;
};

// The place of an image in a .klg or .sens file. Raw depth is 16-bit little endian counts, other
// depth is compressed by zlib. Raw colour is red, green and blue, other colour is a JPEG or PNG.
struct ImageBytes {
  std::uint64_t at = 0, count = 0;
  ImageSize size;
  bool is_raw = false;
};

// Reads the images of a frame, without colour if it has no bytes. Throws InputError naming the file
// and the frame if the bytes do not hold an image of that size. The size is compared with the bytes
// before memory is taken for the image.
FrameImages ReadImages(const BinaryFile& file, int frame, const ImageBytes& depth,
                       const ImageBytes& color);

// Warns of a file that has fewer frames than it claims.
template <typename Count>
void WarnIfShort(const std::string& path, Count claimed, int found, OpenedRecording* opened) {
  if (claimed == static_cast<Count>(found)) return;
  opened->warnings.push_back(
      Concat(path, " claims ", claimed, " frames, but is damaged or ends after ", found));
}

}  // namespace surfit
