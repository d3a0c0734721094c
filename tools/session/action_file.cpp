// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/action_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "framework/scene/diagnostics.h"
#include "framework/scene/load.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

using Json = nlohmann::json;

// ---- writing ----

/// Always with a point or an exponent where it is needed to keep the sign of zero.
std::string number(double value) {
  if (!std::isfinite(value)) throw std::runtime_error("an action has a number that is not finite: it has no text");
  return value == 0 && std::signbit(value) ? "-0.0" : printReal(value);
}

std::string quoted(const std::string& text) {
  try {
    return Json(text).dump();
  } catch (const Json::exception&) {
    throw std::runtime_error(fmt::format("an action has a text that is not UTF-8: {}", inQuotes(text)));
  }
}

std::string list(const Vec3& value) {
  return fmt::format("[{},{},{}]", number(value[0]), number(value[1]), number(value[2]));
}

std::string printedBall(long step, long which, const Input& input) {
  if (!input.nodes.empty() || !input.targets.empty() || !input.force.isZero(0))
    throw std::runtime_error("an action has a ball and also nodes, targets or a force: it has no text");
  const auto& [centre, radius] = *input.ball;
  return fmt::format(
      "{{\"step\":{},\"input\":{},\"state\":{},\"ball\":[{},{},{},{}],\"stiffness\":{},\"damping\":{}}}\n", step, which,
      quoted(input.state), number(centre[0]), number(centre[1]), number(centre[2]), number(radius),
      number(input.stiffness), number(input.damping));
}

std::string printed(const RunEvent& event) {
  if (const auto* edit = std::get_if<AttributeEdit>(&event.what))
    return fmt::format("{{\"step\":{},\"set\":{},\"attribute\":{},\"value\":{}}}\n", event.step, quoted(edit->path),
                       quoted(edit->attribute), quoted(edit->text));
  if (const auto* change = std::get_if<StateChange>(&event.what)) refuseAgain(*change);
  const auto& [which, input] = std::get<InputChange>(event.what);
  if (!input) return fmt::format("{{\"step\":{},\"end\":{}}}\n", event.step, which);
  if (input->ball) return printedBall(event.step, which, *input);
  std::vector<std::string> targets;
  for (const Vec3& target : input->targets) targets.push_back(list(target));
  return fmt::format(
      "{{\"step\":{},\"input\":{},\"state\":{},\"nodes\":[{}],\"force\":{},\"targets\":[{}],\"stiffness\":{},"
      "\"damping\":{}}}\n",
      event.step, which, quoted(input->state), fmt::join(input->nodes, ","), list(input->force),
      fmt::join(targets, ","), number(input->stiffness), number(input->damping));
}

// ---- reading ----

/// What is wrong with a line; the reader adds its place.
struct Wrong {
  std::string message, expected, suggestion{};
};

constexpr std::int64_t most = std::int64_t(1) << 53;  ///< steps and numbers of inputs

constexpr int deepest = 2;  ///< a target lies in a list in the object of its line
constexpr const char* example = "one object a line, as {\"step\":20,\"end\":1}";

/// The object of one line: each of its keys is asked for by name, and none is left.
class Line {
 public:
  explicit Line(const std::string& text) {
    std::string twice;
    const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
      const bool is_list = event == Json::parse_event_t::array_start;
      if (depth == 0 && is_list) throw Wrong{"this is no object", example};
      // refused before it is read: a long line of brackets would take a hundred times its bytes
      if (depth > deepest && (is_list || event == Json::parse_event_t::object_start))
        throw Wrong{"the line has lists within lists of lists", "lists of numbers, or of targets"};
      if (depth == 1 && event == Json::parse_event_t::key && !keys_.insert(parsed.get<std::string>()).second)
        twice = parsed.get<std::string>();
      return true;
    };
    try {
      object_ = Json::parse(text, watch);
    } catch (const Json::exception& error) {
      const std::string sentence = error.what();  // "[json.exception...] parse error at line 1, column 8: ..."
      const std::size_t column = sentence.find("column ");
      throw Wrong{fmt::format("this is no JSON: {}",
                              sentence.substr(column == std::string::npos ? sentence.find(']') + 2 : column, 160)),
                  example};
    }
    if (!object_.is_object()) throw Wrong{"this is no object", example};
    if (!twice.empty()) throw Wrong{fmt::format("{} is there twice", inQuotes(twice)), "each name once"};
  }

  bool has(const char* key) const { return object_.contains(key); }
  /// Refuses names that are none of these.
  void expectOnly(const std::vector<std::string>& names) const {
    for (const std::string& key : keys_)
      if (std::find(names.begin(), names.end(), key) == names.end())
        throw Wrong{fmt::format("{} is no name of such a line", inQuotes(key)),
                    fmt::format("{}", fmt::join(names, ", ")), nearest(key, names)};
  }

  std::string text(const char* key) const {
    const Json& value = at(key);
    if (!value.is_string()) wrong(key, "a text in quotes");
    return value.get<std::string>();
  }
  long whole(const char* key, std::int64_t least) const { return wholeOf(at(key), key, least, most); }
  double real(const char* key) const { return has(key) ? realOf(at(key), key, "a number") : 0; }
  Vec3 vector(const char* key) const {
    return has(key) ? vectorOf(at(key), key, "three numbers, as [0, 1.5, 0]") : Vec3(0, 0, 0);
  }
  std::vector<Vec3> vectors(const char* key) const {
    constexpr const char* expected = "a list of targets, as [[0, 1.5, 0], [1, 0, 0]]";
    std::vector<Vec3> out;
    if (!has(key)) return out;
    if (!at(key).is_array()) wrong(key, expected);
    for (const Json& value : at(key)) out.push_back(vectorOf(value, key, expected));
    return out;
  }
  Ball ball(const char* key) const {
    constexpr const char* expected = "three numbers of its centre and its radius, as [0, 1.5, 0, 0.1]";
    const Json& value = at(key);
    if (!value.is_array() || value.size() != 4) wrong(key, expected);
    const auto real = [&](std::size_t i) { return realOf(value[i], key, expected); };
    return {{real(0), real(1), real(2)}, real(3)};
  }
  std::vector<Index> nodes(const char* key) const {
    std::vector<Index> out;
    if (!at(key).is_array()) wrong(key, "a list of nodes, as [40, 41]");
    for (const Json& value : at(key)) out.push_back(Index(wholeOf(value, key, 0, std::numeric_limits<Index>::max())));
    return out;
  }

 private:
  [[noreturn]] static void wrong(const char* key, const std::string& expected) {
    throw Wrong{fmt::format("\"{}\" has a value of another kind", key), expected};
  }
  const Json& at(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end())
      throw Wrong{fmt::format("\"{}\" is missing", key), fmt::format("{{\"{}\": ...}}", key),
                  nearest(key, {keys_.begin(), keys_.end()})};
    return *found;
  }
  static long wholeOf(const Json& value, const char* key, std::int64_t least, std::int64_t greatest) {
    const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <= std::uint64_t(greatest)
                                                 : value.is_number_integer() && value.get<std::int64_t>() <= greatest;
    if (!fits || value.get<std::int64_t>() < least)
      wrong(key, fmt::format("whole numbers from {} to {}", least, greatest));
    return long(value.get<std::int64_t>());
  }
  static double realOf(const Json& value, const char* key, const char* expected) {
    if (!value.is_number()) wrong(key, expected);
    return value.get<double>();
  }
  static Vec3 vectorOf(const Json& value, const char* key, const char* expected) {
    if (!value.is_array() || value.size() != 3) wrong(key, expected);
    return {realOf(value[0], key, expected), realOf(value[1], key, expected), realOf(value[2], key, expected)};
  }

  Json object_;
  std::set<std::string> keys_;
};

RunEvent parsedEvent(const Line& line) {
  if (line.has("set")) {
    line.expectOnly({"step", "set", "attribute", "value"});
    return {line.whole("step", 0), AttributeEdit{line.text("set"), line.text("attribute"), line.text("value")}};
  }
  if (line.has("end")) {
    line.expectOnly({"step", "end"});
    return {line.whole("step", 0), InputChange{line.whole("end", 1)}};
  }
  if (!line.has("input"))
    throw Wrong{"the line does not say what was done",
                "\"set\" (an attribute), \"input\" (a force, a pull or a ball) or \"end\" (of an input)"};
  if (line.has("ball")) {
    line.expectOnly({"step", "input", "state", "ball", "stiffness", "damping"});
    Input input;
    input.state = line.text("state"), input.ball = line.ball("ball");
    input.stiffness = line.real("stiffness"), input.damping = line.real("damping");
    return {line.whole("step", 0), InputChange{line.whole("input", 1), std::move(input)}};
  }
  line.expectOnly({"step", "input", "state", "nodes", "force", "targets", "stiffness", "damping"});
  Input input{line.text("state"),      line.nodes("nodes"),    line.vector("force"),
              line.vectors("targets"), line.real("stiffness"), line.real("damping")};
  return {line.whole("step", 0), InputChange{line.whole("input", 1), std::move(input)}};
}

/// What one event asks of those before it.
class Order {
 public:
  void add(const RunEvent& event) {
    if (event.step < step_)
      throw Wrong{fmt::format("step {} comes after step {}", event.step, step_), "steps that ascend"};
    step_ = event.step;
    const auto* change = std::get_if<InputChange>(&event.what);
    if (!change) return;
    if (change->input) {
      begun_.insert(change->number);
    } else if (begun_.erase(change->number) == 0) {
      throw Wrong{fmt::format("input {} ends and has not begun", change->number), "the number of an input before"};
    }
  }

 private:
  long step_ = 0;
  std::set<long> begun_;
};

/// False at the end of the text. Of a line that is too long, `line` has as much as may be.
bool nextLine(std::istream& text, std::string& line) {
  const std::size_t limit = ReadLimits().attribute_bytes;
  line.clear();
  std::streambuf& buffer = *text.rdbuf();
  constexpr int end = std::char_traits<char>::eof();
  int next = buffer.sbumpc();
  if (next == end) return false;
  for (; next != end && next != '\n'; next = buffer.sbumpc()) {
    if (line.size() >= limit) throw Wrong{fmt::format("the line is longer than {} bytes", limit), "one action a line"};
    line += char(next);
  }
  return true;
}

std::string parsedHead(const std::string& text) {
  const Wrong none{"this is no file of actions",
                   "{\"stroma\":\"actions\",\"version\":1,\"scene\":...} in the first line"};
  if (text.find("\"stroma\"") == std::string::npos) throw none;
  const Line line(text);
  line.expectOnly({"stroma", "version", "scene"});
  if (line.text("stroma") != "actions") throw none;
  if (const long version = line.whole("version", 1); version != 1)
    throw Wrong{fmt::format("the actions have version {}", version), "version 1"};
  return line.text("scene");
}

}  // namespace

std::string printActions(const RecordedActions& actions) {
  std::string text = fmt::format("{{\"stroma\":\"actions\",\"version\":1,\"scene\":{}}}\n", quoted(actions.scene));
  for (const RunEvent& event : actions.events) text += printed(event);
  return text;
}

RecordedActions parseActions(std::istream& text, const std::string& file) {
  RecordedActions actions;
  Diagnostics problems;
  Order order;
  std::string line;
  for (int number = 1;; ++number) {
    try {
      if (!nextLine(text, line) && number > 1) break;
      if (number == 1) {
        actions.scene = parsedHead(line);
      } else {
        actions.events.push_back(parsedEvent(Line(line)));
        order.add(actions.events.back());
      }
    } catch (const Wrong& wrong) {
      problems.error({file, number, 0}, {}, wrong.message, wrong.expected, wrong.suggestion);
      // what follows is no action, or is within the same line
      if (number == 1 || line.size() >= ReadLimits().attribute_bytes) break;
      if (problems.errorCount() < told_action_problems) continue;
      problems.error({file, number + 1, 0}, {}, "what follows was not looked at");
      break;
    }
  }
  if (problems.hasErrors()) throw SceneError(std::move(problems));
  return actions;
}

RecordedActions readActions(const std::string& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw std::runtime_error(fmt::format("{}: cannot open (this is a folder)", file));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(fmt::format("{}: cannot open ({})", file, std::strerror(errno)));
  return parseActions(stream, file);
}

}  // namespace stroma
