#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

namespace surfit {

// Replaces a file in one step. `write` fills a temporary file in the same folder, which is flushed
// to the disk and renamed to `path`. After a crash, `path` has either the old or the complete new
// content. If `write` throws or the disk is full, the old file is unchanged. A killed process may
// leave the temporary file.
//
// Writes directly to devices and pipes, also behind a symbolic link. Throws InputError with the
// path for other symbolic links, and if writing fails. Exceptions of `write` are passed on.
// Concurrent calls are safe: the last one determines the content.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);

// File for records that are appended while a program runs. Each record is passed to the operating
// system at once, but not flushed to the disk. An incomplete record is removed, except on devices
// and pipes. Not thread-safe.
class AppendedFile {
 public:
  // Creates the file. An old file or symbolic link at `path` is deleted first. Writes directly to
  // devices and pipes. Throws InputError with the path if the file cannot be opened.
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
