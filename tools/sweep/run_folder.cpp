// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/run_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "framework/scene/output_file.h"
#include "tools/sweep/cores.h"

namespace stroma::sweep {
namespace {

using RunJson = nlohmann::json;
namespace fs = std::filesystem;

std::optional<RunJson> jsonIn(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) return {};
  RunJson json = RunJson::parse(stream, nullptr, false);
  if (json.is_discarded() || !json.is_object()) return {};
  return json;
}

std::string summaryFile(const std::string& folder, int repetition) {
  return fmt::format("{}/{}.json", folder, repetition);
}

Repetition repetitionOf(const RunJson& outcome, RunJson summary) {
  Repetition run;
  run.exit_code = outcome.value("exit_code", 0);
  run.process_seconds = outcome.value("process_seconds", 0.0);
  run.cpu_seconds = outcome.value("cpu_seconds", 0.0);
  run.others_seconds = outcome.value("others_seconds", 0.0);
  run.timed = outcome.value("timed", true);
  run.cores = outcome.value("cores", std::vector<int>{});
  run.beside = outcome.value("beside", 0);
  run.load = outcome.value("load_at_start", 0.0);
  run.host = outcome.value("host", "");
  run.machine = outcome.value("machine", run.host);
  run.seconds = summary.value("wall_seconds", 0.0);
  run.load_seconds = summary.value("load_seconds", 0.0);
  if (summary.contains("ms_per_step")) run.step_ms = summary["ms_per_step"].value("median", 0.0);
  run.summary = std::move(summary);
  return run;
}

std::vector<const Repetition*> thatCount(const std::vector<Repetition>& all) {
  std::vector<const Repetition*> runs;
  for (const Repetition& run : all)
    if (run.exit_code == 0 && run.timed) runs.push_back(&run);
  return runs;
}

std::vector<double> valuesOf(const std::vector<Repetition>& all, double Repetition::*value) {
  std::vector<double> values;
  for (const Repetition* run : thatCount(all)) values.push_back(run->*value);
  std::ranges::sort(values);
  return values;
}

}  // namespace

int Runs::untimed() const {
  return int(std::ranges::count_if(repetitions, [](const Repetition& run) { return !run.timed; }));
}

bool Runs::hasTimes() const { return !thatCount(repetitions).empty(); }

double Runs::medianOf(double Repetition::*value) const {
  const std::vector<double> values = valuesOf(repetitions, value);
  if (values.empty()) return 0;
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

double Runs::spreadOf(double Repetition::*value) const {
  const std::vector<double> values = valuesOf(repetitions, value);
  return values.empty() ? 0 : values.back() - values.front();
}

bool Runs::wereDisturbed() const {
  return std::ranges::any_of(thatCount(repetitions), [](const Repetition* run) { return run->wasDisturbed(); });
}

std::string outcomeFile(const std::string& folder, int repetition) {
  return fmt::format("{}/{}.outcome.json", folder, repetition);
}

std::string endFile(const std::string& folder) { return folder + "/end.values"; }

void writeOutcome(const std::string& folder, const Job& job, const ProcessEnd& end,
                  const Circumstances& circumstances) {
  nlohmann::ordered_json json;
  json["exit_code"] = end.exit_code;
  json["process_seconds"] = circumstances.seconds;
  json["cpu_seconds"] = end.cpu_seconds;
  json["others_seconds"] = circumstances.others_seconds;
  json["preemptions"] = end.preemptions;
  json["timed"] = job.timed;
  json["cores"] = circumstances.cores;
  json["beside"] = circumstances.beside;
  json["load_at_start"] = circumstances.load;
  json["host"] = hostName();
  json["machine"] = machineText();
  writeWholeFile(outcomeFile(folder, job.repetition), json.dump(2) + "\n");
}

std::string sentenceIn(const std::string& log_file) {
  std::ifstream stream(log_file);
  std::string last, error;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty()) continue;
    const bool is_summary = line.find("nothing was run") != std::string::npos;
    if (!is_summary) last = line;
    if (error.empty() && line.find("error: ") != std::string::npos) error = line;
  }
  return error.empty() ? last : error;
}

Runs readRuns(const std::string& folder) {
  Runs runs;
  for (int k = 1;; ++k) {
    const auto outcome = jsonIn(outcomeFile(folder, k));
    if (!outcome) break;
    const int code = outcome->value("exit_code", 0);
    auto summary = jsonIn(summaryFile(folder, k));
    const bool has_end = fs::exists(endFile(folder));
    if (code == 0 && (!summary || !has_end)) break;  // somebody has tidied up: made again
    runs.repetitions.push_back(repetitionOf(*outcome, summary.value_or(RunJson::object())));
    runs.outcome = code == 0   ? "done"
                   : code == 2 ? "refused"
                   : summary   ? summary->value("outcome", "failed")
                               : "failed";
    if (code == 0) continue;
    runs.failure = summary ? summary->value("reason", "") : "";
    if (runs.failure.empty()) runs.failure = sentenceIn(fmt::format("{}/{}.log", folder, k));
    if (runs.failure.empty()) runs.failure = fmt::format("the run ended with exit code {}", code);
    break;
  }
  return runs;
}

}  // namespace stroma::sweep
