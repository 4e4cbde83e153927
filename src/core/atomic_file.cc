#include "surfit/core/atomic_file.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "surfit/core/error.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void ThrowCannotWrite(const std::string& path, const std::error_code& reason) {
  throw InputError(Concat("cannot write '", path, "': ", reason.message()));
}

std::error_code LastError() { return {errno, std::generic_category()}; }

void WriteDirectly(const std::string& path, const std::function<void(std::ostream&)>& write) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) ThrowCannotWrite(path, LastError());
  write(file);
  file.close();
  if (!file) ThrowCannotWrite(path, LastError());
}

}  // namespace

void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write) {
  const fs::file_status status = fs::status(path);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    WriteDirectly(path, write);
    return;
  }
  const std::string target = fs::exists(status) ? fs::canonical(path).string() : path;
  const std::string partial = target + ".partial";
  std::error_code error;
  try {
    WriteDirectly(partial, write);
  } catch (...) {
    fs::remove(partial, error);
    throw;
  }
  fs::rename(partial, target, error);
  if (error) ThrowCannotWrite(path, error);
}

}  // namespace surfit
