// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>
#include <utility>

namespace stroma {
namespace {

namespace fs = std::filesystem;

/// All of `bytes`; 0 or the error number.
int writeAll(int descriptor, std::string_view bytes, bool is_regular, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t count = is_regular ? ::pwrite(descriptor, bytes.data(), bytes.size(), off_t(offset))
                                     : ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes.remove_prefix(std::size_t(count));
    offset += std::uint64_t(count);
  }
  return 0;
}

/// A link to a file would take that file's place, whatever it is. Links of the system, such as /dev/stdout, lead to where
/// output goes.
void refuseLink(const std::string& path) {
  std::error_code error;
  if (!fs::is_symlink(fs::symlink_status(path, error)) || !fs::is_regular_file(path, error)) return;
  const std::string place = fs::absolute(path, error).lexically_normal().string();
  if (place.starts_with("/dev/") || place.starts_with("/proc/")) return;
  throw OutputError(
      path, "is a symbolic link to " + fs::read_symlink(path, error).string() + ", which would be overwritten", EEXIST);
}

/// A file in the folder of `path` that has no name, or, where the file system knows no such files, one of its own.
class Draft {
 public:
  explicit Draft(const std::string& path) : path_(path) {
    const fs::path folder = fs::path(path).parent_path();
    const bool can_be_named_later = ::access("/proc/self/fd", X_OK) == 0;
    if (can_be_named_later)
      descriptor_ = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) return;
    const bool is_unknown = errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL || errno == ENOENT;
    if (can_be_named_later && !is_unknown) fail("cannot open for writing");
    const int error = name([this] {
      descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      return descriptor_ >= 0;
    });
    if (error != 0) throw OutputError(path_, "cannot open for writing", error);
  }
  Draft(const Draft&) = delete;
  ~Draft() {
    ::close(descriptor_);
    if (!name_.empty()) ::unlink(name_.c_str());
  }

  /// Behind what was written before.
  void write(std::string_view bytes) {
    if (const int reason = writeAll(descriptor_, bytes, true, size_)) throw OutputError(path_, "cannot write", reason);
    size_ += bytes.size();
  }
  void rename() {
    if (name_.empty()) {  // a link cannot take the place of a file: a name of its own comes between
      const std::string descriptor = "/proc/self/fd/" + std::to_string(descriptor_);
      const int error =
          name([&] { return ::linkat(AT_FDCWD, descriptor.c_str(), AT_FDCWD, name_.c_str(), AT_SYMLINK_FOLLOW) == 0; });
      if (error != 0) throw OutputError(path_, "cannot write", error);
    }
    if (::rename(name_.c_str(), path_.c_str()) != 0) fail("cannot write");
    name_.clear();
  }

 private:
  /// Tries names until `take` has one that nobody has; 0 or the error number.
  template <class Take>
  int name(const Take& take) {
    std::random_device random;
    for (int attempt = 0; attempt < 100; ++attempt) {
      name_ = path_ + "." + std::to_string(random()) + ".part";
      if (take()) return 0;
      if (errno != EEXIST) break;
    }
    name_.clear();
    return errno;
  }
  [[noreturn]] void fail(const char* what) { throw OutputError(path_, what, errno); }

  std::string path_, name_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Writes beside `path`: a full disk may take a new file, but no bytes. Of a file that is there and grows, only the space
/// is in question.
void tryBeside(const std::string& path, bool needs_folder) {
  try {
    Draft(path).write(std::string(4096, ' '));
  } catch (const OutputError& failure) {
    const bool is_full = failure.reason == ENOSPC || failure.reason == EDQUOT;
    if (is_full || needs_folder)
      throw OutputError(path, is_full ? "cannot write" : "cannot open for writing", failure.reason);
  }
}

/// Whether a file is to appear in its folder: a new one, or a draft that takes the place of the one that is there.
bool needsFolder(const std::string& path, bool is_replaced) {
  std::error_code error;
  if (!fs::exists(path, error)) return true;
  return is_replaced && fs::is_regular_file(fs::symlink_status(path, error));
}

/// Whether the file system of a folder that is there has no room; one that counts no blocks is not asked.
bool isFull(const fs::path& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0 || disk.f_blocks == 0) return false;
  return (::geteuid() == 0 ? disk.f_bfree : disk.f_bavail) == 0;
}

}  // namespace

OutputError::OutputError(const std::string& path, const std::string& what, int number)
    : std::runtime_error(path + ": " + what + " (" + std::strerror(number) + ")"), reason(number) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(is_regular_, other.is_regular_);
  std::swap(is_new_, other.is_new_);
  std::swap(is_cut_, other.is_cut_);
  std::swap(failed_, other.failed_);
  return *this;
}

void OutputFile::open(const std::string& path) {
  forget();
  refuseLink(path);
  path_ = path, size_ = 0, is_cut_ = failed_ = false;
  is_new_ = ::access(path.c_str(), F_OK) != 0;
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw OutputError(path, "cannot open for writing", errno);
  struct stat status {};
  is_regular_ = ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
}

void OutputFile::append(std::string_view bytes) {
  struct stat status {};
  if (is_regular_ && ::fstat(descriptor_, &status) == 0 && status.st_nlink == 0)
    fail("the file was removed while it was being written", ENOENT);
  if (is_regular_ && !is_cut_ && ::ftruncate(descriptor_, off_t(size_)) != 0) fail("cannot write", errno);
  is_cut_ = true;
  if (const int reason = writeAll(descriptor_, bytes, is_regular_, size_)) {
    // on a full disk a piece is cut short; that it cannot be taken back harms no reader
    if (is_regular_ && ::ftruncate(descriptor_, off_t(size_)) != 0) errno = 0;
    fail("cannot write", reason);
  }
  size_ += bytes.size();
  is_new_ = false;
}

void OutputFile::fail(const char* what, int reason) {
  failed_ = true;
  throw OutputError(path_, what, reason);
}

void OutputFile::close() {
  const int descriptor = descriptor_;
  if (is_new_) return forget();
  descriptor_ = -1;
  if (descriptor >= 0 && ::close(descriptor) != 0 && !failed_) fail("cannot finish writing", errno);
}

void OutputFile::forget() noexcept {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  descriptor_ = -1;
  if (is_new_) ::unlink(path_.c_str());
}

void makeFolderOf(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error) throw OutputError(folder.string(), "cannot make the folder", error.value());
}

void checkAccess(const std::string& path, bool is_replaced) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code error;
  fs::path there = folder;  // or the nearest above it that is there
  while (!there.empty() && there != there.root_path() && !fs::exists(there, error)) there = there.parent_path();
  const bool is_missing = there != folder;
  if (there.empty()) there = ".";
  if (!fs::is_directory(there, error)) throw OutputError(folder.string(), "cannot make the folder", ENOTDIR);
  if (is_missing && ::access(there.c_str(), W_OK | X_OK) != 0)
    throw OutputError(folder.string(), "cannot make the folder", errno);
  if (fs::is_directory(path, error)) throw OutputError(path, "cannot open for writing", EISDIR);
  refuseLink(path);
  const bool is_there = !is_missing && ::access(path.c_str(), F_OK) == 0;
  if (!is_missing && !is_there && errno != ENOENT) throw OutputError(path, "cannot open for writing", errno);
  if (is_there && ::access(path.c_str(), W_OK) != 0) throw OutputError(path, "cannot open for writing", errno);
  if (!is_missing && needsFolder(path, is_replaced) && ::access(there.c_str(), W_OK) != 0)
    throw OutputError(path, "cannot open for writing", errno);
  if ((!is_there || fs::is_regular_file(path, error)) && isFull(there)) throw OutputError(path, "cannot write", ENOSPC);
}

void checkWritable(const std::string& path, bool is_replaced) {
  checkAccess(path, is_replaced);
  makeFolderOf(path);
  std::error_code error;
  const auto kind = fs::status(path, error).type();
  // to open a pipe is to wait for its reader
  if (kind == fs::file_type::fifo || kind == fs::file_type::socket) return;
  const bool is_there = kind != fs::file_type::not_found;
  if (is_there) {
    OutputFile file;
    file.open(path);
  }
  if (!is_there || kind == fs::file_type::regular) tryBeside(path, needsFolder(path, is_replaced));
}

void writeWholeFile(const std::string& path, std::string_view bytes, std::span<const std::string_view> rest) {
  refuseLink(path);
  std::error_code error;
  // a device or a pipe has no other name, and what a link points to stays behind it
  if (fs::is_symlink(fs::symlink_status(path, error)) ||
      (fs::exists(path, error) && !fs::is_regular_file(path, error))) {
    OutputFile file;
    file.open(path);
    file.append(bytes);
    for (const std::string_view piece : rest) file.append(piece);
    return file.close();
  }
  Draft draft(path);
  draft.write(bytes);
  for (const std::string_view piece : rest) draft.write(piece);
  draft.rename();
}

}  // namespace stroma
