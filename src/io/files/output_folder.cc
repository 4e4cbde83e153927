#include "io/files/output_folder.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>

#include "core/files.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockName = "/.surfit.lock";

std::string OwnerIn(int lock) {
  char text[32];
  const ssize_t count = pread(lock, text, sizeof(text), 0);
  std::string owner(text, static_cast<std::size_t>(count < 0 ? 0 : count));
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  return owner;
}

// False if another process has removed or replaced `path` since it was opened.
bool IsStillAt(const std::string& path, int file) {
  struct stat opened {};
  struct stat there {};
  return fstat(file, &opened) == 0 && lstat(path.c_str(), &there) == 0 &&
         opened.st_ino == there.st_ino && opened.st_dev == there.st_dev;
}

// Locks the file `path` and returns its descriptor. Throws InputError if another process has the
// lock. The operating system releases the lock when the process ends, even after a crash.
int Lock(const std::string& folder, const std::string& path) {
  for (;;) {
    const int lock = open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (lock < 0) ThrowCannotWrite(path);
    if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
      const std::string owner = OwnerIn(lock);
      close(lock);
      throw InputError(folder, " is in use as output folder of process ", owner,
                       ": choose another folder");
    }
    if (IsStillAt(path, lock)) return lock;
    close(lock);
  }
}

void WriteOwner(const std::string& folder, int lock) {
  const std::string former = OwnerIn(lock);
  if (!former.empty()) {
    LOG(WARNING) << folder << ": process " << former
                 << " ended without removing its lock: taken over";
  }
  const std::string own = Concat(getpid(), "\n");
  if (ftruncate(lock, 0) != 0 || pwrite(lock, own.data(), own.size(), 0) < 0) {
    LOG(WARNING) << folder << ": cannot write the process id to the lock file";
  }
}

void RequireNoInput(const std::string& path, const std::vector<std::string>& inputs) {
  std::error_code none;
  for (const std::string& input : inputs) {
    ThrowIf(!input.empty() && fs::equivalent(path, input, none), path,
            " is an input file, must not be in the output folder");
  }
}

void Remove(const std::string& folder, const std::string& name) {
  const fs::path path = fs::path(folder) / name, in = path.parent_path();
  std::error_code error;
  if (in != fs::path(folder) && fs::is_symlink(fs::symlink_status(in, error))) {
    throw InputError(in.string(), " is a symbolic link, must be a real folder");
  }
  fs::remove(path, error);
  if (error && error != std::errc::not_a_directory) {
    throw InputError(folder, "/", name, ": cannot be replaced: ", error.message());
  }
}

// Removes temporary files of an interrupted WriteFileAtomically().
void RemovePartials(const std::string& folder, const std::vector<std::string>& files) {
  std::set<fs::path> folders, partials;
  for (const std::string& file : files) folders.insert((fs::path(folder) / file).parent_path());
  std::error_code none;
  for (const fs::path& in : folders) {
    for (fs::directory_iterator at(in, none), end; at != end; at.increment(none)) {
      const std::string path = at->path().string();
      const std::size_t mark = path.rfind(kPartialMark);
      if (mark == path.npos) continue;
      const std::string name = path.substr(folder.size() + 1, mark - folder.size() - 1);
      if (std::find(files.begin(), files.end(), name) != files.end()) partials.insert(at->path());
    }
  }
  for (const fs::path& partial : partials) fs::remove(partial, none);
}

}  // namespace

void CreateFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw InputError(folder, ": cannot create the output folder: ", error.message());
  }
}

OutputFolder::OutputFolder(const std::string& folder, const std::vector<std::string>& former_files,
                           const std::vector<std::string>& inputs)
    : lock_path_(folder + kLockName) {
  CreateFolder(folder);
  lock_ = Lock(folder, lock_path_);
  WriteOwner(folder, lock_);
  try {
    for (const std::string& name : former_files) RequireNoInput(Concat(folder, "/", name), inputs);
    for (const std::string& name : former_files) Remove(folder, name);
    RemovePartials(folder, former_files);
  } catch (...) {
    unlink(lock_path_.c_str());
    close(lock_);
    throw;
  }
}

OutputFolder::~OutputFolder() {
  unlink(lock_path_.c_str());
  close(lock_);
}

}  // namespace surfit
