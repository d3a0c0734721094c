// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stroma {

/// A file could not be written: the sentence has its path and the system's reason.
class OutputError : public std::runtime_error {
 public:
  OutputError(const std::string& path, const std::string& what, int number);
  const int reason;  ///< of errno.h
};

/// A file that grows by whole pieces. Opening takes nothing from a file that is there: the first append() does. What has
/// been appended stays when the process dies, when a later append fails, and when another file cannot be written.
class OutputFile {
 public:
  OutputFile() = default;
  OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile() { forget(); }

  /// Opens the file or makes it. Throws OutputError.
  void open(const std::string& path);
  bool isOpen() const { return descriptor_ >= 0; }
  const std::string& path() const { return path_; }
  /// The next append follows the first `bytes` of the file; what lies behind them goes.
  void keep(std::uint64_t bytes) { size_ = bytes, is_cut_ = false; }
  /// Bytes kept and appended.
  std::uint64_t size() const { return size_; }
  /// All of `bytes`, or none: a piece that a full disk cuts short is taken back. Throws OutputError, also when somebody
  /// has removed the file.
  void append(std::string_view bytes);
  bool hasFailed() const { return failed_; }  ///< in an append: nothing more can follow
  /// Throws OutputError. A file that nothing was appended to, and that was not there before, is removed.
  void close();

 private:
  void forget() noexcept;
  [[noreturn]] void fail(const char* what, int reason);

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  bool is_regular_ = true, is_new_ = false, is_cut_ = false, failed_ = false;
};

/// Makes the folder of a file when it is missing. Throws OutputError.
void makeFolderOf(const std::string& path);

/// Throws the OutputError that checkWritable() would, as far as that is known without writing. It misses what only an
/// attempt shows (a quota, a special file system).
void checkAccess(const std::string& path, bool is_replaced = false);

/// checkAccess(); makes the folder; throws OutputError when the file cannot be opened for writing, or its disk is full.
/// Nothing is taken from a file that is there, and no file of this name is made. `is_replaced`: writeWholeFile() is to
/// write it, which needs a folder that can be written in.
void checkWritable(const std::string& path, bool is_replaced = false);

/// Writes a file without a name and then gives it this one, so that nobody ever sees half a file, two programs that do it
/// at once leave one of the two, and a killed one leaves nothing (where the file system knows files without names; else it
/// may leave a ".part"). `rest` follows `bytes`. Throws OutputError; a file that was there before is then still there.
void writeWholeFile(const std::string& path, std::string_view bytes, std::span<const std::string_view> rest = {});

}  // namespace stroma
