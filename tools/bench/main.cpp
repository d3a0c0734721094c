// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma-bench: measures the machine and Stroma in one run.
#include <fmt/format.h>

#include <cstdio>
#include <stdexcept>

#include "framework/scene/diagnostics.h"
#include "tools/bench/accuracy.h"
#include "tools/bench/body.h"
#include "tools/bench/figures.h"
#include "tools/bench/report.h"

namespace {

using namespace stroma::bench;

constexpr const char* help = "stroma-bench does the work of `stroma bench`: `stroma bench --help` lists the options\n";

class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Request {
  bool help = false, accuracy = false, list = false;
  std::string json_file;
  AccuracyRequest asked;  ///< with accuracy
  std::vector<std::string> passed_on{"stroma-bench", "--benchmark_repetitions=9", "--benchmark_min_time=0.05"};
  static constexpr std::size_t usual_options = 3;  ///< of these

  Request(int count, char** values) {
    const auto isOption = [](const std::string& word) { return word.rfind("--", 0) == 0; };
    for (int i = 1; i < count; ++i) {
      std::string word = values[i], value;
      const auto equal = word.find('=');
      const bool own = word.rfind("--benchmark", 0) != 0;
      if (own && equal != std::string::npos) value = word.substr(equal + 1), word.resize(equal);
      const auto argument = [&] {
        if (equal == std::string::npos && i + 1 < count && !isOption(values[i + 1])) value = values[++i];
        if (value.empty()) throw UsageError(fmt::format("{} needs a value", word));
        return value;
      };
      if (word == "--help" || word == "-h")
        help = true;
      else if (word == "--accuracy")
        accuracy = true, asked.problem = value;
      else if (word == "--json")
        json_file = argument();
      else if (word == "--csv")
        asked.csv_file = argument();
      else if (word == "--against")
        asked.stored_file = argument();
      else if (word == "--beads")
        asked.beads = argument();
      else if (word == "--scenes")
        setSceneFolder(argument());
      else if (own)
        throw UsageError(fmt::format("there is no option '{}'; --help lists them", word));
      else
        passed_on.push_back(word);
      list = list || word.rfind("--benchmark_list_tests", 0) == 0;
    }
    if (!asked.csv_file.empty() && !accuracy) throw UsageError("--csv goes with --accuracy");
    if (!asked.stored_file.empty() && !accuracy) throw UsageError("--against goes with --accuracy");
    if (!asked.beads.empty() && !accuracy) throw UsageError("--beads goes with --accuracy");
    if (accuracy) readRepetitions();
  }

 private:
  /// The one option of Google Benchmark that means something with --accuracy too.
  void readRepetitions() {
    const std::string name = "--benchmark_repetitions=";
    for (std::size_t i = usual_options; i < passed_on.size(); ++i) {
      const std::string& word = passed_on[i];
      const std::string number = word.rfind(name, 0) == 0 ? word.substr(name.size()) : "";
      if (number.empty()) throw UsageError(fmt::format("{} does not go with --accuracy", word));
      if (number.size() > 6 || number.find_first_not_of("0123456789") != std::string::npos || std::stoi(number) < 1)
        throw UsageError(fmt::format("{}: expected a number of repetitions from 1 on", word));
      asked.repetitions = std::stoi(number);
    }
  }
};

void measure(Request& request) {
  std::vector<char*> arguments;
  for (std::string& word : request.passed_on) arguments.push_back(word.data());
  int count = int(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (count > 1) throw UsageError(fmt::format("Google Benchmark has no option '{}'", arguments[1]));

  Catalogue catalogue;
  addKernelFigures(catalogue);
  addHexahedronFigures(catalogue);
  addQuadraticFigures(catalogue);
  addThreadFigures(catalogue);
  addStepFigures(catalogue);
  addShapeMemoryFigures(catalogue);
  addFrameFigures(catalogue);
  addHyperelasticFigures(catalogue);
  addStartFigures(catalogue);
  Collector collector(catalogue);
  if (request.list) {
    benchmark::RunSpecifiedBenchmarks(&collector);
    return;
  }
#ifndef NDEBUG
  fmt::print(stderr, "this build is not optimised: the figures say nothing\n");
#endif
  const Machine machine = measureMachine();
  printMachine(machine);
  if (benchmark::RunSpecifiedBenchmarks(&collector) == 0) throw UsageError("no figure matches the filter");
  printTable(catalogue, machine);
  if (!request.json_file.empty()) writeJson(request.json_file, catalogue, machine);
}

}  // namespace

int main(int count, char** values) {
  try {
    Request request(count, values);
    if (request.help) {
      fmt::print("{}", help);
    } else if (request.accuracy) {
      compareAccuracy(request.asked);
    } else {
      measure(request);
    }
    return 0;
  } catch (const stroma::SceneError& error) {
    fmt::print(stderr, "{}\n", error.diagnostics().text());
  } catch (const std::exception& error) {
    fmt::print(stderr, "stroma bench: {}\n", error.what());
  }
  return 2;
}
