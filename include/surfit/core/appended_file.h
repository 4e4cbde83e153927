#pragma once

#include <cstdint>
#include <string>

namespace surfit {

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
