#include "core/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::size_t kMaxOfPipe = std::size_t{1} << 30;    // bytes
constexpr std::size_t kMaxOfJson = std::size_t{256} << 20;  // bytes
constexpr int kMaxNested = 100;

[[noreturn]] void ThrowCannotRead(const std::string& path) {
  const std::error_code reason(errno, std::generic_category());
  throw InputError("cannot read '", path, "': ", reason.message());
}

class OpenFile {
 public:
  // Without O_NONBLOCK, opening a pipe blocks until another process opens it for writing.
  OpenFile(const std::string& path, int flags)
      : path_(path), file_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | flags)) {
    if (file_ < 0 || fstat(file_, &status_) != 0) ThrowCannotRead(path);
  }
  ~OpenFile() { close(file_); }
  OpenFile& operator=(OpenFile&&) = delete;

  bool is_regular() const { return S_ISREG(status_.st_mode); }
  std::size_t size() const { return static_cast<std::size_t>(status_.st_size); }

  std::string Read(std::size_t most) const {
    std::string bytes;
    std::size_t used = 0;
    std::size_t room = is_regular() ? size() + 1 : std::size_t{1} << 16;
    while (used < most) {
      bytes.resize(std::min(room, most));
      const ssize_t count = read(file_, &bytes[used], bytes.size() - used);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) ThrowCannotRead(path_);
      if (count == 0) break;
      used += static_cast<std::size_t>(count);
      if (used == room) room *= 2;
    }
    bytes.resize(used);
    return bytes;
  }

 private:
  const std::string& path_;
  int file_;
  struct stat status_ {};
};

void RequireNoMoreThan(std::size_t most, std::size_t bytes, const std::string& path) {
  if (bytes <= most) return;
  throw InputError(path, " is too large, must have ", most, " bytes at most");
}

void RequireShallow(const std::string& json, const std::string& path) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string && c == '\\') ++i;
    if (c == '"') in_string = !in_string;
    if (in_string) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    ThrowIf(depth > kMaxNested, path, " is nested too deeply, must be at most ", kMaxNested,
            " brackets deep");
  }
}

}  // namespace

void ThrowCannotWrite(const std::string& path) {
  const std::error_code reason(errno, std::generic_category());
  throw InputError("cannot write '", path, "': ", reason.message());
}

int CreateFileExclusively(const std::string& path) {
  constexpr mode_t kAsTheUserAllows = 0666;
  return open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kAsTheUserAllows);
}

int OpenSpecialFile(const std::string& path) {
  return open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
}

bool WriteAll(int file, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = write(file, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
  return true;
}

FileBuffer::FileBuffer(int file) : file_(file), bytes_(1 << 16) {
  setp(bytes_.data(), bytes_.data() + bytes_.size());
}

FileBuffer::~FileBuffer() {
  if (file_ >= 0) close(file_);
}

bool FileBuffer::Close(bool to_disk) {
  Flush();
  if (error_ == 0 && to_disk && fsync(file_) != 0) error_ = errno;
  if (close(file_) != 0 && error_ == 0) error_ = errno;
  file_ = -1;
  errno = error_;
  return error_ == 0;
}

bool FileBuffer::Flush() {
  const auto count = static_cast<std::size_t>(pptr() - pbase());
  setp(bytes_.data(), bytes_.data() + bytes_.size());
  if (error_ == 0 && !WriteAll(file_, bytes_.data(), count)) error_ = errno;
  return error_ == 0;
}

FileBuffer::int_type FileBuffer::overflow(int_type c) {
  if (!Flush()) return traits_type::eof();
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  return sputc(traits_type::to_char_type(c));
}

int FileBuffer::sync() { return Flush() ? 0 : -1; }

FileBuffer::pos_type FileBuffer::seekoff(off_type offset, std::ios_base::seekdir from,
                                         std::ios_base::openmode /*which*/) {
  if (!Flush()) return pos_type(off_type(-1));
  const int whence = from == std::ios_base::beg   ? SEEK_SET
                     : from == std::ios_base::cur ? SEEK_CUR
                                                  : SEEK_END;
  return pos_type(lseek(file_, offset, whence));
}

FileBuffer::pos_type FileBuffer::seekpos(pos_type position, std::ios_base::openmode which) {
  return seekoff(off_type(position), std::ios_base::beg, which);
}

std::string ReadFile(const std::string& path, std::size_t most) {
  const OpenFile file(path, O_NONBLOCK);
  ThrowIf(!file.is_regular(), "cannot read '", path, "': it is not a regular file");
  RequireNoMoreThan(most, file.size(), path);
  return file.Read(most);
}

std::string ReadFileOrPipe(const std::string& path) {
  const OpenFile file(path, 0);
  if (file.is_regular()) return file.Read(kAnySize);
  std::string bytes = file.Read(kMaxOfPipe + 1);
  RequireNoMoreThan(kMaxOfPipe, bytes.size(), path);
  return bytes;
}

std::string ReadJsonText(const std::string& path) {
  std::string text = ReadFile(path, kMaxOfJson);
  RequireShallow(text, path);
  return text;
}

}  // namespace surfit
