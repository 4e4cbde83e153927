#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

namespace surfit {

// Replaces a file in one step. After a crash of the program or the machine, `path` has either the
// old or the complete new content. `write` fills a temporary file in the folder of `path`. The file
// is flushed to the disk and then renamed to `path`. If `write` throws or the disk is full, the old
// file is unchanged and the temporary file is removed. A killed process may leave the temporary
// file. Devices and pipes, also behind a symbolic link, are written to directly. Other symbolic
// links are rejected. Throws InputError with the path if the file cannot be written. Exceptions of
// `write` are passed on.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);

// File for records that are appended while a program runs. It contains complete records only.
// Append() hands each record to the operating system without a buffer. A partly written record is
// removed, except on devices and pipes. Not thread-safe.
class AppendedFile {
 public:
  // Creates the file. An old file or symbolic link at `path` is deleted first. Devices and pipes
  // are written to directly. Throws InputError with the path if the file cannot be opened.
  explicit AppendedFile(const std::string& path);
  ~AppendedFile();
  AppendedFile& operator=(AppendedFile&&) = delete;

  // Throws InputError with the path and the reason if the record cannot be written completely.
  void Append(const std::string& piece);

 private:
  std::string path_;
  int file_ = -1;
  std::int64_t size_ = 0;  // bytes of complete records
};

}  // namespace surfit
