// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace stroma::command {

/// The scene, what it includes, and whatever its attributes may name as files, those that are not there and those that
/// would be written too. No component is made: a scene with mistakes names files as well.
std::vector<std::string> filesNamedBy(const std::string& scene);

/// How files are at one time. Looking again and again finds whatever an editor does: files that are written in place,
/// replaced by others under their name, removed, or recreated.
class FileStamps {
 public:
  FileStamps() = default;
  explicit FileStamps(const std::vector<std::string>& files);
  /// Takes the stamps that `other` has.
  void takeFrom(const FileStamps& other);
  /// A sentence on the first files that differ from these stamps now: "beam.xml was saved"; empty when none does.
  std::string changed() const;
  bool operator==(const FileStamps&) const = default;
  std::vector<std::string> files() const;

 private:
  struct Stamp {
    long seconds = 0, nanoseconds = 0, size = 0;
    unsigned long device = 0, inode = 0;
    bool operator==(const Stamp&) const = default;
  };
  static std::optional<Stamp> stampOf(const std::string& file);

  std::map<std::string, std::optional<Stamp>> stamps_;  ///< none: the file is not there
};

}  // namespace stroma::command
