// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma stress: a scene disturbed in many ways.
#include <fmt/format.h>

#include <cmath>
#include <thread>

#include "framework/scene/services.h"
#include "tools/command/options.h"
#include "tools/command/session.h"
#include "tools/stress/stresser.h"

namespace stroma::command {
namespace {

const Manual stress_manual{
    "stroma stress SCENE [options]",
    "Disturbs a scene in many ways, each in a process of its own, and says in one table what becomes of it:\n"
    "  shapes      cells inside out, flat, crushed; nodes at random places, pulled, kicked\n"
    "  constraints what is held jumps, and jumps back\n"
    "  numbers     dt, stiffnesses, masses, ratios and all others by decades and to the ends of their ranges. They "
    "are\n"
    "              found by the unit and the range that attributes declare, also in modules of your own\n"
    "  NaN         in attributes, positions, velocities, forces\n"
    "  machine     1 to 64 threads, which must give the same bits; short memory\n"
    "  forces      against energies, derivatives, balances and mappings, as components promise them\n\n"
    "A case ends in one of these ways:\n"
    "  good        back at the shape of the undisturbed run, or the checked property holds\n"
    "  runs        finite to the last step and without a doubt; not, or not yet, at that shape\n"
    "  elsewhere   at rest in another shape, indistinguishable from a right one\n"
    "  doubt       finite, with a sentence why it may be no result\n"
    "  stops       refused or stopped, with a sentence\n"
    "  unfinished  took longer than a case may\n"
    "  breaks      a crash, a number that is not finite, a stop without a sentence, a promise that is broken\n\n"
    "No exporter writes. DIR gets stress.html, stress.json and cases.jsonl; the same command goes on with the cases "
    "that\n"
    "are open, and makes none twice. A seed gives the same cases, and they end the same.\n\n"
    "Exit codes:\n"
    "  0    nothing breaks\n"
    "  1    something breaks\n"
    "  2    the scene or the options are wrong; nothing was run\n"
    "  3    the scene has no result as it is\n"
    "  4    an output could not be written\n"
    "  130  interrupted with Ctrl-C, 143 ended by SIGTERM; the same command goes on",
    "  stroma stress liver.xml\n"
    "  stroma stress liver.xml --case 17\n"
    "  stroma stress liver.xml --hours 8 --seed 2 -o results/liver_night\n"
    "  stroma stress own.xml --module build/own.so --json | python3 -m json.tool\n"};

OptionList stressOptions() {
  OptionList options("options");
  options.add_options()                                                                                         //
      ("output,o", po::value<std::string>()->value_name("DIR"), "folder of the results (results/STEM/stress)")  //
      ("seconds", po::value<double>()->value_name("S"), "begin no case after S seconds (120)")                  //
      ("hours", po::value<double>()->value_name("H"),
       "a campaign of H hours: beyond the list of cases, magnitudes are at random")                                  //
      ("cases", po::value<long>()->value_name("N"), "the first N cases")                                             //
      ("case", po::value<long>()->value_name("N"), "only case N, with all its messages; nothing is written")        //
      ("seed", po::value<unsigned>()->value_name("N"), "seed of the random choices (1)")                            //
      ("steps,n", po::value<long>()->value_name("STEPS"), "steps of each case (6 to 40, by the size of the scene)")  //
      ("jobs", po::value<int>()->value_name("N"), "cases at once (by default the number of cores)")                //
      ("json", po::value<std::string>()->implicit_value("-")->value_name("FILE"),
       "print the results as JSON; --json=FILE writes them to a file")  //
      ("quiet,q", "no progress");
  addSceneOptions(options);
  return options;
}

CommandLine stressLine() { return {stress_manual, stressOptions(), {"SCENE"}}; }

stress::StressRequest stressRequest(const Values& values) {
  stress::StressRequest request;
  request.program = fs::read_symlink("/proc/self/exe").string();
  request.scene = required(values, "SCENE", stress_manual);
  if (!fs::exists(request.scene)) throw UsageError(fmt::format("{}: there is no such file", request.scene));
  const std::string folder = values.count("output") ? values["output"].as<std::string>()
                                                    : "results/" + fs::path(request.scene).stem().string() + "/stress";
  request.scene = fs::absolute(request.scene).lexically_normal().string();
  request.folder = fs::absolute(folder).lexically_normal().string();
  request.overrides = overridesOf(values);
  if (values.count("module"))
    for (const std::string& module : values["module"].as<std::vector<std::string>>())
      request.modules.push_back(fs::absolute(module).string());
  if (values.count("seconds") && values.count("hours")) throw UsageError("--seconds and --hours exclude each other");
  request.seconds = within(values, "seconds", 120., 0., 1e7);
  request.goes_on = values.count("hours") > 0;
  if (request.goes_on) request.seconds = 3600 * within(values, "hours", 1., 0., 1e4);
  constexpr long many = 1000000000;
  if (values.count("cases")) request.cases = within(values, "cases", 1L, 1L, many);
  if (values.count("case")) request.only = within(values, "case", 1L, 1L, many);
  if (values.count("steps")) request.steps = within(values, "steps", 1L, 1L, many);
  if (values.count("seed")) request.seed = values["seed"].as<unsigned>();
  request.jobs = within(values, "jobs", int(std::max(1u, std::thread::hardware_concurrency())), 1, 1024);
  request.quiet = values.count("quiet") > 0;
  if (values.count("json")) request.json_file = values["json"].as<std::string>();
  return request;
}

int stressScene(const Arguments& arguments) {
  const auto values = parseOptions(stressLine(), arguments);
  if (!values) return exit_done;
  if (values->count("threads")) throw UsageError("--threads: cases use one thread, and those with more say so");
  stress::StressRequest request = stressRequest(*values);
  request.words.assign(arguments.begin(), arguments.end());
  return service<stress::Stresser>()->stress(request);
}

}  // namespace

const Subcommand stress_command{"stress", "disturb a scene in many ways to find its limits", Group::checks,
                                stressScene, stressLine};

}  // namespace stroma::command
