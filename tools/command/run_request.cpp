// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/run_request.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "framework/scene/output_file.h"
#include "tools/command/default_recording.h"
#include "tools/command/recorder.h"
#include "tools/command/session.h"
#include "tools/session/file_uses.h"

namespace stroma::command {
namespace {

constexpr long default_steps = 100;

const Manual run_manual{
    "stroma run SCENE [options]",
    "Simulates a scene, a file of XML or one of Python with createScene(root): 100 steps unless -n or --until says otherwise.\n"
    "Progress and messages go to standard error,\n"
    "the summary to standard output. Ctrl-C, SIGTERM or SIGHUP ends the run with its last whole step, and a\n"
    "long step is given up; once more ends it at once. A reader of the output who goes early (`| head`) does not end "
    "it.\n\n"
    "A run leaves some twenty instants and a checkpoint in results/STEM/last, below the current folder, for\n"
    "`stroma view results/STEM/last`. The instants are kept in memory, and written every minute and at the end. The\n"
    "next run of a scene of that name replaces them. --no-record leaves nothing, --record DIR keeps what you name.\n\n"
    "--record leaves a checkpoint, DIR/last.checkpoint: every minute, and at the end. The same command with --resume\n"
    "goes on from it, or starts when there is none yet: after a crash, a kill, or Ctrl-C. --restart FILE goes on from\n"
    "any checkpoint; that of results/STEM/last is replaced when the run ends with a result. The run has the time, "
    "step\n"
    "number and bits of one that never stopped: -n and --until are those of the whole run, and the files of observers\n"
    "and recordings are continued where the checkpoint was written.\n\n"
    "--replay FILE does again, each before its step, what was done to a run of this scene while somebody looked on:\n"
    "nodes pulled and attributes changed. The bits are those of that run.\n\n"
    "Exit codes:\n"
    "  0    done\n"
    "  2    the scene or the options are wrong, or an output cannot be written; nothing was run\n"
    "  3    no result: a step diverged, statics found no equilibrium, or a position constraint did not hold. The last\n"
    "       state is in results/STEM/last, or DIR, with the elements that are inverted in it. With --strict also a\n"
    "       result in doubt: elements inside out, a body that burst, energy from nowhere. Also a run of which an "
    "action\n"
    "       of --replay was refused: the state before it is recorded and named\n"
    "  4    an output could not be written any more: the run ended; what the files have is whole up to there\n"
    "  129  ended by SIGHUP: the terminal was closed; what was recorded is complete\n"
    "  130  interrupted with Ctrl-C, likewise\n"
    "  143  ended by SIGTERM, likewise",
    "  stroma run liver.xml -n 200 && stroma view results/liver/last\n"
    "  stroma run liver.xml --until 2 --set /liver/fem.method=polar --record results/liver --record-every 10\n"
    "  stroma run liver.xml -n 5000 --record out --resume\n"
    "  stroma run liver.xml -n 800 --replay liver.actions\n"
    "  stroma run liver.xml -n 50 --json --quiet | python3 -m json.tool\n"};

}  // namespace

void addRunOptions(OptionList& options) {
  options.add_options()                                                                                               //
      ("steps,n", po::value<long>()->value_name("STEPS"), "number of steps; 0 loads, compiles and records t = 0")     //
      ("until", po::value<double>()->value_name("T"), "run to this time [s] instead")                                 //
      ("record", po::value<std::string>()->value_name("DIR"), "write positions and velocities of every state there")  //
      ("no-record", "write nothing to results/STEM/last, even if the run has no result")                            //
      ("record-every", po::value<long>()->value_name("K"),
       "record every K steps; the first and last instant always")  //
      ("checkpoint-seconds", po::value<double>()->value_name("S"),
       "write DIR/last.checkpoint, or that of results/STEM/last, every S seconds of wall time (by default 60; 0: only at the "
       "end)")  //
      ("checkpoint-every", po::value<long>()->value_name("K"), "write DIR/last.checkpoint every K steps too")  //
      ("resume", "continue from DIR/last.checkpoint if it exists")                                              //
      ("restart", po::value<std::string>()->value_name("FILE"), "continue from a checkpoint of this scene")       //
      ("replay", po::value<std::string>()->value_name("FILE"), "repeat the actions of this file")       //
      ("json", po::value<std::string>()->implicit_value("-")->value_name("FILE"),
       "print the summary as JSON; --json=FILE writes it to a file")  //
      ("profile", po::value<std::string>()->value_name("FILE"),
       "where the time goes: a table at the end, and a trace for https://ui.perfetto.dev")  //
      ("measure", po::value<std::string>()->value_name("FILE"),
       "as `stroma sweep` does: no exporter writes, and the shapes and cells of the end go to this file")  //
      ("measure-value", po::value<std::string>()->value_name("PATH.NAME[:NODES]"),
       "a quantity whose mean at the end goes to the file too")         //
      ("strict", "a result in doubt is none: the exit code is then 3")  //
      ("quiet,q", "no progress, no notes, no summary");
}

CommandLine runLine() {
  CommandLine line{run_manual, OptionList("options"), {"SCENE"}};
  addRunOptions(line.options);
  addSceneOptions(line.options);
  return line;
}

std::optional<Values> parseRunOptions(const Arguments& arguments) { return parseOptions(runLine(), arguments); }

RunRequest::RunRequest(const Values& values)
    : scene(required(values, "SCENE", run_manual)),
      quiet(values.count("quiet") > 0),
      strict(values.count("strict") > 0),
      resume(values.count("resume") > 0),
      no_record(values.count("no-record") > 0) {
  if (values.count("steps")) steps = values["steps"].as<long>();
  if (values.count("until")) until = values["until"].as<double>();
  if (values.count("record")) record_folder = values["record"].as<std::string>();
  if (values.count("json")) json_file = values["json"].as<std::string>();
  if (values.count("profile")) profile_file = values["profile"].as<std::string>();
  if (values.count("measure")) measure_file = values["measure"].as<std::string>();
  if (values.count("measure-value")) measured_quantity = values["measure-value"].as<std::string>();
  if (!measured_quantity.empty() && measure_file.empty()) throw UsageError("--measure-value needs --measure FILE");
  if (values.count("restart")) restart_file = values["restart"].as<std::string>();
  if (values.count("replay")) replay_file = values["replay"].as<std::string>();
  if (values.count("set")) overrides = values["set"].as<std::vector<std::string>>();
  if (values.count("module"))
    for (const std::string& file : values["module"].as<std::vector<std::string>>())
      modules.push_back(std::filesystem::absolute(file).string());
  if (recordsIn() && no_record) throw UsageError("--record and --no-record exclude each other");
  if (steps && until) throw UsageError("-n and --until exclude each other");
  if (steps && *steps < 0) throw UsageError(fmt::format("-n {}: expected 0 or more steps", *steps));
  if (resume && !restart_file.empty()) throw UsageError("--resume and --restart exclude each other");
  for (const char* option : {"record-every", "checkpoint-every", "resume"})
    if (values.count(option) && !recordsIn()) throw UsageError(fmt::format("--{} needs --record DIR", option));
  readInterval(values, "record-every", record_every);
  readInterval(values, "checkpoint-every", checkpoint_every);
  if (!values.count("checkpoint-seconds")) return;
  checkpoint_seconds = values["checkpoint-seconds"].as<double>();
  if (!(checkpoint_seconds >= 0) || !std::isfinite(checkpoint_seconds))
    throw UsageError(fmt::format("--checkpoint-seconds {}: expected 0 or more", checkpoint_seconds));
}

void RunRequest::readInterval(const Values& values, const std::string& option, long& interval) const {
  if (!values.count(option)) return;
  interval = values[option].as<long>();
  if (interval < 1) throw UsageError(fmt::format("--{} {}: expected 1 or more", option, interval));
}

long RunRequest::stepsOf(const Session& session) const {
  if (!until) return steps.value_or(default_steps);
  try {
    return session.simulation().steps() + session.stepsUntil(*until);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("--until {}: {}", *until, error.what()));
  }
}

std::string RunRequest::checkpointToGoOnFrom() const {
  if (!resume) return restart_file;
  const std::string last = (std::filesystem::path(record_folder) / "last.checkpoint").string();
  return std::filesystem::exists(last) ? last : "";
}

void checkOutputs(const RunRequest& request, const Simulation& simulation) {
  std::vector<FileUse> outputs;
  if (request.recordsIn())
    for (const std::string& file : recordedFiles(simulation, request.record_folder))
      outputs.push_back({file, "--record", file.ends_with(".checkpoint")});
  if (!request.json_file.empty() && request.json_file != "-") outputs.push_back({request.json_file, "--json", true});
  if (!request.profile_file.empty()) outputs.push_back({request.profile_file, "--profile", true});
  if (!request.measure_file.empty()) outputs.push_back({request.measure_file, "--measure", true});
  std::vector<FileUse> all = outputsOf(simulation);
  all.insert(all.end(), outputs.begin(), outputs.end());
  if (request.leavesLast())
    for (const std::string& file : lastFiles(request.scene))
      all.push_back({file, "what the run leaves to be looked at (--no-record leaves nothing)", true});
  std::vector<FileUse> inputs = inputsOf(simulation.scene());
  if (!request.replay_file.empty()) inputs.push_back({request.replay_file, "--replay"});
  if (const auto sentence = overwriting(all, inputs)) throw UsageError(*sentence);
  simulation.checkOutputs();
  for (const FileUse& output : outputs) checkWritable(output.path, output.is_replaced);
}

}  // namespace stroma::command
