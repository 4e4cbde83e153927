#include "core/new_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "surfit/core/error.h"

namespace surfit {

void ThrowCannotWrite(const std::string& path) {
  const std::error_code reason(errno, std::generic_category());
  throw InputError("cannot write '", path, "': ", reason.message());
}

int MakeNewFile(const std::string& path) {
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

}  // namespace surfit
