// SPDX-License-Identifier: LGPL-2.1-or-later
// The checkpoint file of a run. `stroma run --record`, `--resume` and `--restart` share one format.
//
//   stroma checkpoint 1
//   scene <path>                    as it was given
//   build <identity>                of the program that wrote it
//   value <r|i|t> <count> <crc> <owner>:<name>      one line for each value, in the order of their data
//   end <crc of all above>
//   <data: 8-byte little-endian doubles (r) and integers (i), text (t) as it is>
//
// Counts are numbers, or bytes of a text; check sums are CRC-32.
#pragma once
#include <string>

#include "framework/scene/archive.h"

namespace stroma {

struct Checkpoint {
  std::string scene;  ///< the scene's file, as it was given
  std::string build;  ///< see buildIdentity()
  Archive values;     ///< Simulation::checkpoint()

  std::string bytes() const;
  /// `name` is for messages. Throws std::runtime_error if the bytes are not a checkpoint, truncated or
  /// damaged.
  static Checkpoint fromBytes(const std::string& bytes, const std::string& name);

  /// Written under a temporary name first, so that the file at `path` is always complete. Creates the folder. Throws OutputError.
  void write(const std::string& path) const;
  static Checkpoint read(const std::string& path);

 private:
  /// The lines before the data.
  std::string head() const;
};

/// Version, compiler and headers of this build: another build may compute different bits.
std::string buildIdentity();

}  // namespace stroma
