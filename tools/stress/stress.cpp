// SPDX-License-Identifier: LGPL-2.1-or-later
// The module's door: the story of a campaign.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <limits>

#include "framework/scene/abi.h"
#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/session/children.h"
#include "tools/session/file_uses.h"
#include "tools/session/session.h"
#include "tools/session/told_line.h"
#include "tools/stress/case_run.h"
#include "tools/stress/record.h"
#include "tools/stress/table.h"
#include "tools/sweep/digest.h"
#include "tools/sweep/process.h"

namespace stroma::stress {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
constexpr int by_signal = 128;          // of an exit code
constexpr double longest_first = 3600;  // s, of the undisturbed run
constexpr const char* record_file = "/cases.jsonl";

/// Many steps of what is small, a few of what is large: the same on every machine.
long stepsFor(const Simulation& simulation) {
  Index rows = 0;
  for (const State* state : simulation.states()) rows += state->size();
  return std::clamp<long>(40L * 3000 / std::max<long>(rows, 1), 6, 40);
}

std::string packed(const Undisturbed& run) {
  Json json{{"failure", run.failure}, {"doubts", run.doubts}, {"hash", run.hash}, {"seconds", run.seconds}};
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  text.append(reinterpret_cast<const char*>(run.positions.data()), run.positions.size() * sizeof(double));
  return text;
}
Undisturbed unpacked(const std::string& text) {
  const auto line = text.find('\n');
  const Json json = Json::parse(text.substr(0, line));
  Undisturbed run;
  run.failure = json.at("failure").get<std::string>();
  run.doubts = json.at("doubts").get<std::vector<std::string>>();
  run.hash = json.at("hash").get<std::uint64_t>();
  run.seconds = json.at("seconds").get<double>();
  run.positions.resize((text.size() - line - 1) / sizeof(double));
  std::memcpy(run.positions.data(), text.data() + line + 1, run.positions.size() * sizeof(double));
  return run;
}

std::string outcomeText(const Outcome& outcome) {
  return toJson(outcome).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Outcome outcomeOf(const ChildEnd& end, Kind kind) {
  if (end.failure.empty()) return outcomeFrom(Json::parse(end.text));
  Outcome outcome;
  // neither makes a scene slow that was quick: it does not end
  const bool hangs = end.is_late && (kind == Kind::memory || kind == Kind::threads);
  outcome.ending = end.is_late && !hangs ? Ending::unfinished : Ending::breaks;
  outcome.sentences = {(hangs ? "it does not end: " : "") + end.failure};
  return outcome;
}

class Campaign {
 public:
  explicit Campaign(const StressRequest& request) : request_(request) {
    for (const std::string& module : request.modules) session_.modules().open(module);
    session_.setOverrides(request.overrides);
    const Simulation& simulation = session_.load(request.scene);
    scenery_ = {request.scene, request.overrides, request.modules, request.steps.value_or(stepsFor(simulation))};
    list_.emplace(simulation, request.seed);
    std::vector<std::string> inputs;
    for (const FileUse& input : inputsOf(simulation.scene())) inputs.push_back(input.path);
    key_ = sweep::digestOfBuild(request.program, request.modules) + " " + sweep::digestOfFiles(inputs) +
           fmt::format(" {} {} {}", request.seed, scenery_.steps, request.scene);
    for (const Override& one : request.overrides) key_ += fmt::format(" {}.{}={}", one.path, one.attribute, one.value);
    session_.unload();
  }

  int make(const sweep::SignalGuard& signals) {
    if (request_.only && (*request_.only < 1)) throw std::invalid_argument("--case: cases are counted from 1");
    if (const int signal = runFirst(signals)) return by_signal + signal;
    if (!undisturbed_.failure.empty()) {
      fmt::print(stderr, "the scene has no result as it is: {}\n", undisturbed_.failure);
      return 3;
    }
    if (request_.only) return tellOne(signals);
    Record record(request_.folder + record_file, sweep::digestOf(key_));
    const int signal = runAll(record, signals);
    return tell(record, signal);
  }

 private:
  /// The undisturbed run, in a child too: it may crash.
  int runFirst(const sweep::SignalGuard& signals) {
    Children children;
    children.start(0, longest_first, [&] {
      try {
        return packed(runUndisturbed(scenery_));
      } catch (const std::exception& error) {
        Undisturbed none;
        none.failure = error.what();
        return packed(none);
      }
    });
    for (ChildEnd end; children.running() > 0;) {
      if (const int signal = signals.wait(0)) return signal;
      if (!children.wait(end)) continue;
      if (end.failure.empty())
        undisturbed_ = unpacked(end.text);
      else
        undisturbed_.failure = end.failure;
    }
    // of wall time beside others; a hundred times what the scene takes is no slow case but a lost one
    limit_ = std::clamp(100 * undisturbed_.seconds, 20., 900.);
    return 0;
  }

  std::function<std::string()> workOf(const Case& what) const {
    return [this, what] { return outcomeText(runCase(scenery_, what, undisturbed_)); };
  }

  long last() const {
    if (request_.cases) return *request_.cases;
    return request_.goes_on ? std::numeric_limits<long>::max() : list_->size();
  }

  int runAll(Record& record, const sweep::SignalGuard& signals) {
    const auto end_of_time = Clock::now() + std::chrono::milliseconds(long(request_.seconds * 1000));
    Children children;
    long next = 1;
    ToldLine line;
    const auto told = [&] {
      if (!request_.quiet && line.isOnTerminal())
        line.tell(fmt::format("{} cases, {} at work", record.made().size(), children.running()));
    };
    for (;;) {
      while (next <= last() && int(children.running()) < request_.jobs && Clock::now() < end_of_time) {
        if (!record.made().contains(next)) children.start(next, limit_, workOf(list_->at(next)));
        ++next;
      }
      if (children.running() == 0) break;
      if (const int signal = signals.wait(0)) return signal;
      ChildEnd end;
      if (!children.wait(end)) continue;
      record.add(end.number, outcomeOf(end, list_->at(end.number).kind));
      told();
    }
    return 0;
  }

  int tellOne(const sweep::SignalGuard& signals) {
    const Case what = list_->at(*request_.only);
    Children children;
    children.start(what.number, limit_, workOf(what));
    ChildEnd end;
    while (!children.wait(end))
      if (const int signal = signals.wait(0)) return by_signal + signal;
    const Outcome outcome = outcomeOf(end, what.kind);
    Json json{{"case", what.number}, {"group", what.group}, {"text", what.text}};
    json.update(toJson(outcome));
    const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (request_.json_file == "-") {
      fmt::print("{}", text);
    } else {
      if (!request_.json_file.empty()) writeWholeFile(request_.json_file, text);
      fmt::print("case {}: {}\n{} after {} of {} steps", what.number, what.text, wordOf(outcome.ending), outcome.steps,
                 scenery_.steps);
      if (outcome.distance >= 0) fmt::print(", {:.3g} sizes from the undisturbed run", outcome.distance);
      fmt::print("\n");
      for (const std::string& sentence : outcome.sentences) fmt::print("{}\n", sentence);
      if (what.override)
        fmt::print("by hand: stroma run {} -n {}{}\n", quoted(request_.scene), scenery_.steps,
                   optionsOf(request_, {*what.override}));
      else if (what.kind == Kind::threads)
        fmt::print("by hand: stroma run {} -n {} --threads {}{}\n", quoted(request_.scene), scenery_.steps, what.amount,
                   optionsOf(request_, {}));
    }
    return outcome.ending == Ending::breaks ? 1 : 0;
  }

  int tell(const Record& record, int signal) {
    Findings findings{request_, scenery_.steps, 0, {}, undisturbed_.doubts};
    for (const auto& [number, outcome] : record.made())
      if (number <= last()) findings.results.push_back({list_->at(number), outcome});
    if (!request_.goes_on) findings.open = last() - long(findings.results.size());
    const std::string json = jsonOf(findings).dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
    writeWholeFile(request_.folder + "/stress.json", json);
    writeWholeFile(request_.folder + "/stress.html", pageOf(findings));
    if (request_.json_file == "-")
      fmt::print("{}", json);
    else if (!request_.json_file.empty())
      writeWholeFile(request_.json_file, json);
    if (request_.json_file != "-") {
      for (const std::string& doubt : findings.doubts) fmt::print("the undisturbed run is in doubt: {}\n", doubt);
      fmt::print("{}\n{} cases of {} steps, seed {}; --case N --seed {} repeats one alone\n", tableOf(findings),
                 findings.results.size(), scenery_.steps, request_.seed, request_.seed);
      if (findings.open > 0)
        fmt::print("{} cases of the list are open: the same command goes on with them\n", findings.open);
      fmt::print("{}: stress.html stress.json\n", request_.folder);
    }
    if (signal) return by_signal + signal;
    return findings.count(Ending::breaks) > 0 ? 1 : 0;
  }

  const StressRequest& request_;
  Session session_;  ///< its modules are open for all cases
  Scenery scenery_;
  std::optional<CaseList> list_;
  std::string key_;
  Undisturbed undisturbed_;
  double limit_ = 0;
};

class LocalStresser final : public Stresser {
 public:
  int stress(const StressRequest& request) const override {
    const sweep::SignalGuard signals;
    return Campaign(request).make(signals);
  }
};

}  // namespace
}  // namespace stroma::stress

extern "C" __attribute__((visibility("default"))) const stroma::ServiceInfo* stroma_service() {
  static const stroma::ServiceInfo info{
      STROMA_ABI, stroma::stress::Stresser::role,
      []() -> void* { return static_cast<stroma::stress::Stresser*>(new stroma::stress::LocalStresser); }};
  return &info;
}
