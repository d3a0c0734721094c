// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/bits.h"
#include "tools/session/drop_readers.h"
#include "tools/session/scene_program.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "framework/algebra/parallel.h"
#include "framework/scene/output_file.h"

namespace stroma::command {
namespace {

const std::string this_build = "gcc-" __VERSION__ "-" STROMA_BUILD_TYPE;

/// The hash after each step, the start first.
std::vector<std::uint64_t> run(Session& session, long steps, bool& factorised) {
  const Simulation& simulation = session.simulation();
  std::vector<std::uint64_t> hashes{simulation.stateHash()};
  while (simulation.steps() < steps) {
    const StepReport report = session.step();
    if (report.diverged) throw std::runtime_error("diverged: " + report.reason);
    hashes.push_back(simulation.stateHash());
    factorised = factorised || report.factorisations > 0;
  }
  return hashes;
}

/// `a` starts at step `first`.
void requireSame(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b, const char* what,
                 long first = 0) {
  for (std::size_t step = 0; step < a.size(); ++step)
    if (a[step] != b[step])
      throw std::runtime_error(
          fmt::format("{} differs from step {} on: {:016x} and {:016x}", what, first + long(step), a[step], b[step]));
}

}  // namespace

Bits bitsOfEveryRun(const RegressionCase& test, Session& session) {
  if (isSceneProgram(test.scene)) throw std::runtime_error("a scene in Python is compared by its states, without --bits");
  const auto load = [&](int thread_count) {
    setThreads(thread_count);
    dropReaders(session.load(test.scene, parseOverrides(test.overrides)));
  };
  session.followMeshChanges();
  Bits bits;
  bits.factorised = test.bits_of_processor;
  load(1);
  const auto first = run(session, test.steps, bits.factorised);
  session.simulation().reset();
  const long half = test.steps / 2;
  const auto again = run(session, half, bits.factorised);
  const Checkpoint checkpoint = session.checkpoint();
  requireSame(again, first, "the run after a reset");
  requireSame(run(session, test.steps, bits.factorised), {first.begin() + half, first.end()}, "the run after a reset",
              half);
  load(1);
  session.restore(checkpoint, "the checkpoint");
  requireSame(run(session, test.steps, bits.factorised), {first.begin() + half, first.end()},
              "the run from a checkpoint", half);
  load(2);
  const auto parallel = run(session, test.steps, bits.factorised);
  setThreads(1);
  requireSame(first, parallel, "the run with two threads");
  bits.hash = first.back();
  return bits;
}

StoredHashes::StoredHashes(std::string file) : file_(std::move(file)) {
  std::ifstream stream(file_);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string first, level, hash;
    if (!(words >> first)) continue;
    const bool is_build = first == "build" && words >> build_;
    const bool is_hash = !is_build && words >> level >> hash && hash.size() == 16 &&
                         hash.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!is_build && !is_hash)
      throw UsageError(fmt::format("{}:{}: expected `build NAME` or `CASE LEVEL HASH`", file_, number));
    if (is_hash) hashes_[{first, level}] = std::stoull(hash, nullptr, 16);
  }
}

std::string StoredHashes::compare(const std::string& name, const Bits& bits) const {
  const std::string text = fmt::format("the same bits in all runs, hash {:016x}", bits.hash);
  if (bits.factorised) return text + "; not stored, because factorisations depend on the processor's BLAS";
  if (build_ != this_build)
    return text + (build_.empty() ? "; none is stored"
                                  : fmt::format("; stored are those of {}, not of {}", build_, this_build));
  const auto stored = hashes_.find({name, instructionLevel()});
  if (stored == hashes_.end()) return text + "; none is stored for " + instructionLevel();
  if (stored->second != bits.hash)
    throw std::runtime_error(fmt::format(
        "the last state has the hash {:016x}, stored is {:016x}: its bits have changed (when they should have, --bits "
        "--update stores the new ones)",
        bits.hash, stored->second));
  return text + ", as stored";
}

std::string StoredHashes::store(const std::string& name, const Bits& bits) {
  if (bits.factorised) return "not stored, because factorisations depend on the processor's BLAS";
  if (build_ != this_build) hashes_.clear();
  build_ = this_build;
  const auto stored = hashes_.find({name, instructionLevel()});
  if (stored != hashes_.end() && stored->second != bits.hash)
    std::erase_if(hashes_, [&](const auto& entry) { return entry.first.first == name; });
  hashes_[{name, instructionLevel()}] = bits.hash;
  return fmt::format("stored {:016x}", bits.hash);
}

void StoredHashes::write() const {
  std::ostringstream stream;
  stream << "# The bits of the last state of each case, by instruction set: positions and velocities, as `stroma run`\n"
            "# prints them. Written by `stroma regress LIST --bits --update`; only the same build can be expected to\n"
            "# reproduce them.\n"
         << "build " << build_ << '\n';
  for (const auto& [key, hash] : hashes_) stream << fmt::format("{} {} {:016x}\n", key.first, key.second, hash);
  writeWholeFile(file_, stream.str());
}

}  // namespace stroma::command
