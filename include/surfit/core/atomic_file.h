#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

namespace surfit {

// Writes a file that is there either as a whole or not at all, whatever ends the program or the
// machine: `write` fills a new file beside `path`, which is flushed to the disk and then takes the
// place of `path` in one step. If `write` throws, or the disk is full, an older file stays as it
// was and the new one is removed. A symbolic link to a file is refused: what it leads to is
// somebody else's. What is no regular file (a device, a pipe) is written to directly.
// Throws InputError naming the file if it cannot be written, and whatever `write` throws.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);

// A file that grows while a program runs, and holds whole pieces only, whatever happens: each piece
// is with the system when Append() returns, and one for which there is no place is taken back.
class AppendedFile {
 public:
  // Begins a new file in the place of an older one, or of a link, which is not followed. What is
  // neither file nor link (a device, a pipe) is written to. Throws InputError naming the file.
  explicit AppendedFile(const std::string& path);
  ~AppendedFile();
  AppendedFile& operator=(AppendedFile&&) = delete;

  // Throws InputError naming the file and the reason if not all of it could be written.
  void Append(const std::string& piece);

 private:
  std::string path_;
  int file_ = -1;
  std::int64_t size_ = 0;  // bytes
};

}  // namespace surfit
