// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/view_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "framework/scene/output_file.h"
#include "tools/command/recorder.h"
#include "tools/command/session.h"
#include "tools/session/file_uses.h"

namespace stroma::command {
namespace {

const Manual view_manual{
    "stroma view SCENE|FOLDER [options]",
    "Shows a scene in the browser while it runs: turn, cut and colour it, pull at it, change attributes, plot, "
    "record.\n"
    "A folder that `stroma run` left, or `stroma run --record` wrote, is shown as it was recorded. The address is "
    "printed; whoever has it sees the\n"
    "run, and nobody else. Only this machine can, unless --host says otherwise. Ctrl-C ends it.\n\n"
    "--export FILE.html makes a page that plays a run, or a recording, by itself, without a server, and ends.\n\n"
    "Exit codes:\n"
    "  0    done\n"
    "  2    the scene or the options are wrong, or an output cannot be written; nothing was run\n"
    "  3    no result: the run ended by itself, and nobody has reset it\n"
    "  4    an output could not be written any more; what the files have is whole up to there",
    "  stroma view scenes/examples/organ.xml\n"
    "  stroma view organ.xml --paused --set /organ/fem.youngModulus=3000 --record results/pulled\n"
    "  stroma view results/pulled\n"
    "  stroma view results/organ/last                what `stroma run organ.xml` has left\n"
    "  stroma run organ.xml -n 500 --replay results/pulled/run.actions       the same run without a browser\n"
    "  stroma view organ.xml --export organ.html -n 200 --every 2 --field vonMises\n"
    "  stroma view results/pulled --export pulled.html --every 5             every fifth instant of a recording\n"};

OptionList viewOptions() {
  OptionList options("options");
  options.add_options()                                                                            //
      ("port", po::value<int>()->value_name("N"), "port to listen on; by default a free one")  //
      ("host", po::value<std::string>()->value_name("ADDRESS"),
       "address to listen on instead of 127.0.0.1; others can then reach the run, unencrypted")           //
      ("open", "open the address with xdg-open")                                                          //
      ("no-open", "only print the address; without either it is opened where there is a display")         //
      ("at-once", "start before the first page is connected: by default the run waits for it")  //
      ("paused", "wait until run is pressed")                                                       //
      ("fps", po::value<double>()->value_name("N"), "largest number of frames per second (by default 60)")         //
      ("record", po::value<std::string>()->value_name("DIR"),
       "write positions and velocities of every state there, and all actions")                          //
      ("record-every", po::value<long>()->value_name("K"), "record every K steps")                                //
      ("replay", po::value<std::string>()->value_name("FILE"), "repeat the actions of an earlier run")  //
      ("export", po::value<std::string>()->value_name("FILE.html"), "write a page that plays a run, and end")     //
      ("steps,n", po::value<long>()->value_name("STEPS"), "with --export: steps to run (by default 100)")     //
      ("every", po::value<long>()->value_name("K"),
       "with --export: a picture every K steps; of a recording, every K instants")  //
      ("field", po::value<std::vector<std::string>>()->value_name("NAME"),
       "with --export: keep this field of the cells, as vonMises; may be repeated")        //
      ("inside", "with --export: keep the inside of bodies too, so that they can be cut")  //
      ("outputs",
       "write the files of the scene's observers too; without it none is written, however long one looks")  //
      ("quiet,q", "no notes");
  addSceneOptions(options);
  return options;
}

bool isGiven(const char* variable) {
  const char* value = std::getenv(variable);
  return value && *value;
}

bool shouldOpen(const Values& values) {
  if (values.count("open") && values.count("no-open")) throw UsageError("--open and --no-open exclude each other");
  if (values.count("open")) return true;
  return !values.count("no-open") && (isGiven("DISPLAY") || isGiven("WAYLAND_DISPLAY"));
}

/// An option that would have no effect is a mistake.
void checkViewPartners(const Values& values, bool is_recording) {
  if (values.count("export")) {
    for (const char* option : {"port", "host", "open", "no-open", "at-once", "paused", "fps", "record"})
      if (values.count(option))
        throw UsageError(
            fmt::format("--{} and --export exclude each other: --export writes a page and starts no server", option));
  } else {
    for (const char* option : {"steps", "every", "field", "inside"})
      if (values.count(option)) throw UsageError(fmt::format("--{} needs --export FILE.html", option));
  }
  if (values.count("record-every") && !values.count("record")) throw UsageError("--record-every needs --record DIR");
  if (!is_recording) return;
  if (values.count("record")) throw UsageError("--record: a recording is not recorded again");
  for (const char* option : {"replay", "outputs"})
    if (values.count(option)) throw UsageError(fmt::format("--{}: a recording is not run", option));
  if (values.count("steps"))
    throw UsageError("--steps: a recording is not run (expected --every K for every K-th of its instants)");
}

}  // namespace

CommandLine viewLine() { return {view_manual, viewOptions(), {"SCENE"}}; }

std::optional<Values> parseViewOptions(const Arguments& arguments) { return parseOptions(viewLine(), arguments); }

ViewCommand::ViewCommand(const Values& values)
    : scene(required(values, "SCENE", view_manual)),
      record_folder(textOf(values, "record")),
      replay_file(textOf(values, "replay")),
      exports(values.count("export") > 0),
      outputs(values.count("outputs") > 0),
      quiet(values.count("quiet") > 0) {
  if (fs::is_directory(scene)) recording_folder = scene;
  checkViewPartners(values, isRecording());
  record_every = within<long>(values, "record-every", 1, 1, 1L << 40);
  if (exports) {
    page.file = textOf(values, "export");
    page.steps = within<long>(values, "steps", 100, 0, 1L << 40);
    page.every = within<long>(values, "every", 1, 1, 1L << 40);
    if (values.count("field")) page.fields = values["field"].as<std::vector<std::string>>();
    page.inside = values.count("inside") > 0;
  } else {
    opens = shouldOpen(values);
    if (values.count("host")) live.host = textOf(values, "host");
    if (live.host.starts_with('[') && live.host.ends_with(']')) live.host = live.host.substr(1, live.host.size() - 2);
    live.port = within<int>(values, "port", 0, 0, 65535);
    live.fps = within<double>(values, "fps", 60, 0.1, 240);
    live.at_once = values.count("at-once") > 0;
    live.paused = values.count("paused") > 0;
  }
  if (!isRecording()) return;
  recorded = recordedRun(recording_folder);
  scene = recorded.scene;
}

std::string ViewCommand::actionsFile() const { return (fs::path(record_folder) / "run.actions").string(); }

void checkOutputs(const ViewCommand& command, const Simulation& simulation) {
  std::vector<FileUse> named;  // by options
  if (command.exports) named.push_back({command.page.file, "--export", true});
  if (!command.record_folder.empty()) {
    for (const std::string& file : recordedFiles(simulation, command.record_folder))
      named.push_back({file, "--record", file.ends_with(".checkpoint")});
    named.push_back({command.actionsFile(), "--record", true});
  }
  std::vector<FileUse> outputs = outputsOf(simulation), inputs = inputsOf(simulation.scene());
  outputs.insert(outputs.end(), named.begin(), named.end());
  if (!command.replay_file.empty()) inputs.push_back({command.replay_file, "--replay"});
  if (command.isRecording())
    for (const FileUse& file : filesOfRecording(command.recording_folder, simulation)) inputs.push_back(file);
  if (const auto sentence = overwriting(outputs, inputs)) throw UsageError(*sentence);
  simulation.checkOutputs();
  // a page is written at the end, when its options have proved right: not even its folder is made before
  for (const FileUse& output : named) (command.exports ? checkAccess : checkWritable)(output.path, output.is_replaced);
}

}  // namespace stroma::command
