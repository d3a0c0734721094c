// SPDX-License-Identifier: LGPL-2.1-or-later
// The files that runs leave to be looked at, and how those of one run take the place of another's.
#pragma once
#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>

namespace stroma::command {

std::string checkpointIn(const std::string& folder);

/// Which file it is, whatever its name.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  long seconds = 0, nanoseconds = 0;  ///< of its last change
  bool operator==(const FileIdentity&) const = default;
};
/// Nothing when there is no such file.
std::optional<FileIdentity> identityOf(const std::string& file);

/// Why a run must leave `folder` as it is, a sentence; empty when it is not there, or a run left it so.
std::string reasonToKeep(const std::string& folder);

/// Puts the instants, and the checkpoint if there is one, that `write` makes in a fresh folder in the place of those in
/// `folder`: all or nothing, and of two runs at once those of one. A checkpoint of another run goes; `own`, which is of
/// this run, stays until there is a new one. Other files stay. Throws std::runtime_error; then nothing has changed, or
/// the disk has failed between two names.
void replaceFiles(const std::string& folder, const std::optional<FileIdentity>& own,
                  const std::function<void(const std::string& fresh)>& write);

}  // namespace stroma::command
