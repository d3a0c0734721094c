// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/picture_request.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "framework/scene/output_file.h"
#include "tools/command/session.h"

namespace stroma::command {
namespace {

const Manual picture_manual{
    "stroma picture SCENE|FOLDER [options]",
    "Draws a scene into a PNG file, without a display: runs it, 100 steps unless -n, --until or --at says otherwise, "
    "and\n"
    "draws its last state. Of a folder that `stroma run` recorded it draws the last instant, and runs nothing. The "
    "file is\n"
    "STEM.png in the current folder unless -o says otherwise. With --animate it is an animated PNG, which browsers "
    "play.\n\n"
    "Exit codes:\n"
    "  0    done\n"
    "  2    the scene or the options are wrong, or nothing can be drawn on this machine; nothing was written\n"
    "  3    no result: the run diverged or found no equilibrium; nothing was written, unless with --anyway\n"
    "  4    the picture could not be written",
    "  stroma picture scenes/examples/organ.xml -n 200\n"
    "  stroma picture organ.xml --at start,end --field displacement --colours warm -o pulled.png\n"
    "  stroma picture organ.xml --field help                                  lists the fields\n"
    "  stroma picture organ.xml --views front,side,iso --edges --ghost\n"
    "  stroma picture organ.xml --cut x=0.02 --range 0,3000 --size 1600x1200\n"
    "  stroma picture two.xml --frame /left --frame /right                    two bodies, each at its own scale\n"
    "  stroma picture results/organ/last --animate --fps 25 -o organ_film.png a film of a recording\n"};

void addLook(OptionList& options) {
  options.add_options()  //
      ("field", po::value<std::string>()->value_name("NAME"),
       "field shown by colours: displacement, velocity, vonMises, ...; none; help lists those of the scene")       //
      ("range", po::value<std::string>()->value_name("LOW,HIGH"), "of the colours, in the SI unit of the field")  //
      ("colours", po::value<std::string>()->value_name("viridis|cividis|inferno|warm|grey|diverging"),
       "the colour map, by default viridis; diverging is symmetric about zero")  //
      ("flat", "one colour for each cell instead of the mean at the nodes")   //
      ("no-shading", "colours exactly as in the legend")                        //
      ("view", po::value<std::vector<std::string>>()->value_name("oblique|iso|front|back|left|right|side|top|bottom"),
       "direction of view, by default oblique; or AZIMUTH,ELEVATION in degrees; may be repeated: side by side")  //
      ("views", po::value<std::string>()->value_name("NAME,NAME..."), "several views by name")                     //
      ("size", po::value<std::string>()->value_name("WxH"), "pixels; by default as fits the bodies")           //
      ("edges", "draw the edges of the cells")                                                                     //
      ("ghost", "draw the outline of the rest shape")                                                              //
      ("cut", po::value<std::string>()->value_name("x=VALUE"),
       "cut the bodies open at a coordinate [m] of x, y or z and look inside; x=VALUE,below or ,above names the side "
       "kept")                                                                                     //
      ("exaggerate", po::value<double>()->value_name("K"), "draw displacements K times as large")  //
      ("hide", po::value<std::vector<std::string>>()->value_name("PATH"),
       "do not draw the bodies of this node; may be repeated")  //
      ("frame", po::value<std::vector<std::string>>()->value_name("PATH"),
       "as large as the bodies of this node; may be repeated: side by side, each at its own scale")  //
      ("title", po::value<std::string>()->value_name("TEXT"), "above the picture")                   //
      ("transparent", "no background")                                                               //
      ("no-legend", "no legend of the colours")                                                      //
      ("bare", "only the bodies: no legend, axes, captions or fixed nodes");
}

OptionList pictureOptions() {
  OptionList options("options");
  options.add_options()                                                                                          //
      ("output,o", po::value<std::string>()->value_name("FILE.png"), "write this file")                          //
      ("steps,n", po::value<long>()->value_name("STEPS"), "number of steps; 0 draws the scene as it is loaded")  //
      ("until", po::value<double>()->value_name("T"), "run to this time [s] instead")                            //
      ("restart", po::value<std::string>()->value_name("FILE"),
       "start from a checkpoint of this scene, written by Python or run --record; -n counts from there, by default 0")  //
      ("at", po::value<std::string>()->value_name("T,T..."),
       "times to draw, side by side: seconds, start, end")  //
      ("animate", "write an animated PNG")                  //
      ("every", po::value<long>()->value_name("K"),
       "with --animate: a frame every K steps, or frames of a recording (by default at most 101 frames)")  //
      ("fps", po::value<double>()->value_name("N"), "with --animate: frames per second (by default 20)")       //
      ("anyway", "draw the last good state of a run without a result, with a warning in the picture");
  addLook(options);
  options.add_options()("quiet,q", "no notes");
  addSceneOptions(options);
  return options;
}

std::vector<std::string> parts(const std::string& text, char separator) {
  std::vector<std::string> out;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) out.push_back(part);
  return out;
}

std::optional<double> numberIn(const std::string& text) {
  try {
    std::size_t read = 0;
    const double number = std::stod(text, &read);
    if (read == text.size() && std::isfinite(number)) return number;
  } catch (const std::exception&) {
  }
  return std::nullopt;
}

picture::Range rangeIn(const std::string& text) {
  const auto ends = parts(text, ',');
  const auto low = ends.size() == 2 ? numberIn(ends[0]) : std::nullopt, high = low ? numberIn(ends[1]) : std::nullopt;
  if (!high || *low >= *high)
    throw UsageError(fmt::format("--range {}: expected LOW,HIGH with LOW below HIGH, as --range=0,2500", text));
  constexpr double narrow = 1e-9, least = 1e-30, most = 1e30;
  const double size = std::max(std::abs(*low), std::abs(*high));
  if (size > most || *high - *low < std::max(least, narrow * size))
    throw UsageError(fmt::format(
        "--range {}: no legend tells its ends apart (expected a width of {:g} or more, and of {:g} of the ends)", text,
        least, narrow));
  return {*low, *high};
}

picture::Cut cutIn(const std::string& text) {
  const std::string expected =
      fmt::format("--cut {}: expected x=VALUE, y=VALUE or z=VALUE, perhaps with ,below or ,above behind it", text);
  const auto words = parts(text, ',');
  if (words.empty() || words.size() > 2 || words[0].size() < 3 || words[0][1] != '=') throw UsageError(expected);
  picture::Cut cut;
  const auto axis = std::string("xyz").find(words[0][0]);
  const auto at = numberIn(words[0].substr(2));
  if (axis == std::string::npos || !at) throw UsageError(expected);
  cut.axis = int(axis), cut.at = *at;
  if (words.size() < 2) return cut;
  if (words[1] != "below" && words[1] != "above") throw UsageError(expected);
  cut.keep = words[1] == "below" ? picture::Cut::Keep::below : picture::Cut::Keep::above;
  return cut;
}

std::vector<AskedTime> timesIn(const std::string& text) {
  std::vector<AskedTime> times;
  for (const std::string& word : parts(text, ',')) {
    if (word == "start") {
      times.push_back({AskedTime::Kind::start, 0});
    } else if (word == "end") {
      times.push_back({AskedTime::Kind::end, 0});
    } else if (const auto time = numberIn(word)) {
      times.push_back({AskedTime::Kind::time, *time});
    } else {
      throw UsageError(fmt::format("--at {}: '{}' is no time (expected seconds, start or end)", text, word));
    }
  }
  constexpr std::size_t most = 12;
  if (times.empty() || times.size() > most)
    throw UsageError(fmt::format("--at {}: expected 1 to {} times", text, most));
  return times;
}

void readSize(const std::string& text, picture::PictureRequest& look) {
  const auto sides = parts(text, 'x');
  const auto width = sides.size() == 2 ? numberIn(sides[0]) : std::nullopt,
             height = width ? numberIn(sides[1]) : std::nullopt;
  constexpr double least = 64, most = 7680;
  const auto fits = [](double side) { return side >= least && side <= most && side == std::floor(side); };
  if (!height || !fits(*width) || !fits(*height))
    throw UsageError(
        fmt::format("--size {}: expected WIDTHxHEIGHT, {} to {} pixels each, as 1200x900", text, least, most));
  look.width = int(*width), look.height = int(*height);
}

template <class T>
std::optional<T> positive(const Values& values, const char* option, T least, T most = std::numeric_limits<T>::max()) {
  if (!values.count(option)) return std::nullopt;
  const T value = values[option].as<T>();
  if (!(value >= least)) throw UsageError(fmt::format("--{} {}: expected {} or more", option, value, least));
  if (value > most) throw UsageError(fmt::format("--{} {}: expected {} or less", option, value, most));
  return value;
}

/// An option that would have no effect is a mistake.
void checkPicturePartners(const Values& values, bool is_recording) {
  if (values.count("steps") && values.count("until")) throw UsageError("-n and --until exclude each other");
  for (const char* option : {"every", "fps"})
    if (values.count(option) && !values.count("animate")) throw UsageError(fmt::format("--{} needs --animate", option));
  if (values.count("animate") && values.count("at"))
    throw UsageError("--at and --animate exclude each other: a film shows the whole run");
  if (values.count("view") && values.count("views")) throw UsageError("--view and --views exclude each other");
  if (!is_recording) return;
  for (const char* option : {"steps", "until", "anyway", "restart"})
    if (values.count(option))
      throw UsageError(fmt::format("--{}: a recording is not run (expected --at T for one of its instants)", option));
}

/// Views and times stand side by side.
void checkPanels(const PictureCommand& command) {
  const std::size_t views = std::max<std::size_t>(1, command.look.views.size()),
                    times = std::max<std::size_t>(1, command.at.size()),
                    frames = std::max<std::size_t>(1, command.look.framed.size());
  const int width = command.look.width > 0 ? command.look.width : picture::most_width;
  const auto most = std::size_t(width / picture::least_panel_width);
  if (views * times * frames > most)
    throw UsageError(
        fmt::format("{} views of {} times{} side by side: on {} pixels there is room for {} panels of {} pixels "
                    "(expected fewer views or "
                    "times, or a wider --size)",
                    views, times, frames > 1 ? fmt::format(" and {} frames", frames) : "", width, most,
                    picture::least_panel_width));
}

/// organ.xml, results/organ/last and results/organ/ give organ.png.
std::string usualFile(const std::string& scene, bool is_recording) {
  fs::path path = fs::absolute(scene).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (is_recording && path.filename() == "last") path = path.parent_path();
  return (is_recording ? path.filename() : path.stem()).string() + ".png";
}

bool isPictureOfStroma(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(4096, '\0');
  file.read(start.data(), std::streamsize(start.size()));
  start.resize(std::size_t(file.gcount()));
  return start.starts_with("\x89PNG") && start.find(std::string("Software\0\0\0\0\0stroma", 19)) != std::string::npos;
}

void readLook(const Values& values, picture::PictureRequest& look) {
  look.field = textOf(values, "field");
  if (values.count("range")) look.range = rangeIn(textOf(values, "range"));
  if (values.count("colours")) look.colours = textOf(values, "colours");
  if (values.count("view")) look.views = values["view"].as<std::vector<std::string>>();
  if (values.count("views")) look.views = parts(textOf(values, "views"), ',');
  if (values.count("size")) readSize(textOf(values, "size"), look);
  if (values.count("cut")) look.cut = cutIn(textOf(values, "cut"));
  if (values.count("hide")) look.hidden = values["hide"].as<std::vector<std::string>>();
  if (values.count("frame")) look.framed = values["frame"].as<std::vector<std::string>>();
  look.exaggeration = positive<double>(values, "exaggerate", 0).value_or(1);
  look.title = textOf(values, "title");
  look.edges = values.count("edges") > 0;
  look.flat = values.count("flat") > 0;
  look.ghost = values.count("ghost") > 0;
  look.shaded = values.count("no-shading") == 0;
  look.transparent = values.count("transparent") > 0;
  look.legend = values.count("no-legend") == 0;
  look.bare = values.count("bare") > 0;
  if (look.field == "none" && look.range) throw UsageError("--range has no effect with --field none");
}

}  // namespace

CommandLine pictureLine() { return {picture_manual, pictureOptions(), {"SCENE"}}; }

std::optional<Values> parsePictureOptions(const Arguments& arguments) { return parseOptions(pictureLine(), arguments); }

PictureCommand::PictureCommand(const Values& values)
    : scene(required(values, "SCENE", picture_manual)),
      file(textOf(values, "output")),
      is_named(values.count("output") > 0),
      steps(positive<long>(values, "steps", 0)),
      animates(values.count("animate") > 0),
      every(positive<long>(values, "every", 1)),
      fps(positive<double>(values, "fps", 0.1, 1000).value_or(20)),
      anyway(values.count("anyway") > 0),
      restart_file(textOf(values, "restart")),
      lists_fields(textOf(values, "field") == "help"),
      quiet(values.count("quiet") > 0) {
  if (fs::is_directory(scene)) recording_folder = scene;
  checkPicturePartners(values, isRecording());
  if (values.count("until")) until = values["until"].as<double>();
  if (values.count("at")) at = timesIn(textOf(values, "at"));
  readLook(values, look);
  checkPanels(*this);
  if (!is_named) file = usualFile(scene, isRecording());
  const std::string ending = fs::path(file).extension().string();
  if (ending != ".png" && ending != ".apng")
    throw UsageError(fmt::format("-o {}: expected a name that ends with .png", file));
  if (!isRecording()) return;
  recorded = recordedRun(recording_folder);
  scene = recorded.scene;
}

void checkOutputs(const PictureCommand& command, const Simulation& simulation) {
  std::vector<FileUse> inputs = inputsOf(simulation.scene());
  if (command.isRecording())
    for (const FileUse& file : filesOfRecording(command.recording_folder, simulation)) inputs.push_back(file);
  if (const auto sentence = overwriting({{command.file, "the picture", true}}, inputs)) throw UsageError(*sentence);
  if (!command.is_named && fs::exists(command.file) && !isPictureOfStroma(command.file))
    throw UsageError(fmt::format(
        "{} is there, and is no picture of stroma: it is not written over (expected -o FILE.png)", command.file));
  checkAccess(command.file, true);
}

}  // namespace stroma::command
