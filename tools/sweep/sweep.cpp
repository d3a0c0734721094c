// SPDX-License-Identifier: LGPL-2.1-or-later
// The module's door: the story of a sweep.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <list>
#include <map>
#include <set>

#include "framework/scene/abi.h"
#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/sweep/digest.h"
#include "tools/sweep/engine.h"
#include "tools/sweep/goal.h"
#include "tools/sweep/probe.h"
#include "tools/sweep/report.h"
#include "tools/sweep/results_text.h"
#include "tools/sweep/run_maker.h"

namespace stroma::sweep {
namespace {

namespace fs = std::filesystem;

/// A file of a folder that a sweep has for itself (LOCK_EX), or with others (LOCK_SH); `kind` as for flock().
class FileLock {
 public:
  FileLock(const std::string& folder, const std::string& name, int kind) {
    const std::string file = folder + "/" + name;
    makeFolderOf(file);
    descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) throw OutputError(file, "cannot open", errno);
    struct stat status {};
    const bool has_lock = flock(descriptor_, kind) == 0;
    // a sweep that was refused may have removed the file between open() and flock()
    if (!has_lock || fstat(descriptor_, &status) != 0 || status.st_nlink == 0) {
      close(descriptor_);
      throw std::invalid_argument(fmt::format("another sweep works in {}: wait for it, or give another -o", folder));
    }
  }
  FileLock(const FileLock&) = delete;
  ~FileLock() { close(descriptor_); }

 private:
  int descriptor_;
};

/// Two sweeps in one folder would make the same runs twice. Shares of one sweep work beside each other, but not beside those
/// of another number of shares.
class FolderLock {
 public:
  explicit FolderLock(const SweepRequest& request) {
    const std::string& folder = request.folder;
    if (request.shares == 0) {
      locks_.emplace_back(folder, ".lock", LOCK_EX | LOCK_NB);
      return;
    }
    const FileLock door(folder, ".lock.door", LOCK_EX);  // one after the other
    const std::string all = ".lock.of_", ours = all + std::to_string(request.shares);
    locks_.emplace_back(folder, ".lock", LOCK_SH | LOCK_NB);
    locks_.emplace_back(folder, ours, LOCK_SH | LOCK_NB);
    locks_.emplace_back(folder, fmt::format(".lock.{}_of_{}", request.share, request.shares), LOCK_EX | LOCK_NB);
    for (const auto& file : fs::directory_iterator(folder))
      if (const std::string name = file.path().filename().string(); name.starts_with(all) && name != ours)
        FileLock(folder, name, LOCK_EX | LOCK_NB);  // nobody has it
  }

 private:
  std::list<FileLock> locks_;
};

/// Whether the folder has nothing but locks.
bool isEmpty(const std::string& folder) {
  const fs::directory_iterator files(folder);
  return std::all_of(fs::begin(files), fs::end(files),
                     [](const auto& file) { return file.path().filename().string().starts_with(".lock"); });
}

constexpr int by_signal = 128, left_open = 4;  // of an exit code

class Sweep {
 public:
  explicit Sweep(const SweepRequest& request)
      : request_(request),
        axes_(parseAxes(request.vary, request.zip)),
        bound_(request.goal.empty() ? 0 : parseGoal(request.goal)) {
    if (bound_ > 0 && !request.timed) throw std::invalid_argument("--goal looks for the cheapest: it needs the times");
    if (bound_ > 0 && (request.shares > 0 || !request.engine.empty()))
      throw std::invalid_argument(
          fmt::format("--goal chooses each run by the errors of those before it: it has no shares, leave --{} out",
                      request.shares > 0 ? "shard" : "engine"));
    const ErrorMeasure measure = ErrorMeasure::parse(request.error);
    allConfigurations(request, axes_);  // what it refuses comes before anything is loaded
    probed_ = probe(request, axes_, measure);
    assessor_.emplace(request_, axes_);
    makeEntries();
    runs_.emplace(request_, axes_, assessor_->measure());
  }

  int make() {
    if (request_.shares > 0) return makeShare();
    if (!request_.quiet) fmt::print(stderr, "{} configurations in {}\n", entries_.size(), request_.folder);
    const int signal = bound_ > 0 ? search() : makeAll();
    if (!request_.quiet && signal == 0) fmt::print(stderr, "{} runs made, the others were there\n", runs_->made());
    if (bound_ <= 0 || signal) assessment_ = assessor_->assess(entries_);
    noteMachines();
    return tell(signal);
  }

  /// Has the runs made by shares elsewhere, until none is open. Returns an exit code of the command when some are, else 0.
  int makeBy(const Engine& engine) {
    constexpr int most_rounds = 3;
    const int shares = engine.sharesOf(entries_.size());
    Engine::End end;
    std::vector<int> open = openShares(shares);
    long count = open_, before = count + 1;  // a round that has made nothing is the last
    for (int round = 0; round < most_rounds && count > 0 && count < before && end.signal == 0; ++round) {
      if (!request_.quiet)
        fmt::print(stderr, "{} of {} configurations are open: {} shares by {}\n", count, entries_.size(), open.size(),
                   request_.engine);
      end = engine.run(open, shares);
      before = count;
      open = openShares(shares);
      count = open_;
    }
    if (count == 0) return 0;
    if (end.signal) {
      fmt::print(stderr, "stopped: {} configurations are open; the same command goes on with them\n", count);
      return by_signal + end.signal;
    }
    const std::string sentence = engine.sentence(open.front());
    fmt::print(stderr,
               "{} configurations are open after {} (exit code {}; engine.log and share_*.log in {}){}\n"
               "The same command goes on with them; without --engine they are made here.\n",
               count, request_.engine, end.exit_code, request_.folder, sentence.empty() ? "" : ": " + sentence);
    return left_open;
  }

 private:
  void makeEntries() {
    build_ = digestOfBuild(request_.program, request_.modules);
    scene_ = digestOfFiles({probed_.inputs.begin(), probed_.inputs.end()});
    std::map<Probed::Files, std::string> digests;  // many configurations read the same
    std::vector<Configuration> all = allConfigurations(request_, axes_);
    if (!request_.reference_settings.empty()) all.push_back(extraReference(request_, axes_));
    for (Configuration& configuration : all) {
      const Probed::Files files = probed_.inputsWith(configuration.choice);
      std::string& digest = digests[files];
      if (digest.empty()) digest = digestOfFiles({files.begin(), files.end()});
      std::string text = build_ + "\n" + digest + "\n";
      for (const std::string& word : runArguments(request_, configuration)) text += word + "\n";
      if (assessor_->measure().asksRun()) text += assessor_->measure().quantity;
      configuration.key = digestOf(text);
      configuration.folder = (fs::path(request_.folder) / "runs" / configuration.key).string();
      const auto same = std::ranges::find(entries_, configuration.key, [](const Entry& entry) -> const std::string& {
        return entry.configuration.key;
      });
      if (same != entries_.end())
        throw std::invalid_argument(fmt::format("{} and {} are the same run: expected different values",
                                                nameOf(axes_, same->configuration), nameOf(axes_, configuration)));
      entries_.emplace_back().configuration = std::move(configuration);
    }
  }

  /// In the order of their keys, which has no pattern: every share has cheap runs and dear ones.
  std::vector<Entry*> inOrderOfKeys() {
    std::vector<Entry*> sorted;
    for (Entry& entry : entries_) sorted.push_back(&entry);
    std::ranges::sort(sorted, {}, [](const Entry* entry) { return entry->configuration.key; });
    return sorted;
  }

  /// The numbers of those with open configurations, which are counted.
  std::vector<int> openShares(int shares) {
    std::set<int> open;
    open_ = 0;
    const std::vector<Entry*> sorted = inOrderOfKeys();
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      if (!runs_->isOpen(*sorted[i])) continue;
      open.insert(int(i % std::size_t(shares)) + 1);
      ++open_;
    }
    return {open.begin(), open.end()};
  }

  int makeShare() {
    std::vector<Entry*> share;
    const std::vector<Entry*> sorted = inOrderOfKeys();
    for (std::size_t i = std::size_t(request_.share) - 1; i < sorted.size(); i += std::size_t(request_.shares))
      share.push_back(sorted[i]);
    const int signal = runs_->make(share);
    const auto open = std::ranges::count_if(share, [](const Entry* entry) { return entry->runs.outcome == "not run"; });
    for (const Entry* entry : share)
      if (!entry->runs.failure.empty())
        fmt::print("without a result: {}: {}\n", nameOf(axes_, entry->configuration), entry->runs.failure);
    fmt::print("share {} of {}: {} of {} configurations, {} runs made; the command without --shard gathers all\n",
               request_.share, request_.shares, share.size(), entries_.size(), runs_->made());
    if (signal) fmt::print(stderr, "stopped: {} configurations are open; the same command goes on with them\n", open);
    return signal ? by_signal + signal : 0;
  }

  /// Shares may have run on machines of several kinds.
  void noteMachines() {
    std::set<std::string> kinds;
    for (const Entry& entry : entries_)
      for (const Repetition& run : entry.runs.repetitions)
        if (run.timed && run.exit_code == 0) kinds.insert(run.machine.substr(std::min(run.machine.size(), run.host.size() + 2)));
    if (kinds.size() > 1)
      assessment_.notes.push_back(fmt::format("runs were timed on {} kinds of machines, whose times do not compare: {}",
                                              kinds.size(), fmt::join(kinds, "; ")));
  }

  int makeAll() {
    std::vector<Entry*> all;
    for (Entry& entry : entries_) all.push_back(&entry);
    return runs_->make(all);
  }

  /// The finest of the grid, and along each ordered axis those that tell how well it is known.
  std::vector<Entry*> referenceRuns() {
    std::vector<Entry*> runs;
    if (entries_.back().configuration.isExtraReference()) runs.push_back(&entries_.back());
    if (!assessor_->needsRuns()) return runs;
    std::vector<std::size_t> finest;
    for (const Axis& axis : axes_) finest.push_back(axis.finest());
    runs.push_back(&entries_[indexOf(axes_, finest)]);
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      if (!axes_[a].isOrdered()) continue;
      std::vector<std::size_t> values(axes_[a].size());
      for (std::size_t k = 0; k < values.size(); ++k) values[k] = k;
      std::ranges::sort(values, [&](std::size_t one, std::size_t other) { return axes_[a].isFiner(one, other); });
      const std::size_t count = std::min<std::size_t>(values.size(), axes_[a].hasOrder() ? 3 : 2);
      for (std::size_t k = 1; k < count; ++k) {
        std::vector<std::size_t> choice = finest;
        choice[a] = values[k];
        runs.push_back(&entries_[indexOf(axes_, choice)]);
      }
    }
    return runs;
  }

  int search() {
    std::vector<Entry*> wave = referenceRuns();
    std::vector<std::size_t> cheapest;
    for (;;) {
      if (const int signal = wave.empty() ? 0 : runs_->make(wave)) return signal;
      assessment_ = assessor_->assess(entries_);
      // a run may change the reference, and with it every error: recomputes all
      GoalSearch search(axes_, bound_);
      for (const Entry& entry : entries_)
        if (!entry.configuration.isExtraReference() && entry.runs.outcome != "not run")
          search.learn(entry.configuration.choice,
                       {entry.error.has_value(), entry.error.value_or(0), entry.runs.medianOf(&Repetition::seconds)});
      cheapest = search.cheapest();
      const std::vector<std::size_t> next = search.next();
      if (next.empty()) break;
      wave = {&entries_[indexOf(axes_, next)]};
    }
    if (!cheapest.empty()) cheapest_ = &entries_[indexOf(axes_, cheapest)];
    return 0;
  }

  std::string goalSentence() const {
    const Numbers numbers = assessment_.is_relative ? Numbers::share : Numbers::plain;
    const std::string assumed =
        "Assumed: a finer mesh, time step or tolerance, and more iterations, give no larger error and take no less "
        "time.";
    if (!cheapest_)
      return fmt::format("No configuration has an error below {}. {}", numberText(bound_, numbers), assumed);
    std::string text = fmt::format("The cheapest with an error below {}: {}, {}, error {}. {}",
                                   numberText(bound_, numbers), nameOf(axes_, cheapest_->configuration),
                                   numberText(cheapest_->runs.medianOf(&Repetition::seconds), Numbers::seconds),
                                   numberText(*cheapest_->error, numbers), assumed);
    if (*cheapest_->error + assessment_.uncertainty >= bound_ || assessment_.knowledge != Knowledge::whole)
      text += fmt::format(
          " This is not certain: of the reference itself {}, and with it the error may be above the bound. Give finer "
          "values, or --reference-set.",
          knownTo(assessment_, numberText(assessment_.uncertainty, numbers)));
    return text;
  }

  int tell(int signal) {
    std::size_t not_run = 0;
    if (bound_ > 0 || signal) {
      const auto isOpen = [](const Entry& entry) { return entry.runs.outcome == "not run"; };
      const Entry* const cheapest = cheapest_;
      const std::string key = cheapest ? cheapest->configuration.key : "";
      not_run = std::size_t(std::ranges::count_if(entries_, isOpen));
      std::erase_if(entries_, isOpen);
      cheapest_ = nullptr;
      for (const Entry& entry : entries_)
        if (!key.empty() && entry.configuration.key == key) cheapest_ = &entry;
    }
    Findings findings{request_, axes_, entries_, assessment_, build_, scene_, not_run, {}, cheapest_};
    if (bound_ > 0 && !signal) findings.goal = goalSentence();
    const Written written = writeReport(findings);
    if (signal) {
      fmt::print(stderr, "stopped: {} runs are open; the same command goes on with them\n", not_run);
      return by_signal + signal;
    }
    printSummary(findings, written);
    const bool any = std::ranges::any_of(entries_, [](const Entry& entry) { return entry.error.has_value(); });
    if (!any) return 3;
    return bound_ > 0 && !cheapest_ ? 1 : 0;
  }

  void printSummary(const Findings& findings, const Written& written) const {
    const Numbers numbers = assessment_.is_relative ? Numbers::share : Numbers::plain;
    const auto good = std::ranges::count_if(entries_, [](const Entry& entry) { return entry.error.has_value(); });
    fmt::print("{} configurations, {} with a result; reference: {}", entries_.size(), good, assessment_.reference);
    if (assessment_.isUncertain())
      fmt::print(", {}", knownTo(assessment_, numberText(assessment_.uncertainty, numbers)));
    fmt::print("\n");
    for (const std::string& note : assessment_.notes) fmt::print("note: {}\n", note);
    for (const Entry& entry : entries_)
      if (!entry.runs.failure.empty())
        fmt::print("without a result: {}: {}\n", nameOf(axes_, entry.configuration), entry.runs.failure);
    fmt::print("\n{}", resultsText(findings));
    if (!findings.goal.empty()) fmt::print("\n{}\n", findings.goal);
    if (cheapest_) fmt::print("\n  {}\n", commandLine(request_, cheapest_->configuration));
    for (const std::string& note : written.notes) fmt::print("note: {}\n", note);
    fmt::print("\n{}: {}\n", request_.folder, fmt::join(written.files, " "));
  }

  const SweepRequest& request_;
  std::vector<Axis> axes_;
  double bound_;
  Probed probed_;
  std::optional<Assessor> assessor_;
  std::optional<RunMaker> runs_;
  std::vector<Entry> entries_;
  Assessment assessment_;
  const Entry* cheapest_ = nullptr;
  std::string build_, scene_;
  long open_ = 0;  ///< of the last openShares()
};

class LocalSweeper final : public Sweeper {
 public:
  int sweep(const SweepRequest& request) const override {
    const SignalGuard signals;             // from here on: one that comes between two runs is taken at the next
    parseAxes(request.vary, request.zip);  // what is misspelt leaves no folder behind
    ErrorMeasure::parse(request.error);
    std::optional<Engine> engine;
    if (!request.engine.empty() && request.shares == 0) engine.emplace(request);
    const bool was_there = fs::exists(request.folder);
    std::optional<FolderLock> lock(std::in_place, request);
    // what another sweep has made meanwhile is not this one's to remove
    bool is_new = !was_there && isEmpty(request.folder);
    try {
      Sweep sweep(request);
      if (engine) {
        is_new = false;
        const FileLock one_engine(request.folder, ".lock.engine", LOCK_EX | LOCK_NB);
        lock.reset();  // shares have their own
        if (const int code = sweep.makeBy(*engine)) return code;
        lock.emplace(request);
      }
      return sweep.make();
    } catch (const std::invalid_argument&) {
      if (is_new) remove(request);
      throw;
    } catch (const Stopped& stopped) {
      if (is_new) remove(request);
      fmt::print(stderr, "stopped before the first run\n");
      return by_signal + stopped.signal;
    }
  }

 private:
  static void remove(const SweepRequest& request) {
    std::error_code none;
    if (request.shares == 0 || isEmpty(request.folder)) fs::remove_all(request.folder, none);
  }
};

}  // namespace
}  // namespace stroma::sweep

extern "C" __attribute__((visibility("default"))) const stroma::ServiceInfo* stroma_service() {
  static const stroma::ServiceInfo info{STROMA_ABI, stroma::sweep::Sweeper::role, []() -> void* {
                                          return static_cast<stroma::sweep::Sweeper*>(new stroma::sweep::LocalSweeper);
                                        }};
  return &info;
}
