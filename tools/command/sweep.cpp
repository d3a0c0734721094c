// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma sweep: configurations of a scene, compared by error and run time.
#include "tools/sweep/sweeper.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "framework/scene/services.h"
#include "tools/command/options.h"
#include "tools/command/session.h"

namespace stroma::command {
namespace {

const Manual sweep_manual{
    "stroma sweep SCENE --vary PATH.ATTR=a,b,c ... -o DIR [options]",
    "Runs a scene with every combination of the values, each in a process and a folder of its own, and compares them "
    "by\n"
    "error and run time. DIR gets report.html (curves with their front; each point has its command line), table.csv,\n"
    "table.json, and the curves as .svg and .png. The same command again goes on where it was stopped, and makes no "
    "run\n"
    "twice. docs/sweep.md is a first example step by step.\n\n"
    "--error is the relative error at the end of the run:\n"
    "  l2, max       of the displacements, compared at common points of the rest shape whatever the meshes\n"
    "  energy        of kinetic and elastic energy\n"
    "  PATH.NAME     mean of an attribute, an output or a field of cells, as /liver/tissue.vonMises; with :NODES over\n"
    "                these, as /beam/dofs.displacement:@/beam/end.indices, or at a place, as /beam/dofs.velocity:(0.2 "
    "0 0)\n\n"
    "--reference is what runs are compared with:\n"
    "  finest        the run with the finest mesh, time step, tolerance, most iterations, and the last of other "
    "values\n"
    "  extrapolated  its extrapolation to size zero, by the order that the runs show\n"
    "  FILE          a recording (.state.gz), a table (.csv with x y z ux uy uz), or what run --measure has written\n"
    "  FORMULA       \"ux; uy; uz\" in x, y, z (at rest) and t; of a quantity one formula or three\n\n"
    "--shard 2/8 makes the second of eight shares of the runs, beside processes that make the others: on one machine, by\n"
    "GNU parallel, or as an array of Slurm. All work in one folder; the command without it gathers and makes what is\n"
    "missing. --engine parallel or slurm does both: it starts the shares, waits for them and gathers. The machines see\n"
    "the folder, the scene and Stroma under the same paths.\n\n"
    "Exit codes:\n"
    "  0    done; runs without a result are in the table with their sentence\n"
    "  1    no configuration reaches the --goal\n"
    "  2    the scene or the options are wrong; nothing was run\n"
    "  3    no run has a result\n"
    "  4    an output could not be written, or --engine has left runs open\n"
    "  130  interrupted with Ctrl-C, 143 ended by SIGTERM, 129 by its terminal; the same command goes on",
    "  stroma sweep liver.xml --vary /liver/linear.iterations=10,25,50,100 --until 1 -o results/iterations\n"
    "  stroma sweep beam.xml --vary \"/beam/grid.n=11 2 2,21 3 3,41 5 5\" --vary /beam/cells/fem.method=large,polar -n "
    "1 \\\n"
    "      --reference extrapolated -o results/beam\n"
    "  stroma sweep liver.xml --vary dt=0.04,0.02,0.01,0.005 --until 1 --goal \"error<1%\" -o results/dt\n"
    "  stroma sweep liver.xml --zip \"dt=0.02,0.01; /liver/linear.iterations=50,100\" --until 1 -o results/both\n"
    "  stroma sweep liver.xml --vary dt=0.02,0.01 --until 1 --shard 1/2 -o results/shared\n"
    "  stroma sweep liver.xml --vary dt=0.02,0.01 --until 1 --engine parallel --sshlogin node1,node2 -o results/shared\n"};

using Texts = std::vector<std::string>;

OptionList sweepOptions() {
  OptionList options("options");
  options.add_options()  //
      ("vary", po::value<Texts>()->value_name("PATH.ATTR=a,b,c"),
       "values of an attribute, of threads, or components in the place of one (\"/solver=BDFOdeSolver order=2,StaticSolver\"); may be "
       "repeated: every combination is run")  //
      ("zip", po::value<Texts>()->value_name("\"PATH.ATTR=a,b; PATH.ATTR=c,d\""),
       "attributes that vary together; may be repeated")                                                           //
      ("output,o", po::value<std::string>()->value_name("DIR"), "folder of the runs and the report")               //
      ("error", po::value<std::string>()->value_name("l2|max|energy|PATH.NAME[:NODES]"), "what is compared (l2)")  //
      ("reference", po::value<std::string>()->value_name("finest|extrapolated|FILE|FORMULA"),
       "what it is compared with (finest)")  //
      ("reference-set", po::value<Texts>()->value_name("PATH.ATTR=VALUE"),
       "the reference is one more run: the finest with this; may be repeated. It is not timed")  //
      ("goal", po::value<std::string>()->value_name("\"error<1%\""),
       "look for the cheapest configuration below this error instead of running all")                             //
      ("steps,n", po::value<long>()->value_name("STEPS"), "number of steps of each run")                          //
      ("until", po::value<double>()->value_name("T"), "run to this time [s] instead")                             //
      ("repeat", po::value<int>()->value_name("K"), "runs of each configuration; the median is used (3)")        //
      ("jobs", po::value<int>()->value_name("N"), "cores that timed runs may use at once (half of the machine)")  //
      ("no-times", "only the errors: runs use the whole machine, each once")                                      //
      ("seed", po::value<unsigned>()->value_name("N"), "of the order of the runs (1)")                            //
      ("shard", po::value<std::string>()->value_name("I/N"),
       "make only share I of N of the runs, in parallel with the others; the command without it collects them")  //
      ("engine", po::value<std::string>()->value_name("parallel|slurm"),
       "have the runs made by shares: GNU parallel starts them, or Slurm as an array; then gather them")  //
      ("sshlogin", po::value<std::string>()->value_name("HOST,HOST"),
       "with --engine parallel: machines to use, as ssh names them; a colon is this one (this one)")  //
      ("shares", po::value<int>()->value_name("N"),
       "with --engine: into how many shares (4 for each machine; 8 with Slurm)")  //
      ("engine-options", po::value<std::string>()->value_name("TEXT"),
       "with --engine: more options for parallel or sbatch, as --engine-options=\"--partition=long\"")  //
      ("quiet,q", "no progress");
  addSceneOptions(options);
  return options;
}

template <class T>
void take(const Values& values, const char* name, T& member) {
  if (values.count(name)) member = values[name].as<T>();
}

/// "2/8": the second of eight.
void takeShare(const std::string& text, sweep::SweepRequest& request) {
  const char* const end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, request.share);
  bool is_good = first == std::errc() && slash != end && *slash == '/';
  if (is_good) {
    const auto [rest, second] = std::from_chars(slash + 1, end, request.shares);
    is_good = second == std::errc() && rest == end && request.share >= 1 && request.share <= request.shares;
  }
  if (!is_good) throw UsageError(fmt::format("--shard {}: expected I/N, I from 1 to N, as 2/8", text));
}

void takeEngine(const Values& values, sweep::SweepRequest& request) {
  take(values, "engine", request.engine), take(values, "sshlogin", request.logins);
  take(values, "engine-options", request.engine_options), take(values, "shares", request.engine_shares);
  if (values.count("engine") && request.engine != "parallel" && request.engine != "slurm")
    throw UsageError(fmt::format("--engine {}: expected parallel or slurm", request.engine));
  if (values.count("engine") && values.count("shard") && !std::getenv(sweep::share_of_engine))
    throw UsageError("--engine makes shares itself: leave --shard out, or --engine to make one share here");
  for (const char* option : {"sshlogin", "shares", "engine-options"})
    if (values.count(option) && request.engine.empty())
      throw UsageError(fmt::format("--{} is for --engine, which is missing: expected --engine parallel{}", option,
                                   std::string_view(option) == "sshlogin" ? "" : " or slurm"));
  if (!request.logins.empty() && request.engine != "parallel")
    throw UsageError("--sshlogin is for --engine parallel: Slurm knows its machines, leave it out");
  if (values.count("shares") && request.engine_shares < 1)
    throw UsageError(fmt::format("--shares {}: expected 1 or more", request.engine_shares));
}

void checkNumbers(const sweep::SweepRequest& request) {
  if (request.steps && request.until) throw UsageError("-n and --until exclude each other");
  if (request.steps && *request.steps < 1) throw UsageError(fmt::format("-n {}: expected 1 or more", *request.steps));
  if (request.until && !(std::isfinite(*request.until) && *request.until > 0))
    throw UsageError(fmt::format("--until {}: expected a time after the start [s]", *request.until));
  if (request.repeat < 1) throw UsageError(fmt::format("--repeat {}: expected 1 or more", request.repeat));
  if (request.jobs < 0) throw UsageError(fmt::format("--jobs {}: expected 1 or more", request.jobs));
  if (request.threads < 1 || request.threads > 1024)
    throw UsageError(fmt::format("--threads {}: expected 1 to 1024", request.threads));
}

sweep::SweepRequest requestOf(const Values& values) {
  sweep::SweepRequest request;
  request.program = fs::read_symlink("/proc/self/exe").string();
  request.scene = required(values, "SCENE", sweep_manual);
  if (!fs::exists(request.scene)) throw UsageError(fmt::format("{}: there is no such file", request.scene));
  request.scene = fs::absolute(request.scene).lexically_normal().string();
  if (!values.count("output")) throw UsageError(fmt::format("-o DIR is missing; usage: {}", sweep_manual.usage));
  request.folder = fs::absolute(values["output"].as<std::string>()).lexically_normal().string();
  take(values, "vary", request.vary), take(values, "zip", request.zip), take(values, "set", request.settings);
  take(values, "reference-set", request.reference_settings);
  take(values, "error", request.error), take(values, "reference", request.reference),
      take(values, "goal", request.goal);
  take(values, "repeat", request.repeat), take(values, "jobs", request.jobs), take(values, "seed", request.seed);
  take(values, "threads", request.threads);
  if (values.count("steps")) request.steps = values["steps"].as<long>();
  if (values.count("until")) request.until = values["until"].as<double>();
  if (values.count("shard")) takeShare(values["shard"].as<std::string>(), request);
  takeEngine(values, request);
  request.timed = !values.count("no-times"), request.quiet = values.count("quiet") > 0;
  if (values.count("module"))
    for (const std::string& module : values["module"].as<Texts>())
      request.modules.push_back(fs::absolute(module).string());
  parseOverrides(request.settings), parseOverrides(request.reference_settings);  // throw for what sets nothing
  checkNumbers(request);
  return request;
}

CommandLine sweepLine() { return {sweep_manual, sweepOptions(), {"SCENE"}}; }

int sweepScene(const Arguments& arguments) {
  const auto values = parseOptions(sweepLine(), arguments);
  if (!values) return exit_done;
  sweep::SweepRequest request = requestOf(*values);
  request.words.assign(arguments.begin(), arguments.end());
  return service<sweep::Sweeper>()->sweep(request);
}

}  // namespace

const Subcommand sweep_command{"sweep", "compare configurations of a scene by error and run time", Group::checks,
                               sweepScene, sweepLine};

}  // namespace stroma::command
