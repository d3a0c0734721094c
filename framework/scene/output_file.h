// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stroma {

/// A file could not be written; the message has its path and the system's reason.
class OutputError : public std::runtime_error {
 public:
  OutputError(const std::string& path, const std::string& what, int number);
  const int reason;  ///< errno
};

/// A file that grows in whole pieces. Opening does not truncate an existing file; the first append() does. Appended data
/// survives if the process dies, if a later append fails, and if another file cannot be written.
class OutputFile {
 public:
  OutputFile() = default;
  OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile() { forget(); }

  /// Opens or creates the file. Throws OutputError.
  void open(const std::string& path);
  bool isOpen() const { return descriptor_ >= 0; }
  const std::string& path() const { return path_; }
  /// The next append follows the first `bytes` of the file; the rest is discarded.
  void keep(std::uint64_t bytes) { size_ = bytes, is_cut_ = false; }
  /// Bytes kept and appended.
  std::uint64_t size() const { return size_; }
  /// Appends all of `bytes` or nothing: a piece cut short by a full disk is removed. Throws OutputError, also if the file has
  /// been deleted.
  void append(std::string_view bytes);
  bool hasFailed() const { return failed_; }  ///< an append has failed: no more can follow
  /// Throws OutputError. Removes a new file that nothing was appended to.
  void close();

 private:
  void forget() noexcept;
  [[noreturn]] void fail(const char* what, int reason);

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  bool is_regular_ = true, is_new_ = false, is_cut_ = false, failed_ = false;
};

/// Creates the folder of a file if it is missing. Throws OutputError.
void makeFolderOf(const std::string& path);

/// Throws the OutputError that checkWritable() would throw, as far as this can be determined without writing. A quota or
/// special rules of a file system are not detected.
void checkAccess(const std::string& path, bool is_replaced = false);

/// checkAccess(); creates the folder; throws OutputError if the file cannot be opened for writing, or its disk is full. An
/// existing file is not changed, and no file with this name is created. `is_replaced`: writeWholeFile() will write it,
/// which needs a writable folder.
void checkWritable(const std::string& path, bool is_replaced = false);

/// Writes an unnamed file and then links it to this name, so that nobody ever sees a partial file, concurrent writers leave
/// one complete file, and a killed process leaves nothing (if the file system supports unnamed files; otherwise it may
/// leave a ".part"). `rest` follows `bytes`. Throws OutputError, and then an existing file is unchanged.
void writeWholeFile(const std::string& path, std::string_view bytes, std::span<const std::string_view> rest = {});

}  // namespace stroma
