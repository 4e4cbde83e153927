// Preloaded library (LD_PRELOAD) that makes one system call fail. Environment variables:
//   SURFIT_FAULT         CALL:N, the N-th call fails. CALL is open, read, write, rename, fsync,
//   malloc
//                        or short. malloc counts blocks of 64 KiB and more, after the first file in
//                        the folder is opened. `short` writes half of the data and returns its
//                        size. slow:20 delays each write and fsync by 20 ms.
//   SURFIT_FAULT_FOLDER  only files in this folder are affected
//   SURFIT_FAULT_MARK    file that is created when the fault occurs
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" void* __libc_malloc(std::size_t size);  // NOLINT: name of glibc

namespace {

constexpr std::size_t kLargeBlock = 1 << 16;  // bytes

struct Fault {
  std::array<char, 16> kind{};
  long at = 0;
  const char* folder = "";
  const char* mark = "";
};

Fault fault;  // NOLINT: state of the library
std::atomic<long> count{0};
std::atomic<bool> has_begun{false};  // a file in the folder has been opened

// Allocations before this constructor do not fail.
__attribute__((constructor)) void ReadFault() {
  const char* const text = getenv("SURFIT_FAULT");
  const char* const folder = getenv("SURFIT_FAULT_FOLDER");
  const char* const mark = getenv("SURFIT_FAULT_MARK");
  if (text == nullptr || folder == nullptr || mark == nullptr) return;
  fault.folder = folder;
  fault.mark = mark;
  std::sscanf(text, "%15[a-z]:%ld", fault.kind.data(), &fault.at);
}

bool IsTurnOf(const char* kind) {
  if (std::strcmp(kind, fault.kind.data()) != 0 || ++count != fault.at) return false;
  const long mark = syscall(SYS_openat, AT_FDCWD, fault.mark, O_WRONLY | O_CREAT, 0600);
  if (mark >= 0) syscall(SYS_close, mark);
  return true;
}

bool IsInFolder(const char* path) {
  return std::strncmp(path, fault.folder, std::strlen(fault.folder)) == 0;
}

bool IsInFolder(int file) {
  std::array<char, 64> link{};
  std::array<char, 4096> path{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", file);
  return readlink(link.data(), path.data(), path.size() - 1) > 0 && IsInFolder(path.data());
}

bool Fails(const char* kind, bool is_in_folder, int error) {
  if (fault.at == 0 || !is_in_folder || !IsTurnOf(kind)) return false;
  errno = error;
  return true;
}

// Simulates a slow disk.
void WaitForDisk(bool is_in_folder) {
  constexpr useconds_t kMillisecond_us = 1000;
  if (!is_in_folder || std::strcmp("slow", fault.kind.data()) != 0) return;
  usleep(static_cast<useconds_t>(fault.at) * kMillisecond_us);
}

template <typename Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  const bool is_in_folder = fault.at != 0 && IsInFolder(path);
  if (is_in_folder) has_begun = true;
  if (Fails("open", is_in_folder, EACCES)) return -1;
  static const auto next = Next<int (*)(const char*, int, mode_t)>("open");
  return next(path, flags, mode);
}

ssize_t write(int file, const void* bytes, std::size_t size) {
  static const auto next = Next<ssize_t (*)(int, const void*, std::size_t)>("write");
  const bool is_in_folder = fault.at != 0 && IsInFolder(file);
  WaitForDisk(is_in_folder);
  if (Fails("write", is_in_folder, ENOSPC)) return -1;
  if (size > 1 && Fails("short", is_in_folder, 0)) size /= 2;
  return next(file, bytes, size);
}

ssize_t read(int file, void* bytes, std::size_t size) {
  if (fault.at != 0 && Fails("read", IsInFolder(file), EIO)) return -1;
  static const auto next = Next<ssize_t (*)(int, void*, std::size_t)>("read");
  return next(file, bytes, size);
}

int rename(const char* from, const char* to) {
  if (Fails("rename", IsInFolder(to), EACCES)) return -1;
  static const auto next = Next<int (*)(const char*, const char*)>("rename");
  return next(from, to);
}

int fsync(int file) {
  const bool is_in_folder = fault.at != 0 && IsInFolder(file);
  WaitForDisk(is_in_folder);
  if (Fails("fsync", is_in_folder, EIO)) return -1;
  static const auto next = Next<int (*)(int)>("fsync");
  return next(file);
}

void* malloc(std::size_t size) {
  if (size >= kLargeBlock && Fails("malloc", has_begun, ENOMEM)) return nullptr;
  return __libc_malloc(size);
}
}
