// SPDX-License-Identifier: LGPL-2.1-or-later
// A run's memory as a file. One format serves `stroma run --record`, `--resume` and `--restart`.
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
  /// `name` is for messages. Throws std::runtime_error with a sentence when the bytes are no checkpoint, cut short or
  /// damaged.
  static Checkpoint fromBytes(const std::string& bytes, const std::string& name);

  /// Under a temporary name first, so that a file under `path` is always whole. Makes the folder. Throws OutputError.
  void write(const std::string& path) const;
  static Checkpoint read(const std::string& path);

 private:
  /// The lines before the data.
  std::string head() const;
};

/// Version, compiler and headers of this build: another one may compute other bits.
std::string buildIdentity();

}  // namespace stroma
