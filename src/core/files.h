#pragma once

#include <cstddef>
#include <limits>
#include <streambuf>
#include <string>
#include <vector>

namespace surfit {

// In the names of files that are still being written, between that of the file to be and a number.
inline constexpr const char* kPartialMark = ".partial-";

// Throws InputError "cannot write '<path>': <reason of errno>".
[[noreturn]] void ThrowCannotWrite(const std::string& path);

// Begins a file: -1 and errno if there is one of that name, or a link, which is never followed.
int MakeNewFile(const std::string& path);

// Opens what is no regular file (a device, a pipe) to be written to: -1 and errno if it cannot be.
int OpenSpecialFile(const std::string& path);

// Writes all bytes: false and errno if not all found place.
bool WriteAll(int file, const char* bytes, std::size_t count);

// Bytes for an open file, which it closes. The first error stays, and fails the streams on it.
class FileBuffer final : public std::streambuf {
 public:
  explicit FileBuffer(int file);
  ~FileBuffer() override;
  FileBuffer& operator=(FileBuffer&&) = delete;

  // Writes what is left, to the disk if asked for, and closes the file: false and errno if any of
  // it has failed, now or before.
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

// All bytes of a regular file. Throws InputError naming the file if it cannot be read, has more
// than `most` bytes, or is something else, which might never end or hold the program up for good: a
// device, a pipe.
std::string ReadFile(const std::string& path, std::size_t most = kAnySize);

// The same for what a user has named, who may name a pipe or a device: of these a gigabyte at most.
std::string ReadFileOrPipe(const std::string& path);

// The text of a file of JSON: 256 megabytes at most, and at most 100 brackets in each other, as
// many as can safely be read and written by recursion.
std::string ReadJsonText(const std::string& path);

}  // namespace surfit
