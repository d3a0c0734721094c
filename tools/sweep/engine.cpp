// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/engine.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "framework/scene/output_file.h"
#include "tools/platform/program_named.h"
#include "tools/sweep/configuration.h"
#include "tools/sweep/cores.h"
#include "tools/sweep/digest.h"
#include "tools/sweep/process.h"
#include "tools/sweep/run_folder.h"

namespace stroma::sweep {
namespace {

namespace fs = std::filesystem;

void addWords(std::vector<std::string>& words, const std::string& text) {
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
}

}  // namespace

Engine::Engine(const SweepRequest& request) : request_(request), is_slurm_(request.engine == "slurm") {
  const std::string name = is_slurm_ ? "sbatch" : "parallel";
  program_ = programNamed(name);
  if (program_.empty())
    throw std::invalid_argument(fmt::format("--engine {}: there is no program {} on the path: expected that of {}", request.engine,
                                            name, is_slurm_ ? "Slurm (package slurm-client)" : "GNU parallel (package parallel)"));
  job_name_ = "stroma_" + digestOf(fmt::format("{}\n{}\n{}", request.folder, hostName(), getpid()));
}

int Engine::sharesOf(std::size_t configurations) const {
  constexpr int for_a_machine = 4, for_a_cluster = 8;
  const auto machines = 1 + int(std::ranges::count(request_.logins, ','));
  const int usual = is_slurm_ ? for_a_cluster : for_a_machine * machines;
  const int wanted = request_.engine_shares > 0 ? request_.engine_shares : usual;
  return int(std::min<std::size_t>(std::size_t(wanted), configurations));
}

std::string Engine::fileOf(const std::string& name) const { return request_.folder + "/" + name; }

/// The command as it was given, with a share: what it is known by is then the same.
void Engine::writeScript(int shares) const {
  std::string command = quoted(request_.program) + " sweep";
  for (const std::string& word : request_.words) command += " " + quoted(word);
  writeWholeFile(fileOf("share.sh"),
                 fmt::format("#!/bin/sh\n"
                             "# Makes share $1 of {0} of the runs; in an array of Slurm that of its task.\n"
                             "share=${{1:-$SLURM_ARRAY_TASK_ID}}\n"
                             "exec >{1}/share_\"$share\".log 2>&1\n"
                             "cd {2} && {4}=1 exec {3} --shard \"$share/{0}\"\n",
                             shares, quoted(request_.folder), quoted(fs::current_path().string()), command, share_of_engine));
}

/// A share takes all cores of its machine, so that a machine has one at a time. Over there parallel starts $SHELL, which may be
/// unset or no shell of POSIX, unless it is told which.
std::vector<std::string> Engine::parallelWords(const std::vector<int>& open) const {
  std::vector<std::string> words{"/usr/bin/env", "PARALLEL_SHELL=/bin/sh", program_, "--will-cite", "--jobs", "1"};
  words.insert(words.end(), {"--retries", "3", "--joblog", fileOf("engine.joblog")});
  if (!request_.logins.empty()) words.insert(words.end(), {"--sshlogin", request_.logins});
  // nobody is there to be asked for a password
  if (!std::getenv("PARALLEL_SSH")) words.insert(words.end(), {"--ssh", "ssh -o BatchMode=yes"});
  addWords(words, request_.engine_options);
  // the script is an argument too: braces in its path would stand for something in the command
  words.insert(words.end(), {"sh {2} {1}", ":::"});
  for (const int share : open) words.push_back(std::to_string(share));
  words.insert(words.end(), {":::", fileOf("share.sh")});
  return words;
}

std::vector<std::string> Engine::slurmWords(const std::vector<int>& open) const {
  std::vector<std::string> words{program_, "--wait", "--requeue", "--output=/dev/null", "--job-name=" + job_name_};
  words.push_back(fmt::format("--array={}", fmt::join(open, ",")));
  addWords(words, request_.engine_options);
  words.push_back(fileOf("share.sh"));
  return words;
}

/// Parallel ends its shares on request; with Slurm the request goes to the shares themselves.
void Engine::stop(int process) const {
  if (!is_slurm_) {
    kill(process, SIGTERM);
    return;
  }
  const std::string cancel = programNamed("scancel");
  if (cancel.empty()) return;
  const pid_t canceller = start(silentProgram({cancel, "--name=" + job_name_}, request_.folder, fileOf("cancel.log")));
  ProcessEnd end;
  while (!hasEnded(canceller, end)) SignalGuard().wait(0.05);
}

Engine::End Engine::run(const std::vector<int>& open, int shares) const {
  const SignalGuard signals;
  constexpr double most_wait = 0.5;
  writeScript(shares);
  for (const int share : open) fs::remove(fileOf(fmt::format("share_{}.log", share)));  // what it said in an earlier round
  const pid_t process =
      start(silentProgram(is_slurm_ ? slurmWords(open) : parallelWords(open), request_.folder, fileOf("engine.log")));
  End end;
  ProcessEnd of_process;
  while (!hasEnded(process, of_process)) {
    const int signal = signals.wait(most_wait);
    if (signal == 0) continue;
    end.signal = signal;
    stop(process);
  }
  end.exit_code = of_process.signal ? 128 + of_process.signal : of_process.exit_code;
  return end;
}

/// What starts shares may have warned of much that is not the reason.
std::string Engine::sentence(int share) const {
  const std::string own = sentenceIn(fileOf(fmt::format("share_{}.log", share)));
  return own.empty() ? sentenceIn(fileOf("engine.log")) : own;
}

}  // namespace stroma::sweep
