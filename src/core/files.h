#pragma once

#include <cstddef>
#include <limits>
#include <streambuf>
#include <string>
#include <vector>

namespace surfit {

// Part of the name of a temporary file: `<final name>.partial-<process>-<number>`.
inline constexpr const char* kPartialMark = ".partial-";

// Throws InputError "cannot write '<path>': <reason of errno>".
[[noreturn]] void ThrowCannotWrite(const std::string& path);

// Returns the descriptor for writing. Returns -1 and sets errno on errors. A file or symbolic link
// of this name is an error.
int CreateFileExclusively(const std::string& path);

// Opens a device or a pipe for writing, and returns its descriptor. Waits until a pipe has a
// reader. Returns -1 and sets errno on errors.
int OpenSpecialFile(const std::string& path);

// Writes all bytes. Returns false and sets errno on errors.
bool WriteAll(int file, const char* bytes, std::size_t count);

// Stream buffer that owns an open file descriptor. The destructor closes the file without flushing:
// call Close(), once, after the last write. After a write error, nothing more is written to the
// file.
class FileBuffer final : public std::streambuf {
 public:
  explicit FileBuffer(int file);
  ~FileBuffer() override;
  FileBuffer& operator=(FileBuffer&&) = delete;

  // Flushes the buffer, syncs the file if `to_disk`, and closes it. Returns false and sets errno if
  // a write, the sync or the closing has failed.
  bool Close(bool to_disk);

 protected:
  int_type overflow(int_type c) override;
  int sync() override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from,
                   std::ios_base::openmode which) override;
  pos_type seekpos(pos_type position, std::ios_base::openmode which) override;

 private:
  bool Flush();

  int file_;
  int error_ = 0;
  std::vector<char> bytes_;
};

inline constexpr std::size_t kAnySize = std::numeric_limits<std::size_t>::max() - 1;  // no limit

// Throws InputError with the path for unreadable files, files above `most` bytes, and files that
// are not regular.
std::string ReadFile(const std::string& path, std::size_t most = kAnySize);

// Reads a regular file, a pipe or a device. Waits until a pipe has a writer. Throws InputError with
// the path for unreadable files. Pipes and devices are limited to 1 GiB.
std::string ReadFileOrPipe(const std::string& path);

// Reads a JSON file as text, without parsing. Throws InputError like ReadFile(), above 256 MiB, and
// above 100 nested brackets, which limits the recursion of the JSON parser.
std::string ReadJsonText(const std::string& path);

}  // namespace surfit
