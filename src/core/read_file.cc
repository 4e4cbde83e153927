#include "core/read_file.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "surfit/core/error.h"

namespace surfit {
namespace {

[[noreturn]] void ThrowCannotRead(const std::string& path) {
  const std::error_code reason(errno, std::generic_category());
  throw InputError(Concat("cannot read '", path, "': ", reason.message()));
}

}  // namespace

std::string ReadFile(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  if (!file) ThrowCannotRead(path);
  std::error_code no_size;  // a pipe has none
  const auto size = std::filesystem::file_size(path, no_size);
  std::string bytes;
  std::size_t used = 0;
  std::size_t block = no_size ? 1 << 16 : size + 1;  // the one more byte meets the end at once
  for (;;) {
    bytes.resize(used + block);
    used += std::fread(&bytes[used], 1, block, file.get());
    if (std::ferror(file.get())) ThrowCannotRead(path);
    if (used < bytes.size()) break;
    block = bytes.size();
  }
  bytes.resize(used);
  return bytes;
}

}  // namespace surfit
