#include "core/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::size_t kMostOfPipe = std::size_t{1} << 30;    // bytes
constexpr std::size_t kMostOfJson = std::size_t{256} << 20;  // bytes
constexpr int kMostNested = 100;

[[noreturn]] void ThrowCannotRead(const std::string& path) {
  const std::error_code reason(errno, std::generic_category());
  throw InputError("cannot read '", path, "': ", reason.message());
}

// A file that is open for reading.
class OpenFile {
 public:
  // Opening a pipe waits for who writes to it, unless `flags` say otherwise.
  OpenFile(const std::string& path, int flags)
      : path_(path), file_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | flags)) {
    if (file_ < 0 || fstat(file_, &status_) != 0) ThrowCannotRead(path);
  }
  ~OpenFile() { close(file_); }
  OpenFile& operator=(OpenFile&&) = delete;

  bool is_regular() const { return S_ISREG(status_.st_mode); }
  std::size_t size() const { return static_cast<std::size_t>(status_.st_size); }

  // At most so many bytes.
  std::string Read(std::size_t most) const {
    std::string bytes;
    std::size_t used = 0;
    // One more byte than there are meets the end at once.
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

// Of JSON: brackets within strings do not count.
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
    ThrowIf(depth > kMostNested, path, " is nested too deeply, must be at most ", kMostNested,
            " brackets deep");
  }
}

}  // namespace

std::string ReadFile(const std::string& path, std::size_t most) {
  const OpenFile file(path, O_NONBLOCK);
  ThrowIf(!file.is_regular(), "cannot read '", path, "': it is no regular file");
  RequireNoMoreThan(most, file.size(), path);
  return file.Read(most);
}

std::string ReadFileOrPipe(const std::string& path) {
  const OpenFile file(path, 0);
  if (file.is_regular()) return file.Read(kAnySize);
  std::string bytes = file.Read(kMostOfPipe + 1);
  RequireNoMoreThan(kMostOfPipe, bytes.size(), path);
  return bytes;
}

std::string ReadJsonText(const std::string& path) {
  std::string text = ReadFile(path, kMostOfJson);
  RequireShallow(text, path);
  return text;
}

}  // namespace surfit
