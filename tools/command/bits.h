// SPDX-License-Identifier: LGPL-2.1-or-later
// Bit for bit: what a run must not depend on (threads, runs before it in the same process), and what it may (compiler
// and instruction set), which is why stored hashes are kept for each of these apart.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "tools/command/regression_list.h"
#include "tools/command/session.h"

namespace stroma::command {

/// The bits at the end of a run.
struct Bits {
  std::uint64_t hash = 0;   ///< Simulation::stateHash()
  bool factorised = false;  ///< a matrix was factorised: BLAS chooses its kernels by the processor, and so the bits
};

/// Runs the scene with one thread, once more after reset(), from a checkpoint of the middle, and with two threads. Throws
/// std::runtime_error naming the first step that is not the same in all of them, or that fails. Leaves one thread set.
Bits bitsOfEveryRun(const RegressionCase& test, Session& session);

/// Hashes of an earlier build. A text file: a line `build COMPILER-BUILDTYPE`, then `CASE LEVEL HASH` with LEVEL as
/// instructionLevel() says it. Another compiler or other options contract and order operations otherwise: then nothing
/// is compared, nor for scenes that factorise a matrix; the remarks say so.
class StoredHashes {
 public:
  /// Reads `file`; none there: nothing is stored. Throws UsageError with file and line.
  explicit StoredHashes(std::string file);
  /// A remark for a case that passes; throws std::runtime_error when another hash is stored.
  std::string compare(const std::string& name, const Bits& bits) const;
  /// Puts the hash in; those of other levels go when it changed, as they must have too.
  std::string store(const std::string& name, const Bits& bits);
  void write() const;

 private:
  std::string file_, build_;  ///< the build that the stored hashes are of; empty: none is stored
  std::map<std::pair<std::string, std::string>, std::uint64_t> hashes_;  ///< by case and level
};

}  // namespace stroma::command
