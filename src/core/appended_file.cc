#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "core/files.h"
#include "surfit/core/atomic_file.h"

namespace surfit {

AppendedFile::AppendedFile(const std::string& path) : path_(path) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::symlink_status(path, none);
  const bool is_replaced = fs::is_regular_file(status) || fs::is_symlink(status);
  if (is_replaced && unlink(path.c_str()) != 0) ThrowCannotWrite(path);
  file_ = fs::exists(status) && !is_replaced ? OpenSpecialFile(path) : MakeNewFile(path);
  if (file_ < 0) ThrowCannotWrite(path);
}

AppendedFile::~AppendedFile() { close(file_); }

void AppendedFile::Append(const std::string& piece) {
  if (WriteAll(file_, piece.data(), piece.size())) {
    size_ += static_cast<std::int64_t>(piece.size());
    return;
  }
  const int reason = errno;
  if (ftruncate(file_, size_) == 0) lseek(file_, size_, SEEK_SET);
  errno = reason;
  ThrowCannotWrite(path_);
}

}  // namespace surfit
