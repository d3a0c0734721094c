// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/run_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "framework/scene/output_file.h"
#include "tools/sweep/cores.h"

namespace stroma::sweep {
namespace {

/// A run that somebody or something kills is made again so often.
constexpr int most_attempts = 3;

/// Whether the log says that the scene was refused. Want of memory or of room on the disk passes.
bool namesError(const std::string& log_file) {
  std::ifstream stream(log_file);
  for (std::string line; std::getline(stream, line);)
    if (line.find(": error: ") != std::string::npos) return true;
  return false;
}

/// Whether the same run would end like this again.
bool isWhole(const ProcessEnd& end, const std::string& log_file) {
  if (end.signal != 0) return false;
  return end.exit_code == 0 || end.exit_code == 3 || (end.exit_code == 2 && namesError(log_file));
}

}  // namespace

RunMaker::RunMaker(const SweepRequest& request, const std::vector<Axis>& axes, const ErrorMeasure& measure)
    : request_(request), measure_(measure), scheduler_(physicalCores(), request.jobs), progress_(axes, request.quiet) {}

Job RunMaker::jobFor(std::size_t number, const Entry& entry, int repetition) const {
  const Configuration& configuration = entry.configuration;
  Job job;
  job.number = number, job.repetition = repetition;
  job.cores = configuration.threads, job.timed = isTimed(entry);
  std::vector<std::string> words = runArguments(request_, configuration);
  words.insert(words.begin(), request_.program);
  words.insert(words.end(),
               {"--quiet", "--no-record", fmt::format("--json={}/{}.json", configuration.folder, repetition),
                "--measure", endFile(configuration.folder)});
  if (measure_.asksRun()) words.insert(words.end(), {"--measure-value", measure_.quantity});
  // names of files are those that the user's own command would have
  job.process = silentProgram(words, std::filesystem::current_path().string(),
                              fmt::format("{}/{}.log", configuration.folder, repetition));
  return job;
}

void RunMaker::take(Entry& entry, const Job& job, const ProcessEnd& end, const Circumstances& circumstances) {
  const std::string& folder = entry.configuration.folder;
  std::string outcome;
  if (isWhole(end, job.process.errors)) {
    writeOutcome(folder, job, end, circumstances);
    ++made_;
    entry.runs = readRuns(folder);
    outcome = entry.runs.outcome;
  } else {
    const std::string how = end.signal ? fmt::format("killed by signal {} ({})", end.signal, strsignal(end.signal))
                                       : fmt::format("ended with exit code {}", end.exit_code);
    outcome = how;
    if (++killed_[entry.configuration.key] < most_attempts) {
      scheduler_.add(job);
      progress_.expect(entry.configuration);
    } else {
      const std::string sentence = sentenceIn(job.process.errors);
      entry.runs.outcome = end.signal ? "killed" : "failed";
      entry.runs.failure = fmt::format("the run {}{} {} times{}", end.signal ? "was " : "", how, most_attempts,
                                       sentence.empty() ? "" : ": " + sentence);
    }
  }
  progress_.finished(entry.configuration, outcome, circumstances.seconds);
}

bool RunMaker::isOpen(Entry& entry) const {
  entry.runs = readRuns(entry.configuration.folder);
  return !entry.runs.areComplete(wanted(entry));
}

int RunMaker::make(const std::vector<Entry*>& entries) {
  std::vector<std::size_t> order(entries.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937 random(request_.seed);
  int most = 1;
  for (Entry* entry : entries) {
    makeFolderOf(outcomeFile(entry->configuration.folder, 1));
    entry->runs = readRuns(entry->configuration.folder);
    most = std::max(most, wanted(*entry));
    for (int k = int(entry->runs.repetitions.size()); k < wanted(*entry) && !entry->runs.areComplete(wanted(*entry));
         ++k)
      progress_.expect(entry->configuration);
  }
  for (int k = 1; k <= most; ++k) {
    std::ranges::shuffle(order, random);
    for (const std::size_t i : order) {
      const Entry& entry = *entries[i];
      if (k <= wanted(entry) && entry.runs.failure.empty() && int(entry.runs.repetitions.size()) == k - 1)
        scheduler_.add(jobFor(i, entry, k));
    }
    const int signal =
        scheduler_.run([&](const Job& job, const ProcessEnd& end,
                           const Circumstances& circumstances) { take(*entries[job.number], job, end, circumstances); },
                       [&] { progress_.draw(scheduler_); });
    progress_.leaveLine();
    if (signal) return signal;
  }
  return 0;
}

}  // namespace stroma::sweep
