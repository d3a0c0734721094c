// SPDX-License-Identifier: LGPL-2.1-or-later
// Shares of a sweep on other machines. GNU parallel or Slurm starts them, each by the same script; this process waits.
#pragma once
#include <string>
#include <vector>

#include "tools/sweep/sweeper.h"

namespace stroma::sweep {

class Engine {
 public:
  /// Of `request.engine`, which is not empty and outlives this. Throws std::invalid_argument when its program is not installed.
  explicit Engine(const SweepRequest& request);
  /// Into how many shares so many configurations are divided.
  int sharesOf(std::size_t configurations) const;
  /// How it ended: its exit code, and SIGINT or SIGTERM when that stopped this process.
  struct End {
    int exit_code = 0, signal = 0;
  };
  /// Makes these shares of `shares`, and waits until the last has ended. Throws OutputError and std::runtime_error.
  End run(const std::vector<int>& open, int shares) const;
  /// The last sentence that it, or else this share, has left behind; empty when nobody has.
  std::string sentence(int share) const;

 private:
  std::string fileOf(const std::string& name) const;
  void writeScript(int shares) const;
  std::vector<std::string> parallelWords(const std::vector<int>& open) const;
  std::vector<std::string> slurmWords(const std::vector<int>& open) const;
  void stop(int process) const;

  const SweepRequest& request_;
  bool is_slurm_;
  std::string program_;   ///< absolute
  std::string job_name_;  ///< of Slurm's jobs
};

}  // namespace stroma::sweep
