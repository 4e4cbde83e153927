#include "surfit/core/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "core/files.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

void Fill(int file, const std::string& path, bool to_disk,
          const std::function<void(std::ostream&)>& write) {
  if (file < 0) ThrowCannotWrite(path);
  FileBuffer buffer(file);
  std::ostream stream(&buffer);
  write(stream);
  if (!buffer.Close(to_disk)) ThrowCannotWrite(path);
}

// Creates a temporary file with a unique name beside `path`. Returns its path and sets *file to its
// descriptor.
std::string MakePartial(const std::string& path, int* file) {
  static std::atomic<int> count{0};
  std::string partial;
  do {
    partial = Concat(path, kPartialMark, getpid(), "-", count++);
    *file = CreateFileExclusively(partial);
  } while (*file < 0 && errno == EEXIST);
  if (*file < 0) ThrowCannotWrite(path);
  return partial;
}

// Flushes the directory entry to the disk. Errors are ignored: some folders are not readable.
void FlushFolderOf(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  const int opened =
      open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return;
  fsync(opened);
  close(opened);
}

void Replace(const std::string& path, const std::function<void(std::ostream&)>& write) {
  int file = -1;
  const std::string partial = MakePartial(path, &file);
  try {
    Fill(file, path, /*to_disk=*/true, write);
    if (std::rename(partial.c_str(), path.c_str()) != 0) ThrowCannotWrite(path);
  } catch (...) {
    unlink(partial.c_str());
    throw;
  }
  FlushFolderOf(path);
}

}  // namespace

void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write) {
  std::error_code none;
  const bool is_link = fs::is_symlink(fs::symlink_status(path, none));
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    Fill(OpenSpecialFile(path), path, /*to_disk=*/false, write);
  } else if (is_link) {
    throw InputError("cannot write '", path,
                     "': it is a symbolic link, must be a regular file or a new name");
  } else {
    Replace(path, write);
  }
}

AppendedFile::AppendedFile(const std::string& path) : path_(path) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::symlink_status(path, none);
  const bool is_replaced = fs::is_regular_file(status) || fs::is_symlink(status);
  if (is_replaced && unlink(path.c_str()) != 0) ThrowCannotWrite(path);
  file_ = fs::exists(status) && !is_replaced ? OpenSpecialFile(path) : CreateFileExclusively(path);
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
