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

// An image within a .klg or .sens file: row by row 16-bit little endian counts, or red, green and
// blue; or else depth compressed by zlib, and colour as JPEG or PNG.
struct ImageBytes {
  std::uint64_t at = 0, count = 0;
  ImageSize size;
  bool is_raw = false;
};

// Of a frame; without colour where it has no bytes. Throws InputError naming the file and the frame
// unless the bytes hold an image of that size; it is compared with what they can hold before memory
// is taken for it.
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
