// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/probe.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>

#include "framework/scene/output_file.h"
#include "tools/sweep/cores.h"
#include "tools/sweep/refinement.h"
#include "tools/sweep/scheduler.h"

namespace stroma::sweep {
namespace {

namespace fs = std::filesystem;

/// Removes a folder, whatever happens.
struct TemporaryFolder {
  fs::path path;
  explicit TemporaryFolder(fs::path folder) : path(std::move(folder)) { makeFolderOf((path / "file").string()); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code none;
    fs::remove_all(path, none);
  }
};

struct Trial {
  std::size_t axis = 0, value = 0;
  Configuration configuration;
  int exit_code = -1;
  std::string messages{};
  std::optional<EndState> end{};
};

/// The first value of all axes, then each other value of each axis with the first ones of the rest, then --reference-set.
std::vector<Trial> trialsOf(const SweepRequest& request, const std::vector<Axis>& axes) {
  std::vector<Trial> trials;
  const std::vector<std::size_t> first(axes.size(), 0);
  trials.push_back({0, 0, configurationOf(request, axes, first)});
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (std::size_t k = 1; k < axes[a].size(); ++k) {
      std::vector<std::size_t> choice = first;
      choice[a] = k;
      trials.push_back({a, k, configurationOf(request, axes, choice)});
    }
  if (!request.reference_settings.empty()) trials.push_back({axes.size(), 0, extraReference(request, axes)});
  return trials;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// Whether a message is about one of the settings itself, rather than about what they make of the scene together.
bool namesSetting(const Trial& trial) {
  return std::ranges::any_of(trial.configuration.settings, [&](const std::string& setting) {
    std::string attribute = setting.substr(0, setting.find('='));
    if (!attribute.starts_with('/')) attribute = "/." + attribute;
    return trial.messages.find("--set " + attribute + ": error") != std::string::npos;
  });
}

[[noreturn]] void refuse(const Trial& trial) {
  std::string text = replaced(trial.messages, "--set ", "--vary ");
  text = replaced(text, "stroma: ", "");
  while (text.ends_with('\n')) text.pop_back();
  throw std::invalid_argument(text.find("nothing was run") == std::string::npos ? text + "\nnothing was run" : text);
}

void runAll(const SweepRequest& request, const ErrorMeasure& measure, const fs::path& folder,
            std::vector<Trial>& trials) {
  SweepRequest only_load = request;
  only_load.steps = 0, only_load.until.reset();
  Scheduler scheduler(physicalCores(), 0);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    Job job;
    job.number = i, job.timed = false;
    const std::string end = (folder / fmt::format("{}.values", i)).string();
    std::vector<std::string> words = runArguments(only_load, trials[i].configuration);
    words.insert(words.begin(), request.program);
    words.insert(words.end(), {"--quiet", "--no-record", "--measure", end});
    if (measure.asksRun()) words.insert(words.end(), {"--measure-value", measure.quantity});
    job.process = silentProgram(words, fs::current_path().string(), (folder / fmt::format("{}.log", i)).string());
    scheduler.add(job);
  }
  const auto finished = [&](const Job& job, const ProcessEnd& ended, const Circumstances&) {
    Trial& trial = trials[job.number];
    trial.exit_code = ended.signal ? -1 : ended.exit_code;
    std::ifstream log(job.process.errors);
    trial.messages.assign(std::istreambuf_iterator<char>(log), {});
    const fs::path end = folder / fmt::format("{}.values", job.number);
    if (ended.exit_code == 0 && fs::exists(end)) trial.end = EndState::read(end.string());
  };
  if (const int signal = scheduler.run(finished, [] {})) throw Stopped{signal};
}

/// What the scene makes of the values tells what they are: a mesh when the spacing differs, a time step when dt does. A
/// value that the scene refuses has no size; it counts as coarser than all others, so that it stands for none of them.
void learnKinds(std::vector<Axis>& axes, const std::vector<Trial>& trials) {
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const double unknown = std::numeric_limits<double>::infinity();
    std::vector<double> spacings(axes[a].size(), unknown), steps(axes[a].size(), unknown);
    std::vector<Mat3> tensors(axes[a].size(), Mat3::Zero());
    for (std::size_t k = 0; k < axes[a].size(); ++k) {
      const auto found = k == 0 ? trials.begin() : std::ranges::find_if(trials, [&](const Trial& trial) {
        return trial.axis == a && trial.value == k;
      });
      if (!found->end) continue;
      spacings[k] = found->end->spacing(), steps[k] = found->end->dt;
      tensors[k] = spacingTensor(*found->end);
    }
    const Vec3 direction = mostRefined(tensors);
    for (std::size_t k = 0; k < spacings.size() && !direction.isZero(); ++k)
      if (!tensors[k].isZero()) spacings[k] = spacingAlong(tensors[k], direction);
    const auto differ = [&](const std::vector<double>& sizes) {
      std::set<double> known(sizes.begin(), sizes.end());
      known.erase(unknown);
      return known.size() > 1 &&
             known.size() ==
                 std::size_t(std::ranges::count_if(sizes, [](double size) { return std::isfinite(size); })) &&
             *known.begin() > 0;
    };
    if (differ(spacings))
      axes[a].kind = AxisKind::mesh, axes[a].sizes = spacings, axes[a].direction = direction;
    else if (differ(steps))
      axes[a].kind = AxisKind::time_step, axes[a].sizes = steps;
  }
}

/// A run whose last step would pass --until ends later than the others.
void checkSteps(const SweepRequest& request, const std::vector<Trial>& trials) {
  constexpr double tolerance = 1e-6;
  for (const Trial& trial : trials) {
    if (!trial.end || !(trial.end->dt > 0)) continue;
    const double steps = (*request.until - trial.end->time) / trial.end->dt;
    if (std::abs(steps - std::round(steps)) > tolerance * steps)
      throw std::invalid_argument(
          fmt::format("--until {:g} is {:.6g} steps of dt={:g}: expected a whole number, so that all runs end at one "
                      "time",
                      *request.until, steps, trial.end->dt));
  }
}

/// A measure that no run can have is refused now, and not after all of them.
void checkMeasure(const ErrorMeasure& measure, const std::vector<Trial>& trials) {
  if (measure.kind == ErrorMeasure::Kind::energy) return;
  std::optional<CommonPoints> points;
  for (const Trial& trial : trials) {
    if (!trial.end) continue;
    try {
      if (!points) points = measure.isField() ? CommonPoints(*trial.end) : CommonPoints();
      measure.valuesOf(*trial.end, {}, *points);
    } catch (const std::runtime_error& problem) {
      throw std::invalid_argument(fmt::format("--error {}: {}", measure.text, problem.what()));
    }
  }
}

/// The files of a value.
std::vector<std::vector<Probed::Files>> filesOfValues(const std::vector<Axis>& axes, const std::vector<Trial>& trials) {
  std::vector<std::vector<Probed::Files>> files;
  const auto take = [](const Trial& trial, Probed::Files& to) {
    if (trial.end) to.insert(trial.end->inputs.begin(), trial.end->inputs.end());
  };
  for (const Axis& axis : axes) {
    files.emplace_back(axis.size());
    take(trials.front(), files.back().front());
  }
  for (const Trial& trial : trials)
    if (trial.axis < axes.size() && trial.value > 0) take(trial, files[trial.axis][trial.value]);
  return files;
}

}  // namespace

Probed::Files Probed::inputsWith(const std::vector<std::size_t>& choice) const {
  if (choice.empty()) return of_reference.empty() ? inputs : of_reference;
  for (std::size_t a = 0; a < of_value.size(); ++a)
    if (of_value[a][choice[a]].empty()) return inputs;  // it may be borne with other values
  Files files;
  for (const std::string& file : inputs) {
    bool is_chosen = false, is_read = false;  // whether values decide on it, and whether one of these reads it
    for (std::size_t a = 0; a < of_value.size(); ++a) {
      const auto readers = std::size_t(std::ranges::count_if(of_value[a], [&](const Files& read) { return read.contains(file); }));
      const auto refused = std::size_t(std::ranges::count(of_value[a], Files{}));
      if (readers + refused == of_value[a].size()) continue;
      is_chosen = is_chosen || readers > 0;
      is_read = is_read || of_value[a][choice[a]].contains(file);
    }
    if (!is_chosen || is_read) files.insert(file);
  }
  return files;
}

Probed probe(const SweepRequest& request, std::vector<Axis>& axes, const ErrorMeasure& measure) {
  // shares work beside each other
  const std::string name = request.shares > 0 ? fmt::format("loading.{}_of_{}", request.share, request.shares) : "loading";
  const TemporaryFolder folder(fs::path(request.folder) / name);
  std::vector<Trial> trials = trialsOf(request, axes);
  runAll(request, measure, folder.path, trials);
  for (const Trial& trial : trials)
    if (trial.exit_code == 2 && (namesSetting(trial) || trial.axis == axes.size())) refuse(trial);
  if (std::ranges::none_of(trials, [](const Trial& trial) { return trial.end.has_value(); })) refuse(trials.front());
  checkMeasure(measure, trials);
  learnKinds(axes, trials);
  std::set<double> steps;
  Probed probed;
  probed.of_value = filesOfValues(axes, trials);
  for (const Trial& trial : trials) {
    if (!trial.end) continue;
    steps.insert(trial.end->dt);
    probed.inputs.insert(trial.end->inputs.begin(), trial.end->inputs.end());
    if (trial.axis == axes.size()) probed.of_reference.insert(trial.end->inputs.begin(), trial.end->inputs.end());
  }
  if (steps.size() > 1 && !request.until)
    throw std::invalid_argument("the time step varies: give --until T instead of -n, so that all runs end at one time");
  if (steps.size() > 1) checkSteps(request, trials);
  return probed;
}

}  // namespace stroma::sweep
