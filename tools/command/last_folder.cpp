// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/last_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <random>

#include "framework/scene/output_file.h"
#include "tools/command/instants.h"

namespace stroma::command {
namespace {

namespace fs = std::filesystem;

/// A folder with a name that nobody has; goes with what is in it.
class FreshFolder {
 public:
  explicit FreshFolder(const std::string& start) {
    std::random_device random;
    std::error_code error;
    path_ = start;
    fs::create_directories(fs::path(start).parent_path(), error);
    for (int attempt = 0; attempt < 100 && !error; ++attempt) {
      path_ = fmt::format("{}{}.part", start, random());
      if (fs::create_directory(path_, error)) return;
    }
    throw OutputError(path_, "cannot make the folder", error ? error.value() : EEXIST);
  }
  FreshFolder(const FreshFolder&) = delete;
  ~FreshFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Of a folder, among the programs that ask. Where the file system has no locks there is none.
class Lock {
 public:
  explicit Lock(const std::string& folder)
      : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)) {
    if (descriptor_ < 0) throw OutputError(folder, "cannot open the folder", errno);
    while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) continue;
  }
  Lock(const Lock&) = delete;
  ~Lock() { ::close(descriptor_); }

 private:
  int descriptor_;
};

void rename(const std::string& from, const std::string& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw OutputError(to, "cannot write", errno);
}

bool isPlainFile(const std::string& file) {
  std::error_code error;
  return fs::is_regular_file(fs::symlink_status(file, error));
}

}  // namespace

std::string checkpointIn(const std::string& folder) { return (fs::path(folder) / "last.checkpoint").string(); }

std::optional<FileIdentity> identityOf(const std::string& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) return {};
  return FileIdentity{status.st_dev, status.st_ino, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

std::string reasonToKeep(const std::string& folder) {
  std::error_code error;
  const fs::file_type type = fs::symlink_status(folder, error).type();
  if (type == fs::file_type::not_found) return {};
  const std::string instants = instantsFile(folder), checkpoint = checkpointIn(folder);
  if (type == fs::file_type::symlink) return fmt::format("{} is a symbolic link: it is not replaced", folder);
  for (const std::string& file : {instants, checkpoint})
    if (identityOf(file) && !isPlainFile(file)) return fmt::format("{} is not a regular file: it is not replaced", file);
  if (type != fs::file_type::directory || !isInstantsFile(instants))
    return fmt::format("{} was not left by a run: it is not replaced", folder);
  return {};
}

void replaceFiles(const std::string& folder, const std::optional<FileIdentity>& own,
                  const std::function<void(const std::string& fresh)>& write) {
  std::error_code error;
  const bool is_there = fs::exists(fs::symlink_status(folder, error));
  const FreshFolder fresh(folder + (is_there ? "/" : "."));
  write(fresh.path());
  if (!is_there && ::rename(fresh.path().c_str(), folder.c_str()) == 0) return;
  const Lock lock(folder);  // another run's folder has come meanwhile, or was there
  if (const std::string reason = reasonToKeep(folder); !reason.empty()) throw std::runtime_error(reason);
  const std::string checkpoint = checkpointIn(folder), next = checkpointIn(fresh.path());
  const auto present = identityOf(checkpoint);
  if (present && present != own && ::unlink(checkpoint.c_str()) != 0)
    throw OutputError(checkpoint, "cannot remove the checkpoint of a run before", errno);
  rename(instantsFile(fresh.path()), instantsFile(folder));
  if (identityOf(next)) rename(next, checkpoint);
}

}  // namespace stroma::command
