// SPDX-License-Identifier: LGPL-2.1-or-later
// The role of the module that compares configurations of a scene. It is in a library of its own, which only `stroma sweep`
// opens.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace stroma::sweep {

/// The environment variable of a share that an engine has started.
inline constexpr char share_of_engine[] = "STROMA_SHARE_OF_ENGINE";

/// What the user asked for, as it was written.
struct SweepRequest {
  std::string program;                 ///< the command that makes the runs
  std::string scene, folder;           ///< absolute
  std::vector<std::string> vary, zip;  ///< "PATH.ATTR=a,b,c"; zip: several of these with ";" between them
  std::vector<std::string> settings;   ///< --set of all runs
  std::vector<std::string> modules;    ///< --module of all runs
  std::optional<long> steps;
  std::optional<double> until;  ///< [s]
  int threads = 1;
  std::string error = "l2", reference = "finest";
  std::vector<std::string> reference_settings;  ///< of one more run, which is the reference
  std::string goal;                             ///< "error<1%", or empty: the whole grid
  int repeat = 3;                               ///< runs of each configuration
  int jobs = 0;                                 ///< cores for timed runs; 0: half of them
  bool timed = true;
  unsigned seed = 1;  ///< of the order of the runs
  int share = 0, shares = 0;  ///< the runs of this share, from 1, of so many, and no report; 0: all
  std::string engine;         ///< "parallel" or "slurm" makes the runs by shares elsewhere; empty: this process does
  std::string logins;         ///< of parallel, with commas between them; empty: this machine
  std::string engine_options; ///< more words for it
  int engine_shares = 0;      ///< 0: it chooses
  bool quiet = false;
  std::vector<std::string> words;  ///< the command's arguments as they were given, for the report
};

class Sweeper {
 public:
  static constexpr const char *role = "sweeper", *library = "sweep", *missing = "build it with `ninja sweep`";
  virtual ~Sweeper() = default;
  /// Makes the runs that are not there yet, writes the tables and the report; of a share the runs only. Returns an exit code
  /// of the command: 0, 1 (no configuration reaches the goal), 3 (no run has a result), 4 (an engine has left runs open), 130 or
  /// 143 (stopped). Throws
  /// std::invalid_argument with a sentence for bad input, before anything is run, and OutputError.
  virtual int sweep(const SweepRequest& request) const = 0;
};

}  // namespace stroma::sweep
