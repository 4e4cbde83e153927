#pragma once

#include <cstddef>
#include <limits>
#include <streambuf>
#include <string>
#include <vector>

namespace surfit {

// Part of the name of a partially written file: `<final name>.partial-<process>-<number>`.
inline constexpr const char* kPartialMark = ".partial-";

// Throws InputError "cannot write '<path>': <reason of errno>".
[[noreturn]] void ThrowCannotWrite(const std::string& path);

// Creates a file for writing and returns its descriptor. Returns -1 and sets errno on errors, for
// example if the name exists, also as a symbolic link.
int CreateFileExclusively(const std::string& path);

// Opens a device or a pipe for writing and returns its descriptor. Returns -1 and sets errno on
// errors.
int OpenSpecialFile(const std::string& path);

// Returns false and sets errno if not all bytes were written.
bool WriteAll(int file, const char* bytes, std::size_t count);

// Stream buffer that owns an open file. After the first error all later writes fail.
class FileBuffer final : public std::streambuf {
 public:
  explicit FileBuffer(int file);
  ~FileBuffer() override;
  FileBuffer& operator=(FileBuffer&&) = delete;

  // Flushes the buffer, writes the file to the disk if `to_disk`, and closes the file. Returns
  // false and sets errno if this or an earlier operation failed.
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

inline constexpr std::size_t kAnySize = std::numeric_limits<std::size_t>::max() - 1;

// Reads a regular file. Throws InputError with the file name if the file cannot be read, is larger
// than `most` bytes, or is not a regular file. Reading a device or a pipe might never end.
std::string ReadFile(const std::string& path, std::size_t most = kAnySize);

// Reads a regular file, a pipe or a device that the user named. Pipes and devices are limited to 1
// GiB.
std::string ReadFileOrPipe(const std::string& path);

// Reads a JSON file. Throws InputError above 256 MiB or above 100 nested brackets, which bounds the
// recursion of the JSON parser and writer.
std::string ReadJsonText(const std::string& path);

}  // namespace surfit
